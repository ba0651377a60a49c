"""Whose noise is measured: the runs between which a verdict has to decide, and no others.

Only maps and look-ups are repeated; the G-buffer and the traced truth stay.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ..text.progress import steps_of_call
from .candidates import Outcome
from .counts import WrongPixels, to_decide
from .ranking import standings
from .thresholds import BASELINE, close, hardly_wrong

if TYPE_CHECKING:
    from .measures import Over
    from .run import Run


def with_noise(runs: Sequence[Run], phases: int, progress: bool | None) -> list[Run]:
    """The runs, those between which a verdict has to decide with the noise of their wrong pixels."""
    made = list(runs)
    judged = [i for i, run in enumerate(runs) if not run.failure and "compared" in run.numbers]
    if phases == 1 or not judged:
        return made
    rows = [runs[i].row() for i in judged]
    chosen = [judged[i] for i in to_decide(rows, {run.label: run.technique for run in runs})]
    with steps_of_call(len(chosen), progress) as step:
        for i in chosen:
            step(f"noise of {runs[i].label} {runs[i].resolution}²")
            made[i] = runs[i].over_phases(phases)
    return made


def outcomes_to_decide(outcomes: Sequence[Outcome], over: Over) -> set[tuple[int, str]]:
    """Budgets and candidates between which an advice has to decide.

    With each budget the best over all views, uniform, and those close to the best over all views or to that of any.
    None where hardly a pixel is wrong.
    """
    known = [one for one in outcomes if one.error is not None]
    wrong = [WrongPixels.of(one.numbers) for one in known]
    if all(hardly_wrong(one.count, one.share) for one in wrong):
        return set()
    pixels = sum(one.compared for one in wrong) / len(wrong)
    chosen: set[tuple[int, str]] = set()
    ranked = [one for one in standings(outcomes, over) if one.ranked]
    for memory in {one.memory for one in ranked}:
        of = [one for one in ranked if one.memory == memory]
        plain = [one for one in of if one.technique == BASELINE]
        near = [one for one in of if close(pixels * (one.error or 0.0), pixels * (of[0].error or 0.0))]
        chosen |= {(memory, one.candidate) for one in (*near, *plain[:1])}
        names = {one.candidate for one in of}
        here = [one for one in known if one.memory == memory and one.candidate in names]
        for view in {one.view.label for one in here}:
            counts = {o.candidate: WrongPixels.of(o.numbers).count for o in here if o.view.label == view}
            least = min(counts.values())
            chosen |= {(memory, name) for name, count in counts.items() if close(count, least)}
    return chosen


def outcomes_with_noise(
    outcomes: Sequence[Outcome], over: Over, phases: int, step: Callable[[str], None]
) -> list[Outcome]:
    """The outcomes, ranked by wrong pixels: those to decide between with the mean over shifts of their texels."""
    chosen = set() if phases == 1 else outcomes_to_decide(outcomes, over)
    made = list(outcomes)
    for i, one in enumerate(outcomes):
        if (one.memory, one.candidate) in chosen and one.error is not None and one.run is not None:
            step(f"noise of {one.candidate}, {one.view.label}")
            run = one.run.over_phases(phases)
            wrong = WrongPixels.of(run.numbers)
            sd = (wrong.sd or 0.0) / wrong.compared
            variance = wrong.variance / wrong.compared**2
            made[i] = replace(one, run=run, numbers=run.numbers, error=wrong.share, sd=sd, variance=variance)
    return made
