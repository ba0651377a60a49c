r"""The bias that a plane needs: what its depth gains over the reach of a filter, in the unit of each part of `Bias`.

Source: theory.md (13.2), (13.9) for linear depth, and (13.1) for what a depth is in world units. The gain is taken at
the corners of the reach, so that it is exact under a post-warp, too. On a plane depth is a quotient of affine functions
of x and t, with t = y of the map, or t = 1 / w where a logarithm of w replaces y; projective depth is affine itself.

```
      light          what a texel stores is the plane's depth at its centre c; a receiver p of the same texel is
        \  \         compared with it. The gain is the depth of p less that of the farthest centre that is read.
         p--\--
             c\-___
```
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .map_geometry import along_knots, slopes_along_knots, ways_to_light

if TYPE_CHECKING:
    from ..types import BiasPart, Filter, Light

Reals: TypeAlias = NDArray[np.float64]


class PlanePoints(NamedTuple):
    """Points of surfaces: world positions, unit normals on either side, and unit vectors to the light, (N, 3) each."""

    position: Reals
    normal: Reals
    to_light: Reals


def plane_bias(
    gbuffer: _core.GBuffer, camera: _core.Camera, light: Light, parameterization: _core.Parameterization,
    chosen: NDArray[np.int16], where: NDArray[np.bool_], part: BiasPart, bias: _core.Bias, resolution: tuple[int, int],
    filter: Filter, stored: _core.Stored,
) -> Reals:  # fmt: skip
    """The least value of one part of a bias that leaves no acne on the plane of each pixel of `where`, (N,).

    `chosen` is the map that each pixel asks; pixels without one need 0. The other parts are those of `bias`, whose
    limit of the slope part is not counted. Infinite where this part cannot do it: where a plane is seen edge on by the
    light, and of `slope` where a plane gains less than the rounding of its depth. Of maps that store the front.
    """
    where = where & (chosen >= 0)
    found = np.zeros(np.count_nonzero(where))
    position, normal, map_of = gbuffer.position[where], gbuffer.normal[where].astype(np.float64), chosen[where]
    to_light = ways_to_light(light, position)
    reach = _core.filter_reach(gbuffer, camera, light, parameterization, resolution=resolution, filter=filter)[where]
    measures = _core.depth_rows(parameterization, (0.0, 0.0, 0.0), stored)
    for k, partition in enumerate(parameterization.partitions):
        of = map_of == k
        if of.any():
            seen = PlanePoints(position[of], normal[of], to_light[of])
            found[of] = _of_map(partition, measures[k], seen, part, bias, resolution, reach[of], stored)
    return found


def _of_map(
    partition: _core.Partition, measure: Reals, of: PlanePoints, part: BiasPart, bias: _core.Bias,
    resolution: tuple[int, int], reach_texels: Reals, stored: _core.Stored,
) -> Reals:  # fmt: skip
    rows = partition.matrix.copy()
    w_row = rows[3]
    if partition.post_warp == "log":
        rows[1] = 0.0, 0.0, 0.0, 1.0
    clip = of.position @ rows[:, :3].T + rows[:, 3]
    w = clip[:, 3]
    x, t = (clip[:, :2] / w[:, None]).T
    # Depth is a quotient of two affine functions of the point, z / w where it is projective.
    over, under = (of.position @ measure[:, :3].T + measure[:, 3]).T
    z = over / under
    # Of both along the way to the light.
    over_rise, under_rise = (of.to_light @ measure[:, :3].T).T

    def gradient(i: int, value: Reals) -> Reals:
        step: Reals = (rows[i, :3] - value[:, None] * w_row[:3]) / w[:, None]
        return step

    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        grad_x, grad_t = gradient(0, x), gradient(1, t)
        grad_z = (measure[0, :3] - z[:, None] * measure[1, :3]) / under[:, None]
        volume = _triple(grad_x, grad_t, of.normal)

        def on_plane(grad: Reals) -> tuple[Reals, Reals]:
            """How a function of this gradient changes on the plane: grad = a grad_x + b grad_t + c normal."""
            return _triple(grad, grad_t, of.normal) / volume, -_triple(grad, grad_x, of.normal) / volume

        # (13.9): a plane's depth changes by a quotient, whose divisor is 1 where depth is projective.
        divisor = measure[1, :3] / under[:, None] - w_row[:3] / w[:, None]
        steps = _reach(partition, x, t, resolution, reach_texels)
        gain = _largest_fall(on_plane(grad_z), on_plane(divisor), *steps)
        gain = np.where(np.isfinite(gain), np.maximum(gain, 0.0), np.inf)
        # A depth is rounded nearer to the light by half a step at most; single precision is that of the rasteriser.
        rounded = 0.5 * _core.depth_steps(stored, np.clip(z, 0.0, 1.0)) if stored.format != "f32" else np.zeros_like(z)

        def way(depth: Reals) -> Reals:
            """How far along the ray depth becomes this."""
            found: Reals = (depth * under - over) / (over_rise - depth * under_rise)
            return found

        def moved(shift: Reals) -> Reals:
            """What a way along the ray takes off the depth."""
            less: Reals = z - (over + shift * over_rise) / (under + shift * under_rise)
            return less

        texel = np.zeros_like(w)
        if part == "texels" or bias.texels != 0.0 or bias.normal != 0.0:
            texel = _texel_size(partition, x, t, grad_x, grad_t, of.to_light, resolution)
        along, off, times = bias.world + bias.texels * texel, bias.ndc, bias.slope + bias.plane
        # Moved along the normal by so much and back along the plane, which gains nothing, it is moved along the ray.
        facing = np.abs(np.einsum("ij,ij->i", of.normal, of.to_light))
        along = along + np.divide(bias.normal * texel, facing, out=np.zeros_like(texel), where=facing > 0.0)
        if part == "slope":
            needed = (gain * (1.0 - bias.plane) + rounded - moved(along) - off) / gain
        elif part == "ndc":
            needed = gain * (1.0 - times) + rounded - moved(along)
        elif part == "world":
            needed = way(z - gain * (1.0 - times) - rounded + off) - (along - bias.world)
        else:
            needed = (way(z - gain * (1.0 - times) - rounded + off) - (along - bias.texels * texel)) / texel
    # A plane across the ray gains nothing and needs nothing; what has no finite answer needs more than there is.
    least: Reals = np.where(gain + rounded > 0.0, np.where(np.isnan(needed), np.inf, np.maximum(needed, 0.0)), 0.0)
    return least


def _triple(a: Reals, b: Reals, c: Reals) -> Reals:
    product: Reals = np.einsum("ij,ij->i", np.cross(a, b), c)
    return product


def _largest_fall(
    slopes: tuple[Reals, Reals], divisors: tuple[Reals, Reals], steps_x: tuple[Reals, Reals],
    steps_t: tuple[Reals, Reals],
) -> Reals:  # fmt: skip
    """The most that depth on a plane falls within the reach: a quotient of affine functions is least at a corner.

    Infinite where a corner lies beyond the plane's horizon.
    """
    falls = []
    for dx in steps_x:
        for dt in steps_t:
            divisor = 1.0 + divisors[0] * dx + divisors[1] * dt
            falls.append(np.where(divisor > 0.0, -(slopes[0] * dx + slopes[1] * dt) / divisor, np.inf))
    fall: Reals = np.max(falls, axis=0)
    return fall


def _reach(
    partition: _core.Partition, x: Reals, t: Reals, resolution: tuple[int, int], reach_texels: Reals
) -> tuple[tuple[Reals, Reals], tuple[Reals, Reals]]:
    """Steps of x and of t to both ends of the filter's reach."""
    half_x, half_y = 2.0 * reach_texels[:, 0] / resolution[0], 2.0 * reach_texels[:, 1] / resolution[1]
    if partition.post_warp == "log":
        # y = scale ln w + offset: a step of y multiplies t = 1 / w.
        rate = half_y / partition.post_warp_terms["scale"]
        return _even(half_x), (t * np.expm1(-rate), t * np.expm1(rate))
    knots = partition.post_warp_knots
    if knots is None:
        return _even(half_x), _even(half_y)
    return _uneven(knots[0], x, half_x), _uneven(knots[1], t, half_y)


