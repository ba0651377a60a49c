"""The texel that a pixel is compared with: the way there, and its outline."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .. import _core
from ..travel import Value

if TYPE_CHECKING:
    from ..types import Vector
    from .footprint import Footprint
    from .map_rays import MapRays
    from .pixel_surface import PixelSurface

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
