"""How long a texel is in the image, and from which length on it shows."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

# A texel that is longer than a pixel in the image shows.
UNDERSAMPLED_FROM_PX = 1.0


def largest_extent(columns: NDArray[Any], area: NDArray[Any]) -> NDArray[Any]:
    """The larger singular values of 2 x 2 matrices by the lengths of their columns (..., 2) and their determinants."""
    squares = np.square(columns[..., 0], dtype=np.float64) + np.square(columns[..., 1], dtype=np.float64)
    rest = np.maximum(squares * squares - 4.0 * np.square(area, dtype=np.float64), 0.0)
    largest: NDArray[Any] = np.sqrt(0.5 * (squares + np.sqrt(rest))).astype(area.dtype)
    return largest
