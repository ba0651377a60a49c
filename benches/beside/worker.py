"""One side in Python: `python worker.py MODULE NAME JSON` does the work NAME of MODULE once for every line."""

from __future__ import annotations

import importlib
import json
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np


@dataclass
class Work:
    """What a side does.

    Attributes
    ----------
    run : callable
        The work; it is timed. It is called with what `prepare` returned, if there is one.
    about : str
        The program and its version.
    check : dict
        Numbers that the other side must have, too.
    prepare : callable, optional
        Called before each run, and not timed.
    """

    run: Callable
    about: str
    check: dict[str, float] = field(default_factory=dict)
    prepare: Callable | None = None


def of_map(depth: np.ndarray) -> dict[str, float]:
    """Numbers of a map that another picture does not have: mean depth, texels drawn, and first moments of depth."""
    rows, columns = (depth.mean(axis=axis, dtype=np.float64) for axis in (1, 0))
    return {
        "mean depth": float(rows.mean()),
        "texels drawn": int((depth < 1).sum()),
        "depth downwards": float(rows @ np.arange(len(rows))),
        "depth across": float(columns @ np.arange(len(columns))),
    }


def main() -> None:
    """Answer until standard input ends."""
    module, name, options = sys.argv[1:4]
    sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))
    work: Work = getattr(importlib.import_module(module), name)(**json.loads(options))
    print(json.dumps({"about": work.about, "check": work.check}), flush=True)
    for _ in sys.stdin:
        prepared = () if work.prepare is None else (work.prepare(),)
        wall, cpu = time.perf_counter(), time.process_time()
        result = work.run(*prepared)
        times = {"wall": time.perf_counter() - wall, "cpu": time.process_time() - cpu}
        del result, prepared
        print(json.dumps(times), flush=True)


if __name__ == "__main__":
    main()
