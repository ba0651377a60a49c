"""Numbers of text files whose rows run on: where rows end is known from what they hold, not from ends of lines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Rows(NamedTuple):
    """So many rows that hold the same things: for each, whether it is a list, which begins with its length."""

    many: int
    lists: tuple[bool, ...]


def running_counts(values: NDArray[np.float64], groups: Sequence[Rows]) -> NDArray[np.int64] | None:
    """How many numbers each row has; None where the rows do not take all of the numbers and no more."""
    found: list[NDArray[np.int64]] = []
    at = 0
    for count, lists in groups:
        if any(lists):
            widths = _of_lists(values, at, count, lists)
            if widths is None:
                return None
        else:
            # No array before it is known that there are as many numbers.
            if count * len(lists) > len(values) - at:
                return None
            widths = np.full(count, len(lists), np.int64)
        found.append(widths)
        at += int(widths.sum())
    return np.concatenate(found) if at == len(values) else None


def _of_lists(values: NDArray[np.float64], at: int, count: int, lists: tuple[bool, ...]) -> NDArray[np.int64] | None:
    """The numbers in each of `count` rows from a place on."""
    if count * len(lists) > len(values) - at:
        return None
    numbers = values[at:].tolist()
    found, place = [], 0
    for _ in range(count):
        begin = place
        for is_list in lists:
            if place >= len(numbers):
                return None
            if is_list:
                length = numbers[place]
                if not (0 <= length <= len(numbers) and length == int(length)):
                    return None
                place += int(length)
            place += 1
        found.append(place - begin)
    return np.array(found, np.int64) if place <= len(numbers) else None
