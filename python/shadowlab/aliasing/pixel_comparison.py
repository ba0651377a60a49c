"""The comparison of one pixel with its map: the reference depth, each part of the bias, and what each texel says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .. import _core
from ..travel import Value
from .bias_parts import BIAS_PARTS, only
from .codes import NoTexel

if TYPE_CHECKING:
    import numpy.typing as npt

    from ..types import Filter, Light, ShadowMaps
    from .map_rays import MapRays
    from .pixel_held import Held
    from .pixel_surface import PixelSurface


@dataclass(frozen=True, eq=False)
class BiasShare(Value):
    """What one part of a bias does at a pixel.

    Attributes
    ----------
    name : str
        One of `BIAS_PARTS`.
    value : float
        In the part's own unit (docs/bias.md).
    ndc : float
        By how much it lowers the reference depth, alone, in the units of what the map stores.
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
    reference : float or None
        The reference depth that it is compared with, in the units of what the map stores: under `Bias.plane` each texel
        has its own. None where the pixel is lit without a look at the map.
    is_lit : bool
        Whether its depth is no nearer to the light than the reference.
    held : Held
        What it stores.
    """

    column: int
    row: int
    weight: float
    reference: float | None
    is_lit: bool
    held: Held


@dataclass(frozen=True, eq=False)
class PixelComparison(Value):
    """How a pixel is compared.

    Attributes
    ----------
    unbiased : float or None
        Reference depth without bias, in the units of what the map stores.
    reference : float or None
        The same with all of the bias, at the texel that the pixel falls into. None where the pixel is lit
        without a look at the map: it lies before the near plane, or the bias carries it there or past the light.
    bias_world : float
        How far all of the bias carries the receiver towards the light, world units.
    shortfall : float or None
        How much further towards the light the receiver would have to be carried for the texel that it falls into to
        light it, world units; negative: how much less would still do. None without a reference and of an empty texel.
    parts : tuple of BiasShare
        What each part does alone.
    reads : tuple of TexelRead
        The texels that the filter's kernel reads, in rows from the top; of a disc, as its points come.
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


class Compared(NamedTuple):
    """What a pixel is compared with.

    Attributes
    ----------
    map : int
        Index of its map, or a `NoTexel`.
    reference : float or None
        Reference depth at the texel that it falls into; None where it is lit without a look.
    taps : list of (int, int, float, float or None)
        Column, row, weight and reference depth of each texel that is read.
    """

    map: int
    reference: float | None
    taps: list[tuple[int, int, float, float | None]]


def compared_at(
    gbuffer: _core.GBuffer, camera: _core.Camera, light: Light, p: _core.Parameterization, pixel: tuple[int, int],
    resolution: int, bias: _core.Bias, filter: Filter, stored: _core.Stored, asked: int | None = None,
) -> Compared:  # fmt: skip
    """What one pixel is compared with, in the map that it chooses or in one that is `asked`."""
    maps, _, depths, texels, weights, own = _core.compared(
        gbuffer, camera, light, p, np.array([pixel]), resolution=resolution, bias=bias, filter=filter, stored=stored,
        map=asked,
    )  # fmt: skip
    taps = [
        (int(column), int(row), float(weight), _known(depth))
        for (column, row), weight, depth in zip(texels[0], weights[0], own[0], strict=True)
        if weight > 0.0
    ]
    return Compared(int(maps[0]), _known(depths[0]), taps)


def _known(depth: float) -> float | None:
    return None if np.isnan(depth) else float(depth)


def look_up_near(
    maps: ShadowMaps, gbuffer: _core.GBuffer, camera: _core.Camera, light: Light, p: _core.Parameterization,
    corner: tuple[int, int], size: tuple[int, int], bias: _core.Bias, filter: Filter, blend: float,
    stored: _core.Stored,
) -> npt.NDArray[np.float32]:  # fmt: skip
    """The light (height, width) at a rectangle of pixels through maps that are there."""
    part = gbuffer.crop(*corner, *size)
    return _core.look_up(maps, part, camera, light, p, bias=bias, filter=filter, blend=blend, stored=stored)[0]


def is_map(index: int) -> bool:
    """Whether a number names a map, and not why there is none."""
    return index > max(NoTexel)


def bias_parts(
    gbuffer: _core.GBuffer, camera: _core.Camera, light: Light, p: _core.Parameterization, pixel: tuple[int, int],
    index: int, rays: MapRays, surface: PixelSurface, bias: _core.Bias, filter: Filter,
) -> tuple[float | None, tuple[BiasShare, ...]]:  # fmt: skip
    """Reference depth without bias, and what each part of a bias that is not 0 does alone."""

    def depth(of: _core.Bias) -> float | None:
        side = rays.resolution[0]
        return compared_at(gbuffer, camera, light, p, pixel, side, of, filter, rays.stored, index).reference

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
