"""The command `shadowlab`: compare, advise, matrix, diagnose, techniques, doctor.

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
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

from .._core import Note
from ..errors import ArgumentError, ShadowlabError, ShadowlabWarning
from ..text import parse_bias, parse_resolutions, parse_size
from .advise import advise_options
from .matrix import diagnose_command, matrix_command
from .view import load_view, view_options

USAGE_ERROR = 2
INTERRUPTED = 130  # 128 + SIGINT, as shells say it
DEFAULT_TECHNIQUES = ("uniform", "lispsm")
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
        print(f"shadowlab: error: {' '.join(explanation(error).split())}", file=sys.stderr)
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
    top.add_argument("--debug", action="store_true", help="show where an error comes from")
    shared = Parser(add_help=False)
    shared.add_argument("--debug", action="store_true", help="show where an error comes from")
    commands = top.add_subparsers(metavar="COMMAND", required=True, parser_class=Parser)

    compare = commands.add_parser(
        "compare",
        parents=[shared, view_options(Parser(add_help=False))],
        help="techniques side by side, against traced truth",
        description=compare_command.__doc__,
    )
    compare.add_argument(
        "--technique",
        action="append",
        metavar="NAME[:param=value,...]",
        help='repeat for several; "all" for every technique that serves the light; preset:NAME for what an engine '
        "ships; matrix:file=F,convention=C for matrices of your own; `shadowlab techniques` lists the names "
        "(default: uniform and lispsm)",
    )
    compare.add_argument(
        "--resolution", action="append", metavar="N[,N...]", help="texels along each side of the maps (default: 1024)"
    )
    compare.add_argument(
        "--backend", default="auto", choices=("cpu", "gpu", "auto"), help="the renderer (default: auto)"
    )
    compare.add_argument(
        "--filter", default="nearest", choices=("nearest", "pcf2x2"), help="how maps are read (default: nearest)"
    )
    compare.add_argument(
        "--bias",
        metavar="NAME=VALUE,...",
        help="what is taken off the depth before it is compared: world, texels, ndc, slope, slope_limit",
    )
    compare.add_argument(
        "--out", default="report", metavar="DIR", help="where report.html and the rest go (default: report)"
    )
    compare.set_defaults(run=compare_command)
    advise_options(commands, shared)

    matrix = commands.add_parser(
        "matrix",
        parents=[shared, view_options(Parser(add_help=False))],
        help="the matrix of a technique",
        description=matrix_command.__doc__,
    )
    matrix.add_argument("--technique", action="append", metavar="NAME[:param=value,...]", help="(default: lispsm)")
    matrix.add_argument(
        "--resolution",
        action="append",
        metavar="N",
        help="texels along each side the fit is made for (default: 1024)",
    )
    matrix.add_argument(
        "--convention",
        default="webgpu",
        metavar="NAME[:field=value,...]",
        help="how the matrix is written: opengl, direct3d, vulkan... (default: webgpu, column vectors and z in 0..1)",
    )
    matrix.add_argument("--format", default="text", choices=("npy", "json", "text"), help="(default: text)")
    matrix.add_argument("--out", metavar="FILE", help="write there instead of standard output")
    matrix.set_defaults(run=matrix_command)

    diagnose = commands.add_parser(
        "diagnose",
        parents=[shared],
        help="what sets two shadow matrices apart",
        description=diagnose_command.__doc__,
    )
    diagnose.add_argument(
        "mine", metavar="MINE", help="npy, json or text, in this program's convention or as json says"
    )
    diagnose.add_argument("theirs", metavar="THEIRS", help="npy, json or text, in any convention")
    view_options(diagnose, optional=True)
    diagnose.add_argument("--resolution", default="1024", metavar="N", help="texels along each side (default: 1024)")
    diagnose.set_defaults(run=diagnose_command)

    table = commands.add_parser(
        "techniques",
        parents=[shared],
        help="the techniques and their parameters",
        description=techniques_command.__doc__,
    )
    table.set_defaults(run=techniques_command)
    doctor = commands.add_parser(
        "doctor",
        parents=[shared],
        help="what is here, what is missing, and how to get it",
        description=doctor_command.__doc__,
    )
    doctor.set_defaults(run=doctor_command)
    return top


def compare_command(options: argparse.Namespace) -> int:
    """Compares techniques on a scene and writes a report: report.html, results.csv, results.json and pictures."""
    from .._core import Bias, Renderer
    from ..checks import picture_size
    from ..experiments.compare import compare
    from ..experiments.tables import text_table
    from ..techniques.registry import technique_of, with_all

    resolutions = [r for text in options.resolution or ["1024"] for r in parse_resolutions(text)]
    asked = options.technique or list(DEFAULT_TECHNIQUES)
    named = with_all(asked)
    techniques = {spec: technique_of(spec) for spec in named}
    for spec in named:
        if named.count(spec) > 1:
            raise ArgumentError(f"technique: {spec!r} is given twice; give it once")
    if len(set(resolutions)) < len(resolutions):
        raise ArgumentError("resolution: the same one is given twice; give each once")
    size = None if options.size is None else parse_size(options.size)
    scene, camera, light, source = load_view(options, size)
    size = size or picture_size(camera.aspect)
    bias = None if options.bias is None else Bias(**parse_bias(options.bias))
    renderer = Renderer(options.backend)
    directory = writable_directory(options.out)
    study = compare(
        scene,
        camera,
        light,
        {spec: techniques[spec] for spec in with_all(asked, light)},
        resolution=resolutions,
        size=size,
        renderer=renderer,
        bias=bias,
        filter=options.filter,
        source=replace(source, out=options.out),
    )
    if all(run.failure for run in study.runs):
        raise ArgumentError(study.runs[0].failure)
    report = study.save(directory)
    print(f"{source.name} on {study.backend} ({study.adapter}), {size[0]} x {size[1]} pixels\n")
    print(text_table(study.table))
    for line in notes_of(study.runs):
        print(line)
    print(f"\n{study.verdict}\n\nReport: {report}")
    return 0


def notes_of(runs: Sequence[Any]) -> list[str]:
    """At most a line for each technique: its first note, and how many others there are."""
    notes: dict[str, list[Note]] = {}
    for run in runs:
        of = notes.setdefault(run.label, [])
        of += [note for note in run.notes if note not in of]
    more = {label: f" (and {len(of) - 1} more, in the report)" if len(of) > 1 else "" for label, of in notes.items()}
    return [f"{label}: {of[0]}{more[label]}" for label, of in notes.items() if of]


def techniques_command(_: argparse.Namespace) -> int:
    """Lists the techniques with title, source, lights, parameters and their ranges; then the presets of engines."""
    from ..techniques.presets import PRESETS
    from ..techniques.registry import techniques

    previous = None
    for row in techniques().to_dict("records"):
        if row["name"] != previous:
            space = "" if previous is None else "\n"
            print(f"{space}{row['name']}: {row['title']}\n  {row['source']}\n  lights: {row['lights']}")
        previous = row["name"]
        if row["parameter"]:
            unit = f" {row['unit']}" if row["unit"] else ""
            print(f"  {row['parameter']}={row['default']}{unit} ({row['range']}): {row['doc']}")
    print("\npresets, for directional lights: what engines ship, on the same body and fit")
    for preset in PRESETS:
        print(f"  preset:{preset.name}: {preset.engine}\n    {preset.formula}")
    return 0


def doctor_command(_: argparse.Namespace) -> int:
    """Says what works here, what is missing, and the command that brings it. Exit status 0 where the core works."""
    from ..doctor import report

    found = report()
    print(found)
    return 0 if found.works else 1


def writable_directory(path: str) -> Path:
    """The directory, made, and tried before long work."""
    if not path:
        raise ArgumentError("out: expected the name of a directory, got nothing; leave --out away for ./report")
    directory = Path(path)
    try:
        directory.mkdir(parents=True, exist_ok=True)
        probe = directory / ".shadowlab-probe"
        probe.write_bytes(b"")
        probe.unlink()
    except OSError as error:
        raise ArgumentError(
            f"out: cannot write to {path!r} ({error.strerror or error}); choose another directory"
        ) from error
    return directory
