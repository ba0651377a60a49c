"""Which texels of the maps an image reads: samples per texel, texels per pixel, and the share that nobody reads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..text.arrays import check_map_depths
from ..text.checks import check_filter
from ..travel import Value

if TYPE_CHECKING:
    import numpy.typing as npt
    import pandas as pd

    from ..types import Filter, Light, Maps, Size


@dataclass(frozen=True, eq=False, repr=False)
class Usage(Value):
    """How often the pixels of an image read each texel.

    Attributes
    ----------
    reads : (K, H, W) uint32
        Pixels that read each texel of each map, rows from the top.
    pixels : int
        Pixels that look up a map.
    """

    reads: NDArray[np.uint32]
    pixels: int

    @property
    def texels(self) -> int:
        """Texels of all maps."""
        return int(self.reads.size)

    @property
    def unused(self) -> float:
        """Share of the texels that no visible pixel reads: waste."""
        return float(np.count_nonzero(self.reads == 0) / self.reads.size)

    @property
    def unused_by_map(self) -> list[float]:
        """The same of each map."""
        return [float(np.count_nonzero(layer == 0) / layer.size) for layer in self.reads]

    @property
    def mean(self) -> float:
        """Reads of a texel that is read at all, on average; 0 where none is."""
        used = np.count_nonzero(self.reads)
        return float(self.reads.sum(dtype=np.int64) / used) if used else 0.0

    @property
    def histogram(self) -> pd.DataFrame:
        """Texels by how many pixels read them, in octaves: from, to (reads, both inclusive), texels, share (of all)."""
        import pandas as pd

        counts = np.bincount(octaves(self.reads).ravel(), minlength=2)
        lows = np.array([0, *(1 << np.arange(len(counts) - 1))])
        highs = np.array([0, *((2 << np.arange(len(counts) - 1)) - 1)])
        return pd.DataFrame({"from": lows, "to": highs, "texels": counts, "share": counts / self.reads.size})

    def __repr__(self) -> str:
        maps, height, width = self.reads.shape
        of = f"{maps} maps of {width} x {height}" if maps > 1 else f"{width} x {height} texels"
        return (
            f"Usage({of}: {self.unused:.1%} read by no pixel, the others by {self.mean:.3g} on average, "
            f"{self.pixels:,} pixels look up)"
        )


def octaves(reads: NDArray[np.uint32]) -> NDArray[np.int64]:
    """0 of no reads, 1 of one, 2 of two and three, 3 of four to seven..."""
    return np.frexp(reads.astype(np.float64))[1].astype(np.int64)  # 0 has the exponent 0, 2^k to 2^(k+1) - 1 have k + 1


def usage(
    gbuffer: _core.GBuffer,
    camera: _core.Camera,
    light: Light,
    parameterization: Maps,
    *,
    resolution: Size | None = None,
    filter: Filter = "nearest",
) -> Usage:
    """How often the pixels of an image read each texel of the maps.

    Parameters
    ----------
    gbuffer, camera, light, parameterization, resolution
        As in `footprint`.
    filter : str
        One of `sl.filters()`; each pixel counts once at each texel that its kernel reads.

    Returns
    -------
    Usage

    Raises
    ------
    ArgumentError
        For arguments of another type, or maps that do not fit into memory.
    UnknownNameError
        For a filter that does not exist.
    """
    check_filter(filter)
    return Usage(*_core.reads(gbuffer, camera, light, parameterization, resolution=resolution, filter=filter))


def texel_coordinates(
    gbuffer: _core.GBuffer,
    camera: _core.Camera,
    light: Light,
    parameterization: Maps,
    *,
    resolution: Size | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.int16]]:
    """Where the receiver of each pixel lies in its map.

    Parameters
    ----------
    gbuffer, light, parameterization, resolution
        As in `footprint`.
    camera : Camera
        Whose depth tells which of several maps serves a receiver: the one of the G-buffer, or another that the maps
        were made for.

    Returns
    -------
    texel : (H, W, 2) float64
        x to the right, y down; texel (i, j) covers [i, i + 1) x [j, j + 1). NaN where nothing is looked up.
    map : (H, W) int16
        As `Footprint.map`.

    Raises
    ------
    ArgumentError
        For arguments of another type.
    """
    return _core.texel_coordinates(gbuffer, camera, light, parameterization, resolution=resolution)


def look_up(
    maps: npt.ArrayLike,
    gbuffer: _core.GBuffer,
    camera: _core.Camera,
    light: Light,
    parameterization: Maps,
    *,
    bias: _core.Bias | None = None,
    filter: Filter = "nearest",
    blend: float = 0.0,
    stored: _core.Stored | str | None = None,
) -> NDArray[np.float32]:
    """The shadow mask of an image through maps that are there: of a renderer of ours, or of somebody's engine.

    Parameters
    ----------
    maps : (H, W) or (K, H, W) array_like float32
        Depths in [0, 1], 1 where no caster is, row 0 at the top, as `Renderer.shadow_map` gives them.
    gbuffer, light, parameterization
        As in `footprint`; the parameterization that the maps were rendered with.
    camera : Camera
        As in `texel_coordinates`.
    bias : Bias, optional
    filter : str
        One of `sl.filters()`. A kernel in pixels is measured in those of the picture that the G-buffer is, or is a part
        of, seen by `camera`.
    blend : float
        As of `Renderer.shadow_mask`.
    stored : Stored or str, optional
        What the maps store; the nearest depth as it is where none is given.

    Returns
    -------
    (H, W) float32
        1 lit, 0 in shadow, NaN where nothing is: as `Renderer.shadow_mask`.

    Raises
    ------
    ArgumentError
        For maps of another shape than the parameterization has, and what is no depth in [0, 1].
    UnknownNameError
        For a filter that does not exist.
    """
    check_filter(filter)
    check_map_depths("maps", maps)
    looks = (maps, gbuffer, camera, light, parameterization)
    return _core.look_up(*looks, bias=bias, filter=filter, blend=blend, stored=stored)[0]
