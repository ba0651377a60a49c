"""What `compare` was given, checked before any work: each error names the parameter, what came, and what to do."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from ..errors import ArgumentError, ShadowlabWarning
from ..scene.source import Source
from ..text.arrays import checked_items
from ..text.checked import a_light
from ..text.checks import (
    check_bias,
    check_camera,
    check_filter,
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
    single = isinstance(value, (int, float, np.generic))
    given = [value] if single else checked_items("resolution", value, "a whole number or several", "try 1024")
    found = [whole("resolution", r) for r in given]
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


def checked_source(source: object) -> Source | None:
    """Where a scene came from, or None.

    Raises
    ------
    ArgumentError
        For something else.
    """
    if source is not None and not isinstance(source, Source):
        raise ArgumentError(
            f"source: expected a Source or None, got {type(source).__name__}; sl.Source(name) makes one"
        )
    return source


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
    a_light(
        "light", light, "sl.evaluate(sl.View(scene, camera, lights), technique) adds up their wrong pixels, and "
        "sl.advise(scene, camera, lights) ranks over all of them"
    )  # fmt: skip
    check_bias(bias)
    check_filter(filter)
