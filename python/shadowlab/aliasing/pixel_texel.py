"""The texel that a pixel is compared with: the way there, its outline, and whose depth it stores."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .. import _core
from ..trace import first_hit
from ..travel import Value
from .map_rays import MapRays
from .pixel_surface import Met

if TYPE_CHECKING:
    from ..types import Vector
    from .footprint import Footprint
    from .pixel_surface import PixelSurface

# How far from a texel's centre what it stores may be met, texels: rasterisers round vertices to 1/256 of a texel.
SNAP_TEXELS = 1.0 / 128.0
ABOUT = np.array([[0.0, 0.0], [-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]]) * SNAP_TEXELS
# Two units in the last place of single precision near 1: of stored depths.
DEPTH_ROUNDING = 2.0 * float(np.finfo(np.float32).eps)
TEXEL_CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


@dataclass(frozen=True, eq=False)
class MapChain(Value):
    """The way of a point into its map, step by step: ``clip = fit @ warp @ lift @ (point, 1)``.

    Attributes
    ----------
    light_ray : (4,) float64 or None
        ``lift @ (point, 1)``: x, y and w are the light's ray through the point, z is its place along the ray. None of
        matrices from elsewhere, which have no factors.
    warped : (4,) float64 or None
        ``warp @ light_ray``: after the technique's homography.
    clip : (4,) float64
        ``matrix @ (point, 1)``: after the crop.
    projected : (3,) float64
        ``clip[:3] / clip[3]``.
    ndc : (3,) float64
        The same after a logarithm or a rectilinear warp; equal to `projected` where there is none.
    place : (2,) float64
        In texels, x to the right and y down.
    """

    light_ray: Vector | None
    warped: Vector | None
    clip: Vector
    projected: Vector
    ndc: Vector
    place: Vector


@dataclass(frozen=True, eq=False)
class PixelTexel(Value):
    """The texel that a pixel falls into.

    Attributes
    ----------
    map : int
        Index of the map.
    column, row : int
        Counted from 0, row 0 at the top.
    centre : (3,) float64 or None
        Where the ray through its centre meets the receiver's plane, world; None where that plane is seen edge on.
    corners : (4, 3) float64 or None
        The same of its corners, clockwise in the map from the upper left.
    corners_px : (4, 2) float64 or None
        Those in the picture, x to the right and y down, pixels; None also where one is not before the camera.
    size_px : (float, float) or None
        Its longest extent in the picture and that across it, pixels: `Footprint.major` and `minor`.
    size_world : (float, float)
        Lengths of its sides along the map's x and y, across the light's ray at the receiver, world units.
    """

    map: int
    column: int
    row: int
    centre: Vector | None
    corners: Vector | None
    corners_px: Vector | None
    size_px: tuple[float, float] | None
    size_world: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Held(Value):
    """What a texel stores, and whose surface that is.

    Attributes
    ----------
    depth : float
        Stored NDC depth; 1 where no caster is.
    point : (3,) float64 or None
        Where that depth is on the ray through the texel's centre, world; None of an empty texel.
    gap : float or None
        Distance, along the light ray through the texel's centre, from the receiver's plane to that point: positive
        towards the light, world units. None of an empty texel and where the plane is seen edge on.
    instance, triangle : int
        Whose triangle it is, by a ray from the light through the texel's centre; -1 where the ray meets nothing.
    ray_depth : float or None
        NDC depth at which that ray meets it; None where it meets nothing within the map's depths.
    difference : float
        From the stored depth to where rays within 1/128 of a texel about the centre meet surfaces, along the ray,
        world units: 0 where it lies among them, infinite where only one of both is empty.
    agrees : bool
        Whether the ray confirms the stored depth, up to the rounding of rasterisers.
    """

    depth: float
    point: Vector | None
    gap: float | None
    instance: int
    triangle: int
    ray_depth: float | None
    difference: float
    agrees: bool

    @property
    def is_empty(self) -> bool:
        """Whether the texel stores no caster."""
        return self.depth >= 1.0


def map_chain(rays: MapRays, surface: PixelSurface) -> MapChain:
    """The way of a pixel's point into a map."""
    part, point = rays.partition, surface.point - rays.origin
    shift = np.eye(4)
    shift[:3, 3] = rays.origin
    lifted = warped = None
    if part.lift is not None and part.warp is not None:
        lifted = np.asarray(part.lift) @ shift @ np.append(point, 1.0)
        warped = np.asarray(part.warp) @ lifted
    clip = rays.clip(point)
    return MapChain(lifted, warped, clip, clip[:3] / clip[3], rays.ndc(point), rays.place(point))


