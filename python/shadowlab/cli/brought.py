"""Cameras and lights that a file brings, on the command line: `--camera NAME`, `--light NAME`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from ..errors import ArgumentError, UnknownNameError
from ..scene.source import NAMED_CAMERA, NAMED_LIGHT
from ..text import parse_pair
from .command import Options

if TYPE_CHECKING:
    from .._core import Camera
    from ..scene.scenes import Scene
    from ..scene.source import Source
    from ..types import Light

T = TypeVar("T")
# What a camera's name goes with: the name says where the camera stands.
EXCLUDED = ("eye", "target", "view")
# What a light's name goes without.
OF_PLACED_LIGHTS = ("light_position", "range", "cone_deg")


def light_name(text: str | None) -> str | None:
    """The name of a light, where a text is no direction: none of its parts is a number."""
    parts = [] if text is None else text.replace(",", " ").split()
    return None if not parts or any(map(_is_float, parts)) else text


def _is_float(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def named_camera(options: Options, scene: Scene, aspect: float) -> Camera:
    """The file's camera that was named, in the picture's aspect, with the lens and depths that were given.

    Raises
    ------
    UnknownNameError
        For another name.
    ArgumentError
        For a place or a view beside it.
    """
    found = camera_named(options, scene)
    changes: dict[str, Any] = {"aspect": aspect}
    if options.fov_deg is not None:
        if not 0 < options.fov_deg < 180:
            raise ArgumentError(f"fov-deg: expected degrees above 0 and below 180, got {options.fov_deg:g}; try 50")
        from math import radians

        changes["fov_y"] = radians(options.fov_deg)
    if options.shift is not None:
        changes["shift"] = parse_pair(options.shift, "shift")
    given = {"height": options.ortho_height, "near": options.near, "far": options.far}
    changes |= {name: value for name, value in given.items() if value is not None}
    return found.replace(**changes)


def camera_named(options: Options, scene: Scene) -> Camera:
    """The file's camera as it is; errors as of `named_camera`."""
    for name in EXCLUDED:
        if getattr(options, name) is not None:
            raise ArgumentError(f"camera: expected no --{name} beside the camera of a file, got one; remove either")
    return _by_name(scene.cameras, options.camera, "camera", "--eye and --target place one")


def named_light(options: Options, scene: Scene) -> Light | None:
    """The file's light that was named; None where the text is a direction, or none was given.

    Raises
    ------
    UnknownNameError
        For another name.
    ArgumentError
        For a place, a range or a cone beside it.
    """
    name = light_name(options.light)
    if name is None:
        return None
    for other in OF_PLACED_LIGHTS:
        if getattr(options, other) is not None:
            option = other.replace("_", "-")
            raise ArgumentError(f"light: expected no --{option} beside the light of a file, got one; remove either")
    return _by_name(scene.lights, name, "light", "--light dx,dy,dz gives a direction")


def _by_name(found: Mapping[str, T], name: str, what: str, otherwise: str) -> T:
    if name not in found:
        valid = f"expected one of {', '.join(found)}" if found else f"the scene brings none: {otherwise}"
        raise UnknownNameError(f"{what}: unknown name {name!r}; {valid}")
    return found[name]


def brought_text(scene: Scene, source: Source) -> str:
    """A line with the cameras and lights of a file that were not taken; empty where it has none, or one was."""
    taken = {name for name, _ in source.given} & {NAMED_CAMERA, NAMED_LIGHT}
    if taken or not (scene.cameras or scene.lights):
        return ""
    parts = [
        f"{what}{'s' if len(names) > 1 else ''} {', '.join(names)} (--{what} NAME)"
        for what, names in (("camera", list(scene.cameras)), ("light", list(scene.lights)))
        if names
    ]
    return f"\nThe file brings {' and '.join(parts)}."
