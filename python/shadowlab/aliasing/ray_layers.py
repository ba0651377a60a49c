r"""What a map stores of one ray of its light: the surface that is met first, or what follows from those behind it.

      light      front: a    back: b, the first whose outer side is averted    second: b
        |        midpoint: half way from a to b    dual: that, at most so many texels behind a
      __a__
     |  b__|
   _____|_____

Source: theory.md 13, by rays where renderers rasterise. The twin of what the core follows for `causes`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .. import _core
from ..trace import first_hit
from .pixel_surface import AGAIN, Met

if TYPE_CHECKING:
    from ..types import Vector
    from .map_rays import MapRays

# The part of a texel by which the size of one is measured for the limit of dual layers, which is a derivative.
LIMIT_PART = 1e-3


class RayLayers(NamedTuple):
    """What a map stores of a ray.

    Attributes
    ----------
    height : float
        From a point of the ray towards the light to the stored depth, world units; minus infinity where none is stored.
    surfaces : tuple of Met
        What the depth comes from: one triangle, or of `midpoint` and `dual` the first and the second, if there is one.
    first : Met or None
        What light meets first; None where that is nothing.
    passed : tuple of (float, Met)
        Of `back`, the surfaces before that one with their heights: where one of them and an averted one lie in each
        other, as a box that stands on another, the ray names the one of the lower number.
    """

    height: float
    surfaces: tuple[Met, ...]
    first: Met | None
    passed: tuple[tuple[float, Met], ...] = ()


NO_LAYERS = RayLayers(-np.inf, (), None)


def ray_layers(scene: _core.Scene, rays: MapRays, at: Vector | None) -> RayLayers:
    """What a map stores of the ray through a point, relative to the origin of its rays; nothing of no point."""
    if at is None:
        return NO_LAYERS
    to_light, start, stored = rays.to_light(at), rays.start(at), rays.stored

    def below(height: float) -> tuple[float, Met] | None:
        """What light meets first from a height on, within the map's depths."""
        begin = at + rays.origin + height * to_light
        t, triangle, instance = first_hit(scene, begin[None], -to_light[None])
        if triangle[0] < 0:
            return None
        place, way = begin - t[0] * to_light, start - height + float(t[0])
        z = rays.z(place - rays.origin)
        # What lies beyond the far plane is not drawn.
        if z is None or z >= 1.0:
            return None
        return start - way, Met(int(instance[0]), int(triangle[0]), place, way)

    found = below(start)
    if found is None:
        return NO_LAYERS
    height, first = found
    if stored.surface == "front":
        return RayLayers(height, (first,), first)
    if stored.surface == "back":
        size = float(np.linalg.norm(np.ptp(np.asarray(scene.bounds), axis=0)))
        step = AGAIN * (size + float(np.linalg.norm(rays.origin)))
        passed = []
        while found is not None and not is_averted(scene, found[1], to_light):
            passed.append(found)
            found = below(found[0] - step)
        if found is None:
            return RayLayers(-np.inf, (), first, tuple(passed))
        return RayLayers(found[0], (found[1],), first, tuple(passed))
    second = below(height - rays.same_depth(first.point - rays.origin))
    if second is None and stored.surface != "dual":
        return RayLayers(-np.inf, (), first)
    if second is not None and stored.surface == "second":
        return RayLayers(second[0], (second[1],), first)
    half = np.inf if second is None else 0.5 * (height - second[0])
    if stored.surface == "dual":
        half = min(half, stored.limit * max(rays.texel_sides(first.point - rays.origin, LIMIT_PART)))
    surfaces = (first,) if second is None else (first, second[1])
    # Moved beyond the map's depths it is none.
    depth = rays.depth(at + (height - half) * to_light) if np.isfinite(half) else None
    return RayLayers(-np.inf if depth is None or depth >= 1.0 else height - half, surfaces, first)


def is_averted(scene: _core.Scene, met: Met, to_light: Vector) -> bool:
    """Whether the outer side of a triangle, by its mesh's winding however that is placed, is averted from the light."""
    corners = _core.face_corners(scene, met.instance, met.triangle)
    if corners is None:
        return False
    a, b, c = corners
    return bool(np.cross(b - a, c - a) @ to_light < 0.0)
