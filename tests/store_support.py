"""A table that a process fills into a store and may be killed at: what is done, and what it comes to."""

from __future__ import annotations

import math
import os
import traceback
from pathlib import Path
from typing import Any

import shadowlab as sl


def row_of(i: int) -> dict[str, Any]:
    """The row of a run: what it holds follows from its number."""
    return {
        "scene": "forest", "view": f"view {i % 7}", "technique": ("uniform", "lispsm", "tsm")[i % 3],
        "resolution": 64 + i, "misclassified": None if i % 11 == 0 else i * i, "share": math.sin(i) / 3,
        "texel_max": math.inf if i % 5 else i / 7, "notes": f"größe {i} " * (i % 40),
        "failure": "refused" if i % 11 == 0 else "",
    }  # fmt: skip


def key_of(i: int) -> str:
    return f"{i * 2654435761 % (1 << 32):08x}"


def fill(path: str | Path, rows: int, told: int | None = None) -> int:
    """Makes what is missing, with a byte to the pipe `told` after each row; returns how many rows that were."""
    keys = {key_of(i): i for i in range(rows)}
    with sl.Store(path) as store:
        missing = store.missing(keys)
        for key in missing:
            store.put(key, {"failure": "in flight"}, done=False)
            store.put(key, row_of(keys[key]))
            if told is not None:
                os.write(told, b".")
    return len(missing)


def filling(path: Path, rows: int) -> tuple[int, int]:
    """A process that fills it: its number, and a pipe that tells with a byte of each row that is done."""
    told_here, told_there = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.close(told_here)
            fill(str(path), rows, told_there)
        except BaseException:  # noqa: BLE001 - nothing of the tests may go on in here
            traceback.print_exc()
            os._exit(1)
        os._exit(0)
    os.close(told_there)
    return child, told_here
