"""Whose noise is measured: the runs between which a verdict has to decide, and no others.

Only maps and look-ups are repeated; the G-buffer and the traced truth stay.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from .counts import to_decide
from .progress import Steps

if TYPE_CHECKING:
    from .run import Run


def with_noise(runs: Sequence[Run], phases: int, progress: bool) -> list[Run]:
    """The runs, those between which a verdict has to decide with the noise of their wrong pixels."""
    made = list(runs)
    judged = [i for i, run in enumerate(runs) if not run.failure and "compared" in run.numbers]
    if phases == 1 or not judged:
        return made
    rows = [runs[i].row() for i in judged]
    chosen = [judged[i] for i in to_decide(rows, {run.label: run.technique for run in runs})]
    with Steps(len(chosen), progress) as step:
        for i in chosen:
            step(f"noise of {runs[i].label} {runs[i].resolution}²")
            made[i] = runs[i].over_phases(phases)
    return made
