"""Functions of one process timed in turn."""

from __future__ import annotations

import time

import numpy as np


def interleaved(work: dict, seconds: float, least: int = 5) -> dict[str, dict[str, float]]:
    """Minimum and median milliseconds of each function, called in turn until `seconds` have gone by."""
    for run in work.values():
        run()
    wall: dict[str, list[float]] = {name: [] for name in work}
    cpu: dict[str, list[float]] = {name: [] for name in work}
    begin = time.perf_counter()
    while time.perf_counter() - begin < seconds or min(map(len, wall.values())) < least:
        for name, run in work.items():
            start, start_cpu = time.perf_counter(), time.process_time()
            run()
            wall[name].append(1e3 * (time.perf_counter() - start))
            cpu[name].append(1e3 * (time.process_time() - start_cpu))
    return {
        name: {"min_ms": min(t), "median_ms": float(np.median(t)), "cpu_ms": min(cpu[name]), "runs": len(t)}
        for name, t in wall.items()
    }
