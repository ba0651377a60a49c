"""The procedural scenes: seeded, no files, each with a camera and a light that show what it is for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

from .. import _core
from ..errors import ArgumentError
from ..text import parse_spec, shown
from ..text.arrays import checked_number
from .scenes import Scene

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["LibraryScene", "names", "scene", "table"]


class LibraryScene(Scene):
    """A scene of the library, with the camera and the light to start with.

    Attributes
    ----------
    camera : Camera
    light : DirectionalLight or SpotLight
    """

    camera: _core.Camera
    light: _core.DirectionalLight | _core.SpotLight | _core.PointLight


def names() -> list[str]:
    """The names of the library's scenes."""
    return [spec["name"] for spec in _core.library_specs()]


def scene(name: str, *, seed: int = 1, **params: float) -> LibraryScene:
    """The library scene of that name.

    Parameters
    ----------
    name : str
        One of `names()`.
    seed : int
        0 or more; equal seeds give equal scenes.
    **params : float
        As `table()` lists them.

    Raises
    ------
    UnknownNameError
        No such scene or parameter.
    ArgumentError
        A value outside its range.
    """
    if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed < 2**64:
        raise ArgumentError(f"seed: expected a whole number from 0 to 2**64 - 1, got {shown(seed)}; choose another one")
    given = [(key, checked_number(key, value, "see shadowlab.library.table()")) for key, value in params.items()]
    core, camera, light = _core.library_build(name, seed, given)
    built = LibraryScene(core)
    parts = [f"seed={seed}"] * (seed != 1) + [f"{k}={int(v) if v.is_integer() else v!r}" for k, v in given]
    settings = ",".join(parts)
    built.source = f"@{name}" + (f":{settings}" if settings else "")
    keywords = "".join(f", {k}={v!r}" for k, v in [("seed", seed), *params.items()])
    built.recipe = f"sl.library.scene({name!r}{keywords})"
    built.camera, built.light = camera, light
    return built


def scene_of_spec(text: str) -> LibraryScene:
    """The library scene of a text such as "@forest:trees=500".

    Raises
    ------
    ArgumentError, UnknownNameError
        As `scene`, and for a text that does not read.
    """
    name, params = parse_spec(text.removeprefix("@"), "scene")
    return scene(name, **cast("dict[str, Any]", params))


def table() -> pd.DataFrame:
    """One row a scene: name, title, what it shows, parameters."""
    import pandas as pd

    def describe(p: dict[str, Any]) -> str:
        return f"{p['name']}={p['default']:g} ({p['min']:g} to {p['max']:g}: {p['doc']})"

    rows = [
        {
            "name": s["name"],
            "title": s["title"],
            "shows": s["shows"],
            "parameters": "; ".join(map(describe, s["params"])),
        }
        for s in _core.library_specs()
    ]
    return pd.DataFrame(rows, columns=["name", "title", "shows", "parameters"])
