"""What a texel holds: its depth, where that is on the ray through its centre, and whose surface it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .. import _core
from ..travel import Value
from .map_rays import DEPTH_ROUNDING
from .ray_layers import RayLayers, ray_layers

if TYPE_CHECKING:
    from ..types import Vector
    from .map_rays import MapRays
    from .pixel_surface import Met, PixelSurface

# How far from a texel's centre what it stores may be met, texels: rasterisers round vertices to 1/256 of a texel.
SNAP_TEXELS = 1.0 / 128.0
ABOUT = np.array([[0.0, 0.0], [-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]]) * SNAP_TEXELS


@dataclass(frozen=True, eq=False)
class Held(Value):
    """What a texel stores, and whose surface that is.

    Attributes
    ----------
    depth : float
        The stored number, in the units of what the map stores; 1 where no caster is stored.
    point : (3,) float64 or None
        Where that depth is on the ray through the texel's centre, world; None of an empty texel.
    gap : float or None
        Distance, along the light ray through the texel's centre, from the receiver's plane to that point: positive
        towards the light, world units. None of an empty texel and where the plane is seen edge on.
    step : float
        One step of the map's format there, world units along the ray; 0 of an empty texel.
    surfaces : tuple of Met
        The triangles that the depth comes from, by a ray from the light through the texel's centre: of `front`, `back`
        and `second` the one whose depth is stored; of `midpoint` and `dual` the first and the second that light meets,
        between which it lies. Empty where nothing is stored of the ray.
    first : Met or None
        What light meets first on that ray, stored or not; None where it meets nothing.
    first_gap : float or None
        `gap` of that.
    ray_depth : float or None
        The depth that the ray gives, in the same units, before it is rounded to the format; None where it gives none.
    difference : float
        From the stored depth to what rays within 1/128 of a texel about the centre give, along the ray, world units: 0
        where it lies among them, infinite where only one of both is empty.
    agrees : bool
        Whether the ray confirms the stored depth, up to the rounding of rasterisers and of the format.
    """

    depth: float
    point: Vector | None
    gap: float | None
    step: float
    surfaces: tuple[Met, ...]
    first: Met | None
    first_gap: float | None
    ray_depth: float | None
    difference: float
    agrees: bool

    @property
    def is_empty(self) -> bool:
        """Whether the texel stores no caster."""
        return self.depth >= 1.0

    @property
    def instance(self) -> int:
        """Instance of the first of `surfaces`; -1 where there is none."""
        return self.surfaces[0].instance if self.surfaces else -1

    @property
    def triangle(self) -> int:
        """Triangle of the first of `surfaces`, a row of its mesh's face array; -1 where there is none."""
        return self.surfaces[0].triangle if self.surfaces else -1


def held_by(scene: _core.Scene, rays: MapRays, surface: PixelSurface, texel: tuple[int, int], depth: float) -> Held:
    """What a texel stores, and what the ray from the light through its centre says of it."""
    point, centre = surface.point - rays.origin, np.array(texel, np.float64) + 0.5
    plane = surface.normal
    if rays.on_plane(centre, point, plane) is None:
        plane = rays.to_light(point)
    places = [rays.on_plane(centre + step, point, plane) for step in ABOUT]
    found = [ray_layers(scene, rays, at) for at in places]
    anchor = places[0]
    stored = None if depth >= 1.0 or anchor is None else rays.height(anchor, depth)
    step, slack = _step_and_slack(rays, anchor, min(depth, 1.0), point)
    if stored is not None:
        found = [_coincident(of, stored, slack) for of in found]
    # Of rays about the centre, the one that gives what is stored; the centre's where it does.
    away = [_apart(rays, at, of, stored) for at, of in zip(places, found, strict=True)]
    chosen = 0 if away[0] <= slack else int(np.argmin(away))
    known = [of.height for of in found if np.isfinite(of.height)]
    among = stored is not None and bool(known) and min(known) <= stored <= max(known)
    # A map without rays of its own confirms nothing that it stores.
    lost = anchor is None and depth < 1.0
    difference = 0.0 if among else np.inf if lost else min(away)
    own, at = found[chosen], places[chosen]
    on_plane = plane is surface.normal and anchor is not None
    first_gap = None
    if on_plane and at is not None and own.first is not None:
        first_gap = float((own.first.point - rays.origin - at) @ rays.to_light(at))
    ray_depth = None
    if at is not None and np.isfinite(own.height):
        ray_depth = rays.depth(at + own.height * rays.to_light(at))
    return Held(
        depth,
        None if stored is None or anchor is None else anchor + stored * rays.to_light(anchor) + rays.origin,
        stored if on_plane else None,
        0.0 if stored is None else step,
        own.surfaces if np.isfinite(own.height) else (),
        own.first,
        first_gap,
        ray_depth,
        difference,
        difference <= slack,
    )


def _coincident(of: RayLayers, stored: float, slack: float) -> RayLayers:
    """What a ray gives, or the surface before it that lies where something is stored: an averted one lies in it."""
    lies = [(height, met) for height, met in of.passed if abs(height - stored) <= slack < abs(of.height - stored)]
    return of._replace(height=lies[0][0], surfaces=(lies[0][1],)) if lies else of


def _apart(rays: MapRays, at: Vector | None, of: RayLayers, stored: float | None) -> float:
    """How far apart along a ray what it gives and what is stored lie; 0 where both are nothing, or rounded to it."""
    if stored is not None:
        return abs(of.height - stored)
    if at is None or not np.isfinite(of.height):
        return 0.0
    depth = rays.depth(at + of.height * rays.to_light(at))
    ends = depth is not None and depth + float(_core.depth_steps(rays.stored, np.array([depth]))[0]) >= 1.0
    return 0.0 if ends else np.inf


def _step_and_slack(rays: MapRays, anchor: Vector | None, depth: float, point: Vector) -> tuple[float, float]:
    """One step of the format along the ray, and a difference that counts as none.

    That is the rounding of depths and positions, and a part of a texel.
    """
    if anchor is None:
        return 0.0, 0.0
    own = float(_core.depth_steps(rays.stored, np.array([depth]))[0])
    here = rays.height(anchor, depth)
    step = abs(rays.height(anchor, depth - own) - here)
    single = abs(rays.height(anchor, depth - DEPTH_ROUNDING) - here)
    rounding = DEPTH_ROUNDING * float(np.linalg.norm(point))
    return step, 2.0 * SNAP_TEXELS * max(rays.texel_sides(anchor)) + max(step, single) + rounding
