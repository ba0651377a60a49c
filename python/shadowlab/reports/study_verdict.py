"""What a study's table says, in plain English; no sentence without a row behind it.

The question that readers bring: which technique at which resolution is good enough here, and is the warp worth it?
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import repeat
from typing import TYPE_CHECKING, Any, NamedTuple

from .._core import Note
from ..experiments.counts import WrongPixels, maps_of, most_unjudged, relation, texels
from ..experiments.thresholds import FEW_PIXELS, LITTLE_SEEN, hardly_wrong
from ..text import is_missing, listed, share_text
from .study_errors import best_row, error_sentences
from .study_uniform import memory_sentences, warp_sentences
from .words import (
    amount,
    count_details,
    doubt_of,
    judged_sentences,
    noise_sentences,
    pixels_text,
    place,
    rows_of,
    size_text,
    unwarped_maps,
)

if TYPE_CHECKING:
    import pandas as pd

# Why counts are told as about equal.
SO_CLOSE = "the difference is within the noise, or less than one part in twenty"


class Remarks(NamedTuple):
    """What a run says beside the numbers of its row: its notes, and what its technique says in refusing the view."""

    notes: Sequence[Note] = ()
    refusal: str = ""


def sentences(
    table: pd.DataFrame | Sequence[Mapping[str, Any]],
    technique_of_label: Mapping[str, str] | None = None,
    *,
    remarks: Sequence[Remarks] | None = None,
    seen: float | None = None,
) -> list[str]:
    """The sentences of a study's verdict on its table, the most important one first.

    Where more than one visible pixel in a hundred is undecided or not compared, that comes before any result.

    Parameters
    ----------
    table : DataFrame, or sequence of mappings
        As `Study.table` or `Study.rows`.
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
    elif any(is_missing(row["misclassified"]) for row in drawn):
        found.append("The truth was not traced, so nothing is said about errors.")
    elif drawn[0]["compared"] == 0:
        found.append(_nothing_compared(drawn[0]))
    else:
        # Of several maps one that warps is enough.
        flat = ((row, *unwarped_maps(notes, maps_of(row))) for row, notes in noted)
        unwarped = {row["technique"]: reason for row, many, reason in flat if many >= maps_of(row)}
        warped = [row for row in drawn if row["technique"] not in unwarped]
        ranked = _ranked(drawn, unwarped)
        found += judged_sentences(most_unjudged(WrongPixels.of(row) for row in drawn))
        found += _fewest(ranked)
        if all(hardly_wrong(int(row["misclassified"]), float(row["share"])) for row in drawn):
            found.append(f"This view hardly tests shadows: no run has {FEW_PIXELS} wrong pixels or more.")
        else:
            found += _about_as_few(ranked)
            found += warp_sentences(warped, technique_of_label)
            found += memory_sentences(drawn, technique_of_label)
            found += error_sentences(best_row(ranked))
            found += noise_sentences([WrongPixels.of(row) for row in drawn])
        for label, reason in unwarped.items():
            found.append(f"{label} does not warp here ({reason}): its map is a uniform one.")
    for label, doubt in dict.fromkeys(doubted):
        found.append(f"{label} is left out of the ranking: {doubt.rstrip('.')}.")
    if seen is not None and 0 < seen < LITTLE_SEEN:
        found.append(f"Only {share_text(seen)} of the picture's pixels show anything: move the camera closer.")
    return found + _failures(failed)


def _ranked(drawn: Sequence[Mapping[str, Any]], unwarped: Mapping[str, str]) -> list[Mapping[str, Any]]:
    """The rows to choose from: of techniques that do not warp, whose maps may be alike, only what beats the others."""
    wrong = {id(row): WrongPixels.of(row).count for row in drawn}
    least = min((wrong[id(row)] for row in drawn if row["technique"] not in unwarped), default=None)
    return [row for row in drawn if least is None or row["technique"] not in unwarped or wrong[id(row)] < least]


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


def _nothing_compared(row: Mapping[str, Any]) -> str:
    """Why there is no number: nothing seen, or nothing that rays could decide."""
    if int(row["undecided"]) > 0:
        return f"No pixel could be compared: the truth of all {int(row['undecided']):,} visible pixels is undecided."
    return "No pixel could be compared: the camera sees nothing of the scene."


def _fewest(drawn: Sequence[Mapping[str, Any]]) -> list[str]:
    """Which row has the fewest wrong pixels; ties go to the smallest map."""
    wrong = [WrongPixels.of(row) for row in drawn]
    least = min(one.count for one in wrong)
    best = [row for row, one in zip(drawn, wrong, strict=True) if one.count == least]
    cheapest = min(texels(row) for row in best)
    best = [row for row in best if texels(row) == cheapest]
    mine = WrongPixels.of(best[0])
    if len(drawn) == 1 and least > 0:
        return [f"{place(best[0])} gets {pixels_text(mine)} wrong ({count_details(best)})."]
    sizes = dict.fromkeys(size_text(row) for row in best)
    who = f"{listed([row['technique'] for row in best])} at {next(iter(sizes))}"
    who = who if len(sizes) == 1 else listed([place(row) for row in best])
    if least == 0:
        verb = "gets" if len(best) == 1 else "get"
        return [f"{who} {verb} all {mine.compared:,} compared pixels right."]
    verb = "has" if len(best) == 1 else "share"
    return [f"{who} {verb} the fewest wrong pixels: {pixels_text(mine)} ({count_details(best)})."]


def _about_as_few(drawn: Sequence[Mapping[str, Any]]) -> list[str]:
    """The rows that are too close to the best to choose by the difference."""
    best = best_row(drawn)
    mine = WrongPixels.of(best)
    others = [(row, WrongPixels.of(row)) for row in drawn]
    near = [
        f"{place(row)}, {amount(one)}"
        for row, one in others
        if one.count > mine.count and relation(one, mine) == "about_equal"
    ]
    return [f"About as few have {listed(near)}: {SO_CLOSE}."] if near else []
