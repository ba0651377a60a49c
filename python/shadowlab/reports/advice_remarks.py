"""What an advice says beside its ranking: unequal memory, views that say little, failures, what was not drawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..experiments.candidates import Outcome
from ..experiments.measures import Measure
from ..experiments.memory import MOST_TEXELS, UNUSED_FROM, memory_text
from ..experiments.ranking import Standing
from ..experiments.thresholds import LITTLE_SEEN
from ..experiments.tried import Untried
from ..text import listed, share_text
from .words import MOST_TOLD, doubt_of, unwarped_maps


def unequal_memory(valid: Sequence[Standing], outcomes: Sequence[Outcome]) -> list[str]:
    """Where memory is not as equal as it should be: maps of the largest size, lights of several kinds."""
    sentences = []
    capped = list(dict.fromkeys(s.candidate for s in valid if s.resolution == MOST_TEXELS and (s.unused or 0) > 0))
    if capped:
        their = "its map is" if len(capped) == 1 else "their maps are"
        sentences.append(
            f"{listed(capped[:MOST_TOLD])} cannot use all the memory: {their} the largest, {MOST_TEXELS}²."
        )
    # The one that leaves most, of each budget.
    most = {s.memory: max((o for o in valid if o.memory == s.memory), key=_left) for s in valid}
    short = [s for s in most.values() if _left(s) > UNUSED_FROM]
    if short:
        told = [f"{s.candidate} takes {100 * (1 - _left(s)):.0f} % of {memory_text(s.memory)}" for s in short]
        sentences.append(f"Memory is not quite equal, as sides are whole texels: {listed(told[:MOST_TOLD])}.")
    kinds = sorted({o.view.light.kind for o in outcomes if hasattr(o.view.light, "kind")})
    if len(kinds) > 1:
        sentences.append(
            f"Lights are of several kinds, {listed(kinds)}, and share the resolution of the kind with most maps: ask "
            "for each kind by itself to give each the whole memory."
        )
    return sentences


def _left(one: Standing) -> float:
    """The share of the budget that it leaves because sides are whole texels."""
    return 0.0 if one.resolution == MOST_TEXELS else one.unused or 0.0


def pixels_outside(valid: Sequence[Standing], outcomes: Sequence[Outcome], measure: Measure) -> list[str]:
    """Who leaves pixels without a map: those in shadow are wrong, and no length of a texel counts any of them."""
    names = {s.candidate for s in valid}
    column = "outside_shadow" if measure.population else "outside"
    lost: dict[str, int] = {}
    for one in outcomes:
        if one.candidate in names and (outside := one.numbers.get(column)):
            lost[one.candidate] = max(lost.get(one.candidate, 0), int(outside))
    said = (
        "pixels in shadow of a view outside of its maps, which are lit and wrong."
        if measure.population
        else "pixels of a view outside of its maps, which are lit and count in no texel length."
    )
    most = sorted(lost.items(), key=lambda item: (-item[1], item[0]))[:MOST_TOLD]
    return [f"{name} leaves up to {n:,} {said}" for name, n in most]


def blank_views(outcomes: Sequence[Outcome], counted: Sequence[str], filled: Mapping[str, float]) -> list[str]:
    """Views that say nothing or little."""
    labels = list(dict.fromkeys(o.view.label for o in outcomes))
    blank = [label for label in labels if label not in counted] if counted else []
    little = [label for label in counted if 0 < filled.get(label, 1.0) < LITTLE_SEEN]
    sentences = []
    if blank:
        sentences.append(f"{_views(blank)} nothing to compare and {'is' if len(blank) == 1 else 'are'} left out.")
    if little:
        sentences.append(f"{_views(little)} less than {share_text(LITTLE_SEEN)} of the pixels filled: move closer.")
    return sentences


def _views(labels: Sequence[str]) -> str:
    """Views with their verb."""
    told = list(labels[:MOST_TOLD]) + ([f"{len(labels) - MOST_TOLD} more"] if len(labels) > MOST_TOLD else [])
    return f"The view {told[0]} has" if len(told) == 1 else f"The views {listed(told)} have"


def unwarped_candidates(outcomes: Sequence[Outcome], counted: Sequence[str]) -> list[str]:
    """Where a technique's maps are all uniform ones, and why."""
    found: dict[tuple[str, tuple[str, ...]], list[str]] = {}
    by_candidate: dict[str, dict[str, str]] = {}
    for one in outcomes:
        maps = one.maps or 1
        count, reason = unwarped_maps(one.notes, maps)
        if one.error is not None and one.view.label in counted and count >= maps:
            by_candidate.setdefault(one.candidate, {})[one.view.label] = reason
    for name, of in by_candidate.items():
        found.setdefault((next(iter(of.values())), tuple(of)), []).append(name)
    return [
        f"{listed(sorted(names))} {'does' if len(names) == 1 else 'do'} not warp in {listed(list(views))} ({reason}): "
        f"{'its map is a uniform one' if len(names) == 1 else 'their maps are uniform ones'}."
        for (reason, views), names in sorted(found.items())
    ]


def left_out(ranking: Sequence[Standing]) -> list[str]:
    """What is not ranked, and why; candidates that fail for one reason together."""
    doubted = {s.candidate: doubt_of(s.notes).rstrip(".") for s in ranking if s.doubted and not s.failure}
    sentences = [f"{name} is left out of the ranking: {doubt}." for name, doubt in doubted.items()]
    alike: dict[tuple[str, str], list[str]] = {}
    budgets = {s.memory for s in ranking}
    for name in sorted({s.candidate for s in ranking if s.failure}):
        for reason in dict.fromkeys(s.failure for s in ranking if s.candidate == name and s.failure and not s.unseen):
            where = [s.memory for s in ranking if s.candidate == name and s.failure == reason]
            at = "" if len(where) == len(budgets) else f" at {listed([memory_text(m) for m in where])}"
            alike.setdefault((reason, at), []).append(name)
    told = [f"{listed(names)} failed{at}: {reason.rstrip('.')}." for (reason, at), names in alike.items()]
    more = [f"{len(told) - MOST_TOLD} more failures are in the table."] if len(told) > MOST_TOLD else []
    return sentences + told[:MOST_TOLD] + more


def tried_sentences(ranking: Sequence[Standing], untried: Sequence[Untried]) -> list[str]:
    """What was drawn, by technique, and what was not, with the cause."""
    drawn: dict[str, set[str]] = {}
    for one in ranking:
        drawn.setdefault(one.technique, set()).add(one.candidate)
    names = [name if len(of) == 1 else f"{name} ({len(of)} settings)" for name, of in drawn.items()]
    sentences = [f"Drawn: {listed(sorted(names))}."] if len(names) > 1 else []
    alike: dict[str, list[str]] = {}
    for left in untried:
        at = "" if left.memory is None else f" at {memory_text(left.memory)}"
        causes = {
            "light": f"not for {listed(list(left.lights) or ['such'])} lights", "not_asked": "not asked for",
            "same": f"the map of {left.twin}", "predicted": f"predicted to be worse{at}",
        }  # fmt: skip
        alike.setdefault(causes[left.cause], []).append(left.technique)
    told = [f"{listed(names)} ({cause})" for cause, names in alike.items()]
    return [*sentences, *([f"Not drawn, so nothing is said of them: {'; '.join(told)}."] if told else [])]
