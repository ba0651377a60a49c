"""The command `shadowlab`: compare, techniques, matrix, doctor.

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

from .errors import ArgumentError, ShadowlabError, ShadowlabWarning
from .specs import parse_bias, parse_resolutions, parse_size, parse_spec, parse_vector

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
    from ._core import __version__

    top = Parser(prog="shadowlab", description="The laboratory for shadow-map parameterizations.")
    top.add_argument("--version", action="version", version=f"shadowlab {__version__}")
    top.add_argument("--debug", action="store_true", help="show where an error comes from")
    shared = Parser(add_help=False)
    shared.add_argument("--debug", action="store_true", help="show where an error comes from")
    commands = top.add_subparsers(metavar="COMMAND", required=True, parser_class=Parser)

    compare = commands.add_parser(
        "compare",
        parents=[shared, view_options()],
        help="techniques side by side, against traced truth",
        description=compare_command.__doc__,
    )
    compare.add_argument(
        "--technique",
        action="append",
        metavar="NAME[:param=value,...]",
        help="repeat for several (default: uniform and lispsm)",
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

    matrix = commands.add_parser(
        "matrix", parents=[shared, view_options()], help="the matrix of a technique", description=matrix_command.__doc__
    )
    matrix.add_argument("--technique", action="append", metavar="NAME[:param=value,...]", help="(default: lispsm)")
    matrix.add_argument(
        "--resolution",
        action="append",
        metavar="N",
        help="texels along each side the fit is made for (default: 1024)",
    )
    matrix.add_argument("--format", default="text", choices=("npy", "json", "text"), help="(default: text)")
    matrix.add_argument("--out", metavar="FILE", help="write there instead of standard output")
    matrix.set_defaults(run=matrix_command)

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


def view_options() -> Parser:
    """Scene, camera and light: what compare and matrix share."""
    options = Parser(add_help=False)
    options.add_argument(
        "scene", metavar="MESH|@LIBRARY", help="a mesh file, or a scene of the library such as @forest:trees=500"
    )
    view = options.add_argument_group("view", "In the file's axes. What is not given is chosen to fit the scene.")
    view.add_argument("--up", default="y", choices=("y", "z"), help="the file's up axis (default: y)")
    view.add_argument("--ground", action="store_true", help="add a floor under the scene")
    view.add_argument("--eye", metavar="X,Y,Z", help="where the camera is")
    view.add_argument("--target", metavar="X,Y,Z", help="a point in the middle of the picture")
    view.add_argument("--fov-deg", type=number, metavar="DEG", help="full vertical field of view")
    view.add_argument("--near", type=number, metavar="D", help="near depth")
    view.add_argument("--far", type=number, metavar="D", help="far depth")
    view.add_argument("--light", metavar="DX,DY,DZ", help="the way a directional light travels")
    view.add_argument(
        "--size",
        metavar="WxH",
        help="pixels of the eye view (default: 1024x1024, or as many in the aspect of a library scene's camera)",
    )
    return options


def number(text: str) -> float:
    """A number, or argparse's error."""
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected a number, got {text!r}") from None


def compare_command(options: argparse.Namespace) -> int:
    """Compares techniques on a scene and writes a report: report.html, results.csv, results.json and pictures."""
    from ._core import Bias, Renderer
    from .arguments import picture_size
    from .study import compare
    from .tables import text_table

    resolutions = [r for text in options.resolution or ["1024"] for r in parse_resolutions(text)]
    specs = options.technique or list(DEFAULT_TECHNIQUES)
    techniques = {spec: technique_of(spec) for spec in specs}
    if len(techniques) < len(specs):
        raise ArgumentError("technique: the same one is given twice; give each once")
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
        techniques,
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
    for run in study.runs:
        for note in run.notes:
            print(f"{run.label} at {run.resolution}²: {note}")
    print(f"\n{study.verdict}\n\nReport: {report}")
    return 0


def matrix_command(options: argparse.Namespace) -> int:
    """Prints a technique's shadow_clip_from_world: column vectors, NDC x, y in [-1, 1], z in [0, 1], 0 at the light."""
    import json

    import numpy as np

    from .record import plain

    texts = options.resolution or ["1024"]
    resolutions = [r for text in texts for r in parse_resolutions(text)]
    if len(resolutions) != 1:
        raise ArgumentError(f"resolution: expected one number of texels, got {','.join(texts)!r}; give one")
    specs = options.technique or ["lispsm"]
    if len(specs) != 1:
        raise ArgumentError(f"technique: expected one, got {' and '.join(specs)}; ask for one matrix at a time")
    if options.out == "":
        raise ArgumentError("out: expected the name of a file, got nothing; leave --out away for standard output")
    technique = technique_of(specs[0])
    scene, camera, light, _ = load_view(options, None if options.size is None else parse_size(options.size))
    p = technique.parameterize(scene, camera, light, resolution=resolutions[0])
    matrices = np.asarray(p.matrices)
    if options.format == "npy":
        stream = io.BytesIO()
        np.save(stream, matrices[0] if len(matrices) == 1 else matrices)
        content = stream.getvalue()
    elif options.format == "json":
        data = {
            "technique": p.technique,
            "settings": dict(p.settings),
            "resolution": p.resolution,
            "matrix": matrices[0] if len(matrices) == 1 else None,
            "matrices": matrices,
            "eye_depth": [list(part.eye_depth) for part in p.partitions],
            "values": dict(p.values),
            "notes": list(p.notes),
        }
        content = (json.dumps(plain(data), indent=1, allow_nan=False, ensure_ascii=False) + "\n").encode()
    else:
        blocks = ["\n".join(" ".join(f"{x:24.17g}" for x in row) for row in m) for m in matrices]
        content = ("\n\n".join(blocks) + "\n").encode()
        for note in p.notes:
            print(f"shadowlab: note: {note}", file=sys.stderr)
    write_out(content, options.out)
    return 0


