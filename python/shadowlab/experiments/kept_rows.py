"""Rows of a table that are kept in a file as they are made, so that long work goes on where it stopped."""

from __future__ import annotations

import csv
import hashlib
import pickle
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import ArgumentError
from ..text import shown
from .columns import COLUMNS, frame

if TYPE_CHECKING:
    import pandas as pd

KEY = "key"
DIGEST_BYTES_OF_KEY = 12


class KeptRows:
    """Rows of one kind of table, by their keys, in a CSV file or only in memory.

    Parameters
    ----------
    columns : sequence of str
        Names in `columns.COLUMNS`, "key" among them.
    file : Path, optional
        Where the rows are; read if it is there. None keeps them in memory.

    Raises
    ------
    ArgumentError
        For a file that is no table with these columns.
    """

    def __init__(self, columns: Sequence[str], file: Path | None = None):
        self._columns, self._file = tuple(columns), file
        self._rows: dict[str, dict[str, Any]] = {}
        if file is not None and file.exists():
            self._rows = {row[KEY]: row for row in rows_in(file, self._columns)}

    def get(self, key: str) -> dict[str, Any] | None:
        """The row of a key; None where there is none."""
        return self._rows.get(key)

    def add(self, rows: Mapping[str, Mapping[str, Any]]) -> None:
        """Keeps rows by their keys; the file is whole at every moment."""
        self._rows.update({key: {**row, KEY: key} for key, row in rows.items()})
        if self._file is not None and rows:
            beside = self._file.with_name(f".{self._file.name}.part")
            self.table(list(self._rows)).to_csv(beside, index=False)
            beside.replace(self._file)

    def table(self, keys: Sequence[str]) -> pd.DataFrame:
        """The rows of these keys, in this order."""
        return frame(self._columns, [self._rows[key] for key in keys])


def rows_in(file: Path, columns: Sequence[str]) -> list[dict[str, Any]]:
    """The rows of a CSV file that `KeptRows` wrote; None where a cell is empty."""
    try:
        with file.open(newline="", encoding="utf-8") as stream:
            head, *lines = csv.reader(stream)
        if head != list(columns):
            raise ValueError(f"its columns are {shown(head)}")
        return [{name: read_cell(name, text) for name, text in zip(columns, line, strict=True)} for line in lines]
    except (ValueError, OSError, csv.Error) as error:
        reason = " ".join(str(error).split())
        raise ArgumentError(
            f"out: {str(file)!r} is no table of this experiment ({reason}); remove it, or choose another directory"
        ) from error


def read_cell(name: str, text: str) -> Any:
    """What a cell of a column holds; None where it is empty."""
    if not text:
        return None
    dtype = COLUMNS[name].dtype
    return int(text) if dtype == "Int64" else float(text) if dtype == "float64" else text


def key_of_row(*parts: object) -> str:
    """A digest of everything that a row depends on: texts, numbers, and values that travel."""
    return hashlib.blake2b(pickle.dumps(parts, protocol=4), digest_size=DIGEST_BYTES_OF_KEY).hexdigest()
