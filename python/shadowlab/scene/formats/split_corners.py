"""Corners of faces with several indices each (place, texture, normal) as vertices: one for each combination.

Vertices come in the order that trimesh's ``unmerge_faces`` gives them, so that a file has the same rows in both
programs: combinations are sorted by numbers made of their indices, the last index counting most, and then by place
alone with numpy's default sort, which leaves the order among those of one place to numpy.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .polygons import Indices

# Bits of the numbers that combinations are sorted by.
_BITS = 64


def split_corners(indices: Sequence[NDArray[np.integer]]) -> tuple[Indices, list[Indices]]:
    """The vertex of each corner, and the indices of each vertex.

    Parameters
    ----------
    indices : sequence of (C,) int
        Of each kind one per corner, 0 or more; places first.

    Returns
    -------
    corner : (C,) int64
        Index of each corner's vertex.
    vertices : list of (V,) int64
        Of each kind one per vertex; places do not fall.
    """
    stack = np.stack(indices, axis=1).astype(np.int64)
    _, first, corner = np.unique(_sortable(stack), return_index=True, return_inverse=True)
    combinations = stack[first]
    order = combinations[:, 0].argsort()
    place = np.empty(len(order), np.int64)
    place[order] = np.arange(len(order))
    return place[corner.reshape(-1)], list(combinations[order].T)


def _sortable(rows: Indices) -> NDArray[np.generic]:
    """A value for each row (C, K), equal for equal rows: a number where the indices are small, else its bytes."""
    width = _BITS // rows.shape[1]
    half = 1 << (width - 1)
    if len(rows) and rows.max() >= half - 1:
        bytes_of_row: NDArray[np.generic] = rows.view(np.dtype((np.void, rows.itemsize * rows.shape[1]))).reshape(-1)
        return bytes_of_row
    numbers = np.zeros(len(rows), np.uint64)
    for k, column in enumerate(rows.T):
        numbers ^= (column + half).astype(np.uint64) << np.uint64(k * width)
    return numbers
