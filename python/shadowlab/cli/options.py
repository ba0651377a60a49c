"""The options that several commands share, each declared once, and what they mean."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from ..errors import ArgumentError
from ..text import BIAS, bias_of, parse_resolutions, parse_size
from ..text.checks import BACKENDS, FILTERS, UP_AXES, VIEWS

if TYPE_CHECKING:
    from .._core import Bias

#: What a command adds itself to.
Commands: TypeAlias = "argparse._SubParsersAction[Any]"


def view_options(options: argparse.ArgumentParser, optional: bool = False) -> None:
    """Adds scene, camera and light: what compare, advise, explain, matrix and diagnose share."""
    options.add_argument(
        "scene",
        metavar="MESH|@LIBRARY",
        nargs="?" if optional else None,
        help="a mesh file, or a scene of the library such as @forest:trees=500",
    )
    view = options.add_argument_group("view", "In the file's axes. What is not given is chosen to fit the scene.")
    view.add_argument("--up", choices=UP_AXES, help="the file's up axis (default: as a COLLADA file says, else y)")
    view.add_argument("--ground", action="store_true", help="add a floor under the scene")
    view.add_argument(
        "--view",
        choices=VIEWS,
        help="which of the views that are chosen for a scene: along it at eye level, from above, or along it against "
        "the light (default: along; a scene of the library has a view of its own)",
    )
    view.add_argument("--camera", metavar="NAME", help="a camera of the file, by its name")
    view.add_argument("--eye", metavar="X,Y,Z", help="where the camera is")
    view.add_argument("--target", metavar="X,Y,Z", help="a point in the middle of the picture")
    view.add_argument("--fov-deg", type=number, metavar="DEG", help="full vertical field of view")
    view.add_argument("--ortho-height", type=number, metavar="D", help="an orthographic camera, its picture this high")
    view.add_argument(
        "--shift", metavar="X,Y", help="the picture's middle beside the view axis, in half widths and heights"
    )
    view.add_argument("--near", type=number, metavar="D", help="near depth")
    view.add_argument("--far", type=number, metavar="D", help="far depth; inf for none")
    view.add_argument(
        "--light",
        metavar="DX,DY,DZ|NAME",
        help="the way a directional light or the middle of a spot travels, or a light of the file, by its name",
    )
    view.add_argument("--light-position", metavar="X,Y,Z", help="where a point light is, or a spot")
    view.add_argument("--cone-deg", type=number, metavar="DEG", help="full angle of a spot's cone")
    view.add_argument("--range", type=number, metavar="D", help="how far a point light or a spot reaches")
    view.add_argument(
        "--size",
        metavar="WxH",
        help="pixels of the eye view (default: 1360x765, or as many in the aspect of a library scene's camera)",
    )


def technique_option(options: argparse.ArgumentParser, help: str) -> None:
    """Adds the techniques, which may be repeated; `help` says how they are given and what the default is."""
    options.add_argument("--technique", action="append", metavar="NAME[:param=value,...]", help=help)


def resolution_option(
    options: argparse.ArgumentParser, help: str, *, action: str = "append", metavar: str = "N"
) -> None:
    """Adds the texels of a map; `help` says of which."""
    options.add_argument("--resolution", action=action, metavar=metavar, help=f"{help} (default: 1024)")


def lookup_options(options: argparse.ArgumentParser) -> None:
    """Adds who draws the maps, what they store and how they are read."""
    options.add_argument("--backend", default="auto", choices=BACKENDS, help="the renderer (default: auto)")
    options.add_argument(
        "--filter",
        default="nearest",
        metavar="NAME[:setting=value,...]",
        help=f"how maps are read: {', '.join(FILTERS)}, such as pcf:size=3 or tent:size=3px (default: nearest)",
    )
    options.add_argument(
        "--bias",
        metavar="NAME=VALUE,...",
        help=f"what is taken off the depth before it is compared: {', '.join(BIAS)}",
    )
    options.add_argument(
        "--blend",
        type=number,
        default=0.0,
        metavar="SHARE",
        help="the last share of each map's range over which the next map is mixed in, 0 to 1 (default: 0)",
    )
    options.add_argument(
        "--stored",
        metavar="SURFACE:NAME=VALUE,...",
        help="what maps store, such as back:spacing=linear,format=unorm16 (default: front)",
    )


def directory_option(options: argparse.ArgumentParser, default: str, what: str) -> None:
    """Adds the directory of results."""
    options.add_argument("--out", default=default, metavar="DIR", help=f"where {what} go (default: {default})")


def number(text: str) -> float:
    """A number, or argparse's error."""
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected a number, got {text!r}") from None


def size_given(options: argparse.Namespace) -> tuple[int, int] | None:
    """Width and height of the picture; None where none are given."""
    return None if options.size is None else parse_size(options.size)


def bias_given(options: argparse.Namespace) -> Bias | None:
    """The bias; None where none is given."""
    return None if options.bias is None else bias_of(options.bias)


def lookup_given(options: argparse.Namespace) -> dict[str, Any]:
    """How maps are read and what they store, as keyword arguments."""
    from ..text.checks import check_filter, checked_blend, checked_stored

    bias = bias_given(options)
    check_filter(options.filter)
    blend, stored = checked_blend(options.blend), checked_stored(options.stored)
    return {"bias": bias, "filter": options.filter, "blend": blend, "stored": stored}


def resolution_texts(options: argparse.Namespace) -> list[str]:
    """The texts of numbers of texels, or that of the default."""
    given = "1024" if options.resolution is None else options.resolution
    return [given] if isinstance(given, str) else list(given)


def resolutions_given(options: argparse.Namespace) -> list[int]:
    """All numbers of texels."""
    return [texels for text in resolution_texts(options) for texels in parse_resolutions(text)]


def one_resolution(options: argparse.Namespace) -> int:
    """The only number of texels.

    Raises
    ------
    ArgumentError
        For several.
    """
    resolutions = resolutions_given(options)
    if len(resolutions) != 1:
        texts = ",".join(resolution_texts(options))
        raise ArgumentError(f"resolution: expected one number of texels, got {texts!r}; give one")
    return resolutions[0]


def check_once(name: str, texts: Sequence[str]) -> None:
    """Raises for a text that is given twice.

    Raises
    ------
    ArgumentError
    """
    for text in texts:
        if texts.count(text) > 1:
            raise ArgumentError(f"{name}: {text!r} is given twice; give it once")


def writable_file(name: str, path: str) -> Path:
    """The file, tried before long work; one that is there stays as it is, and its directory is made.

    Raises
    ------
    ArgumentError
        Where it cannot be written; `name` is the option.
    """
    if not path:
        raise ArgumentError(f"{name}: expected the name of a file, got nothing; try --{name} study.npz")
    file = Path(path)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        there = file.exists()
        with file.open("ab"):
            pass
        if not there:
            file.unlink()
    except OSError as error:
        raise ArgumentError(
            f"{name}: cannot write {path!r} ({error.strerror or error}); choose another file"
        ) from error
    return file


def writable_directory(path: str) -> Path:
    """The directory, made, and tried before long work.

    Raises
    ------
    ArgumentError
        Where it cannot be written.
    """
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
