"""Two sides of a comparison: processes that do their work on request, in turn, and the ratios of their times.

A side is a program that prints one line of JSON when it is ready (what it is, and numbers by which its result can be
held against the other side's), then does its work once for every line `run` and answers with the seconds it took, by
the clock and of the processor, all its threads together. Each side is a process of its own, so that thread pools,
instruction sets and memory of one do not meet the other's.
"""

from __future__ import annotations

import json
import os
import subprocess
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

# Variables that give the programs' thread pools one thread: ours, OpenMP's (Open3D, numpy), oneTBB has none.
ONE_THREAD = {"SHADOWLAB_THREADS": "1", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
# The least number of times that each side runs, after the first, which is not counted.
ROUNDS = 7


class SideError(RuntimeError):
    """A side could not be started or ended early; its text says why and what to install."""


class Side:
    """A program that runs on request; use as a context manager."""

    def __init__(self, command: Sequence[str], *, one_thread: bool, environment: Mapping[str, str] | None = None):
        self.command = list(command)
        self._environment = os.environ | (ONE_THREAD if one_thread else {}) | dict(environment or {})
        self._one_thread = one_thread

    def __enter__(self) -> Side:
        self._process = subprocess.Popen(
            self.command, env=self._environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        if self._one_thread and hasattr(os, "sched_setaffinity"):
            # Threads that a program starts nevertheless share the core, so that processor time stays comparable.
            os.sched_setaffinity(self._process.pid, {max(os.sched_getaffinity(0))})
        self.ready = self._answer()
        return self

    def __exit__(self, *_: object) -> None:
        self._process.stdin.close()
        try:
            self._process.wait(timeout=10)
        except subprocess.TimeoutExpired:
            self._process.kill()

    def run(self) -> dict[str, float]:
        """Seconds of one run: `wall`, `cpu`."""
        self._process.stdin.write("run\n")
        self._process.stdin.flush()
        return self._answer()

    def _answer(self) -> dict:
        # Libraries greet on standard output; answers are the lines that begin like JSON.
        for line in self._process.stdout:
            if line.startswith("{"):
                return json.loads(line)
        raise SideError(f"{' '.join(self.command)} ended with status {self._process.wait()}")


@dataclass(frozen=True)
class Ratio:
    """How many times the work of one side goes into the time of the other: theirs / ours.

    Attributes
    ----------
    ratio : float
        Of the least times of both sides.
    low, high : float
        Tenth and ninetieth percentile of the ratios of neighbouring runs: the spread.
    ours, theirs : float
        Least times, milliseconds.
    rounds : int
        How often each side ran.
    """

    ratio: float
    low: float
    high: float
    ours: float
    theirs: float
    rounds: int

    def as_data(self) -> dict[str, float]:
        """The fields as a dictionary for JSON."""
        return dict(vars(self))


def alternated(ours: Side, theirs: Side, seconds: float, of: str = "cpu") -> Ratio:
    """The ratio of the processor's (or, by `of="wall"`, the clock's) time; sides take turns for `seconds` at least."""
    ours.run(), theirs.run()
    times: list[tuple[float, float]] = []
    begin = time.perf_counter()
    while time.perf_counter() - begin < seconds or len(times) < ROUNDS:
        times.append((ours.run()[of], theirs.run()[of]))
    pairs = np.array(times)
    least = pairs.min(axis=0)
    low, high = np.percentile(pairs[:, 1] / pairs[:, 0], [10, 90])
    return Ratio(
        float(least[1] / least[0]), float(low), float(high), 1e3 * float(least[0]), 1e3 * float(least[1]), len(times)
    )
