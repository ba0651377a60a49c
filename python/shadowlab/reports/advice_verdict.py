"""What an advice says, in plain English; no sentence without a row behind it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..aliasing.causes import CAUSES, CauseName
from ..experiments.candidates import Outcome
from ..experiments.choice import Gain, gains
from ..experiments.counts import WrongPixels
from ..experiments.measures import Measure
from ..experiments.memory import memory_text
from ..experiments.ranking import Standing, counted_views
from ..experiments.thresholds import FEW_PIXELS, MAIN_CAUSE, SLIGHT, hardly_wrong
from ..experiments.tried import Untried
from ..text import listed, share_text
from .advice_remarks import (
    blank_views,
    left_out,
    pixels_outside,
    tried_sentences,
    unequal_memory,
    unwarped_candidates,
)
from .advice_switches import switch_sentences
from .words import MOST_TOLD, judged_sentences, times

OF_BIAS: dict[CauseName, str] = {
    "acne": "surfaces that shadow themselves; more bias trades them for leaks",
    "leak": "light that its bias lets through (without the bias they would be dark); less bias trades them for acne",
}


def advice_sentences(
    ranking: Sequence[Standing],
    switched: Sequence[Mapping[str, Any]],
    outcomes: Sequence[Outcome],
    measure: Measure,
    over: str,
    filled: Mapping[str, float],
    *,
    untried: Sequence[Untried] = (),
) -> list[str]:
    """The sentences on standings and switches, the most important one first.

    Parameters
    ----------
    ranking, switched, outcomes, measure, over
        As `Advice` has them.
    filled : mapping
        The share of pixels that show anything, by view.
    untried : sequence of Untried
        What was not drawn.

    Returns
    -------
    list of str
    """
    counted = counted_views(outcomes)
    several = len(counted) > 1
    sentences: list[str] = []
    budgets = list(dict.fromkeys(s.memory for s in ranking))
    valid = [s for s in ranking if s.ranked]
    if not counted:
        sentences.append(_nothing(outcomes, filled))
    elif not valid:
        sentences.append("No candidate gave a result." if all(s.failure for s in ranking) else "Nothing is ranked.")
    else:
        by_memory = {gain.memory: gain for gain in gains(ranking)}
        sentences += _judged(outcomes, several)
        for memory in budgets:
            of = [s for s in valid if s.memory == memory]
            if of:
                runs = [o for o in outcomes if o.memory == memory and o.error is not None]
                sentences += _best(of, measure, over, runs, by_memory.get(memory))
        if measure.caveat:
            sentences.append(measure.caveat)
        elif measure.name == "misclassified" and _nothing_wrong(outcomes):
            sentences.append(f"These views hardly test shadows: no run has {FEW_PIXELS} wrong pixels or more.")
        else:
            sentences += switch_sentences(switched, measure, several, len(budgets))
            sentences += _poor(valid, measure, over if several else "")
            sentences += _causes(valid, outcomes, counted)
    sentences += unequal_memory(valid, outcomes)
    sentences += pixels_outside(valid, outcomes, measure)
    sentences += blank_views(outcomes, counted, filled)
    sentences += unwarped_candidates(outcomes, counted)
    phases = sorted({int(o.numbers.get("phases") or 1) for o in outcomes if o.sd is not None})
    if phases:
        told = listed([str(n) for n in phases])
        sentences.append(f"Shares with ± are mean and standard deviation over {told} shifts of the texels.")
    sentences += left_out(ranking)
    return sentences + (tried_sentences(ranking, untried) if valid else [])


def _nothing(outcomes: Sequence[Outcome], filled: Mapping[str, float]) -> str:
    """Why there is no number at all."""
    if outcomes and all(o.failure for o in outcomes):
        return "No candidate gave a result."
    if not any(filled.values()):
        where = "the camera sees" if len({o.view.camera_label for o in outcomes}) == 1 else "the cameras see"
        return f"Nothing could be compared: {where} nothing of the scene."
    return "Nothing could be compared: no pixel that is seen looks up a texel, or the truth of all is undecided."


def _judged(outcomes: Sequence[Outcome], several: bool) -> list[str]:
    """How much of the view could be judged; of several views, of the one where that is least."""
    drawn = [o for o in outcomes if o.error is not None]
    least = max(drawn, key=lambda o: WrongPixels.of(o.numbers).unjudged)
    return judged_sentences(WrongPixels.of(least.numbers).unjudged, least.view.label if several else "")


def _at(one: Standing) -> str:
    """A candidate with the size of its maps."""
    maps = f"{one.resolution}²" if one.maps == 1 else f"{one.maps} × {one.resolution}²"
    return f"{one.candidate} ({maps})"


def error_text(one: Standing, measure: Measure) -> str:
    """The error that is ranked by, with its noise where that was counted."""
    return measure.noisy_text(float(one.error or 0.0), one.sd)


def _best(of: Sequence[Standing], measure: Measure, over: str, runs: Sequence[Outcome], gain: Gain | None) -> list[str]:
    """Who is best with one budget, against uniform, and who does as well."""
    best = of[0]
    views = list(dict.fromkeys(o.view.label for o in runs))
    if len(views) == 1:
        value = error_text(best, measure)
        if measure.population:
            (wrong,) = (WrongPixels.of(o.numbers) for o in runs if o.candidate == best.candidate)
            value += f" ({wrong.count:,.0f} of {wrong.compared:,} compared pixels)"
    elif over == "mean":
        worst = f"{measure.text(float(best.worst or 0.0))} at worst: {best.worst_view}"
        value = f"{error_text(best, measure)} on average over {len(views)} views ({worst})"
    else:
        mean = f"{best.worst_view}; {measure.text(float(best.mean or 0.0))} on average"
        value = f"{error_text(best, measure)} at worst of {len(views)} views ({mean})"
    head = f"At {memory_text(best.memory)}, {_at(best)} has the least {measure.title}: {value}"
    if len(of) == 1:
        head = f"At {memory_text(best.memory)}, {_at(best)} has this {measure.title}: {value}"
    if measure.caveat:
        return [f"{head}."]
    near = [s for s in of[1:] if s.about_best]
    found = [head + ("" if gain is None else _beside_uniform(best, gain, measure)) + "."]
    others = [s.candidate for s in near if gain is None or s.candidate != gain.baseline.candidate]
    if others:
        told = others if len(others) <= MOST_TOLD else [*others[:MOST_TOLD], f"{len(others) - MOST_TOLD} more"]
        does = "does" if len(told) == 1 else "do"
        because = measure.equal_because if best.sd is None else "within the noise or one part in twenty"
        text = f"{listed(told)} {does} about as well ({because})"
        fewest = min(near, key=lambda s: s.maps or 0)
        if (fewest.maps or 0) < (best.maps or 0):
            text += f"; {fewest.candidate} needs only {fewest.maps} map{'' if fewest.maps == 1 else 's'}"
        found.append(f"{text}.")
    return found


def _beside_uniform(best: Standing, gain: Gain, measure: Measure) -> str:
    """The best beside a uniform map of as much memory; of warps that were not drawn nothing is said."""
    plain, many = gain.baseline, len(gain.drawn)
    none = f"none of the {many} other candidates drawn has" if many > 1 else "the other candidate drawn does not have"
    other = error_text(plain, measure)
    if plain.candidate == best.candidate:
        return f"; {none} less by more than the noise; {gain.best.candidate} has {error_text(gain.best, measure)}"
    if gain.relation == "about_equal":
        same = f", about as much as {plain.candidate} with {other}"
        return f"{same}; {none} less than that by more than the noise or one part in twenty"
    mine, base = float(best.error or 0.0), float(plain.error or 0.0)
    if mine == 0:
        return f", where {plain.candidate} has {other} in as much memory"
    if base / mine <= SLIGHT:
        return f", {share_text(1 - mine / base)} less than {plain.candidate} in as much memory ({other})"
    return f", {times(base / mine)} times less than {plain.candidate} in as much memory ({other})"


def _nothing_wrong(outcomes: Sequence[Outcome]) -> bool:
    """Whether no run has wrong pixels worth the name."""
    wrong = [o.numbers for o in outcomes if o.error is not None and "misclassified" in o.numbers]
    return bool(wrong) and all(hardly_wrong(n["misclassified"] or 0, n["share"] or 0.0) for n in wrong)


def _poor(valid: Sequence[Standing], measure: Measure, over: str) -> list[str]:
    """A warning where even the best is poor."""
    most = max(s.memory for s in valid)
    best = next(s for s in valid if s.memory == most)
    value = float(best.error or 0.0)
    if value < measure.poor_from:
        return []
    how = {"mean": " on average", "worst": " at worst"}.get(over, "")
    more = ""
    if measure.falls_with == "side":
        # Lengths of texels fall with the side of the map, so memory goes with their square.
        factor = (value / measure.poor_from) ** 2
        more = f" It would take about {times(max(factor, 1.1))} times the memory."
    return [
        f"No candidate drawn is good here: even the best has {measure.text(value)}{how} at {memory_text(most)}, and "
        f"from {measure.text(measure.poor_from)} on, {measure.poor_because}.{more}"
    ]


def _causes(valid: Sequence[Standing], outcomes: Sequence[Outcome], counted: Sequence[str]) -> list[str]:
    """What to look at first where bias, not resolution, makes most of the best one's wrong pixels."""
    most = max(s.memory for s in valid)
    best = next(s for s in valid if s.memory == most)
    runs = [
        o.numbers for o in outcomes if (o.candidate, o.memory) == (best.candidate, most) and o.view.label in counted
    ]
    sums = {cause: sum(n.get(cause) or 0 for n in runs) for cause in CAUSES.values()}
    wrong = sum(n.get("misclassified") or 0 for n in runs)
    return [
        f"{share_text(sums[cause] / wrong)} of the {wrong:,} wrong pixels of {best.candidate} at {memory_text(most)} "
        f"are {words}."
        for cause, words in OF_BIAS.items()
        if wrong >= FEW_PIXELS and sums[cause] > MAIN_CAUSE * wrong
    ]
