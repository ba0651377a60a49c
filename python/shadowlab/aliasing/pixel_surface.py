"""What one pixel sees, and what the ray from there to the light meets: truth's side of an explanation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .. import _core
from ..trace import first_hit
from ..travel import Value

if TYPE_CHECKING:
    from ..types import Light, Vector

# Rays that begin again behind the surface that they start on: its neighbours at a corner, no more.
MOST_STARTS = 8
# How far a ray begins again behind what it met, as a share of the scene's size: above double precision, below single.
AGAIN = 2.0**-40


@dataclass(frozen=True, eq=False)
class Met(Value):
    """A triangle that a ray meets.

    Attributes
    ----------
    instance, triangle : int
        Index of the instance, and row of its mesh's face array.
    point : (3,) float64
        Where, world.
    distance : float
        From the beginning of the ray, world units.
    """

    instance: int
    triangle: int
    point: Vector
    distance: float


@dataclass(frozen=True, eq=False)
class PixelSurface(Value):
    """The surface that a pixel sees.

    Attributes
    ----------
    point : (3,) float64
        The point that is looked up in the map, world: the G-buffer's.
    normal : (3,) float64
        Unit geometric normal on the side of the eye.
    instance, triangle : int
        Index of the instance, and row of its mesh's face array.
    eye_depth : float
        Depth along the view, world units.
    to_light : (3,) float64
        Unit vector to the light.
    light_cosine : float
        Of the angle between normal and the way to the light; 0 or less faces away.
    faces_light : bool
        Whether light could arrive: it faces the light, and lies within its cone and range.
    """

    point: Vector
    normal: Vector
    instance: int
    triangle: int
    eye_depth: float
    to_light: Vector
    light_cosine: float
    faces_light: bool


def pixel_surface(
    gbuffer: _core.GBuffer, camera: _core.Camera, light: Light, pixel: tuple[int, int], faces_light: bool
) -> PixelSurface | None:
    """The surface at a pixel (column, row) of a G-buffer; None where it shows nothing."""
    one = gbuffer.crop(*pixel, 1, 1)
    triangle = int(one.triangle[0, 0])
    if triangle < 0:
        return None
    point = np.asarray(one.origin, np.float64) + np.asarray(one.position_relative[0, 0], np.float64)
    normal = np.asarray(one.normal[0, 0], np.float64)
    way = way_to_light(light, point)
    length = float(np.linalg.norm(way))
    to_light = way / length if length > 0 else np.zeros(3)
    depth = float(camera.depth(point[None])[0])
    cosine = float(normal @ to_light)
    return PixelSurface(
        point, normal, int(one.instance[0, 0]), triangle, depth, to_light, cosine, faces_light
    )  # fmt: skip


def way_to_light(light: Light, point: Vector) -> Vector:
    """(3,): from a point to a placed light, or the unit vector towards one at infinity."""
    of_light = np.asarray(light.point, np.float64)
    way: Vector = of_light[:3] - of_light[3] * point
    return way


def met_on_the_way(
    scene: _core.Scene,
    camera: _core.Camera,
    light: Light,
    surface: PixelSurface,
    pixel: tuple[int, int],
    size: tuple[int, int],
) -> Met | None:
    """What the ray from a pixel's surface to the light meets first; None where nothing is in the way.

    The ray begins where the camera's ray meets the surface, in double precision, as truth's does; the surface itself
    is not in its own way.
    """
    origins, directions = camera.rays(np.array([pixel], np.float64) + 0.5, size)
    t, triangle, instance = first_hit(scene, origins, directions)
    own = (surface.instance, surface.triangle)
    begin = origins[0] + t[0] * directions[0] if (int(instance[0]), int(triangle[0])) == own else surface.point
    way = way_to_light(light, begin)
    placed = float(np.asarray(light.point)[3]) != 0
    length = float(np.linalg.norm(way))
    if length == 0:
        return None
    step = AGAIN * float(np.ptp(np.asarray(scene.bounds), axis=0).max())
    unit, start = way / length, 0.0
    for _ in range(MOST_STARTS):
        found = first_hit(scene, (begin + start * unit)[None], unit[None])
        distance, hit = start + float(found[0][0]), (int(found[2][0]), int(found[1][0]))
        if hit[0] < 0 or (placed and distance >= length):
            return None
        if hit != own:
            return Met(*hit, begin + distance * unit, distance)
        start = distance + step
    return None
