"""How rows of a study's table are said: their sizes, counts and ratios, and which of their maps did not warp."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

from .._core import Note
from ..conventions.doubts import doubts_in
from ..experiments.counts import WrongPixels, maps_of
from ..experiments.thresholds import UNJUDGED
from ..text import listed, share_text

if TYPE_CHECKING:
    import pandas as pd

# Switches, failures and the like that are told; the rest is counted and left to the tables.
MOST_TOLD = 4


def unwarped_maps(notes: Sequence[Note], maps: int) -> tuple[int, str]:
    """How many of so many maps did not warp, as a run's notes say, and the reasons."""
    unwarped = [note for note in notes if note.kind == "no_warp"]
    found = sum(maps if note.maps is None else len(note.maps) for note in unwarped)
    # The first detail is the reason; others add numbers to it.
    return found, "; ".join(dict.fromkeys(note.reasons[0] for note in unwarped if note.reasons))


def doubt_of(notes: Sequence[Note]) -> str:
    """What speaks against a given matrix; empty where nothing does."""
    return "; ".join(doubts_in(notes))


def rows_of(table: pd.DataFrame | Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """The rows of a table, by the names of its columns."""
    return list(table) if isinstance(table, Sequence) else cast("list[Mapping[str, Any]]", table.to_dict("records"))


def place(row: Mapping[str, Any]) -> str:
    """Label and size of a row."""
    return f"{row['technique']} at {size_text(row)}"


def size_text(row: Mapping[str, Any]) -> str:
    """The size of a row's maps: 1024², or 4 × 1024² of four."""
    maps = maps_of(row)
    return f"{int(row['resolution'])}²" if maps == 1 else f"{maps} × {int(row['resolution'])}²"


def deviation(sd: float) -> str:
    """A standard deviation with two digits."""
    return f"{sd:,.0f}" if sd >= 99.5 else f"{sd:.2g}"


def count_text(wrong: WrongPixels) -> str:
    """A number of wrong pixels with its noise, where that was measured."""
    return f"{wrong.count:,.0f}" if wrong.sd is None else f"{wrong.count:,.0f} ± {deviation(wrong.sd)}"


def pixels_text(wrong: WrongPixels) -> str:
    """The same with its noun."""
    return f"{count_text(wrong)} pixel{'' if wrong.count == 1 and wrong.sd is None else 's'}"


def amount(wrong: WrongPixels) -> str:
    """The same with its share of the compared pixels."""
    return f"{count_text(wrong)} ({share_text(wrong.share)})"


def wrong_text(wrong: WrongPixels) -> str:
    """The same with a noun in its middle."""
    noun = "wrong pixel" if wrong.count == 1 and wrong.sd is None else "wrong pixels"
    return f"{count_text(wrong)} {noun} ({share_text(wrong.share)})"


def against(mine: WrongPixels, other: WrongPixels) -> str:
    """Two numbers of wrong pixels with their shares, where the sentence has the noun already."""
    return f"{amount(mine)} against {amount(other)}"


def judged_sentences(unjudged: float, view: str = "") -> list[str]:
    """How much of the picture, or of a view, a verdict is about, where that is not nearly all of it."""
    if unjudged <= UNJUDGED:
        return []
    where = f" of {view}" if view else ""
    return [
        f"Only {share_text(1 - unjudged)} of the visible pixels{where} could be judged; {share_text(unjudged)} are "
        "undecided or not compared."
    ]


def noise_sentences(wrong: Sequence[WrongPixels]) -> list[str]:
    """What stands behind the signs of plus and minus, where there are any."""
    phases = sorted({one.phases for one in wrong if one.sd is not None})
    if not phases:
        return []
    counts = listed([str(n) for n in phases])
    return [
        f"Counts with ± are the mean and standard deviation over {counts} shifts of the texels by parts of a texel."
    ]


def split(row: Mapping[str, Any]) -> str:
    """The two kinds of error of a row."""
    return f"{int(row['false_shadow']):,} false shadow, {int(row['false_light']):,} false light"


def count_details(rows: Sequence[Mapping[str, Any]]) -> str:
    """Share, compared pixels and kinds of error of runs with equal counts: what holds for all of them, no more."""
    wrong = [WrongPixels.of(row) for row in rows]
    # The kinds are of the map as fitted, whose count is not the mean over shifts.
    kinds = ["as fitted " * (one.sd is not None) + split(row) for one, row in zip(wrong, rows, strict=True)]
    shares = [f"{share_text(one.share)} of {one.compared:,} compared" for one in wrong]
    both = [texts[0] for texts in (shares, kinds) if len(set(texts)) == 1]
    return "; ".join(both) or f"up to {share_text(max(one.share for one in wrong))} of those compared"


def times(ratio: float) -> str:
    """A ratio of 1 or more as people write it: 1.5, 12, 1,200."""
    return f"{ratio:,.0f}" if ratio >= 9.95 else f"{ratio:.1f}".removesuffix(".0")


def factor(ratio: float) -> str:
    """A ratio of any size with two digits, never as a power of ten."""
    if ratio >= 0.995:
        return times(ratio)
    return "less than 0.01" if 0 < ratio < 0.00995 else f"{ratio:.2g}"


def span(ratios: Sequence[float]) -> str:
    """One ratio, or the range of several."""
    low, high = times(min(ratios)), times(max(ratios))
    return low if low == high else f"{low} to {high}"
