"""From outcomes to standings and switches: who is best over all views at equal memory, and where that changes.

A winner is kept for as long as it is best or about equal to the best, so that noise alone switches nothing: views or
budgets in a row are divided into as few stretches as there can be, in each of which one candidate is about best all
along. Going through the row from its start ends each stretch as late as can be, from its end as early: what lies in one
stretch either way is its core, and its winner is about best all over that and as far beyond as may be. Where the
stretches of two winners overlap both are about equal, and the switch lies anywhere in there.

    about best at 10°   A B        core of A
                  30°   A   C      both, A and C
                  60°     B C D    core of C: A switches to C between 10° and 60°, about equal at 30°
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from typing import Any

from .. import _core
from ..conventions.doubts import doubts_in
from ..text import listed
from .candidates import Outcome
from .memory import memory_text, taken, unused
from .thresholds import BASELINE, about_equal
from .views import SAME_ANGLE, LabelledView, axis_of

MEMORY = "memory"
NOTHING_SEEN = "nothing to compare in any view: no camera sees anything that looks up a texel"
NO_TEXEL = "no pixel of the view looks up a texel of its maps"


@dataclass(frozen=True)
class Standing:
    """A candidate with a budget over all views; `error` is the mean or the worst, whichever is ranked by.

    `sd` is the standard deviation of the error where the texels shift, None where that was not counted in every view.
    `unseen` says that it failed only because no view shows anything to compare.
    """

    memory: int
    candidate: str
    technique: str
    text: str
    maps: int | None
    resolution: int | None
    mean: float | None = None
    worst: float | None = None
    worst_view: str = ""
    error: float | None = None
    variance: float = 0.0
    sd: float | None = None
    notes: tuple[_core.Note, ...] = ()
    failure: str = ""
    unseen: bool = False
    rank: int | None = None
    ratio_to_best: float | None = None
    ratio_to_uniform: float | None = None
    about_best: bool = False

    @property
    def doubted(self) -> bool:
        """Whether its matrices are hardly maps of the light, so that it is not ranked."""
        return bool(doubts_in(self.notes))

    @property
    def ranked(self) -> bool:
        """Whether it takes part."""
        return self.error is not None and not self.doubted

    @property
    def unused(self) -> float | None:
        """The share of the budget that its maps do not take; None where there are none."""
        known = self.maps is not None and self.resolution is not None
        return unused(self.memory, self.maps or 0, self.resolution or 0) if known else None

    def row(self) -> dict[str, Any]:
        """The row of `Advice.table`."""
        size = None if self.maps is None or self.resolution is None else taken(self.maps, self.resolution)
        return {
            "memory": self.memory, "rank": self.rank, "technique": self.candidate, "spec": self.text,
            "maps": self.maps, "resolution": self.resolution, "bytes": size, "unused_memory": self.unused,
            "error_mean": self.mean, "error_worst": self.worst, "error_sd": self.sd,
            "worst_view": self.worst_view,
            "ratio_to_best": self.ratio_to_best, "ratio_to_uniform": self.ratio_to_uniform,
            "about_best": self.about_best, "notes": "; ".join(map(str, self.notes)), "failure": self.failure,
        }  # fmt: skip


def counted_views(outcomes: Sequence[Outcome]) -> list[str]:
    """The views in which any candidate could be measured; the others say nothing about any."""
    return list(dict.fromkeys(o.view.label for o in outcomes if o.error is not None))


def standings(outcomes: Sequence[Outcome], over: str) -> list[Standing]:
    """All candidates and budgets: budgets rising, within each the best first, those without a number last."""
    counted = counted_views(outcomes)
    groups: dict[tuple[int, str], list[Outcome]] = {}
    for one in outcomes:
        groups.setdefault((one.memory, one.candidate), []).append(one)
    found = []
    for memory in sorted({memory for memory, _ in groups}):
        found += ranked([standing_of(of, counted, over) for (m, _), of in groups.items() if m == memory])
    return found


def standing_of(of: Sequence[Outcome], counted: Sequence[str], over: str) -> Standing:
    """A candidate with a budget over the views that count."""
    first = of[0]
    used = [o for o in of if o.view.label in counted] if counted else list(of)
    sides = [o.resolution for o in of if o.resolution is not None]
    maps = max((o.maps for o in of if o.maps is not None), default=None)
    notes = tuple(dict.fromkeys(note for o in used for note in o.notes))
    head = (first.memory, first.candidate, first.technique, first.text, maps, sides[0] if sides else None)
    failure = failure_of(used)
    if failure:
        return Standing(*head, notes=notes, failure=failure)
    if not counted or all(o.error is None for o in used):
        return Standing(*head, notes=notes, failure=NOTHING_SEEN, unseen=True)
    mean = sum(float(o.error or 0.0) for o in used) / len(used)
    last = max(used, key=lambda o: float(o.error or 0.0))
    worst = float(last.error or 0.0)
    deciding = used if over == "mean" else [last]
    # Of a mean over views whose errors scatter each for itself.
    variance = sum(o.variance for o in deciding) / len(deciding) ** 2
    known = [o.sd for o in deciding if o.sd is not None]
    sd = math.hypot(*known) / len(known) if len(known) == len(deciding) else None
    error = mean if over == "mean" else worst
    return Standing(*head, mean, worst, last.view.label, error, variance, sd, notes)


def failure_of(used: Sequence[Outcome]) -> str:
    """Why a candidate has no number over all views, and in which views; nothing where it has."""
    reasons: dict[str, list[str]] = {}
    for one in used:
        missing = NO_TEXEL if one.error is None and any(o.error is not None for o in used) else ""
        if reason := one.failure or missing:
            reasons.setdefault(reason, []).append(one.view.label)
    parts = [
        reason if len(views) == len(used) else f"{reason} (in {len(views)} of {len(used)} views: {listed(views)})"
        for reason, views in reasons.items()
    ]
    return "; ".join(parts)


def ranked(of_budget: Sequence[Standing]) -> list[Standing]:
    """The standings of one budget in order, with rank and ratios. Whatever order they come in, the result is one."""
    order = sorted(of_budget, key=lambda s: (not s.ranked, bool(s.failure), s.error or 0.0, s.maps or 0, s.candidate))
    valid = [s for s in order if s.ranked]
    plain = min((float(s.error or 0.0) for s in valid if s.technique == BASELINE), default=None)
    made = []
    for one in order:
        if not one.ranked:
            made.append(one)
            continue
        error, best = float(one.error or 0.0), valid[0]
        least = float(best.error or 0.0)
        made.append(
            replace(
                one,
                rank=1 + sum(float(s.error or 0.0) < error for s in valid),
                ratio_to_best=ratio(error, least),
                ratio_to_uniform=None if plain is None else ratio(error, plain),
                about_best=about_equal(error, least, one.variance + best.variance),
            )
        )
    return made


def ratio(error: float, other: float) -> float:
    """One error over another; 1 where neither has any."""
    return error / other if other > 0 else 1.0 if error == 0 else math.inf


# An error with its variance, by candidate: what is known at one view or budget.
Point = Mapping[str, tuple[float, float]]


@dataclass(frozen=True, order=True)
class Stretch:
    """Points in a row, from the first to the last, at all of which a candidate is about equal to the best."""

    winner: str
    first: int
    last: int


def stretches(points: Sequence[Point]) -> list[Stretch]:
    """As few as there can be, in order, each as long as can be: neighbours overlap where both are about equal.

    Points in the other order give the same stretches, mirrored; but for candidates with the very same sum of errors,
    of which the names decide. No point may be without candidates.
    """
    near = [about_best(point) for point in points]
    latest = greedy_starts(near)
    # The same from the other end: the first point after each stretch that ends as early as can be.
    earliest = [len(near) - start for start in reversed(greedy_starts(near[::-1]))]
    # The least sum of errors over the cores; sums are exact, so that the order of summands is none of the result.
    ways: list[tuple[Fraction, list[str], tuple[Stretch, ...]]] = [(Fraction(0), [], ())]
    for start, end in zip(latest, earliest, strict=True):
        options = [
            (
                extended(near, name, start, end),
                sum((Fraction(point[name][0]) for point in points[start:end]), Fraction(0)),
            )
            for name in sorted(set.intersection(*near[start:end]))
        ]
        found = []
        for one, cost in options:
            # Between two winners no point is left where neither is about best.
            fitting = [way for way in ways if not way[2] or way[2][-1].last + 1 >= one.first]
            if fitting:
                total, names, path = min(fitting)
                found.append((total + cost, sorted([*names, one.winner]), (*path, one)))
        ways = found
    return list(min(ways)[2])


def about_best(point: Point) -> set[str]:
    """The best candidate, and those about equal to it."""
    best, (least, spread) = min(point.items(), key=lambda item: (item[1][0], item[0]))
    return {best} | {name for name, (error, variance) in point.items() if about_equal(error, least, variance + spread)}


def greedy_starts(near: Sequence[set[str]]) -> list[int]:
    """Where stretches begin that end as late as can be: a new one begins where no candidate is left of the last."""
    starts: list[int] = []
    kept = set[str]()
    for i, names in enumerate(near):
        if not kept & names:
            starts.append(i)
            kept = names
        kept = kept & names
    return starts


def extended(near: Sequence[set[str]], name: str, start: int, end: int) -> Stretch:
    """The stretch of a candidate from a core, as far as it is about best without a gap."""
    while start > 0 and name in near[start - 1]:
        start -= 1
    while end < len(near) and name in near[end]:
        end += 1
    return Stretch(name, start, end - 1)


def switches(outcomes: Sequence[Outcome], ranking: Sequence[Standing]) -> list[dict[str, Any]]:
    """Where the winner changes: by the light for each budget and camera, and along budgets over all views."""
    counted = counted_views(outcomes)
    rows: list[dict[str, Any]] = []
    unranked = {s.candidate for s in ranking if s.doubted}
    valid = [o for o in outcomes if o.error is not None and o.view.label in counted and o.candidate not in unranked]
    for camera, of_camera in rows_of_views(valid).items():
        axis = axis_of([o.view for o in of_camera])
        for memory in sorted({o.memory for o in of_camera}):
            here = [o for o in of_camera if o.memory == memory]
            order = {o.view.label: o.view for o in sorted(here, key=lambda o: place_of(o.view, axis))}
            points = [
                {o.candidate: (float(o.error or 0.0), o.variance) for o in here if o.view.label == label}
                for label in order
            ]
            places = [(label, getattr(view, axis)) for label, view in order.items()]
            rows += changes(points, places, {"along": axis.replace("_", " "), "camera": camera, "memory": memory})
    budgets = sorted({s.memory for s in ranking})
    points = [
        {s.candidate: (float(s.error or 0.0), s.variance) for s in ranking if s.memory == m and s.ranked}
        for m in budgets
    ]
    places = [(memory_text(m), float(m)) for m in budgets]
    return rows + changes(points, places, {"along": MEMORY, "camera": "", "memory": None})


def rows_of_views(valid: Sequence[Outcome]) -> dict[str, list[Outcome]]:
    """What lies in one row by its light: the views of each camera; with one light those of all cameras."""
    if len({o.view.light_label for o in valid}) == 1:
        return {"": [o for o in valid if o.view.light_angle is not None]}
    groups: dict[str, list[Outcome]] = {}
    for one in valid:
        if one.view.light_angle is not None:
            groups.setdefault(one.view.camera_label, []).append(one)
    return groups


def place_of(view: LabelledView, axis: str) -> tuple[int, float, str]:
    """Where a view stands in its row; the other angle, then the label, order those in one place."""
    angle, elevation = view.light_angle or 0.0, view.light_elevation or 0.0
    own, other = (angle, elevation) if axis == "light_angle" else (elevation, angle)
    return round(own / SAME_ANGLE), other, view.label


def changes(
    points: Sequence[Point], places: Sequence[tuple[str, float | None]], head: Mapping[str, Any]
) -> list[dict[str, Any]]:
    """A row for each change of winner along points at places (label, number)."""
    known = [i for i, point in enumerate(points) if point]
    points, places = [points[i] for i in known], [places[i] for i in known]
    rows = []

    def error(i: int, name: str) -> float | None:
        return points[i][name][0] if name in points[i] else None

    for before, after in pairwise(stretches(points)):
        # The last point without the new winner and the first without the old one; all between have both.
        left, right = after.first - 1, before.last + 1
        both = places[left + 1 : right] or [("", None)]
        rows.append({
            **head, "from": places[left][0], "to": places[right][0], "at_from": places[left][1],
            "at_to": places[right][1], "equal_from": both[0][1], "equal_to": both[-1][1],
            "winner_from": before.winner, "winner_to": after.winner, "error_from": error(left, before.winner),
            "error_to": error(right, after.winner), "other_from": error(left, after.winner),
            "other_to": error(right, before.winner),
        })  # fmt: skip
    return rows
