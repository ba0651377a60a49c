"""The rows of tables as plain values and as CSV, without pandas: to import it takes longer than a small study."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from ..text import is_missing
from .columns import COLUMNS, TABLES

_PLAIN: Mapping[str, Callable[[Any], Any]] = {"str": str, "Int64": int, "float64": float, "boolean": bool}


def records(name: str, rows: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """The rows of the table of that name as plain values; None where a cell holds nothing, texts are empty there."""
    return [{one: plain_cell(one, row.get(one)) for one in TABLES[name]} for row in rows]


def plain_cell(column: str, value: object) -> Any:
    """A value as the type of its column."""
    kind = COLUMNS[column].dtype
    if is_missing(value):
        return "" if kind == "str" else None
    return _PLAIN[kind](value)


def csv_text(name: str, rows: Iterable[Mapping[str, Any]]) -> str:
    """The `records` of the table of that name as CSV, letter by letter as pandas writes it."""
    lines = io.StringIO()
    writer = csv.DictWriter(lines, TABLES[name], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return lines.getvalue()
