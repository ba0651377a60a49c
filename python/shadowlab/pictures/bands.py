"""How pictures are drawn fast: band by band, and with colours from a table.

Bands are of whole rows, so that what one needs on the way stays in a core's cache.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

# Pixels of a band: a dozen planes of them in single precision fit into a megabyte. Whole planes of a million pixels
# are fresh memory each time, which took as long to clear as to work on.
BAND_PIXELS = 1 << 14


def row_bands(shape: tuple[int, ...]) -> Iterator[slice]:
    """The rows of a picture (H, W), in bands of about `BAND_PIXELS` pixels from the top."""
    height, width = shape
    step = max(1, BAND_PIXELS // max(1, width))
    for begin in range(0, height, step):
        yield slice(begin, min(begin + step, height))


def packed(colours: NDArray[np.uint8]) -> NDArray[np.uint32]:
    """A table of colours (N, 3) as one number each, for `put_colours`."""
    table: NDArray[np.uint32] = np.pad(colours, ((0, 0), (0, 1))).view(np.uint32)[:, 0]
    return table


def put_colours(picture: NDArray[np.uint8], table: NDArray[np.uint32], places: NDArray[np.integer]) -> None:
    """Puts the colours at some places (H, W) of a packed table into a picture (H, W, 3).

    All channels are looked up at once and copied one after the other: pixels of three bytes take five times as long.
    """
    channels = table.take(places, mode="clip")[..., None].view(np.uint8)
    for channel in range(3):
        picture[..., channel] = channels[..., channel]
