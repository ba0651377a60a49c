"""Searches along one part of a bias: the least value that leaves few pixels in acne, and that of fewest wrong pixels.

Both need nothing but that acne and all false shadow never grow with the value, and that false light never shrinks.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable
from itertools import pairwise

from .bias_looks import UNLIMITED, BiasCounts

# Values below a start by this factor count as none: single precision resolves 2^-24 of a depth.
NONE_BELOW = 2.0**-40
# Of the fewest wrong pixels: how far below it the count of a value that was not tried may be, unless a search of so
# many look-ups leaves it open.
LEFT_OPEN, MOST_LOOKS = 0.01, 200


class BiasSearch:
    """The counts that are known, by value, and what finds more of them.

    Parameters
    ----------
    count : callable
        The counts with a value.
    tolerance : float
        How close values are told apart, relative to themselves.
    """

    def __init__(self, count: Callable[[float], BiasCounts], tolerance: float):
        self._count, self._tolerance = count, tolerance
        self.known: dict[float, BiasCounts] = {}

    def at(self, value: float) -> BiasCounts:
        """The counts with a value, looked up once."""
        if value not in self.known:
            self.known[value] = self._count(value)
        return self.known[value]

    def least(self, allowed: int, start: float) -> float | None:
        """The least value, to the tolerance above it, that leaves `allowed` pixels in acne; None where none does.

        Of this value the count is at most `allowed`, of one less by the tolerance it is more. The search begins at
        `start`, by factors of two, and goes on by halves.
        """
        if self.at(0.0).acne <= allowed:
            return 0.0
        if self.at(UNLIMITED).acne > allowed:
            return None
        low, high = 0.0, start
        while high < UNLIMITED and self.at(high).acne > allowed:
            low, high = high, 2.0 * high
        while low == 0.0 and high > NONE_BELOW * start:
            if self.at(0.5 * high).acne > allowed:
                low = 0.5 * high
            else:
                high = 0.5 * high
        while low > 0.0 and high - low > self._tolerance * high:
            middle = 0.5 * (low + high)
            if self.at(middle).acne > allowed:
                low = middle
            else:
                high = middle
        return high

    def fewest_wrong(self) -> float:
        """The value of fewest wrong pixels: of several the least.

        Between values a < b there are at least as many wrong pixels as false shadow with b and false light with a.
        Intervals in which that leaves room for fewer than the fewest by `LEFT_OPEN` are halved, until none is left that
        is wider than the tolerance. `bound` says what is left open.
        """
        values = sorted(self.known)
        open_ = [self._interval(a, b) for a, b in pairwise(values)]
        heapq.heapify(open_)
        fewest = min(counts.wrong for counts in self.known.values())
        for _ in range(MOST_LOOKS):
            if not open_ or open_[0][0] >= (1.0 - LEFT_OPEN) * fewest:
                break
            _, a, b = heapq.heappop(open_)
            if b - a <= self._tolerance * b or b <= NONE_BELOW:
                continue
            middle = 2.0 * a if b == UNLIMITED and 0.0 < a < 0.5 * b else 0.5 * (a + b)
            fewest = min(fewest, self.at(middle).wrong)
            heapq.heappush(open_, self._interval(a, middle))
            heapq.heappush(open_, self._interval(middle, b))
        return min(self.known, key=lambda value: (self.known[value].wrong, value))

    @property
    def bound(self) -> int:
        """No value has fewer wrong pixels, by what is known; see `fewest_wrong`."""
        between = [self._interval(a, b)[0] for a, b in pairwise(sorted(self.known))]
        return min([*between, *(counts.wrong for counts in self.known.values())])

    def _interval(self, a: float, b: float) -> tuple[int, float, float]:
        return self.known[b].false_shadow + self.known[a].leaks, a, b
