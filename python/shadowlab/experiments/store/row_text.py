"""A row as the text that is kept of it, and back, bit for bit; and the digest that a reader holds it against.

The text is JSON, so that other programs read it (`sqlite3 runs.sqlite "select json_extract(row, '$.misclassified')
from runs"`). A float has as many digits as tell it from its neighbours; an infinity is 1e999, which is JSON and reads
as one.
"""

from __future__ import annotations

import hashlib
import json
import math
import struct
from collections.abc import Mapping
from typing import TypeAlias

import numpy as np

from ...errors import ArgumentError
from ...text import shown

#: What a cell of a row may hold.
Cell: TypeAlias = bool | int | float | str | None

DIGEST_BYTES_OF_ROW = 16
LARGEST_INT = (1 << 63) - 1
#: Letters of a name of a column, and names of a row: far more than any table has, and soon written.
LONGEST_NAME, MOST_CELLS = 200, 2000
#: Letters of a row: far more than its notes have, and less than SQLite takes.
LONGEST_ROW = 1 << 24


def text_of_row(row: object) -> str:
    """The text of a row.

    Raises
    ------
    ArgumentError
        For something that is no mapping, names that are no texts, cells of another type than `Cell`, and integers of
        more than 64 bits. NaN is kept as None, for it stands for no number.
    """
    if not isinstance(row, Mapping):
        raise ArgumentError(f"row: expected a mapping of columns to values, got {shown(row)}; give run.row()")
    try:
        cells = list(row.items())
    except Exception:  # noqa: BLE001 - mappings of callers may raise whatever they like
        raise ArgumentError(f"row: expected a mapping of columns to values, got {shown(row)}; give a dict") from None
    if len(cells) > MOST_CELLS:
        raise ArgumentError(f"row: expected at most {MOST_CELLS:,} columns, got {len(cells):,}; leave some out")
    text = "{" + ",".join([f"{_name(name)}:{_cell(name, value)}" for name, value in cells]) + "}"
    if len(text) > LONGEST_ROW:
        raise ArgumentError(f"row: expected at most {LONGEST_ROW:,} letters, got {len(text):,}; shorten its texts")
    return text


def row_of_text(text: str) -> dict[str, Cell]:
    """The row of a text.

    Raises
    ------
    ValueError
        For a text that `text_of_row` does not write.
    """
    row = json.loads(text)
    if not isinstance(row, dict) or not all(isinstance(v, (bool, int, float, str, type(None))) for v in row.values()):
        raise ValueError("not a row")
    return row


def of_64_bits(value: int) -> int | float:
    """A whole number as a cell has it: as a float where it has more bits than a column of whole numbers."""
    return value if -LARGEST_INT - 1 <= value <= LARGEST_INT else float(value)


def digest_of_row(key: bytes, version: int, done: bool, text: bytes) -> bytes:
    """The digest of all that is kept of a row."""
    head = struct.pack("<qqI", version, done, len(key))
    return hashlib.blake2b(head + key + text, digest_size=DIGEST_BYTES_OF_ROW).digest()


def digest_of_state(rows: int, digests: bytes) -> bytes:
    """The digest of what is kept of all rows together: how many there are, and their digests xored."""
    return hashlib.blake2b(struct.pack("<q", rows) + digests, digest_size=DIGEST_BYTES_OF_ROW).digest()


def xored(digests: bytes, *others: bytes) -> bytes:
    """Digests taken together: those that come twice cancel."""
    found = int.from_bytes(digests, "little")
    for other in others:
        found ^= int.from_bytes(other, "little")
    return found.to_bytes(DIGEST_BYTES_OF_ROW, "little")


def _name(name: object) -> str:
    if not isinstance(name, str) or not 0 < len(name) <= LONGEST_NAME:
        raise ArgumentError(
            f"row: expected names of columns of 1 to {LONGEST_NAME} letters, got {shown(name)}; rename it"
        )
    return _json_text(name, name)


def _cell(name: str, value: object) -> str:
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, bool):
        return "null" if value is None else "true" if value else "false"
    if isinstance(value, str):
        return _json_text(name, value)
    if isinstance(value, int):
        if not -LARGEST_INT - 1 <= value <= LARGEST_INT:
            raise ArgumentError(f"row: {name}: expected an integer of 64 bits, got {shown(value)}; give it as a text")
        return int.__repr__(value)
    if isinstance(value, float):
        number = float.__repr__(value)
        return number if math.isfinite(value) else "null" if math.isnan(value) else number.replace("inf", "1e999")
    raise ArgumentError(f"row: {name}: expected None, a bool, an int, a float or a str, got {shown(value)}; convert it")


def _json_text(name: str, value: str) -> str:
    try:
        value.encode()
    except UnicodeEncodeError:
        raise ArgumentError(f"row: {shown(name)}: expected text that UTF-8 encodes, got {shown(value)}") from None
    return json.dumps(str(value), ensure_ascii=False)
