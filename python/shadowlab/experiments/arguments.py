"""What `compare` was given, checked before any work: each error names the parameter, what came, and what to do."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from typing import TYPE_CHECKING

from ..errors import ArgumentError, ShadowlabWarning
from ..text import shown
from ..text.checks import (
    check_bias,
    check_camera,
    check_filter,
    check_light,
    check_scene,
    pair,
    picture_size,
    whole,
)

if TYPE_CHECKING:
    from .._core import Camera

# A picture stretched by more than this share looks wrong, and its pixels are no squares of the view any more.
LARGEST_STRETCH = 0.01


def resolutions_of(value: object) -> list[int]:
    """The resolutions of a study, in order, none twice."""
    if isinstance(value, str):
        raise ArgumentError(f"resolution: expected a whole number or several, got {shown(value)}; try 1024")
    found = [whole("resolution", r) for r in (value if isinstance(value, Iterable) else [value])]
    if not found:
        raise ArgumentError("resolution: expected at least one number of texels, got none; 1024 is a good start")
    for texels in found:
        if found.count(texels) > 1:
            raise ArgumentError(f"resolution: {texels} comes twice; give each once")
    return found


def size_of(value: object, camera: Camera) -> tuple[int, int]:
    """Width and height of the eye view; chosen for the camera where none is given. Warns where it stretches."""
    if value is None:
        return picture_size(camera.aspect)
    width, height = (whole("size", s) for s in pair("size", value))
    if abs(width / height / camera.aspect - 1) > LARGEST_STRETCH:
        better = picture_size(camera.aspect, width * height)
        warnings.warn(
            f"size: {width} x {height} stretches the picture of a camera of aspect {camera.aspect:.4g}; "
            f"{better[0]} x {better[1]} has square pixels",
            ShadowlabWarning,
            stacklevel=3,
        )
    return width, height


def check_types(scene: object, camera: object, light: object, bias: object, filter: object) -> None:
    """Raises for a scene, camera, light, bias or filter that is none.

    Raises
    ------
    ArgumentError
        For another type.
    UnknownNameError
        For a filter that does not exist.
    """
    check_scene(scene)
    check_camera(camera)
    check_light(light)
    check_bias(bias)
    check_filter(filter)
