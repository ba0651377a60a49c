"""On which line of a TOML document each key stands, which `tomllib` does not say.

The document has been parsed, so it is well-formed: it is divided into statements, and each is parsed once more alone.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from typing import Any, TypeAlias

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

#: Keys from the top of a document; a whole number stands for one table of an array of tables, from 0.
KeyPlace: TypeAlias = "tuple[str | int, ...]"

_THREE = ('"""', "'''")


def key_lines(text: str) -> dict[KeyPlace, int]:
    """The line, from 1, of every key and table header of a document."""
    lines: dict[KeyPlace, int] = {}
    arrays: dict[KeyPlace, int] = {}
    table: KeyPlace = ()
    for line, statement in statements(text):
        if statement.startswith("["):
            table = placed(_path(tomllib.loads(statement)), arrays)
            if statement.startswith("[["):
                arrays[table] = arrays.get(table, -1) + 1
                table = (*table, arrays[table])
            _note(lines, table, 0, line)
        else:
            _note(lines, (*table, *_path(tomllib.loads(statement))), len(table), line)
    return lines


def _note(lines: dict[KeyPlace, int], place: KeyPlace, known: int, line: int) -> None:
    """Notes the line of a place and of what is above it, as far as that has none."""
    for length in range(known + 1, len(place) + 1):
        lines.setdefault(place[:length], line)
    lines.setdefault(place, line)


def placed(path: KeyPlace, arrays: Mapping[KeyPlace, int]) -> KeyPlace:
    """The place that keys of a header lead to: of an array of tables above it the last table is meant."""
    place: KeyPlace = ()
    for i, key in enumerate(path):
        place = (*place, key)
        if place in arrays and i < len(path) - 1:
            place = (*place, arrays[place])
    return place


def _path(data: Any) -> KeyPlace:
    """The keys down to the value of one statement."""
    path: KeyPlace = ()
    while isinstance(data, dict) and len(data) == 1:
        ((key, data),) = data.items()
        path = (*path, key)
    return path


def statements(text: str) -> Iterator[tuple[int, str]]:
    """Line and text of each statement of a document: a header, or a key with its value, which may take many lines."""
    begin = at = depth = 0
    line = 1
    text += "\n"
    while at < len(text):
        letter = text[at]
        if letter in "\"'":
            at = end_of_string(text, at)
            continue
        if letter == "#":
            # Comments are no part of the statement before them, and may hold quotes and brackets.
            at = text.index("\n", at)
            continue
        depth += (letter in "[{") - (letter in "]}")
        at += 1
        if letter == "\n" and depth == 0:
            statement = text[begin:at].strip()
            if statement and not statement.startswith("#"):
                yield line, statement
            line += text.count("\n", begin, at)
            begin = at


def end_of_string(text: str, at: int) -> int:
    """The place after a string that begins at `at`."""
    mark = text[at : at + 3] if text.startswith(_THREE, at) else text[at]
    at += len(mark)
    while not text.startswith(mark, at):
        at += 2 if text[at] == "\\" and mark[0] == '"' else 1
    at += len(mark)
    # Up to two quotes may stand before the three that close a string.
    while len(mark) == 3 and text.startswith(mark[0], at):
        at += 1
    return at
