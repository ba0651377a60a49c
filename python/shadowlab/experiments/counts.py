"""Wrong pixels with their noise, and what may be concluded from two counts of them.

Verdicts, rankings and tables take counts from here, so that a number and the sentence about it never disagree.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from ..text import is_missing
from .thresholds import BASELINE, about_equal, close, count_variance, hardly_wrong

#: How a run's wrong pixels compare with another's: fewer, about equal (within the noise or one part in twenty), more.
Relation = Literal["fewer", "about_equal", "more"]


@dataclass(frozen=True)
class WrongPixels:
    """The wrong pixels of a run.

    Attributes
    ----------
    count : float
        Pixels: the mean over shifts of the texels where those were counted, else the count of the map as fitted.
    compared : int
        Pixels that were compared.
    sd : float or None
        Standard deviation over the shifts, pixels; None where the map as fitted alone was counted.
    phases : int
        Shifts that were counted; 1 for the map as fitted alone.
    unjudged : float
        Share of the visible pixels that are undecided, or seen by the map or the truth alone: none was compared.
    """

    count: float
    compared: int
    sd: float | None = None
    phases: int = 1
    unjudged: float = 0.0

    @classmethod
    def of(cls, row: Mapping[str, Any]) -> WrongPixels:
        """Those of a row of a table or of the numbers of a run, by the names of columns."""
        compared = int(value_in(row, "compared"))
        left_out = value_in(row, "undecided") + value_in(row, "unmatched")
        phases = int(value_in(row, "phases", 1))
        several = phases > 1
        return cls(
            value_in(row, "misclassified_mean" if several else "misclassified"), compared,
            value_in(row, "misclassified_sd") if several else None, phases,
            left_out / (compared + left_out) if left_out else 0.0,
        )  # fmt: skip

    @property
    def share(self) -> float:
        """Of the compared pixels; 0 where none were."""
        return self.count / self.compared if self.compared else 0.0

    @property
    def variance(self) -> float:
        """The variance of `count`: measured over the shifts, or estimated where none were counted."""
        return count_variance(self.count) if self.sd is None else self.sd**2 / self.phases


@dataclass(frozen=True)
class Comparison:
    """A run beside the best uniform run with as many texels.

    Attributes
    ----------
    technique, baseline : str
        Labels of both.
    resolution : int
        Texels along each side of the maps of both.
    mine, other : WrongPixels
        Of the technique and of the baseline.
    """

    technique: str
    baseline: str
    resolution: int
    mine: WrongPixels
    other: WrongPixels

    @property
    def relation(self) -> Relation:
        """Whether the technique has fewer wrong pixels, about as many, or more."""
        return relation(self.mine, self.other)

    @property
    def ratio(self) -> float | None:
        """Wrong pixels of the technique by those of the baseline; None where the baseline has none."""
        return self.mine.count / self.other.count if self.other.count else None


def most_unjudged(of: Iterable[WrongPixels]) -> float:
    """The largest share of visible pixels that no run could compare; 0 of no runs."""
    return max((one.unjudged for one in of), default=0.0)


def relation(mine: WrongPixels, other: WrongPixels) -> Relation:
    """How one count compares with another."""
    if about_equal(mine.count, other.count, mine.variance + other.variance):
        return "about_equal"
    return "fewer" if mine.count < other.count else "more"


def value_in(row: Mapping[str, Any], name: str, otherwise: float = 0.0) -> float:
    """The number in a column; another one where it holds none."""
    value: Any = row.get(name)
    return otherwise if is_missing(value) else float(value)


def maps_of(row: Mapping[str, Any]) -> int:
    """The number of maps of a row; one where it is not known."""
    return int(value_in(row, "maps", 1))


def texels(row: Mapping[str, Any]) -> int:
    """The texels of all maps of a row."""
    return maps_of(row) * int(row["resolution"]) ** 2


def baselines(rows: Sequence[Mapping[str, Any]], technique_of_label: Mapping[str, str]) -> dict[int, Mapping[str, Any]]:
    """The best uniform row of each resolution."""
    uniform: dict[int, Mapping[str, Any]] = {}
    for row in rows:
        resolution = int(row["resolution"])
        if technique_of_label.get(row["technique"], row["technique"]) == BASELINE and (
            resolution not in uniform or WrongPixels.of(row).count < WrongPixels.of(uniform[resolution]).count
        ):
            uniform[resolution] = row
    return uniform


def against_uniform(
    rows: Sequence[Mapping[str, Any]], technique_of_label: Mapping[str, str]
) -> dict[str, list[Comparison]]:
    """The other techniques beside uniform at equal resolution and equal texels, by label; resolutions rise."""
    uniform = baselines(rows, technique_of_label)
    found: dict[str, list[Comparison]] = {}
    for row in sorted(rows, key=lambda r: int(r["resolution"])):
        resolution = int(row["resolution"])
        base = uniform.get(resolution)
        warps = technique_of_label.get(row["technique"], row["technique"]) != BASELINE
        # More texels are no merit of a warp.
        if warps and base is not None and texels(base) == texels(row):
            pair = WrongPixels.of(row), WrongPixels.of(base)
            found.setdefault(row["technique"], []).append(
                Comparison(row["technique"], base["technique"], resolution, *pair)
            )
    return found


def best_warp(pairs: Mapping[str, Sequence[Comparison]]) -> str:
    """The label with the fewest wrong pixels at any resolution."""
    return min(pairs, key=lambda label: min(one.mine.count for one in pairs[label]))


def to_decide(rows: Sequence[Mapping[str, Any]], technique_of_label: Mapping[str, str]) -> list[int]:
    """Positions of the rows between which a verdict has to decide, and whose counts are close.

    Those close to the best of all; and of the best warp and uniform those that are close to each other at one
    resolution, or where uniform has more texels. None where hardly a pixel is wrong.
    """
    wrong = [WrongPixels.of(row) for row in rows]
    if all(hardly_wrong(one.count, one.share) for one in wrong):
        return []
    best = min(range(len(rows)), key=lambda i: wrong[i].count)
    pairs = {(best, i) for i in range(len(rows))}
    if warps := against_uniform(rows, technique_of_label):
        mine = [i for i, row in enumerate(rows) if row["technique"] == best_warp(warps)]
        uniform = [
            i for i, row in enumerate(rows) if any(row is base for base in baselines(rows, technique_of_label).values())
        ]
        pairs |= {(i, j) for i in mine for j in uniform if texels(rows[j]) >= texels(rows[i])}
    return sorted({k for i, j in pairs if i != j and close(wrong[i].count, wrong[j].count) for k in (i, j)})
