"""The frames of a path: a scene, a camera and a light each, any of which may stay the same."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from .. import _core
from ..errors import ArgumentError
from ..text.arrays import checked_items
from ..text.checked import LIGHTS
from ..text.checks import check_scene

if TYPE_CHECKING:
    from .._core import Camera, Scene
    from ..types import Light

#: What a path is made of, what one of it is, and what makes one.
_KINDS: dict[str, tuple[Any, str, str]] = {
    "cameras": (_core.Camera, "camera", "sl.Camera.look_at(eye, target) makes one"),
    "scene": (_core.Scene, "scene", "scene.with_transforms(indices, matrices) makes one"),
    "light": (LIGHTS, "light", "sl.DirectionalLight((0.3, -1, 0.1)) makes one"),
}


def checked_frames(scene: object, cameras: object, light: object) -> tuple[list[Scene], list[Camera], list[Light]]:
    """Scenes, cameras and lights, one of each per frame; items are not looked at.

    Raises
    ------
    ArgumentError
        For less than two frames, and sequences of different lengths.
    """
    given: dict[str, Any] = {"cameras": cameras, "scene": scene, "light": light}
    several = {name: _items(name, value) for name, value in given.items() if not isinstance(value, _KINDS[name][0])}
    if not several:
        raise ArgumentError(
            "cameras: expected at least two cameras, or two scenes or lights beside one camera, got one of each; "
            f"{_KINDS['cameras'][2]}"
        )
    first, count = next((name, len(items)) for name, items in several.items())
    if count < 2:
        raise ArgumentError(f"{first}: expected at least two, one per frame, got {count}; {_KINDS[first][2]}")
    for name, items in several.items():
        if len(items) != count:
            one = _KINDS[name][1]
            raise ArgumentError(
                f"{name}: expected one {one}, or {count}, one per frame as of {first}, got {len(items)}; give as many"
            )
    found = [several[name] if name in several else [given[name]] * count for name in ("scene", "cameras", "light")]
    return found[0], found[1], found[2]


def _items(name: str, value: object) -> list[Any]:
    if name == "scene" and not isinstance(value, Iterable):
        check_scene(value)
    _, one, fix = _KINDS[name]
    expected = f"one {one}, or at least two, one per frame"
    if isinstance(value, Mapping):
        raise ArgumentError(f"{name}: expected {expected}, got a {type(value).__name__}; give a list of its values")
    return checked_items(name, value, expected, fix)


def check_instances(scenes: list[Scene]) -> None:
    """Raises unless all scenes have the instances of the first, in whatever places.

    Raises
    ------
    ArgumentError
        For a scene with other meshes, or other instances of them.
    """
    first = scenes[0]
    for i, scene in enumerate(scenes):
        if scene is not first and not _core.same_instances(first, scene):
            of = f"{scene.instance_count:,} instances of {scene.mesh_count:,} meshes"
            raise ArgumentError(
                f"scene[{i}]: expected the meshes and instances of scene[0], which move, got others ({of}); make them "
                "with scene[0].with_transforms(indices, matrices)"
            )