def _even(half: Reals) -> tuple[Reals, Reals]:
    return -half, half


def _uneven(knots: Reals, at: Reals, half: Reals) -> tuple[Reals, Reals]:
    """Steps before an ascending piecewise linear function that lead a step of `half` down and up after it."""
    place, back = along_knots(knots, at), knots[:, ::-1]
    return along_knots(back, place - half) - at, along_knots(back, place + half) - at


def _texel_size(
    partition: _core.Partition, x: Reals, t: Reals, grad_x: Reals, grad_t: Reals, to_light: Reals,
    resolution: tuple[int, int],
) -> Reals:  # fmt: skip
    """World size of a texel across the ray, the longer side of its parallelogram; 0 where it has none."""
    of_x, of_t = np.full_like(x, 0.5 * resolution[0]), np.full_like(t, 0.5 * resolution[1])
    if partition.post_warp == "log":
        of_t = of_t * np.abs(partition.post_warp_terms["scale"]) / t  # dy / dt
    elif (knots := partition.post_warp_knots) is not None:
        of_x, of_t = (of * slopes_along_knots(pair, at) for of, pair, at in ((of_x, knots[0], x), (of_t, knots[1], t)))
    grad_x, grad_t = grad_x * of_x[:, None], grad_t * of_t[:, None]
    longer = np.maximum(
        np.linalg.norm(np.cross(grad_x, to_light), axis=1), np.linalg.norm(np.cross(grad_t, to_light), axis=1)
    )
    volume = np.abs(_triple(grad_x, grad_t, to_light))
    size: Reals = np.divide(longer, volume, out=np.zeros_like(longer), where=volume > 0.0)
    return size
