"""Work on large arrays block after block, so that Ctrl-C need not wait for all of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Rows that are copied at once: a few hundredths of a second where memory is touched for the first time.
_ROWS = 1 << 18


def concatenated(parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Arrays of one type, at least one, one after the other."""
    made = np.empty((sum(map(len, parts)), *parts[0].shape[1:]), parts[0].dtype)
    at = 0
    for part in parts:
        for row in range(0, len(part), _ROWS):
            block = part[row : row + _ROWS]
            made[at + row : at + row + len(block)] = block
        at += len(part)
    return made


def gathered_rows(values: NDArray[Any], rows: NDArray[Any]) -> NDArray[Any]:
    """``values[rows]``."""
    made = np.empty((*rows.shape, *values.shape[1:]), values.dtype)
    for row in range(0, len(rows), _ROWS):
        made[row : row + _ROWS] = values[rows[row : row + _ROWS]]
    return made
