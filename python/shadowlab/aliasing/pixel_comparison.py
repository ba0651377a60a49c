"""The comparison of one pixel with its map: the reference depth, each part of the bias, and what each texel says."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor
from typing import TYPE_CHECKING

import numpy as np

from .. import _core
from ..text import BIAS
from ..travel import Value
from .codes import NoTexel

if TYPE_CHECKING:
    import numpy.typing as npt

    from ..types import Filter, Light, ShadowMaps, Vector
    from .map_rays import MapRays
    from .pixel_surface import PixelSurface
    from .pixel_texel import Held

# What limits a part of a bias and moves nothing by itself.
BIAS_LIMITS = ("slope_limit",)
BIAS_PARTS = tuple(name for name in BIAS if name not in BIAS_LIMITS)
# The largest value of parts that have one.
MOST_OF_PART = {"plane": 1.0}
# Texels along each axis that a filter reads.
FILTER_SIDES: dict[Filter, int] = {"nearest": 1, "pcf2x2": 2}


@dataclass(frozen=True, eq=False)
class BiasShare(Value):
    """What one part of a bias does at a pixel.

    Attributes
    ----------
    name : str
        "world", "texels", "ndc", "slope", "plane" or "normal".
    value : float
        In the part's own unit (docs/bias.md).
    ndc : float
        By how much it lowers the reference depth, alone.
    world : float
        How far that carries the receiver towards the light, world units.
    """

    name: str
    value: float
    ndc: float
    world: float


@dataclass(frozen=True, eq=False)
class TexelRead(Value):
    """A texel that a lookup reads.

    Attributes
    ----------
    column, row : int
        Within the map: what lies beyond the edge reads the nearest texel.
    weight : float
        Those of a lookup sum to 1.
    is_lit : bool
        Whether its depth is no nearer to the light than the reference.
    held : Held
        What it stores.
    """

    column: int
    row: int
    weight: float
    is_lit: bool
    held: Held


@dataclass(frozen=True, eq=False)
class PixelComparison(Value):
    """How a pixel is compared.

    Attributes
    ----------
    unbiased : float or None
        Reference depth without bias, NDC.
    reference : float or None
        Reference depth with all of the bias, NDC. None where the pixel is lit without a look at the map: it lies before
        the near plane, or the bias carries it there or past the light.
    bias_world : float
        How far all of the bias carries the receiver towards the light, world units.
    shortfall : float or None
        How much further towards the light the receiver would have to be carried for the texel that it falls into to
        light it, world units; negative: how much less would still do. None without a reference and of an empty texel.
    parts : tuple of BiasShare
        What each part does alone.
    reads : tuple of TexelRead
        The texels that are read, in rows from the top.
    light : float
        Share of the light that arrives by this comparison, 0 to 1.
    """

    unbiased: float | None
    reference: float | None
    bias_world: float
    shortfall: float | None
    parts: tuple[BiasShare, ...]
    reads: tuple[TexelRead, ...]
    light: float


def compared_at(
    gbuffer: _core.GBuffer, camera: _core.Camera, light: Light, p: _core.Parameterization, pixel: tuple[int, int],
    resolution: int, bias: _core.Bias, filter: Filter,
) -> tuple[int, Vector, float | None]:  # fmt: skip
    """Map (or a `NoTexel`), place in texels, and reference depth of a pixel; None where it is lit without a look."""
    maps, places, depths = _core.compared(
        gbuffer, camera, light, p, np.array([pixel]), resolution=resolution, bias=bias, filter=filter
    )
    depth = float(depths[0])
    return int(maps[0]), places[0], None if np.isnan(depth) else depth


def only(bias: _core.Bias, part: str | None) -> _core.Bias:
    """One part of a bias with its limits, or no part."""
    values = {name: getattr(bias, name) if name in BIAS_LIMITS or name == part else 0.0 for name in BIAS}
    return _core.Bias(**values)


def with_part(bias: _core.Bias, part: str, value: float) -> _core.Bias:
    """The bias with another value of a part."""
    return _core.Bias(**{name: value if name == part else getattr(bias, name) for name in BIAS})


def look_up_near(
    maps: ShadowMaps, gbuffer: _core.GBuffer, camera: _core.Camera, light: Light, p: _core.Parameterization,
    corner: tuple[int, int], size: tuple[int, int], bias: _core.Bias, filter: Filter,
) -> npt.NDArray[np.float32]:  # fmt: skip
    """The light (height, width) at a rectangle of pixels through maps that are there."""
    part = gbuffer.crop(*corner, *size)
    return _core.look_up(maps, part, camera, light, p, bias=bias, filter=filter)[0]


def taps(place: Vector, filter: Filter, resolution: tuple[int, int]) -> list[tuple[int, int, float]]:
    """Column, row and weight of the texels that are read at a place, in rows from the top."""
    side = FILTER_SIDES[filter]
    shift = 0.5 * (side - 1)
    first = [floor(at - shift) for at in place]
    part = [at - shift - corner if side > 1 else 0.0 for at, corner in zip(place, first, strict=True)]
    width, height = resolution
    found = []
    for j in range(side):
        for i in range(side):
            weight = (part[0] if i else 1.0 - part[0]) * (part[1] if j else 1.0 - part[1])
            found.append((min(max(first[0] + i, 0), width - 1), min(max(first[1] + j, 0), height - 1), weight))
    return found


def is_map(index: int) -> bool:
    """Whether a number names a map, and not why there is none."""
    return index > max(NoTexel)


def bias_parts(
    gbuffer: _core.GBuffer, camera: _core.Camera, light: Light, p: _core.Parameterization, pixel: tuple[int, int],
    rays: MapRays, surface: PixelSurface, bias: _core.Bias, filter: Filter,
) -> tuple[float | None, tuple[BiasShare, ...]]:  # fmt: skip
    """Reference depth without bias, and what each part of a bias that is not 0 does alone."""

    def depth(of: _core.Bias) -> float | None:
        return compared_at(gbuffer, camera, light, p, pixel, rays.resolution[0], of, filter)[2]

    unbiased = depth(only(bias, None))
    if unbiased is None:
        return None, ()
    found = []
    for name in BIAS_PARTS:
        value = float(getattr(bias, name))
        at = depth(only(bias, name)) if value != 0 else None
        if at is not None:
            found.append(BiasShare(name, value, unbiased - at, carried(rays, surface, unbiased, at)))
    return unbiased, tuple(found)


def carried(rays: MapRays, surface: PixelSurface, unbiased: float, reference: float) -> float:
    """How far towards the light a receiver of one reference depth is carried to have another, world units."""
    point = surface.point - rays.origin
    # From what the same ray says of the unbiased depth, so that the clamp at the far plane counts as no bias.
    return rays.height(point, reference) - rays.height(point, unbiased)
