"""A box of texels about a place in a map: averages of comparisons, and averages of what is stored.

A box of n texels, n odd, is blurred into the map and the map is read with bilinear weights, as hardware filters a
texture. Along each axis the n + 1 texels about a place, f texels behind the centre of the first, then have the weights
(1 - f, 1, ..., 1, f) / n. Comparisons get the same weights, so that both average over the same kernel. Beyond the map
its edge goes on.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..types import Vector
from .prefiltered_formats import PrefilteredFormat

# Texels, or pixels with their taps, that one step of numpy works on: some ten milliseconds, so that Ctrl-C is heard.
BAND_TEXELS = 1 << 18


def bands(count: int, size: int) -> Iterator[slice]:
    """Slices of `count` things, each of as many as together have `BAND_TEXELS` parts, where one has `size`."""
    step = max(1, BAND_TEXELS // size)
    for first in range(0, count, step):
        yield slice(first, min(count, first + step))


def blurred(texels: NDArray[Any], format: PrefilteredFormat, kernel: int) -> NDArray[Any]:
    """A map (H, W, C) whose texels have the average over the box about them, stored in the same format.

    Rows and then columns are averaged in double precision, and the result is rounded once.
    """
    height, width = texels.shape[:2]
    reach = kernel // 2
    found = np.empty_like(texels)
    columns = np.clip(np.arange(-reach, width + reach), 0, width - 1)
    for rows in bands(height, width):
        wanted = np.clip(np.arange(rows.start - reach, rows.stop + reach), 0, height - 1)
        values = format.read(texels[wanted])[:, columns]
        along = np.zeros((len(wanted), width, values.shape[-1]))
        for i in range(kernel):
            along += values[:, i : i + width]
        total = np.zeros((rows.stop - rows.start, *along.shape[1:]))
        for i in range(kernel):
            total += along[i : i + len(total)]
        found[rows] = format.restored(total / kernel**2)
    return found


def read_between(texels: NDArray[Any], format: PrefilteredFormat, places: Vector) -> Vector:
    """(N, C): what is read of a map (H, W, C) at places (N, 2), weighted between the four nearest texels."""
    height, width = texels.shape[:2]
    found = np.zeros((len(places), texels.shape[-1]))
    first, part = texels_before(places)
    for j in (0, 1):
        row = np.clip(first[:, 1] + j, 0, height - 1)
        for i in (0, 1):
            column = np.clip(first[:, 0] + i, 0, width - 1)
            weight = np.abs(1 - i - part[:, 0]) * np.abs(1 - j - part[:, 1])
            found += weight[:, None] * format.read(texels[row, column])
    return found


def compared(depths: Vector, places: Vector, receivers: Vector, gradients: Vector, kernel: int) -> Vector:
    """(N,): the weighted share of the kernel's texels that are not before the receivers' planes.

    Parameters
    ----------
    depths : (H, W) float64
        Of the map, infinite where it is empty.
    places : (N, 2) float64
        Of receivers, texels.
    receivers : (N,) float64
        Their depths.
    gradients : (N, 2) float64
        What the depth of a receiver's plane gains by a texel to the right and by a texel down.
    kernel : int
        Side of the box, texels, odd.
    """
    height, width = depths.shape
    first, part = texels_before(places)
    first = first - kernel // 2
    light = np.zeros(len(places))
    for j in range(kernel + 1):
        row = np.clip(first[:, 1] + j, 0, height - 1)
        down = first[:, 1] + j + 0.5 - places[:, 1]
        for i in range(kernel + 1):
            column = np.clip(first[:, 0] + i, 0, width - 1)
            right = first[:, 0] + i + 0.5 - places[:, 0]
            plane = receivers + gradients[:, 0] * right + gradients[:, 1] * down
            weight = weight_of(i, part[:, 0], kernel) * weight_of(j, part[:, 1], kernel)
            light += weight * (plane <= depths[row, column])
    return light


def texels_before(places: Vector) -> tuple[NDArray[np.int64], Vector]:
    """The texels whose centres are before places (N, 2), and how far behind those the places are, 0 to 1."""
    first = np.floor(places - 0.5)
    return first.astype(np.int64), places - 0.5 - first


def weight_of(tap: int, part: Vector, kernel: int) -> Vector:
    """The weight (N,) of one of the kernel's texels along an axis; together they are 1."""
    if tap == 0:
        return (1.0 - part) / kernel
    return part / kernel if tap == kernel else np.full_like(part, 1.0 / kernel)
