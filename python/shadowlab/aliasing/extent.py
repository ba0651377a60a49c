"""How long a texel is in the image, and from which length on it shows."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ..types import Floats

# A texel that is longer than a pixel in the image shows.
UNDERSAMPLED_FROM_PX = 1.0


def largest_extent(columns: Floats, area: Floats) -> Floats:
    """The larger singular values of 2 x 2 matrices by the lengths of their columns (..., 2) and their determinants."""
    squares = np.square(columns[..., 0], dtype=np.float64) + np.square(columns[..., 1], dtype=np.float64)
    rest = np.maximum(squares * squares - 4.0 * np.square(area, dtype=np.float64), 0.0)
    largest: Floats = np.sqrt(0.5 * (squares + np.sqrt(rest))).astype(area.dtype)
    return largest
