"""What an advice says, in plain English; no sentence without a row behind it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..aliasing.causes import CAUSES, CauseName
from ..experiments.candidates import Outcome
from ..experiments.measures import Measure
from ..experiments.memory import MOST_TEXELS, UNUSED_FROM, memory_text
from ..experiments.ranking import MEMORY, Standing, counted_views
from ..experiments.thresholds import BASELINE, FEW_PIXELS, LITTLE_SEEN, MAIN_CAUSE, hardly_wrong
from ..experiments.views import degrees
from ..text import listed, share_text
from .words import doubt_of, times, unwarped_maps

# Switches, failures and the like that are told; the rest is counted and left to the tables.
MOST_TOLD = 4
OF_BIAS: dict[CauseName, str] = {
    "acne": "surfaces that shadow themselves; more bias trades them for leaks",
    "leak": "light that its bias lets through (without the bias they would be dark); less bias trades them for acne",
}


def advice_text(
    ranking: Sequence[Standing],
    switched: Sequence[Mapping[str, Any]],
    outcomes: Sequence[Outcome],
    measure: Measure,
    over: str,
    filled: Mapping[str, float],
) -> str:
    """A few sentences on standings and switches; `filled` is the share of pixels that show anything, by view."""
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
        for memory in budgets:
            of = [s for s in valid if s.memory == memory]
            if of:
                sentences.append(_best(of, measure, over, len(counted)))
        if measure.caveat:
            sentences.append(measure.caveat)
        elif measure.name == "misclassified" and _nothing_wrong(outcomes):
            sentences.append(f"These views hardly test shadows: no run has {FEW_PIXELS} wrong pixels or more.")
        else:
            sentences += _switches(switched, measure, several, len(budgets))
            sentences += _poor(valid, measure, over if several else "")
            sentences += _causes(valid, outcomes, counted)
    sentences += _unequal(valid, outcomes)
    sentences += _outside(valid, outcomes)
    sentences += _blank(outcomes, counted, filled)
    sentences += _unwarped(outcomes, counted)
    return " ".join(sentences + _left_out(ranking))


def _nothing(outcomes: Sequence[Outcome], filled: Mapping[str, float]) -> str:
    """Why there is no number at all."""
    if outcomes and all(o.failure for o in outcomes):
        return "No candidate gave a result."
    if not any(filled.values()):
        where = "the camera sees" if len({o.view.camera_label for o in outcomes}) == 1 else "the cameras see"
        return f"Nothing could be compared: {where} nothing of the scene."
    return "Nothing could be compared: no pixel that is seen looks up a texel, or the truth of all is undecided."


def _at(one: Standing) -> str:
    """A candidate with the size of its maps."""
    maps = f"{one.resolution}²" if one.maps == 1 else f"{one.maps} × {one.resolution}²"
    return f"{one.candidate} ({maps})"


def _best(of: Sequence[Standing], measure: Measure, over: str, views: int) -> str:
    """Who is best with one budget, against uniform, and who does as well."""
    best = of[0]
    mean, worst = float(best.mean or 0.0), float(best.worst or 0.0)
    if views == 1:
        value = measure.text(mean)
    elif over == "mean":
        value = (
            f"{measure.text(mean)} on average over {views} views ({measure.text(worst)} at worst: {best.worst_view})"
        )
    else:
        value = f"{measure.text(worst)} at worst of {views} views ({best.worst_view}; {measure.text(mean)} on average)"
    head = f"At {memory_text(best.memory)}, {_at(best)} has the least {measure.title}: {value}"
    if len(of) == 1:
        head = f"At {memory_text(best.memory)}, {_at(best)} has this {measure.title}: {value}"
    if measure.caveat:
        return f"{head}."
    near = [s for s in of[1:] if s.about_best]
    plain = min((s for s in of if s.technique == BASELINE), key=lambda s: float(s.error or 0.0), default=None)
    text = head + (_beside_uniform(best, plain, measure) if len(of) > 1 else "") + "."
    others = [s.candidate for s in near if s is not plain]
    if others:
        told = others if len(others) <= MOST_TOLD else [*others[:MOST_TOLD], f"{len(others) - MOST_TOLD} more"]
        does = "does" if len(told) == 1 else "do"
        text += f" {listed(told)} {does} about as well ({measure.equal_because})"
        fewest = min(near, key=lambda s: s.maps or 0)
        if (fewest.maps or 0) < (best.maps or 0):
            text += f"; {fewest.candidate} needs only {fewest.maps} map{'' if fewest.maps == 1 else 's'}"
        text += "."
    return text


def _beside_uniform(best: Standing, plain: Standing | None, measure: Measure) -> str:
    """The best beside a uniform map of as much memory."""
    if plain is None:
        return ""
    if plain.candidate == best.candidate:
        return ": no warp or split is worth it here"
    mine, other = float(best.error or 0.0), float(plain.error or 0.0)
    if plain.about_best:
        return f", about as much as {plain.candidate} ({measure.text(other)}): no warp or split is worth it here"
    if mine == 0:
        return f", where {plain.candidate} has {measure.text(other)} in as much memory"
    return f", {times(other / mine)} times less than {plain.candidate} in as much memory ({measure.text(other)})"


def _nothing_wrong(outcomes: Sequence[Outcome]) -> bool:
    """Whether no run has wrong pixels worth the name."""
    wrong = [o.numbers for o in outcomes if o.error is not None and "misclassified" in o.numbers]
    return bool(wrong) and all(hardly_wrong(n["misclassified"] or 0, n["share"] or 0.0) for n in wrong)


def _switches(switched: Sequence[Mapping[str, Any]], measure: Measure, several: bool, budgets: int) -> list[str]:
    """Where the winner changes, or that it does not."""
    alike: dict[tuple[Any, ...], list[Mapping[str, Any]]] = {}
    for row in switched:
        names = ("along", "camera", "from", "to", "winner_from", "winner_to")
        alike.setdefault(tuple(row[name] for name in names), []).append(row)
    # What holds with most budgets first, the rest as in the table.
    order = sorted(alike.values(), key=lambda rows: (rows[0]["along"] != MEMORY, -len(rows)))
    sentences = [_switch(rows, measure, budgets) for rows in order[:MOST_TOLD]]
    if len(order) > MOST_TOLD:
        sentences.append(f"The table of switches has {sum(map(len, order[MOST_TOLD:]))} more.")
    angles = any(row["along"] != MEMORY for row in switched)
    if several and not angles:
        each = "with each budget, one" if budgets > 1 else "one"
        sentences.append(
            f"The answer does not switch between views: {each} candidate is best or about equal all along."
        )
    return sentences


def _switch(rows: Sequence[Mapping[str, Any]], measure: Measure, budgets: int) -> str:
    """One change of winner, with the numbers of the largest budget that has it."""
    row = rows[-1]
    of = f" in {memory_text(row['memory'])}" if len(rows) > 1 else ""

    def beside(own: float | None, other: float | None, rival: str) -> str:
        mine = "–" if own is None else measure.text(own)
        if own is not None and other is not None and other < own:
            # It stays the winner here for what it is in the views next to this one.
            return f"({mine}{of}, {measure.equal_because} of {rival}'s {measure.text(other)})"
        return f"({mine}{of}; {rival} {'has no number' if other is None else measure.text(other)})"

    first = f"{row['winner_from']} {beside(row['error_from'], row['other_from'], row['winner_to'])}"
    second = f"{row['winner_to']} {beside(row['error_to'], row['other_to'], row['winner_from'])}"
    if row["along"] == MEMORY:
        return (
            f"The answer switches with memory: up to {row['from']} {first}, from {row['to']} on {second}"
            f"{_equal(row, lambda size: memory_text(int(size)), measure)}."
        )
    low, high = degrees(row["at_from"]), degrees(row["at_to"])
    head = (
        "With every budget the"
        if len(rows) == budgets
        else f"At {listed([memory_text(r['memory']) for r in rows])} the"
    )
    head = head if budgets > 1 else "The"
    where = f" for {row['camera']}" if row["camera"] not in ("", "camera") else ""
    if low == high:
        return f"{head} answer switches between two views{where}: in {row['from']} {first}, in {row['to']} {second}."
    return (
        f"{head} answer switches at a {row['along']} between {low} and {high}{where}: at {low} {first}, at {high} "
        f"{second}{_equal(row, degrees, measure)}."
    )


def _equal(row: Mapping[str, Any], place: Callable[[float], str], measure: Measure) -> str:
    """The stretch within a switch where both winners are about equal, if there is one."""
    if row["equal_from"] is None:
        return ""
    first, last = place(row["equal_from"]), place(row["equal_to"])
    where = f"at {first}" if first == last else f"from {first} to {last}"
    return f"; {where} both do about as well ({measure.equal_because})"


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
        f"No candidate is good here: even the best has {measure.text(value)}{how} at {memory_text(most)}, and from "
        f"{measure.text(measure.poor_from)} on, {measure.poor_because}.{more}"
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


def _unequal(valid: Sequence[Standing], outcomes: Sequence[Outcome]) -> list[str]:
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


def _outside(valid: Sequence[Standing], outcomes: Sequence[Outcome]) -> list[str]:
    """Who leaves pixels without a map, which no length of a texel counts."""
    names = {s.candidate for s in valid}
    lost: dict[str, int] = {}
    for one in outcomes:
        if one.candidate in names and (outside := one.numbers.get("outside")):
            lost[one.candidate] = max(lost.get(one.candidate, 0), int(outside))
    return [
        f"{name} leaves up to {n:,} pixels of a view outside of its maps, which are lit and count in no texel length."
        for name, n in lost.items()
    ][:MOST_TOLD]


def _blank(outcomes: Sequence[Outcome], counted: Sequence[str], filled: Mapping[str, float]) -> list[str]:
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


def _unwarped(outcomes: Sequence[Outcome], counted: Sequence[str]) -> list[str]:
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


def _left_out(ranking: Sequence[Standing]) -> list[str]:
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
