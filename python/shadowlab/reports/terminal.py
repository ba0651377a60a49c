"""Tables as aligned text, short enough for a terminal: those of a study and of an advice."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..experiments.counts import WrongPixels
from ..experiments.measures import Measure
from ..experiments.memory import UNUSED_FROM, memory_text
from ..experiments.ranking import Standing
from ..text import is_missing, px_text, share_text
from .words import deviation, rows_of, size_text

if TYPE_CHECKING:
    import pandas as pd

# What `study_cells` are. The length of a texel in the image is that of 95 % of the pixels.
STUDY_HEADS = (
    "technique", "resolution", "wrong", "share", "false shadow", "false light", "texel", "fit", "map", "look-up",
)  # fmt: skip
# What `advice_cells` are.
ADVICE_HEADS = ("memory", "rank", "candidate", "maps", "taken", "mean", "worst", "of best", "of uniform")
# Letters of a failure that the table shows; all of it is in the verdict and the data.
LONGEST_FAILURE = 60
FAILED = "failed"


def study_table(table: pd.DataFrame | Sequence[Mapping[str, Any]]) -> str:
    """The table of a study."""
    return aligned(STUDY_HEADS, [study_cells(row) for row in rows_of(table)], left=(0,))


def advice_table(standings: Sequence[Standing], measure: Measure) -> str:
    """The table of an advice; a failure stands at the end of its line."""
    failed = [i for i, one in enumerate(standings) if not has_numbers(one)]
    return aligned(ADVICE_HEADS, [advice_cells(one, measure) for one in standings], left=(0, 2), failed=failed)


def aligned(
    heads: Sequence[str], rows: Sequence[Sequence[str]], *, left: Collection[int], failed: Collection[int] = ()
) -> str:
    """The heads, a rule and the rows, columns as wide as their longest cell, those in `left` flush left.

    The last cell of the rows in `failed` may be longer than its column is wide: no other line is widened for it.
    """
    lines, last = [heads, *rows], len(heads) - 1
    whole = [heads, *(row for i, row in enumerate(rows) if i not in failed)]
    widths = [max(len(line[i]) for line in (lines if i < last else whole)) for i in range(len(heads))]
    text = [
        "  ".join(
            cell.ljust(width) if i in left else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(line, widths, strict=True))
        )
        for line in lines
    ]
    return "\n".join([text[0], "-" * len(text[0]), *(line.rstrip() for line in text[1:])])


def study_cells(row: Mapping[str, Any]) -> list[str]:
    """A row of the table as people read it; a dash where nothing was measured."""

    def shown(key: str, form: Callable[[Any], str]) -> str:
        return "–" if is_missing(row[key]) else form(row[key])

    return [
        str(row["technique"]),
        size_text(row),
        FAILED if row["failure"] else shown("misclassified", "{:,}".format) + noise_text(row),
        shown("share", share_text),
        shown("false_shadow", "{:,}".format),
        shown("false_light", "{:,}".format),
        shown("texel_p95", px_text),
        shown("fit_us", lambda v: f"{v:.1f} µs" if v < 1000 else f"{v / 1000:.1f} ms"),
        shown("map_ms", lambda v: f"{v:.1f} ms"),
        shown("lookup_ms", lambda v: f"{v:.1f} ms"),
    ]


def noise_text(row: Mapping[str, Any]) -> str:
    """The noise behind a count of wrong pixels; empty where it was not measured."""
    sd = WrongPixels.of(row).sd
    return "" if sd is None else f" ± {deviation(sd)}"


def has_numbers(one: Standing) -> bool:
    """Whether it has numbers."""
    return one.mean is not None and one.worst is not None


def advice_cells(one: Standing, measure: Measure) -> tuple[str, ...]:
    """A row of the table as people read it; a dash where nothing was measured."""
    size = (
        "–" if one.resolution is None else f"{one.maps} × {one.resolution}²" if one.maps != 1 else f"{one.resolution}²"
    )
    row = one.row()
    taken = (
        "–"
        if row["bytes"] is None
        else f"{row['bytes'] / 2**20:,.2f} MiB"
        if row["bytes"] >= 0.995 * 2**20
        else f"{row['bytes'] / 2**10:,.4g} KiB"
    )
    if (one.unused or 0.0) > UNUSED_FROM:
        taken += f" ({100 * (1 - (one.unused or 0.0)):.0f} %)"
    head = (memory_text(one.memory), "–" if one.rank is None else str(one.rank), one.candidate, size, taken)
    if one.mean is None or one.worst is None:
        short = one.failure if len(one.failure) <= LONGEST_FAILURE else f"{one.failure[:LONGEST_FAILURE]}…"
        return (*head, "–", "–", "–", f"{FAILED}: {short}")
    ratios = (
        "–" if r is None else "∞" if math.isinf(r) else f"{r:.2f}" if r < 9.95 else f"{r:,.0f}"
        for r in (one.ratio_to_best, one.ratio_to_uniform)
    )
    # The noise is that of the error which is ranked by.
    by_mean = one.error == one.mean
    mean = measure.noisy_text(one.mean, one.sd if by_mean else None)
    worst = measure.noisy_text(one.worst, None if by_mean else one.sd)
    return (*head, mean, worst, *ratios)
