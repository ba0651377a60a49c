"""Checks of single arguments: each error names the parameter, what came, and what to do."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, cast, get_args

import numpy as np

from .. import _core
from ..errors import ArgumentError, UnknownNameError
from ..types import Backend, Up, ViewName
from .arrays import checked_items, checked_number
from .checked import a_light, has_all
from .words import shown

if TYPE_CHECKING:
    from ..types import RendererLike

FILTERS: tuple[str, ...] = tuple(name for name, *_ in _core.filter_kinds())
# Another name of "bilinear".
PCF_2X2 = "pcf2x2"
BACKENDS: tuple[Backend, ...] = get_args(Backend)
UP_AXES: tuple[Up, ...] = get_args(Up)
VIEWS: tuple[ViewName, ...] = get_args(ViewName)
# Pixels of a picture whose size nobody chose.
PICTURE_PIXELS = 1024 * 1024
# The largest denominator of an aspect that counts as a ratio of small whole numbers (16:9, 21:9, 64:27).
LARGEST_RATIO_PART = 64


def whole(name: str, value: object) -> int:
    """The value as an int above 0.

    Raises
    ------
    ArgumentError
        For anything else.
    """
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)) or not value > 0:
        raise ArgumentError(f"{name}: expected a whole number above 0, got {shown(value)}; 1024 is a good start")
    if value >= 1 << 63:
        raise ArgumentError(f"{name}: expected a whole number of 64 bits, got {shown(value)}; 1024 is a good start")
    return int(value)


def check_filter(filter: object) -> None:
    """Raises for a filter that is none.

    Raises
    ------
    ArgumentError
        For another type, and for settings that are missing or out of their limits.
    UnknownNameError
        For a filter or a setting that does not exist.
    """
    if not isinstance(filter, str):
        raise ArgumentError(f"filter: expected one of {', '.join(FILTERS)}, got {type(filter).__name__}")
    name = filter.partition(":")[0].strip()
    if name not in (*FILTERS, PCF_2X2):
        raise UnknownNameError(f"filter: unknown filter {shown(name)}; expected one of {', '.join(FILTERS)}")
    _core.filter_text(filter)


def checked_stored(stored: object) -> _core.Stored:
    """What a map stores: a `Stored`, the one that a text says, or the plain one for None.

    Raises
    ------
    ArgumentError
        For another type, and a text that does not read.
    UnknownNameError
        For a surface, spacing or format that does not exist.
    """
    if stored is None:
        return _core.Stored()
    if isinstance(stored, str):
        try:
            return _core.Stored(stored)
        except (ArgumentError, UnknownNameError) as error:
            said = str(error)
            raise type(error)(said if said.startswith("stored") else f"stored: {said}") from None
    if isinstance(stored, _core.Stored):
        return stored
    raise ArgumentError(
        f'stored: expected a Stored or its text, got {type(stored).__name__}; try "back:spacing=linear,format=unorm16"'
    )


def checked_blend(blend: object, name: str = "blend") -> float:
    """The share over which maps blend, as a number; `name` is that of the argument.

    Raises
    ------
    ArgumentError
        For anything but a number from 0 to 1.
    """
    fix = "0.1 blends over the last tenth of each map's range"
    share = checked_number(name, blend, fix, "a number from 0 to 1")
    if not 0.0 <= share <= 1.0:
        raise ArgumentError(f"{name}: expected a number from 0 to 1, got {share}; {fix}")
    return share


def check_scene(scene: object) -> None:
    """Raises unless it is a scene.

    Raises
    ------
    ArgumentError
        For something else.
    """
    if not isinstance(scene, _core.Scene):
        raise ArgumentError(f"scene: expected a Scene, got {type(scene).__name__}; {scene_hint(scene)}")


def scene_hint(value: object) -> str:
    """How to make a scene of this."""
    if str(type(value).__module__).partition(".")[0] == "trimesh":
        return "sl.Scene.from_trimesh(it) makes one"
    if isinstance(value, (str, os.PathLike)):
        return "sl.load_scene(it) reads a file, sl.library.scene(it) builds one of the library"
    return "sl.load_scene, sl.Scene.from_trimesh and sl.Scene.from_arrays make one"


def check_camera(camera: object) -> None:
    """Raises unless it is a camera.

    Raises
    ------
    ArgumentError
        For something else.
    """
    if not isinstance(camera, _core.Camera):
        raise ArgumentError(f"camera: expected a Camera, got {type(camera).__name__}; sl.Camera.look_at makes one")


def check_light(light: object) -> None:
    """Raises unless it is a light.

    Raises
    ------
    ArgumentError
        For something else.
    """
    a_light("light", light)


def check_bias(bias: object) -> None:
    """Raises unless it is a bias or None.

    Raises
    ------
    ArgumentError
        For something else.
    """
    if bias is not None and not isinstance(bias, _core.Bias):
        raise ArgumentError(f"bias: expected a Bias, got {type(bias).__name__}; try sl.Bias(world=0.01)")


def renderer_of(value: object) -> RendererLike:
    """The renderer that is meant: one that is given, one by its name, or the best there is for None."""
    if value is None:
        return _core.Renderer()
    if isinstance(value, str):
        if value not in BACKENDS:
            raise UnknownNameError(f"renderer: unknown renderer {shown(value)}; expected one of {', '.join(BACKENDS)}")
        return _core.Renderer(value)
    if isinstance(value, _core.Renderer):
        return value
    draws = has_all(value, "gbuffer", "shadow_map", "shadow_mask", "backend", "adapter")
    if draws and all(isinstance(getattr(value, name), str) for name in ("backend", "adapter")):
        return cast("RendererLike", value)
    raise ArgumentError(
        f'renderer: expected a Renderer, "cpu", "gpu" or "auto", got {type(value).__name__}; sl.Renderer() takes the '
        "best there is"
    )


def pair(name: str, value: object) -> tuple[object, object]:
    """The value as two things."""
    both = checked_items(name, value, "(width, height)", "try (1024, 1024)")
    if len(both) != 2 or isinstance(value, (set, frozenset, Mapping)):
        raise ArgumentError(f"{name}: expected (width, height), got {shown(value)}; try (1024, 1024)")
    return both[0], both[1]


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


def picture_of(value: object, camera: _core.Camera) -> tuple[int, int]:
    """Width and height of a picture: as given, of a side, or for None about 1024 * 1024 square pixels.

    Raises
    ------
    ArgumentError
        For anything but whole numbers above 0.
    """
    if value is None:
        return picture_size(camera.aspect)
    if isinstance(value, (int, float, np.generic)):
        side = whole("size", value)
        return side, side
    width, height = pair("size", value)
    return whole("size", width), whole("size", height)
