"""Strips and fans of triangles as triangles."""

from __future__ import annotations

import numpy as np

from .polygons import Indices


def strip_triangles(corners: Indices, counts: Indices) -> Indices:
    """Triangles of strips, all turning as the first of their strip does, without those that only join strips.

    Parameters
    ----------
    corners : (C,) int64
        Vertices, strip after strip; -1 begins a new strip.
    counts : (S,) int64
        Corners of each strip.

    Returns
    -------
    (T, 3) int64
    """
    strip = np.repeat(np.arange(len(counts)), counts) + np.cumsum(corners < 0)
    breaks = corners < 0
    begins = np.zeros(len(corners), np.int64)
    new = np.concatenate([[True], (strip[1:] != strip[:-1]) | breaks[:-1]])[: len(corners)]
    begins[new] = np.flatnonzero(new)
    begins = np.maximum.accumulate(begins)
    k = np.arange(max(len(corners) - 2, 0))
    inside = (begins[k] == begins[k + 2]) & ~breaks[k] & ~breaks[k + 1] & ~breaks[k + 2]
    k = k[inside]
    odd = ((k - begins[k]) & 1).astype(bool)
    made = corners[np.stack([k, np.where(odd, k + 2, k + 1), np.where(odd, k + 1, k + 2)], axis=1)]
    a, b, c = made.T
    return np.asarray(made[(a != b) & (b != c) & (c != a)])


def fan_triangles(corners: Indices, counts: Indices) -> Indices:
    """Triangles of fans around their first corners; see `strip_triangles`."""
    starts = np.cumsum(counts) - counts
    many = np.maximum(counts - 2, 0)
    inner = np.arange(int(many.sum())) - np.repeat(np.cumsum(many) - many, many)
    first = np.repeat(starts, many)
    made = corners[np.stack([first, first + inner + 1, first + inner + 2], axis=1)]
    a, b, c = made.T
    return np.asarray(made[(a != b) & (b != c) & (c != a)])
