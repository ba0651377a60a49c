"""Transforms of COLLADA's nodes.

Source: COLLADA 1.5.0, chapter 5, the elements lookat, matrix, rotate, scale, skew and translate.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...errors import LoadError
from .parts import Matrix
from .xml import floats, local

_COUNTS = {"lookat": 9, "matrix": 16, "rotate": 4, "scale": 3, "skew": 7, "translate": 3}


def node_matrix(name: str, node: Any) -> Matrix:
    """parent_from_node of a node: its transforms in their order.

    Raises
    ------
    LoadError
        For another count of numbers than the transform has, and for a direction without length.
    """
    matrix = np.eye(4)
    for element in node:
        kind = local(element)
        if kind in _COUNTS:
            values = floats(name, element.text, kind, _COUNTS[kind])
            with np.errstate(all="ignore"):
                step = _MADE[kind](values)
            if not np.isfinite(step).all():
                raise LoadError(
                    f"{name}: expected a finite {kind} with directions that have a length, got {values.tolist()}"
                )
            matrix = matrix @ step
    return matrix


def _matrix(values: Matrix) -> Matrix:
    return values.reshape(4, 4)


def _translate(values: Matrix) -> Matrix:
    made = np.eye(4)
    made[:3, 3] = values
    return made


def _scale(values: Matrix) -> Matrix:
    return np.diag([*values, 1.0])


def _turn(axis: Matrix, degrees: float) -> Matrix:
    """A rotation about an axis, after Rodrigues."""
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.radians(degrees)
    made = np.eye(4)
    made[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)
    return made


def _rotate(values: Matrix) -> Matrix:
    if values[3] == 0:
        return np.eye(4)  # exporters write an axis of zeros for no rotation
    return _turn(values[:3], float(values[3]))


def _lookat(values: Matrix) -> Matrix:
    eye, target, up = values.reshape(3, 3)
    back = (eye - target) / np.linalg.norm(eye - target)
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    made = np.eye(4)
    made[:3] = np.stack([right, np.cross(back, right), back, eye], axis=1)
    return made


def _skew(values: Matrix) -> Matrix:
    """RenderMan's skew: turns `along` by an angle towards itself from `axis`, in their plane."""
    angle, axis, along = np.radians(values[0]), values[1:4], values[4:7]
    along = along / np.linalg.norm(along)
    across = axis - (axis @ along) * along
    across /= np.linalg.norm(across)
    inclined = np.arctan2(axis @ along, axis @ across)
    made = np.eye(4)
    made[:3, :3] += (np.tan(inclined + angle) - np.tan(inclined)) * np.outer(along, across)
    return made


_MADE = {
    "lookat": _lookat,
    "matrix": _matrix,
    "rotate": _rotate,
    "scale": _scale,
    "skew": _skew,
    "translate": _translate,
}
