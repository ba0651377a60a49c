"""Checks of single arguments: each error names the parameter, what came, and what to do."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import _core
from .errors import ArgumentError, UnknownNameError
from .text import shown

FILTERS = ("nearest", "pcf2x2")


def whole(name: str, value: Any) -> int:
    """The value as an int above 0.

    Raises
    ------
    ArgumentError
        For anything else.
    """
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)) or value <= 0:
        raise ArgumentError(f"{name}: expected a whole number above 0, got {shown(value)}; 1024 is a good start")
    return int(value)


def check_filter(filter: Any) -> None:
    """Raises for a filter that is none.

    Raises
    ------
    ArgumentError
        For another type.
    UnknownNameError
        For a filter that does not exist.
    """
    if not isinstance(filter, str):
        raise ArgumentError(f"filter: expected one of {', '.join(FILTERS)}, got {type(filter).__name__}")
    if filter not in FILTERS:
        raise UnknownNameError(f"filter: unknown filter {filter!r}; expected one of {', '.join(FILTERS)}")


def check_camera(camera: Any) -> None:
    """Raises unless it is a camera.

    Raises
    ------
    ArgumentError
        For something else.
    """
    if not isinstance(camera, _core.Camera):
        raise ArgumentError(f"camera: expected a Camera, got {shown(camera)}; sl.Camera.look_at(...) makes one")


def check_light(light: Any) -> None:
    """Raises unless it is a light.

    Raises
    ------
    ArgumentError
        For something else.
    """
    if not isinstance(light, (_core.DirectionalLight, _core.SpotLight, _core.PointLight)):
        raise ArgumentError(
            f"light: expected a DirectionalLight, a SpotLight or a PointLight, got {shown(light)}; "
            "sl.DirectionalLight((0.3, -1, 0.1)) travels along that vector"
        )
