"""What a study's table says, in plain English; no sentence without a row behind it.

The question that readers bring: which technique at which resolution is good enough here, and is the warp worth it?
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import repeat
from typing import TYPE_CHECKING, Any, NamedTuple

from .._core import Note
from ..experiments.thresholds import BASELINE, FEW_PIXELS, LITTLE_SEEN, SLIGHT, about_equal, hardly_wrong
from ..text import listed, share_text
from .study_errors import best_row, error_sentences
from .words import (
    count,
    count_details,
    doubt_of,
    factor,
    maps_of,
    missing,
    place,
    rows_of,
    size_text,
    span,
    texels,
    times,
    unwarped_maps,
)

if TYPE_CHECKING:
    import pandas as pd


class Remarks(NamedTuple):
    """What a run says beside the numbers of its row: its notes, and what its technique says in refusing the view."""

    notes: Sequence[Note] = ()
    refusal: str = ""


def sentences(
    table: pd.DataFrame,
    technique_of_label: Mapping[str, str] | None = None,
    *,
    remarks: Sequence[Remarks] | None = None,
    seen: float | None = None,
) -> list[str]:
    """The sentences of a study's verdict on its table, the most important one first.

    Parameters
    ----------
    table : DataFrame
        As `Study.table`.
    technique_of_label : mapping, optional
        The technique behind each label, so that a uniform map is known as the baseline under any label. The labels
        themselves where none is given.
    remarks : sequence of Remarks, optional
        Those of the run behind each row; none where none are given. The texts in the table are not read.
    seen : float, optional
        The share of the picture's pixels that show any surface.

    Returns
    -------
    list of str
    """
    technique_of_label = technique_of_label or {}
    rows = rows_of(table)
    told = list(zip(rows, repeat(Remarks()) if remarks is None else remarks, strict=remarks is not None))
    failed = [(row, said.refusal) for row, said in told if row["failure"]]
    done = [(row, said.notes) for row, said in told if not row["failure"]]
    doubted = [(row["technique"], doubt_of(notes)) for row, notes in done if doubt_of(notes)]
    noted = [(row, notes) for row, notes in done if not doubt_of(notes)]
    drawn = [row for row, _ in noted]
    found = []
    if not done:
        found.append("No technique gave a result.")
    elif not drawn:
        found.append("Nothing is ranked.")
    elif any(missing(row["misclassified"]) for row in drawn):
        found.append("The truth was not traced, so nothing is said about errors.")
    elif drawn[0]["compared"] == 0:
        found.append(_nothing_compared(drawn[0]))
    else:
        # Of several maps one that warps is enough.
        flat = ((row, *unwarped_maps(notes, maps_of(row))) for row, notes in noted)
        unwarped = {row["technique"]: reason for row, many, reason in flat if many >= maps_of(row)}
        warped = [row for row in drawn if row["technique"] not in unwarped]
        found += _fewest(warped or drawn)
        if all(hardly_wrong(int(row["misclassified"]), float(row["share"])) for row in drawn):
            found.append(f"This view hardly tests shadows: no run has {FEW_PIXELS} wrong pixels or more.")
        else:
            found += _warps_against_uniform(warped, technique_of_label)
            found += _memory(drawn, technique_of_label)
            found += error_sentences(best_row(warped or drawn))
        for label, reason in unwarped.items():
            found.append(f"{label} does not warp here ({reason}): its map is a uniform one.")
    for label, doubt in dict.fromkeys(doubted):
        found.append(f"{label} is left out of the ranking: {doubt.rstrip('.')}.")
    if seen is not None and 0 < seen < LITTLE_SEEN:
        found.append(f"Only {share_text(seen)} of the picture's pixels show anything: move the camera closer.")
    return found + _failures(failed)


def _failures(failed: Sequence[tuple[Mapping[str, Any], str]]) -> list[str]:
    """What failed, techniques that did for one reason together."""
    alike: dict[str, dict[str, str]] = {}
    for row, refusal in failed:
        # The message names the technique, which sets apart what is one reason.
        reason = f"such a technique {refusal}" if refusal else row["failure"]
        alike.setdefault(reason, {})[row["technique"]] = row["failure"]
    return [
        f"{listed(list(of))} failed: {(reason if len(of) > 1 else next(iter(of.values()))).rstrip('.')}."
        for reason, of in alike.items()
    ]


def _alike(first: int, second: int) -> bool:
    """Whether two counts of wrong pixels are too close to choose by: in ratio, or within their noise."""
    return about_equal(first, second, first + second)


def _nothing_compared(row: Mapping[str, Any]) -> str:
    """Why there is no number: nothing seen, or nothing that rays could decide."""
    if int(row["undecided"]) > 0:
        return f"No pixel could be compared: the truth of all {int(row['undecided']):,} visible pixels is undecided."
    return "No pixel could be compared: the camera sees nothing of the scene."


def _fewest(drawn: Sequence[Mapping[str, Any]]) -> list[str]:
    """Which row has the fewest wrong pixels; ties go to the smallest map."""
    least = min(int(row["misclassified"]) for row in drawn)
    if len(drawn) == 1:
        row = drawn[0]
        if least == 0:
            return [f"{place(row)} gets all {int(row['compared']):,} compared pixels right."]
        return [f"{place(row)} gets {count(row)} wrong ({count_details(drawn)})."]
    best = [row for row in drawn if int(row["misclassified"]) == least]
    cheapest = min(texels(row) for row in best)
    best = [row for row in best if texels(row) == cheapest]
    sizes = dict.fromkeys(size_text(row) for row in best)
    who = f"{listed([row['technique'] for row in best])} at {next(iter(sizes))}"
    who = who if len(sizes) == 1 else listed([place(row) for row in best])
    if least == 0:
        compared = int(best[0]["compared"])
        return [f"{who} {'gets' if len(best) == 1 else 'get'} all {compared:,} compared pixels right."]
    verb = "has" if len(best) == 1 else "share"
    return [f"{who} {verb} the fewest wrong pixels: {count(best[0])} ({count_details(best)})."]


def _warps_against_uniform(drawn: Sequence[Mapping[str, Any]], technique_of_label: Mapping[str, str]) -> list[str]:
    """Techniques against the best uniform map of their resolution, at equal texels, and the one that does as well."""
    uniform = _baselines(drawn, technique_of_label)
    warped = [r for r in drawn if technique_of_label.get(r["technique"], r["technique"]) != BASELINE]
    pairs: dict[str, list[tuple[Mapping[str, Any], Mapping[str, Any]]]] = {}
    for row in sorted(warped, key=lambda r: int(r["resolution"])):
        base = uniform.get(int(row["resolution"]))
        if base is not None and texels(base) == texels(row):  # more texels are no merit of a warp
            pairs.setdefault(row["technique"], []).append((row, base))
    if not pairs:
        return []
    best = min(pairs, key=lambda label: min(int(row["misclassified"]) for row, _ in pairs[label]))
    sentences = [_ratio(best, pairs[best]), *_same_error(pairs[best][0][0], uniform)]
    return sentences + _others({label: pairs[label] for label in pairs if label != best})


def _baselines(
    drawn: Sequence[Mapping[str, Any]], technique_of_label: Mapping[str, str]
) -> dict[int, Mapping[str, Any]]:
    """The best uniform run of each resolution."""
    uniform: dict[int, Mapping[str, Any]] = {}
    for row in drawn:
        resolution = int(row["resolution"])
        if technique_of_label.get(row["technique"], row["technique"]) == BASELINE and (
            resolution not in uniform or row["misclassified"] < uniform[resolution]["misclassified"]
        ):
            uniform[resolution] = row
    return uniform


def _others(pairs: Mapping[str, Sequence[tuple[Mapping[str, Any], Mapping[str, Any]]]]) -> list[str]:
    """The techniques beside the best, in one sentence."""
    parts = []
    for label, rows in pairs.items():
        ratios = [int(row["misclassified"]) / int(base["misclassified"]) for row, base in rows if base["misclassified"]]
        if ratios:
            low, high = factor(min(ratios)), factor(max(ratios))
            parts.append(f"{label} {low if low == high else f'{low} to {high}'} times")
    return [f"The others have, of the wrong pixels of uniform at equal resolution: {listed(parts)}."] if parts else []


def _ratio(label: str, pairs: Sequence[tuple[Mapping[str, Any], Mapping[str, Any]]]) -> str:
    """Is the warp worth it: told for one pair in full, for several as a range."""
    outcomes = [(int(row["misclassified"]), int(base["misclassified"])) for row, base in pairs]
    base_label = pairs[0][1]["technique"]
    first, last = int(pairs[0][0]["resolution"]), int(pairs[-1][0]["resolution"])
    where = f"at {first}²" if len(pairs) == 1 else f"from {first}² to {last}²"
    if len(pairs) == 1:
        mine, base = outcomes[0]
        text = f"({mine:,} against {base:,})"
        if _alike(mine, base):
            return f"{label} {where} makes little difference here: about as many wrong pixels as {base_label} {text}."
        if mine < base:
            if mine == 0:
                return f"{label} is worth it here: {where} it leaves no wrong pixel where {base_label} has {base:,}."
            if base / mine <= SLIGHT:
                less = f"{share_text(1 - mine / base)} fewer wrong pixels than {base_label}"
                return f"{label} is slightly better here: {where} it leaves {less} {text}."
            fewer = f"{times(base / mine)} times fewer wrong pixels than {base_label}"
            return f"{label} is worth it here: {where} it leaves {fewer} {text}."
        if base == 0:
            return f"{label} is not worth it here: {where} it has {mine:,} wrong pixels where {base_label} has none."
        if mine / base <= SLIGHT:
            more = f"{share_text(mine / base - 1)} more wrong pixels than {base_label}"
            return f"{label} is slightly worse here: {where} it has {more} {text}."
        many = f"{times(mine / base)} times as many wrong pixels as {base_label}"
        return f"{label} is not worth it here: {where} it has {many} {text}."
    better = sum(mine < base and not _alike(mine, base) for mine, base in outcomes)
    worse = sum(base < mine and not _alike(mine, base) for mine, base in outcomes)
    ratios = [base / mine for mine, base in outcomes if mine > 0 and base > 0]
    slightly = bool(ratios) and len(ratios) == len(pairs) and min(ratios) >= 1 / SLIGHT and max(ratios) <= SLIGHT
    if better == len(pairs):
        how = "slightly better" if slightly else "worth it"
        spread = f" ({span(ratios)} times fewer wrong pixels)" if ratios and not slightly else ""
        return f"{label} is {how} here: it is better than {base_label} at every resolution {where}{spread}."
    if worse == len(pairs):
        how = "slightly worse" if slightly else "not worth it"
        spread = f" ({span([1 / r for r in ratios])} times as many wrong pixels)" if ratios else ""
        return f"{label} is {how} here: it is worse than {base_label} at every resolution {where}{spread}."
    equal = len(pairs) - better - worse
    return (
        f"Whether {label} is worth it depends on the resolution here: against {base_label} it is better at {better}, "
        f"worse at {worse} and about equal at {equal} of {len(pairs)} resolutions."
    )


def _same_error(row: Mapping[str, Any], uniform: Mapping[int, Mapping[str, Any]]) -> list[str]:
    """The smallest uniform map of the run that does as well as this row, where larger ones were in the run."""
    resolution = int(row["resolution"])
    larger = sorted(r for r in uniform if r > resolution)
    wrong = int(row["misclassified"])

    def as_well(r: int) -> bool:
        mine = int(uniform[r]["misclassified"])
        return mine <= wrong or _alike(mine, wrong)

    if not larger or as_well(resolution):
        return []
    for r in larger:
        if as_well(r):
            ratio = texels(uniform[r]) / texels(row)
            many = "as many texels" if ratio == 1 else f"{times(ratio)} times the texels"
            return [
                f"Of the sizes run, {uniform[r]['technique']} first does as well at {r}² as {place(row)} "
                f"({many}; {uniform[r]['misclassified']:,} against {row['misclassified']:,} wrong pixels)."
            ]
    least = uniform[larger[-1]]
    return [
        f"No uniform map of this run, up to {larger[-1]}², does as well as {place(row)} "
        f"({least['misclassified']:,} against {row['misclassified']:,} wrong pixels)."
    ]


def _memory(drawn: Sequence[Mapping[str, Any]], technique_of_label: Mapping[str, str]) -> list[str]:
    """What techniques gain with other numbers of maps than the uniform ones, with what that costs in the same sentence.

    At equal memory where the run has a uniform map of as many texels, else at equal resolution.
    """
    uniform = _baselines(drawn, technique_of_label)
    first: dict[str, Mapping[str, Any]] = {}
    for row in sorted(drawn, key=lambda r: int(r["resolution"])):
        base = uniform.get(int(row["resolution"]))
        if maps_of(row) > 1 if base is None else texels(row) != texels(base):
            first.setdefault(row["technique"], row)
    sentences: list[str] = []
    bare: dict[int, list[str]] = {}
    for row in first.values():
        base = uniform.get(int(row["resolution"]))
        large = [r for r in uniform.values() if texels(r) >= texels(row)]
        if large and maps_of(row) > 1:
            as_large = min(large, key=texels)
            ratio = texels(as_large) / texels(row)
            many = "as many texels as" if ratio == 1 else f"{times(ratio)} times the texels of"
            sentences.append(f"{place(as_large)} has {many} {place(row)}, and {_against(as_large, row)}.")
        elif base is not None:
            cost = f"with {factor(texels(row) / texels(base))} times the texels"
            sentences.append(
                f"{place(row)} leaves {_gain(row, base)} {place(base)}, {cost} ({_both_counts(row, base)})."
            )
        else:
            bare.setdefault(maps_of(row), []).append(row["technique"])
    if any(maps_of(row) == 1 for row in drawn):
        for maps, labels in bare.items():
            draw = "draws" if len(labels) == 1 else "draw"
            sentences.append(
                f"{listed(labels)} {draw} {maps} maps, {maps} times the texels of one at equal resolution."
            )
    return sentences


def _gain(row: Mapping[str, Any], base: Mapping[str, Any]) -> str:
    """The wrong pixels of a row beside another's."""
    mine, other = int(row["misclassified"]), int(base["misclassified"])
    if _alike(mine, other):
        return "about as many wrong pixels as"
    if mine == 0 or other == 0:
        return "fewer wrong pixels than" if mine < other else "more wrong pixels than"
    return (
        f"{times(other / mine)} times fewer wrong pixels than"
        if mine < other
        else (f"{times(mine / other)} times as many wrong pixels as")
    )


def _both_counts(first: Mapping[str, Any], second: Mapping[str, Any]) -> str:
    """The wrong pixels of two rows, bare."""
    return f"{int(first['misclassified']):,} against {int(second['misclassified']):,}"


def _against(first: Mapping[str, Any], second: Mapping[str, Any]) -> str:
    """The wrong pixels of two rows."""
    return f"{int(first['misclassified']):,} wrong pixels against {int(second['misclassified']):,}"
