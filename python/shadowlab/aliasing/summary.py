"""The errors of an image as a few numbers: the worst, the mean, percentiles, by depth, and what they cost in memory."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from itertools import pairwise
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..errors import ArgumentError
from ..text import shown
from ..text.arrays import checked_array
from ..text.checked import has_all
from ..travel import Value
from ..types import FootprintLike
from .extent import UNDERSAMPLED_FROM_PX

if TYPE_CHECKING:
    import numpy.typing as npt
    import pandas as pd


PERCENTILES = (5, 25, 50, 75, 95, 99)
# More bands than rows of a picture tell nothing.
MOST_BANDS = 10_000
# Limits of the histogram, pixels: octaves and their halves around 1, at which undersampling begins, out to where a
# texel covers a hundred pixels (m > 10 is the worst colour of the published pictures).
HISTOGRAM_LIMITS_PX = 2.0 ** np.arange(-6.5, 7.51, 0.5)
EDGES_PX = (0.0, *map(float, HISTOGRAM_LIMITS_PX), math.inf)


@dataclass(frozen=True, eq=False, repr=False)
class Summary(Value):
    """The errors of an image.

    Attributes
    ----------
    measured : int
        Pixels that look up a texel. All numbers below are None where there is none.
    max, mean, rms : float or None
        Of `Footprint.major`, the longest extent of a texel in the image, pixels: L-infinity, L1 and L2 norm.
    percentiles : dict
        Of the same: 5, 25, 50, 75, 95 and 99 per cent of the measured pixels are no worse.
    undersampled : float or None
        Share of the measured pixels in which a texel is longer than a pixel.
    perspective_max, perspective_mean : float or None
        Of `Footprint.perspective_major`: what remains where slopes add nothing.
    projection_mean : float or None
        Geometric mean of `Footprint.projection`.
    perspective_s_max, perspective_t_max : float or None
        The longest texels along the map's y (s) and x (t) by perspective alone, pixels, of all maps.
    storage_factor : float or None
        Texels over pixels without perspective error: the largest extent along s times the largest along t, by
        perspective alone, times texels, over pixels; summed over the maps (Lloyd et al. [lloyd2008]). Of what is seen,
        not of the frustum.
    resolution_needed : int or None
        Texels along the longer side of every map with which 95 % of the measured pixels are not undersampled, slopes
        and all.
    """

    measured: int
    pixels: int
    counts: Mapping[str, int]
    max: float | None = None
    mean: float | None = None
    rms: float | None = None
    percentiles: Mapping[int, float] | None = None
    undersampled: float | None = None
    perspective_max: float | None = None
    perspective_mean: float | None = None
    projection_mean: float | None = None
    perspective_s_max: float | None = None
    perspective_t_max: float | None = None
    storage_factor: float | None = None
    resolution_needed: int | None = None
    _histogram: NDArray[np.int64] | None = None
    _bands: tuple[Mapping[str, Any], ...] = ()

    @classmethod
    def of(cls, footprint: FootprintLike, bands: int | npt.ArrayLike = 6) -> Summary:
        """The summary of a footprint; see `Footprint.summary`.

        Raises
        ------
        ArgumentError
            For less than one band, or limits that do not rise.
        """
        if not (has_all(footprint, "measured", "map", "major") and isinstance(footprint.map, np.ndarray)):
            raise ArgumentError(
                f"footprint: expected a Footprint, got {shown(footprint)}; sl.aliasing.footprint(...) makes one"
            )
        pixels = int(footprint.map.size)
        limits = checked_bands(bands)
        along_t, along_s = (footprint.perspective_ts[..., k] for k in (0, 1))
        found = _core.summarize(
            footprint.map, footprint.major, footprint.perspective, along_t, along_s, footprint.projection,
            footprint.depth, maps=footprint.maps, percentiles=PERCENTILES, edges=EDGES_PX,
            undersampled_from=UNDERSAMPLED_FROM_PX,
        )  # fmt: skip
        if found is None:
            return cls(0, pixels, footprint.counts())
        measured, values = found["measured"], found["percentiles"]
        worst = [pair for pair in found["longest"] if pair is not None]
        texels_by_pixels = footprint.resolution[0] * footprint.resolution[1] / (footprint.size[0] * footprint.size[1])
        near, far = found["depths"]
        limits = even_limits(near, far, cast("int", bands)) if limits is None else limits
        of_bands = _core.summarize_bands(
            footprint.map, footprint.major, footprint.depth, limits=limits,
            undersampled_from=UNDERSAMPLED_FROM_PX,
        )  # fmt: skip
        return cls(
            measured, pixels, footprint.counts(),
            max=found["max"],
            mean=found["mean"],
            rms=found["rms"],
            percentiles=dict(zip(PERCENTILES, values, strict=True)),
            undersampled=found["undersampled"] / measured,
            perspective_max=found["perspective_max"],
            perspective_mean=found["perspective_mean"],
            projection_mean=found["projection_mean"],
            perspective_s_max=max((s for s, _ in worst), default=None),
            perspective_t_max=max((t for _, t in worst), default=None),
            storage_factor=sum(s * t for s, t in worst) * texels_by_pixels,
            resolution_needed=math.ceil(max(footprint.resolution) * values[PERCENTILES.index(95)]),
            _histogram=np.array(found["histogram"], np.int64),
            _bands=tuple(band_row(near, far, *of) for (near, far), of in zip(pairwise(limits), of_bands, strict=True)),
        )  # fmt: skip

    @property
    def bands(self) -> pd.DataFrame:
        """One row a band of camera depth: near, far (world), pixels, max, mean, p95 (px), undersampled (share)."""
        import pandas as pd

        columns = ["near", "far", "pixels", "max", "mean", "p95", "undersampled"]
        return pd.DataFrame([dict(band) for band in self._bands], columns=columns)

    @property
    def histogram(self) -> pd.DataFrame:
        """Pixels by the longest extent of a texel: from, to (px), pixels (count). The ends hold the rest."""
        import pandas as pd

        counts = np.zeros(len(EDGES_PX) - 1, np.int64) if self._histogram is None else self._histogram
        return pd.DataFrame({"from": EDGES_PX[:-1], "to": EDGES_PX[1:], "pixels": counts})

    def to_dict(self) -> dict[str, Any]:
        """The numbers as plain data, for JSON."""
        names = (
            "measured", "pixels", "max", "mean", "rms", "undersampled", "perspective_max", "perspective_mean",
            "projection_mean", "perspective_s_max", "perspective_t_max", "storage_factor", "resolution_needed",
        )  # fmt: skip
        numbers = {name: getattr(self, name) for name in names}
        percentiles = {f"p{k}": v for k, v in (self.percentiles or {}).items()}
        return {**numbers, **percentiles, "counts": dict(self.counts), "bands": [dict(band) for band in self._bands]}

    def __repr__(self) -> str:
        if self.measured == 0:
            why = ", ".join(f"{count:,} {what}" for what, count in self.counts.items() if what != "measured" and count)
            return f"Summary: no pixel looks up a texel ({why or 'no pixels'})"
        p = self.percentiles or {}
        return (
            f"Summary of {self.measured:,} pixels: a texel is up to {p[50]:.4g} px long in half of them, in 95 % up to "
            f"{p[95]:.4g}, on average {self.mean:.4g}, at most {self.max:.4g}; "
            f"{self.undersampled:.1%} undersampled; storage factor {self.storage_factor:.4g}"
        )

    def _repr_html_(self) -> str:
        table = self.bands.to_html(index=False, border=0, float_format=lambda v: f"{v:.4g}") if self._bands else ""
        return f"<p>{escape(repr(self))}</p>{table}"


def checked_bands(bands: int | npt.ArrayLike) -> NDArray[np.float64] | None:
    """Limits of bands as given; None for a number of them.

    Raises
    ------
    ArgumentError
        For less than one band, or limits that do not rise.
    """
    if isinstance(bands, (int, np.integer)) and not isinstance(bands, bool) and 1 <= bands <= MOST_BANDS:
        return None
    limits: NDArray[np.float64] = checked_array("bands", bands)
    rising = limits.ndim == 1 and limits.size >= 2 and np.isfinite(limits).all() and (np.diff(limits) > 0).all()
    if not rising:
        raise ArgumentError(
            f"bands: expected a whole number from 1 to {MOST_BANDS} or at least two rising depths, "
            f"got {shown(bands)}; try bands=6"
        )
    return limits


def even_limits(near: float, far: float, bands: int) -> NDArray[np.float64]:
    """Limits (B + 1,) of bands that are even in the logarithm of depth; one band where all depths are one.

    Where not all is before the eye, as orthographic cameras may have it, they are even in depth.
    """
    # The last digit of a 32-bit depth does not make a band.
    if far <= near + abs(near) * 4 * np.finfo(np.float32).eps:
        return np.array([near, np.nextafter(far, np.inf)])
    shares = np.arange(bands + 1) / bands
    limits = near * (far / near) ** shares if near > 0 else near + (far - near) * shares
    limits[0], limits[-1] = near, far
    return limits


def band_row(
    near: float, far: float, pixels: int, of_values: tuple[float, float, float, float] | None
) -> dict[str, Any]:
    """One row of a band of depth: its limits, how many pixels, and the numbers of their values if there are any."""
    row: dict[str, Any] = {"near": float(near), "far": float(far), "pixels": pixels}
    return row | dict(zip(("max", "mean", "p95", "undersampled"), of_values or (None,) * 4, strict=True))
