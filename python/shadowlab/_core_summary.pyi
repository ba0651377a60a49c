"""Numbers of whole images of `_core`, which exports them."""

from typing import Any

import numpy as np
import numpy.typing as npt

def summarize(
    map: npt.ArrayLike,
    major: npt.ArrayLike,
    perspective: npt.ArrayLike,
    along_t: npt.ArrayLike,
    along_s: npt.ArrayLike,
    projection: npt.ArrayLike,
    depth: npt.ArrayLike,
    *,
    maps: int,
    percentiles: npt.ArrayLike,
    edges: npt.ArrayLike,
    undersampled_from: float,
) -> dict[str, Any] | None:
    """The numbers of all pixels of a footprint that look up a texel, by name; None where none does. See
    `shadowlab.aliasing.summary.Summary`.
    """

def summarize_bands(
    map: npt.ArrayLike,
    major: npt.ArrayLike,
    depth: npt.ArrayLike,
    *,
    limits: npt.ArrayLike,
    undersampled_from: float,
) -> list[tuple[int, tuple[float, float, float, float] | None]]:
    """Of each band of depth between limits: pixels, and max, mean, 95th percentile of the values and the share of those above
    `undersampled_from`, or None where it has no pixel.
    """

def cause_counts(image: npt.ArrayLike, distance: npt.ArrayLike) -> tuple[list[int], tuple[float, float, float] | None]:
    """Pixels by cause, from 0 (right) to 5 (other), and mean, 95th percentile and maximum of how far edges moved, pixels, or None."""

def compared_depths(image: npt.ArrayLike, depth: npt.ArrayLike) -> tuple[float, float] | None:
    """Nearest and farthest depth of the pixels that were compared, or None."""

def causes_by_depth(image: npt.ArrayLike, depth: npt.ArrayLike, *, limits: npt.ArrayLike) -> npt.NDArray[np.uint64]:
    """Pixels by cause, (B, 6) uint64, in bands of depth between limits."""
