"""What `compare` was given, checked before any work: each error names the parameter, what came, and what to do."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable
from fractions import Fraction
from typing import Any

import numpy as np

from ..checks import check_filter, whole
from ..errors import ArgumentError, ShadowlabWarning
from ..text import shown

# Pixels of a picture whose size nobody chose.
PICTURE_PIXELS = 1024 * 1024
# The largest denominator of an aspect that counts as a ratio of small whole numbers (16:9, 21:9, 64:27).
LARGEST_RATIO_PART = 64
# A picture stretched by more than this share looks wrong, and its pixels are no squares of the view any more.
LARGEST_STRETCH = 0.01


def pair(name: str, value: Any) -> tuple[Any, Any]:
    """The value as two things."""
    try:
        first, second = value
    except (TypeError, ValueError):
        raise ArgumentError(f"{name}: expected (width, height), got {shown(value)}; try (1024, 1024)") from None
    return first, second


def resolutions_of(value: Any) -> list[int]:
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


def size_of(value: Any, camera: Any) -> tuple[int, int]:
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


def picture_size(aspect: float, pixels: int = PICTURE_PIXELS) -> tuple[int, int]:
    """Width and height of about this many pixels for a camera's aspect.

    Exactly of this aspect where it is a ratio of small whole numbers (1360 x 765 for 16:9), else rounded to whole
    pixels.
    """
    ratio = Fraction(aspect).limit_denominator(LARGEST_RATIO_PART)
    if ratio > 0 and abs(float(ratio) - aspect) <= 4 * np.finfo(np.float64).eps * aspect:
        times = round(math.sqrt(pixels / (ratio.numerator * ratio.denominator)))
        if times > 0:
            return times * ratio.numerator, times * ratio.denominator
    return max(1, round(math.sqrt(pixels * aspect))), max(1, round(math.sqrt(pixels / aspect)))


def check_types(scene: Any, camera: Any, light: Any, bias: Any, filter: Any) -> None:
    """Raises for a scene, camera, light, bias or filter that is none.

    Raises
    ------
    ArgumentError
        For another type.
    UnknownNameError
        For a filter that does not exist.
    """
    from .. import _core

    if not isinstance(scene, _core.Scene):
        raise ArgumentError(f"scene: expected a Scene, got {type(scene).__name__}; {scene_hint(scene)}")
    if not isinstance(camera, _core.Camera):
        raise ArgumentError(f"camera: expected a Camera, got {type(camera).__name__}; sl.Camera.look_at makes one")
    if not isinstance(light, (_core.DirectionalLight, _core.SpotLight, _core.PointLight)):
        raise ArgumentError(
            f"light: expected a DirectionalLight, a SpotLight or a PointLight, got {type(light).__name__}; "
            "sl.DirectionalLight((0.3, -1, 0.1)) travels along that vector"
        )
    if bias is not None and not isinstance(bias, _core.Bias):
        raise ArgumentError(f"bias: expected a Bias, got {type(bias).__name__}; try sl.Bias(world=0.01)")
    check_filter(filter)


def scene_hint(value: Any) -> str:
    """How to make a scene of this."""
    if type(value).__module__.partition(".")[0] == "trimesh":
        return "sl.Scene.from_trimesh(it) makes one"
    if isinstance(value, str) or hasattr(value, "__fspath__"):
        return "sl.load_scene(it) reads a file, sl.library.scene(it) builds one of the library"
    return "sl.load_scene, sl.Scene.from_trimesh and sl.Scene.from_arrays make one"


def renderer_of(value: Any) -> Any:
    """The renderer that is meant: one that is given, one by its name, or the best there is for None."""
    from .._core import Renderer

    if value is None:
        return Renderer()
    if isinstance(value, str):
        return Renderer(value)
    if all(hasattr(value, name) for name in ("gbuffer", "shadow_map", "shadow_mask", "backend", "adapter")):
        return value
    raise ArgumentError(
        f'renderer: expected a Renderer, "cpu", "gpu" or "auto", got {type(value).__name__}; sl.Renderer() takes the '
        "best there is"
    )