def pixel_texel(
    rays: MapRays,
    surface: PixelSurface,
    camera: _core.Camera,
    size: tuple[int, int],
    index: int,
    texel: tuple[int, int],
    extent: Footprint,
) -> PixelTexel:
    """The outline of a texel on the receiver's plane, in the world and in a picture of a size."""
    point, at = surface.point - rays.origin, np.array(texel, np.float64)
    found = [rays.on_plane(at + corner, point, surface.normal) for corner in TEXEL_CORNERS]
    corners = None if any(one is None for one in found) else np.array(found) + rays.origin
    centre = rays.on_plane(at + 0.5, point, surface.normal)
    measured = bool(extent.measured[0])
    return PixelTexel(
        index,
        *texel,
        None if centre is None else centre + rays.origin,
        corners,
        None if corners is None else in_picture(camera, corners, size),
        (float(extent.major[0]), float(extent.minor[0])) if measured else None,
        rays.texel_sides(point),
    )


def in_picture(camera: _core.Camera, points: Vector, size: tuple[int, int]) -> Vector | None:
    """Pixels (N, 2) of world points (N, 3); None where one is not before the camera."""
    # Relative to the eye, so that large coordinates lose no precision.
    eye = np.asarray(camera.eye, np.float64)
    rotation = np.asarray(camera.view, np.float64)[:3, :3]
    clip = np.column_stack([(points - eye) @ rotation.T, np.ones(len(points))]) @ np.asarray(camera.projection).T
    if not (clip[:, 3] > 0).all():
        return None
    ndc = clip[:, :2] / clip[:, 3:]
    found: Vector = np.column_stack([0.5 + 0.5 * ndc[:, 0], 0.5 - 0.5 * ndc[:, 1]]) * size
    return found


def held_by(
    scene: _core.Scene, rays: MapRays, surface: PixelSurface, texel: tuple[int, int], depth: float
) -> Held:  # fmt: skip
    """What a texel stores, and what the ray from the light through its centre says of it."""
    point, centre = surface.point - rays.origin, np.array(texel, np.float64) + 0.5
    plane = surface.normal
    if rays.on_plane(centre, point, plane) is None:
        plane = rays.to_light(point)
    heights, met = [], []
    for step in ABOUT:
        at = rays.on_plane(centre + step, point, plane)
        height, hit = _met_from_light(scene, rays, at)
        heights.append(height)
        met.append(hit)
    anchor = rays.on_plane(centre, point, plane)
    stored = None if depth >= 1.0 or anchor is None else rays.height(anchor, depth)
    gap = stored if plane is surface.normal else None
    place = None if stored is None or anchor is None else anchor + stored * rays.to_light(anchor) + rays.origin
    # Of rays about the centre, the one that meets what is stored; the centre's where it does.
    away = [_apart(height, stored) for height in heights]
    slack = _slack(rays, anchor, depth, point) if anchor is not None else 0.0
    chosen = 0 if away[0] <= slack else int(np.argmin(away))
    known = [height for height in heights if np.isfinite(height)]
    among = stored is not None and bool(known) and min(known) <= stored <= max(known)
    # A map without rays of its own confirms nothing that it stores.
    lost = anchor is None and depth < 1.0
    difference = 0.0 if among else np.inf if lost else min(away)
    hit = met[chosen]
    ray_depth = None if hit is None else rays.depth(hit.point - rays.origin)
    instance, triangle = (-1, -1) if hit is None else (hit.instance, hit.triangle)
    return Held(depth, place, gap, instance, triangle, ray_depth, difference, difference <= slack)


def _met_from_light(scene: _core.Scene, rays: MapRays, at: Vector | None) -> tuple[float, Met | None]:
    """How far from a point towards the light its ray meets the first surface within the map's depths, and which."""
    nothing = -np.inf, None
    if at is None:
        return nothing
    to_light, start = rays.to_light(at), rays.start(at)
    begin = at + rays.origin + start * to_light
    t, triangle, instance = first_hit(scene, begin[None], -to_light[None])
    if triangle[0] < 0:
        return nothing
    place = begin - t[0] * to_light
    depth = rays.depth(place - rays.origin)
    # What lies beyond the far plane is not drawn.
    if depth is None or depth >= 1.0:
        return nothing
    return start - float(t[0]), Met(int(instance[0]), int(triangle[0]), place, float(t[0]))


def _apart(height: float, stored: float | None) -> float:
    """How far apart along the ray what was met and what is stored lie; 0 where both are nothing."""
    if stored is None:
        return 0.0 if not np.isfinite(height) else np.inf
    return abs(height - stored)


def _slack(rays: MapRays, anchor: Vector, depth: float, point: Vector) -> float:
    """A difference along the ray that counts as none: rounding of depths and positions, and a part of a texel."""
    step = abs(rays.height(anchor, depth - DEPTH_ROUNDING) - rays.height(anchor, depth))
    rounding = DEPTH_ROUNDING * float(np.linalg.norm(point))
    return 2.0 * SNAP_TEXELS * max(rays.texel_sides(anchor)) + step + rounding
