"""Cameras and lights by a pose, and moved with a scene.

A pose is world from local (4, 4): the camera or light stands at its origin, looks or shines along its -z, and has y up,
as in glTF and OpenGL.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..errors import ArgumentError

if TYPE_CHECKING:
    from ..types import Light

# How far axes may be from orthogonal and of one length, relative to it: poses of single precision and their products.
ROUNDING = 32 * float(np.finfo(np.float32).eps)


def length_scale(matrix: NDArray[np.float64]) -> float:
    """The factor by which an affine map that is a rotation, one scale and a translation changes lengths.

    Raises
    ------
    ArgumentError
        For a map that mirrors, shears or scales unevenly.
    """
    axes = matrix[:3, :3]
    scale = float(np.cbrt(abs(np.linalg.det(axes))))
    even = scale > 0 and np.abs(axes.T @ axes / scale**2 - np.eye(3)).max() <= ROUNDING
    if not even or np.linalg.det(axes) < 0:
        raise ArgumentError("its pose mirrors, shears or scales unevenly")
    return scale


def camera_at(
    pose: NDArray[np.float64],
    *,
    aspect: float,
    near: float,
    far: float,
    fov_y: float | None = None,
    height: float | None = None,
) -> _core.Camera:
    """The camera of a pose, orthographic where it has a height; near, far and height are in local units.

    Raises
    ------
    ArgumentError
        For a pose that mirrors, shears or scales unevenly, or settings outside their range.
    """
    scale = length_scale(pose)
    # Turned at the origin and moved afterwards, so that a place far away takes no digits from the direction.
    origin, forward, up = (0.0, 0.0, 0.0), -pose[:3, 2], pose[:3, 1]
    near, far = near * scale, far * scale
    if height is None:
        lens = {} if fov_y is None else {"fov_y": fov_y}
        turned = _core.Camera.look_at(origin, forward, up=up, aspect=aspect, near=near, far=far, **lens)
    else:
        turned = _core.Camera.orthographic(
            origin, forward, up=up, height=height * scale, aspect=aspect, near=near, far=far
        )
    return turned.replace(eye=pose[:3, 3])


def moved_camera(camera: _core.Camera, matrix: NDArray[np.float64]) -> _core.Camera:
    """The camera that sees the moved world as it saw the world.

    Raises
    ------
    ArgumentError
        As `length_scale`.
    """
    scale, turn = length_scale(matrix), matrix[:3, :3]
    lens = {"height": camera.height * scale} if camera.is_orthographic else {}
    return camera.replace(
        **lens,
        eye=matrix[:3, :3] @ camera.eye + matrix[:3, 3],
        forward=turn @ camera.forward,
        up=turn @ camera.up,
        near=camera.near * scale,
        far=camera.far * scale,
    )


def moved_light(light: Light, matrix: NDArray[np.float64]) -> Light:
    """The light that lights the moved world as it lit the world.

    Raises
    ------
    ArgumentError
        For a direction that the map sends to zero; for placed lights as `length_scale`.
    """
    turn = matrix[:3, :3]
    if isinstance(light, _core.DirectionalLight):
        return _core.DirectionalLight(turn @ light.direction)
    reach = light.range * length_scale(matrix)
    position = turn @ light.position + matrix[:3, 3]
    if isinstance(light, _core.PointLight):
        return _core.PointLight(position, range=reach)
    return _core.SpotLight(position, turn @ light.direction, cone_angle=light.cone_angle, range=reach)


def farthest(bounds: NDArray[np.float64], point: Any) -> float:
    """The distance from a point to the farthest corner of a box (2, 3)."""
    return float(np.linalg.norm(np.abs(bounds - np.asarray(point, np.float64)).max(axis=0)))


def unique(name: str, taken: Any) -> str:
    """The name, with a number where it is taken."""
    if name not in taken:
        return name
    # By halves: one after the other, thousands of one name would take their number squared.
    last, free = 1, 2
    while f"{name} ({free})" in taken:
        last, free = free, 2 * free
    while free - last > 1:
        middle = (last + free) // 2
        last, free = (middle, free) if f"{name} ({middle})" in taken else (last, middle)
    return f"{name} ({free})"
