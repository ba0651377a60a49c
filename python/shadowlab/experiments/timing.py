"""How long a call takes: once, or repeated until the figure is steady."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")

# A fit takes microseconds: this many repeats, or as many as fit into the budget, give a steady median.
FIT_REPEATS = 200
FIT_BUDGET_S = 0.1
# The best of a few runs is what the machine can do; slow maps are drawn once.
DRAW_REPEATS = 3
DRAW_BUDGET_S = 1.0


def median_us(call: Callable[[], T], repeat: bool) -> tuple[T, float]:
    """What a call returns and its time in microseconds, the median of many calls where they are repeated."""
    durations: list[float] = []
    end = time.perf_counter() + FIT_BUDGET_S
    while True:
        start = time.perf_counter()
        result = call()
        durations.append(time.perf_counter() - start)
        if not repeat or len(durations) >= FIT_REPEATS or time.perf_counter() >= end:
            return result, 1e6 * statistics.median(durations)


def best_of(call: Callable[[], object], repeat: bool) -> float:
    """The time of a call in milliseconds, the shortest of a few where they are repeated."""
    best, spent = float("inf"), 0.0
    for _ in range(DRAW_REPEATS if repeat else 1):
        start = time.perf_counter()
        call()
        elapsed = time.perf_counter() - start
        best, spent = min(best, elapsed), spent + elapsed
        if spent > DRAW_BUDGET_S:
            break
    return 1e3 * best
