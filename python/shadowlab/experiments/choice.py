"""What an advice comes to: the candidate to take, and what warps and splits gain over uniform."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from .candidates import Candidate
from .counts import Relation
from .ranking import Standing
from .thresholds import BASELINE, about_equal

if TYPE_CHECKING:
    from ..types import Item


@dataclass(frozen=True)
class Choice:
    """A candidate at its resolution, with the error that it has there.

    Attributes
    ----------
    candidate : str
        Its label.
    technique : Technique, Preset or Parameterization
        What it is: ``choice.technique.parameterize(scene, camera, light, resolution=choice.resolution)``.
    maps, resolution : int
        How many maps there are, and texels along each side.
    bytes, memory : int
        What the maps take, and the budget.
    error : float
        In the unit of the advice's measure.
    view : str or None
        The view that it is of; None for all.
    about_equal : tuple of str
        Candidates that do about as well.
    """

    candidate: str
    technique: Item = field(repr=False)
    maps: int
    resolution: int
    bytes: int
    memory: int
    error: float
    view: str | None
    about_equal: tuple[str, ...]


def choice_of(
    ranking: Sequence[Standing], candidates: Sequence[Candidate], budgets: Collection[int], view: str | None
) -> Choice | None:
    """The candidate with the least error with any of the budgets; of equal ones in the least memory. None without one.

    `view` is the label of the view that the ranking is of; None for all.
    """
    valid = [one for one in ranking if one.rank is not None and one.memory in budgets]
    if not valid:
        return None
    best = min(valid, key=lambda one: (one.error, one.memory, one.rank, one.maps, one.candidate))
    near = tuple(
        s.candidate for s in valid if s.memory == best.memory and s.about_best and s.candidate != best.candidate
    )
    row = best.row()
    item = next(one.item for one in candidates if one.label == best.candidate)
    sizes = (row["maps"], row["resolution"], row["bytes"], best.memory)
    return Choice(best.candidate, item, *sizes, float(best.error or 0.0), view, near)


@dataclass(frozen=True)
class Gain:
    """The best warp or split that was drawn with a budget, beside the best uniform one in as much memory.

    Attributes
    ----------
    memory : int
        The budget, bytes.
    best, baseline : Standing
        Of the warps and splits, and of uniform.
    drawn : tuple of str
        All warps and splits that were drawn and ranked, best first: nothing is said of others.
    """

    memory: int
    best: Standing
    baseline: Standing
    drawn: tuple[str, ...]

    @property
    def relation(self) -> Relation:
        """Whether the best warp or split has less error than uniform, about as much, or more."""
        mine, other = float(self.best.error or 0.0), float(self.baseline.error or 0.0)
        if about_equal(mine, other, self.best.variance + self.baseline.variance):
            return "about_equal"
        return "fewer" if mine < other else "more"


def gains(ranking: Sequence[Standing]) -> list[Gain]:
    """The gain with each budget, rising; none where uniform or all others are missing."""
    found = []
    for memory in dict.fromkeys(one.memory for one in ranking):
        of = [one for one in ranking if one.memory == memory and one.ranked]
        plain = [one for one in of if one.technique == BASELINE]
        others = [one for one in of if one.technique != BASELINE]
        if plain and others:
            found.append(Gain(memory, others[0], plain[0], tuple(one.candidate for one in others)))
    return found
