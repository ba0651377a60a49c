"""Metrics of sweeps that other processes import, and comparison of their tables."""

from __future__ import annotations

import contextlib
import os
import signal
import time
from pathlib import Path

import pandas as pd

SIZE = (64, 36)
#: How tests sweep, and what they sweep where one technique is enough.
HOW = {"size": SIZE, "renderer": "cpu", "progress": False}
ROBOTS = {"scene": "@robots", "technique": "uniform"}
#: What differs from run to run.
TIMES = ["samples_ms", "fit_us", "map_ms", "lookup_ms", "seconds"]
#: Two scenes, a failing technique, a setting that drops out: 18 rows.
SPACE = {
    "scene": ["@robots", "@dueling"], "technique": ["uniform", "lispsm", "scene_optimal:search=published"],
    "lispsm.near": [1, -5], "resolution": [32, 64], "light": ["own", "0.3,-1,0.1"],
}  # fmt: skip


def same(a: pd.DataFrame, b: pd.DataFrame) -> None:
    """Asserts that two tables are equal bit for bit, times aside."""
    pd.testing.assert_frame_equal(a.drop(columns=TIMES), b.drop(columns=TIMES), check_exact=True)


def lit(run) -> dict[str, float]:
    """Numbers of the mask."""
    return {"lit": float((run.mask > 0.5).mean()), "width": run.mask.shape[1]}


def raise_at_64(run) -> int:
    """Fails at one resolution."""
    if run.resolution == 64:
        raise RuntimeError("no good at 64")
    return run.resolution


def kill_at_64(run) -> int:
    """Ends its process at one resolution, each time."""
    if run.resolution == 64:
        os.kill(os.getpid(), signal.SIGKILL)
    return run.resolution


def kill_at_64_once(run, mark: Path) -> int:
    """Ends its process at one resolution, where there is no mark yet."""
    if run.resolution == 64 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return run.resolution


def sleep_at_64(run) -> int:
    """Takes long at one resolution, in pieces that end at an alarm."""
    if run.resolution == 64:
        time.sleep(60)
    return run.resolution


def hang_at_64(run) -> int:
    """Takes long at one resolution, whatever interrupts it."""
    end = time.monotonic() + 60
    while run.resolution == 64 and time.monotonic() < end:
        # As code that catches too much.
        with contextlib.suppress(Exception):
            time.sleep(60)
    return run.resolution


def pid(run) -> int:
    """The process that measured; long enough that another one can start."""
    time.sleep(0.15)
    return os.getpid()