def techniques_command(_: argparse.Namespace) -> int:
    """Lists the techniques: name, title, source, lights, and each parameter with its default and range."""
    from .registry import techniques

    previous = None
    for row in techniques().to_dict("records"):
        if row["name"] != previous:
            space = "" if previous is None else "\n"
            print(f"{space}{row['name']}: {row['title']}\n  {row['source']}\n  lights: {row['lights']}")
        previous = row["name"]
        if row["parameter"]:
            unit = f" {row['unit']}" if row["unit"] else ""
            print(f"  {row['parameter']}={row['default']}{unit} ({row['range']}): {row['doc']}")
    return 0


def doctor_command(_: argparse.Namespace) -> int:
    """Says what works here, what is missing, and the command that brings it. Exit status 0 where the core works."""
    from .doctor import report

    found = report()
    print(found)
    return 0 if found.works else 1


def technique_of(spec: str) -> Any:
    """The technique of `name:param=value,...`."""
    from .registry import technique

    name, params = parse_spec(spec, "technique")
    return technique(name, **params)


def load_view(options: argparse.Namespace, size: tuple[int, int] | None) -> tuple[Any, Any, Any, Any]:
    """Scene, camera, light and where the scene came from; without a size the camera of the library keeps its aspect."""
    from . import library
    from .arguments import picture_size
    from .reproduce import Source
    from .scenes import load_scene
    from .views import default_view

    given = given_vectors(options)
    aspect = 1.0 if size is None else size[0] / size[1]
    if options.scene.startswith("@"):
        if options.up != "y":
            raise ArgumentError("up: scenes of the library have y up; leave --up away")
        name, params = parse_spec(options.scene[1:], "scene")
        scene: Any = library.scene(name, **params)
        camera, light = scene.camera, scene.light
        if size is None:
            width, height = picture_size(camera.aspect)
            aspect = width / height  # that of the picture, so that its pixels are square
        whole = scene.with_ground() if options.ground else scene
    else:
        scene = load_scene(options.scene, up=options.up)
        whole = scene.with_ground() if options.ground else scene
        # The floor is twelve times as wide as the object: the picture frames the object.
        camera, light = default_view(whole, aspect=aspect, focus=scene)
    extra = (*(("--up", options.up) if options.up != "y" else ()), *(("--ground",) if options.ground else ()))
    source = replace(Source.of_scene(whole), arguments=(options.scene, *extra), up=options.up)
    return whole, chosen_camera(options, given, camera, whole, aspect), chosen_light(given, light), source


def given_vectors(options: argparse.Namespace) -> dict[str, Any]:
    """Eye, target and light as given, in the world's axes."""
    from .scenes import turned

    names = [name for name in ("eye", "target", "light") if getattr(options, name) is not None]
    return {name: turned(parse_vector(getattr(options, name), name), up=options.up) for name in names}


def chosen_camera(options: argparse.Namespace, given: dict[str, Any], fitting: Any, scene: Any, aspect: float) -> Any:
    """The fitting camera with everything that was given in its place."""
    import numpy as np

    from ._core import Camera
    from .views import INSIDE_DEPTH_RATIO, fitting_depths

    eye = given.get("eye", fitting.eye)
    middle = np.asarray(scene.bounds).mean(axis=0) if "eye" in given else fitting.eye + fitting.far * fitting.forward
    target = given.get("target", middle)
    near, far = fitting.near, fitting.far
    ahead = np.asarray(target) - np.asarray(eye)
    length = float(np.linalg.norm(ahead))
    if given.keys() & {"eye", "target"} and np.isfinite(length) and length > 0:
        near, far = fitting_depths(scene, eye, ahead / length)
    if options.far is not None:
        far = options.far
        # A far plane before the fitting near plane still leaves a picture; one that is no distance is said as it is.
        near = min(near, far / INSIDE_DEPTH_RATIO) if far > 0 else near
    near = near if options.near is None else options.near
    if options.fov_deg is not None and not 0 < options.fov_deg < 180:
        raise ArgumentError(f"fov-deg: expected degrees above 0 and below 180, got {options.fov_deg:g}; try 50")
    fov_y = fitting.fov_y if options.fov_deg is None else float(np.radians(options.fov_deg))
    # Straight down or up there is no horizon to level; the top of the picture is then -z, as on a map.
    vertical = length > 0 and np.hypot(ahead[0], ahead[2]) <= 1e-6 * length
    return Camera.look_at(
        eye, target, up=(0, 0, -1) if vertical else (0, 1, 0), fov_y=fov_y, aspect=aspect, near=near, far=far
    )


def chosen_light(given: dict[str, Any], fitting: Any) -> Any:
    """The light that was given, or the fitting one."""
    from ._core import DirectionalLight

    return DirectionalLight(given["light"]) if "light" in given else fitting


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


def write_out(content: bytes, path: str | None) -> None:
    """The bytes to a file or to standard output."""
    if path is None:
        sys.stdout.flush()
        sys.stdout.buffer.write(content)
        sys.stdout.buffer.flush()
        return
    try:
        Path(path).write_bytes(content)
    except OSError as error:
        raise ArgumentError(f"out: cannot write {path!r} ({error.strerror or error}); choose another file") from error


if __name__ == "__main__":
    sys.exit(main())
