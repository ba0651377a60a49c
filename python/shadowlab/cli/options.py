"""The options that several commands share, each declared once, and what they mean."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click import Choice

from ..errors import ArgumentError
from ..text import BIAS, bias_of, parse_resolutions, parse_size
from ..text.checks import BACKENDS, FILTERS, UP_AXES, VIEWS
from .command import Argument, Option, number
from .names import filter_names, scene_names, technique_names

if TYPE_CHECKING:
    from .._core import Bias
    from .command import Options

VIEW_SECTION = "View, in the file's axes; what is not given is chosen to fit the scene"


def scene_argument(required: bool = True) -> Argument:
    """The scene: what compare, advise, explain, matrix and diagnose share."""
    return Argument(
        "scene", metavar="MESH|@LIBRARY" if required else "[MESH|@LIBRARY]", required=required,
        shell_complete=scene_names, help="a mesh file, or a scene of the library such as @forest:trees=500",
    )  # fmt: skip


def view_options() -> list[Option]:
    """Camera and a light, in the axes of the file."""
    of_view = partial(Option, section=VIEW_SECTION)
    return [
        of_view("--up", type=Choice(UP_AXES), help="the file's up axis (default: as a COLLADA file says, else y)"),
        of_view("--ground", is_flag=True, help="add a floor under the scene"),
        of_view(
            "--view",
            type=Choice(VIEWS),
            help="which of the views that are chosen for a scene: along it at eye level, from above, or along it "
            "against the light (default: along; a scene of the library has a view of its own)",
        ),
        of_view("--camera", metavar="NAME", help="a camera of the file, by its name"),
        of_view("--eye", metavar="X,Y,Z", help="where the camera is"),
        of_view("--target", metavar="X,Y,Z", help="a point in the middle of the picture"),
        of_view("--fov-deg", type=number, metavar="DEG", help="full vertical field of view"),
        of_view("--ortho-height", type=number, metavar="D", help="an orthographic camera, its picture this high"),
        of_view("--shift", metavar="X,Y", help="the picture's middle beside the view axis, in half widths and heights"),
        of_view("--near", type=number, metavar="D", help="near depth"),
        of_view("--far", type=number, metavar="D", help="far depth; inf for none"),
        of_view("--light-position", metavar="X,Y,Z", help="where a point light is, or a spot"),
        of_view("--cone-deg", type=number, metavar="DEG", help="full angle of a spot's cone"),
        of_view("--range", type=number, metavar="D", help="how far a point light or a spot reaches"),
        of_view(
            "--size",
            metavar="WxH",
            help="pixels of the eye view (default: 1360x765, or as many in the aspect of a library scene's camera)",
        ),
    ]


def one_light(_ctx: click.Context, _option: click.Parameter, texts: Sequence[str]) -> str | None:
    """The light that is given, None without any: click would take the last of several without a word.

    Raises
    ------
    ArgumentError
        For several.
    """
    if len(texts) > 1:
        raise ArgumentError(
            f"light: expected one --light, got {len(texts)}; shadowlab advise ranks over all of them, other commands "
            "take one each"
        )
    return texts[0] if texts else None


def light_option() -> Option:
    """The one light of a view."""
    return Option(
        "--light", section=VIEW_SECTION, metavar="DX,DY,DZ|NAME", multiple=True, callback=one_light,
        help="the way a directional light or the middle of a spot travels, or a light of the file, by its name",
    )  # fmt: skip


def technique_option(help: str) -> Option:
    """The techniques, which may be repeated; `help` says how they are given and what the default is."""
    return Option(
        "--technique", multiple=True, metavar="NAME[:param=value,...]", shell_complete=technique_names, help=help
    )


def resolution_option(help: str, *, metavar: str = "N") -> Option:
    """The texels of a map; `help` says of which."""
    return Option("--resolution", multiple=True, metavar=metavar, help=f"{help} (default: 1024)")


def backend_option() -> Option:
    """Who draws the maps."""
    return Option("--backend", default="auto", type=Choice(BACKENDS), help="the renderer (default: auto)")


def lookup_options() -> list[Option]:
    """Who draws the maps, what they store and how they are read."""
    return [
        backend_option(),
        Option(
            "--filter",
            default="nearest",
            metavar="NAME[:setting=value,...]",
            shell_complete=filter_names,
            help=f"how maps are read: {', '.join(FILTERS)}, such as pcf:size=3 or tent:size=3px (default: nearest)",
        ),
        Option(
            "--bias",
            metavar="NAME=VALUE,...",
            help=f"what is taken off the depth before it is compared: {', '.join(BIAS)}",
        ),
        Option(
            "--blend",
            type=number,
            default=0.0,
            metavar="SHARE",
            help="the last share of each map's range over which the next map is mixed in, 0 to 1 (default: 0)",
        ),
        Option(
            "--stored",
            metavar="SURFACE:NAME=VALUE,...",
            help="what maps store, such as back:spacing=linear,format=unorm16 (default: front)",
        ),
    ]


def directory_option(default: str, what: str) -> Option:
    """The directory of results."""
    return Option(
        "--out", default=default, metavar="DIR", type=click.Path(),
        help=f"where {what} go (default: {default})",
    )  # fmt: skip


def size_given(options: Options) -> tuple[int, int] | None:
    """Width and height of the picture; None where none are given."""
    return None if options.size is None else parse_size(options.size)


def bias_given(options: Options) -> Bias | None:
    """The bias; None where none is given."""
    return None if options.bias is None else bias_of(options.bias)


def lookup_given(options: Options) -> dict[str, Any]:
    """How maps are read and what they store, as keyword arguments."""
    from ..text.checks import check_filter, checked_blend, checked_stored

    bias = bias_given(options)
    check_filter(options.filter)
    blend, stored = checked_blend(options.blend), checked_stored(options.stored)
    return {"bias": bias, "filter": options.filter, "blend": blend, "stored": stored}


def resolution_texts(options: Options) -> list[str]:
    """The texts of numbers of texels, or that of the default."""
    return options.resolution or ["1024"]


def resolutions_given(options: Options) -> list[int]:
    """All numbers of texels."""
    return [texels for text in resolution_texts(options) for texels in parse_resolutions(text)]


def one_resolution(options: Options) -> int:
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
        raise ArgumentError(f"{name}: expected the name of a file, got nothing; name one, or leave --{name} away")
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
        raise ArgumentError("out: expected the name of a directory, got nothing; name one, or leave --out away")
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
