"""What a study's table says of warps and splits against uniform maps: at equal texels, and with what more maps cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..experiments.counts import (
    Comparison,
    WrongPixels,
    against_uniform,
    baselines,
    best_warp,
    maps_of,
    relation,
    texels,
)
from ..experiments.thresholds import SLIGHT
from ..text import listed, share_text
from .words import against, amount, factor, place, span, times, wrong_text


def warp_sentences(drawn: Sequence[Mapping[str, Any]], technique_of_label: Mapping[str, str]) -> list[str]:
    """Techniques against the best uniform map of their resolution, at equal texels, and the one that does as well."""
    pairs = against_uniform(drawn, technique_of_label)
    if not pairs:
        return []
    best = best_warp(pairs)
    first = next(row for row in drawn if (row["technique"], row["resolution"]) == (best, pairs[best][0].resolution))
    sentences = [_ratio(pairs[best]), *_same_error(first, baselines(drawn, technique_of_label))]
    return sentences + _others({label: pairs[label] for label in pairs if label != best})


def _others(pairs: Mapping[str, Sequence[Comparison]]) -> list[str]:
    """The techniques beside the best, in one sentence."""
    parts: list[str] = []
    for label, of in pairs.items():
        ratios = [one.ratio for one in of if one.ratio is not None]
        if ratios:
            low, high = factor(min(ratios)), factor(max(ratios))
            ends = (of[0], of[-1]) if len(of) > 1 else of
            counts = " to ".join(dict.fromkeys(amount(one.mine) for one in ends))
            noun = "" if parts else " the wrong pixels"
            parts.append(f"{label} {low if low == high else f'{low} to {high}'} times{noun}, {counts}")
    return [f"Relative to uniform at equal resolution the others leave: {'; '.join(parts)}."] if parts else []


def _ratio(pairs: Sequence[Comparison]) -> str:
    """Is the warp worth it: told for one pair in full, for several as a range."""
    if len(pairs) == 1:
        return _single_ratio(pairs[0])
    label, base_label = pairs[0].technique, pairs[0].baseline
    where = f"from {pairs[0].resolution}² to {pairs[-1].resolution}²"
    better = sum(one.relation == "fewer" for one in pairs)
    worse = sum(one.relation == "more" for one in pairs)
    ratios = [one.other.count / one.mine.count for one in pairs if one.mine.count > 0 and one.other.count > 0]
    slightly = bool(ratios) and len(ratios) == len(pairs) and min(ratios) >= 1 / SLIGHT and max(ratios) <= SLIGHT
    ends = f"{against(pairs[0].mine, pairs[0].other)}, to {against(pairs[-1].mine, pairs[-1].other)}"
    if better == len(pairs):
        how = "slightly better" if slightly else "worth it"
        spread = f"{span(ratios)} times fewer wrong pixels, " if ratios and not slightly else ""
        return f"{label} is {how} here: it is better than {base_label} at every resolution {where}: {spread}{ends}."
    if worse == len(pairs):
        how = "slightly worse" if slightly else "not worth it"
        spread = f"{span([1 / r for r in ratios])} times as many wrong pixels, " if ratios else ""
        return f"{label} is {how} here: it is worse than {base_label} at every resolution {where}: {spread}{ends}."
    equal = len(pairs) - better - worse
    return (
        f"Whether {label} is worth it depends on the resolution here: against {base_label} it is better at {better}, "
        f"worse at {worse} and about equal at {equal} of {len(pairs)} resolutions: {ends}."
    )


def _single_ratio(pair: Comparison) -> str:
    """Is the warp worth it at one resolution."""
    label, base_label, where = pair.technique, pair.baseline, f"at {pair.resolution}²"
    mine, base = pair.mine.count, pair.other.count
    text = against(pair.mine, pair.other)
    if pair.relation == "about_equal":
        many = f"about as many wrong pixels as {base_label}"
        return f"{label} {where} makes little difference here: it leaves {many}, {text}."
    if pair.relation == "fewer":
        if mine == 0:
            has = f"{base_label} has {wrong_text(pair.other)}"
            return f"{label} is worth it here: {where} it leaves no wrong pixel where {has}."
        if base / mine <= SLIGHT:
            less = f"{share_text(1 - mine / base)} fewer wrong pixels than {base_label}"
            return f"{label} is slightly better here: {where} it leaves {less}, {text}."
        fewer = f"{times(base / mine)} times fewer wrong pixels than {base_label}"
        return f"{label} is worth it here: {where} it leaves {fewer}, {text}."
    if base == 0:
        return f"{label} is not worth it here: {where} it has {wrong_text(pair.mine)} where {base_label} has none."
    if mine / base <= SLIGHT:
        more = f"{share_text(mine / base - 1)} more wrong pixels than {base_label}"
        return f"{label} is slightly worse here: {where} it has {more}, {text}."
    many = f"{times(mine / base)} times as many wrong pixels as {base_label}"
    return f"{label} is not worth it here: {where} it has {many}, {text}."


def _same_error(row: Mapping[str, Any], uniform: Mapping[int, Mapping[str, Any]]) -> list[str]:
    """The smallest uniform map of the run that does as well as this row, where larger ones were in the run."""
    resolution = int(row["resolution"])
    larger = sorted(r for r in uniform if r > resolution)
    wrong = WrongPixels.of(row)

    def as_well(r: int) -> bool:
        return relation(WrongPixels.of(uniform[r]), wrong) != "more"

    if not larger or as_well(resolution):
        return []
    for r in larger:
        if as_well(r):
            ratio = texels(uniform[r]) / texels(row)
            many = "as many texels" if ratio == 1 else f"{times(ratio)} times the texels"
            return [
                f"Of the sizes run, {uniform[r]['technique']} first does as well at {r}² as {place(row)}, with "
                f"{many}: {wrong_text(WrongPixels.of(uniform[r]))} against {amount(wrong)}."
            ]
    least = WrongPixels.of(uniform[larger[-1]])
    return [
        f"No uniform map of this run, up to {larger[-1]}², does as well as {place(row)}: {wrong_text(least)} against "
        f"{amount(wrong)}."
    ]


def memory_sentences(drawn: Sequence[Mapping[str, Any]], technique_of_label: Mapping[str, str]) -> list[str]:
    """What techniques gain with other numbers of maps than the uniform ones, with what that costs in the same sentence.

    At equal memory where the run has a uniform map of as many texels, else at equal resolution.
    """
    uniform = baselines(drawn, technique_of_label)
    first: dict[str, Mapping[str, Any]] = {}
    for row in sorted(drawn, key=lambda r: int(r["resolution"])):
        base = uniform.get(int(row["resolution"]))
        if maps_of(row) > 1 if base is None else texels(row) != texels(base):
            first.setdefault(row["technique"], row)
    sentences: list[str] = []
    bare: dict[int, list[str]] = {}
    for row in first.values():
        mine, base = WrongPixels.of(row), uniform.get(int(row["resolution"]))
        large = [r for r in uniform.values() if texels(r) >= texels(row)]
        if large and maps_of(row) > 1:
            as_large = min(large, key=texels)
            ratio = texels(as_large) / texels(row)
            many = "as many texels as" if ratio == 1 else f"{times(ratio)} times the texels of"
            counts = f"{wrong_text(WrongPixels.of(as_large))} against {amount(mine)}"
            sentences.append(f"{place(as_large)} has {many} {place(row)}, and {counts}.")
        elif base is not None:
            other = WrongPixels.of(base)
            cost = f"with {factor(texels(row) / texels(base))} times the texels"
            sentences.append(f"{place(row)} leaves {_gain(mine, other)} {place(base)}, {cost}: {against(mine, other)}.")
        else:
            bare.setdefault(maps_of(row), []).append(row["technique"])
    if any(maps_of(row) == 1 for row in drawn):
        for maps, labels in bare.items():
            draw = "draws" if len(labels) == 1 else "draw"
            sentences.append(
                f"{listed(labels)} {draw} {maps} maps, {maps} times the texels of one at equal resolution."
            )
    return sentences


def _gain(mine: WrongPixels, other: WrongPixels) -> str:
    """The wrong pixels of a row beside another's."""
    found = relation(mine, other)
    if found == "about_equal":
        return "about as many wrong pixels as"
    if mine.count == 0 or other.count == 0:
        return "fewer wrong pixels than" if found == "fewer" else "more wrong pixels than"
    return (
        f"{times(other.count / mine.count)} times fewer wrong pixels than"
        if found == "fewer"
        else f"{times(mine.count / other.count)} times as many wrong pixels as"
    )
