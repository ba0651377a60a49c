"""How rows of a study's table are said: their sizes, counts and ratios, and which of their maps did not warp."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

from .._core import Note
from ..text import share_text

if TYPE_CHECKING:
    import pandas as pd


def unwarped_maps(notes: Sequence[Note], maps: int) -> tuple[int, str]:
    """How many of so many maps did not warp, as a run's notes say, and the reasons."""
    unwarped = [note for note in notes if note.kind == "no_warp"]
    found = sum(maps if note.maps is None else len(note.maps) for note in unwarped)
    # The first detail is the reason; others add numbers to it.
    return found, "; ".join(dict.fromkeys(note.reasons[0] for note in unwarped if note.reasons))


def doubt_of(notes: Sequence[Note]) -> str:
    """What speaks against a given matrix; empty where nothing does."""
    return "; ".join(reason for note in notes if note.kind == "check_matrix" for reason in note.reasons)


def rows_of(table: pd.DataFrame) -> list[Mapping[str, Any]]:
    """The rows of a table, by the names of its columns."""
    return cast("list[Mapping[str, Any]]", table.to_dict("records"))


def missing(value: Any) -> bool:
    """Whether a cell of the table holds nothing."""
    import pandas as pd

    return bool(pd.isna(value))


def place(row: Mapping[str, Any]) -> str:
    """Label and size of a row."""
    return f"{row['technique']} at {size_text(row)}"


def maps_of(row: Mapping[str, Any]) -> int:
    """The number of maps of a row; one where it is not known."""
    value = row.get("maps")
    return 1 if value is None or missing(value) else int(value)


def texels(row: Mapping[str, Any]) -> int:
    """The texels of all maps of a row."""
    return maps_of(row) * int(row["resolution"]) ** 2


def size_text(row: Mapping[str, Any]) -> str:
    """The size of a row's maps: 1024², or 4 × 1024² of four."""
    maps = maps_of(row)
    return f"{int(row['resolution'])}²" if maps == 1 else f"{maps} × {int(row['resolution'])}²"


def count(row: Mapping[str, Any]) -> str:
    """The wrong pixels of a row with their noun."""
    n = int(row["misclassified"])
    return f"{n:,} pixel{'' if n == 1 else 's'}"


def percent(row: Mapping[str, Any]) -> str:
    """The share of a row in per cent, three digits."""
    return share_text(float(row["share"]))


def split(row: Mapping[str, Any]) -> str:
    """The two kinds of error of a row."""
    return f"{int(row['false_shadow']):,} false shadow, {int(row['false_light']):,} false light"


def count_details(rows: Sequence[Mapping[str, Any]]) -> str:
    """Share, compared pixels and kinds of error of runs with equal counts: what holds for all of them, no more."""
    texts = [(f"{percent(row)} of {int(row['compared']):,} compared", split(row)) for row in rows]
    both = [text[0] for text in zip(*texts, strict=True) if len(set(text)) == 1]
    return "; ".join(both) or f"up to {share_text(max(float(row['share']) for row in rows))} of those compared"


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
