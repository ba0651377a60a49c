"""The command `shadowlab`: compare, advise, explain, experiment, matrix, diagnose, techniques, doctor.

An error is one line on standard error and exit status 2; Ctrl-C is 130. Vectors and points are in the axes of the
file, so `--up z` goes with coordinates as the program that wrote the file shows them.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import re
import sys
import tempfile
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NoReturn

from ..errors import ArgumentError, ShadowlabError, ShadowlabWarning
from .advise import advise_options
from .compare import compare_options
from .diagnose import diagnose_options
from .doctor import doctor_options
from .experiment import experiment_options
from .explain import explain_options
from .matrix import matrix_options
from .options import Commands
from .techniques import techniques_options

USAGE_ERROR = 2
INTERRUPTED = 130  # 128 + SIGINT, as shells say it
# A value that begins with a minus and is not an option: -1,2,3  -.5  -inf,0,0
NEGATIVE_VALUE = re.compile(r"-(\.?\d|inf|nan)", re.IGNORECASE)


class Parser(argparse.ArgumentParser):
    """An argument parser whose errors are one line."""

    def __init__(self, **kwargs: Any):
        super().__init__(allow_abbrev=False, **kwargs)

    def error(self, message: str) -> NoReturn:
        """Says what is wrong and where help is, on one line."""
        raise ArgumentError(f"{' '.join(message.split())}; see {self.prog} --help")


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command line; the exit status."""
    words = joined_negative_values(list(sys.argv[1:] if arguments is None else arguments))
    debug = "--debug" in words
    if sys.stderr is None:  # closed by whoever started this; print would turn to standard output
        sys.stderr = Path(os.devnull).open("w")  # noqa: SIM115 - it lives as long as the process
    if sys.stdout is None:
        print("shadowlab: error: standard output is closed; send it to a file or to /dev/null", file=sys.stderr)
        return USAGE_ERROR
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # a terminal without µ or ² shows a question mark
            stream.reconfigure(errors="replace")
    # Mesa's Vulkan layer asks for a Wayland display, and writes a line of its own where there is no session directory.
    os.environ.setdefault("XDG_RUNTIME_DIR", tempfile.gettempdir())
    try:
        with one_line_warnings():
            options = parser().parse_args(words)
            status = int(options.run(options) or 0)
            sys.stdout.flush()
            return status
    except KeyboardInterrupt:
        print("shadowlab: interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        # Whoever read the output has left (a pager, head); the interpreter must not complain about it when it exits.
        discard_output()
        return 0
    except Exception as error:
        if isinstance(error, OSError) and not isinstance(error, ShadowlabError):
            discard_output()
        if debug:
            raise
        # Standard error may be as full as the disk; the exit status says it then.
        with contextlib.suppress(OSError):
            print(f"shadowlab: error: {' '.join(explanation(error).split())}", file=sys.stderr, flush=True)
        return USAGE_ERROR


def discard_output() -> None:
    """What standard output cannot write is dropped: the interpreter would try again when it exits, and complain."""
    with contextlib.suppress(OSError):
        sys.stdout.flush()
        return
    with contextlib.suppress(OSError):  # a stream without a file behind it holds nothing back
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def explanation(error: Exception) -> str:
    """What went wrong, for a person; anything that is no error of ours is a defect and says so."""
    if isinstance(error, ShadowlabError):
        return str(error)
    if isinstance(error, OSError):
        where = f" {error.filename!r}" if error.filename else ""
        return f"cannot read or write{where}: {error.strerror or error}; is the disk full, or the output closed?"
    if isinstance(error, MemoryError):
        return f"not enough memory: {error}; choose a smaller size or resolution"
    return f"{type(error).__name__}: {error}; a defect in shadowlab: please report it with what --debug shows"


def joined_negative_values(words: list[str]) -> list[str]:
    """`--light -1,2,3` as `--light=-1,2,3`, which argparse would take for an option."""
    joined: list[str] = []
    for word in words:
        takes_value = joined and joined[-1].startswith("--") and "=" not in joined[-1]
        if takes_value and NEGATIVE_VALUE.match(word):
            joined[-1] += f"={word}"
        else:
            joined.append(word)
    return joined


@contextlib.contextmanager
def one_line_warnings() -> Iterator[None]:
    """Warnings of ours as one line each on standard error, after the work; an error stands alone."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("ignore")
        warnings.simplefilter("always", ShadowlabWarning)
        yield
    for text in dict.fromkeys(" ".join(str(w.message).split()) for w in caught):
        print(f"shadowlab: warning: {text}", file=sys.stderr)


def parser() -> Parser:
    """The whole command line."""
    from .._core import __version__

    top = Parser(prog="shadowlab", description="The laboratory for shadow-map parameterizations.")
    top.add_argument("--version", action="version", version=f"shadowlab {__version__}")
    shared = Parser(add_help=False)
    for one in (top, shared):
        one.add_argument("--debug", action="store_true", help="show where an error comes from")
    commands: Commands = top.add_subparsers(metavar="COMMAND", required=True, parser_class=Parser)
    for add in (
        compare_options, advise_options, explain_options, experiment_options, matrix_options, diagnose_options,
        techniques_options, doctor_options,
    ):  # fmt: skip
        add(commands, shared)
    return top
