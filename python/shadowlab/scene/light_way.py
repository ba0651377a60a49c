"""The way of a light, and its angles to a view and to the horizon."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .origin import SceneOrigin

if TYPE_CHECKING:
    from ..types import Light


def light_way(scene: _core.Scene | SceneOrigin, light: Light) -> NDArray[np.float64] | None:
    """The unit vector (3,) along which a light travels, of a point light towards the middle of the scene's box."""
    if not isinstance(light, _core.PointLight):
        way: NDArray[np.float64] = np.asarray(light.direction, np.float64)
        return way
    way = np.asarray(scene.bounds, np.float64).mean(axis=0) - np.asarray(light.position, np.float64)
    length = float(np.linalg.norm(way))
    return way / length if length > 0 else None


def angle_to(way: NDArray[np.float64] | None, camera: _core.Camera) -> float | None:
    """The angle between the way of a light and a view, radians; exact near 0 and pi, too."""
    if way is None:
        return None
    forward = np.asarray(camera.forward, np.float64)
    return float(math.atan2(np.linalg.norm(np.cross(way, forward)), np.dot(way, forward)))


def elevation_of(way: NDArray[np.float64] | None) -> float | None:
    """How high a light stands above the horizon, radians; y points up."""
    return None if way is None else float(math.asin(np.clip(-way[1], -1.0, 1.0)))
