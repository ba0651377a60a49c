"""The command `shadowlab`: what it does with its words, with errors, and with an output that takes nothing.

An error is one line on standard error and exit status 2; Ctrl-C is 130. Vectors and points are in the axes of the
file, so `--up z` goes with coordinates as the program that wrote the file shows them.
"""

from __future__ import annotations

import contextlib
import io
import os
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, cast

import click

from ..errors import ArgumentError, ShadowlabError, ShadowlabWarning
from .all_commands import SHADOWLAB
from .command import COMPLETE, Options

USAGE_ERROR = 2
INTERRUPTED = 130  # 128 + SIGINT, as shells say it


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command line; the exit status."""
    words = list(sys.argv[1:] if arguments is None else arguments)
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
        if COMPLETE in os.environ:
            from .completion import complete

            return complete(SHADOWLAB, os.environ[COMPLETE])
        with one_line_warnings():
            status = int(result_of(words))
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


def result_of(words: Sequence[str], instead: Callable[[Options], Any] | None = None) -> Any:
    """What the command of these words returns; what another function returns that takes its options instead.

    Raises
    ------
    ArgumentError
        For words that are no command, with where help is.
    SystemExit
        After `--help` and `--version`.
    """
    try:
        with SHADOWLAB.make_context("shadowlab", list(words), obj=instead) as ctx:
            return SHADOWLAB.invoke(ctx)
    except click.UsageError as wrong:
        path = "shadowlab" if wrong.ctx is None else wrong.ctx.command_path
        said = wrong.format_message().rstrip(".")
        raise ArgumentError(f"{said[:1].lower()}{said[1:]}; see {path} --help") from None
    except click.exceptions.Exit as left:
        raise SystemExit(left.exit_code) from None


def given_options(words: Sequence[str]) -> Options:
    """The options that the words of a command give, which is not run; errors as of `result_of`."""
    return cast("Options", result_of(words, lambda options: options))


@contextlib.contextmanager
def one_line_warnings() -> Iterator[None]:
    """Warnings of ours as one line each on standard error, after the work; an error stands alone."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("ignore")
        warnings.simplefilter("always", ShadowlabWarning)
        yield
    for text in dict.fromkeys(" ".join(str(w.message).split()) for w in caught):
        print(f"shadowlab: warning: {text}", file=sys.stderr)
