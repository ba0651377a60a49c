"""What maps are made of, for points relative to an origin: rows, rays to the light, and what follows the matrix.

In double precision. Knots (N, 2) are those of `Partition.post_warp_knots`: a function linear between and beyond them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .._core import Partition
    from ..types import Light, Vector


def rows_about(partition: Partition, origin: Vector) -> Vector:
    """(4, 4): shadow clip from points relative to an origin."""
    shift = np.eye(4)
    shift[:3, 3] = origin
    return np.asarray(partition.matrix, np.float64) @ shift


def ways_to_light(light: Light, points: Vector) -> Vector:
    """(..., 3): unit vectors from points of the world (..., 3) to a light; zero at the light."""
    at = np.asarray(light.point, np.float64)
    way: Vector = at[:3] - at[3] * points
    length = np.linalg.norm(way, axis=-1, keepdims=True)
    unit: Vector = np.divide(way, length, out=np.zeros_like(way), where=length > 0.0)
    return unit


def along_knots(knots: Vector, at: Vector) -> Vector:
    """The function at places (...,)."""
    i = _piece(knots, at)
    (x, y), (next_x, next_y) = knots[i].T, knots[i + 1].T
    value: Vector = y + (at - x) * ((next_y - y) / (next_x - x))
    return value


def slopes_along_knots(knots: Vector, at: Vector) -> Vector:
    """Its derivative at places (...,)."""
    slopes: Vector = (np.diff(knots[:, 1]) / np.diff(knots[:, 0]))[_piece(knots, at)]
    return slopes


def _piece(knots: Vector, at: Vector) -> NDArray[np.intp]:
    """The knot that a place comes after, but for those beyond the outer ones."""
    return np.searchsorted(knots[1:-1, 0], at, side="right")
