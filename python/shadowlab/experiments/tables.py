"""A study's table and progress as text on a terminal."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ..reports.words import size_text
from ..text import px_text, share_text

# What `cells` are. The length of a texel in the image is that of 95 % of the pixels.
HEADS = ("technique", "resolution", "wrong", "share", "false shadow", "false light", "texel", "fit", "map", "mask")


def text_table(table: Any) -> str:
    """The table as aligned text, short enough for a terminal."""
    heads = HEADS
    lines: list[tuple[str, ...]] = [heads]
    for row in table.to_dict("records"):
        lines.append(tuple(cells(row)))
    widths = [max(len(line[i]) for line in lines) for i in range(len(heads))]
    text = [
        "  ".join(
            cell.ljust(width) if i == 0 else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(line, widths, strict=True))
        )
        for line in lines
    ]
    return "\n".join([text[0], "-" * len(text[0]), *text[1:]])


def cells(row: Mapping[str, Any]) -> list[str]:
    """A row of the table as people read it; a dash where nothing was measured."""
    import pandas as pd

    def shown(key: str, form: Callable[[Any], str]) -> str:
        return "–" if pd.isna(row[key]) else form(row[key])

    return [
        str(row["technique"]),
        size_text(row),
        "failed" if row["failure"] else shown("misclassified", "{:,}".format),
        shown("share", share_text),
        shown("false_shadow", "{:,}".format),
        shown("false_light", "{:,}".format),
        shown("texel_p95", px_text),
        shown("fit_us", lambda v: f"{v:.1f} µs" if v < 1000 else f"{v / 1000:.1f} ms"),
        shown("map_ms", lambda v: f"{v:.1f} ms"),
        shown("lookup_ms", lambda v: f"{v:.1f} ms"),
    ]
