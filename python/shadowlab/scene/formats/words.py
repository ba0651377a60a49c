"""Text files as bytes: one encoding and one end of line, comments removed; numbers of many lines at once."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]

#: Page breaks are spaces.
_PAGES = bytes.maketrans(b"\f\v", b"  ")
_NEWLINE = 10
#: Bytes that are read at once: about 0.03 s.
_PIECE = 1 << 20
_SPACE = re.compile(rb"[ \t\n\f\v\r]")
_SPACES = np.zeros(256, bool)
_SPACES[[9, 10, 11, 12, 13, 32]] = True


def plain_text(data: bytes) -> bytes:
    """The text with a newline at the end of every line, in an encoding that has ASCII's letters and digits."""
    for mark, encoding in ((b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16")):
        if data.startswith(mark):
            data = data.decode(encoding, "replace").encode()
    data = data.removeprefix(b"\xef\xbb\xbf")
    if not (b"\r" in data or b"\f" in data or b"\v" in data):
        return data if data.endswith(b"\n") else data + b"\n"
    data = data if data.endswith((b"\n", b"\r")) else data + b"\n"
    return b"".join([_plain(piece) for piece in line_pieces(data)])


def _plain(text: bytes) -> bytes:
    return text.replace(b"\r\n", b"\n").replace(b"\r", b"\n").translate(_PAGES)


def line_pieces(text: bytes) -> Iterator[bytes]:
    """The text in pieces of whole lines, so that an interruption need not wait for all of it."""
    place = 0
    while place < len(text):
        end = text.find(b"\n", place + _PIECE) + 1 or len(text)
        yield text[place:end]
        place = end


def without_comments(data: bytes) -> bytes:
    """The text without what follows a "#" at the beginning of a word; its lines stay."""
    if b"#" not in data:
        return data
    return b"".join([_uncommented(piece) if b"#" in piece else piece for piece in line_pieces(data)])


def _uncommented(text: bytes) -> bytes:
    """Lines without their comments."""
    raw = np.frombuffer(text, np.uint8)
    begins = raw == ord("#")
    begins[1:] &= _SPACES[raw[:-1]]
    places = np.flatnonzero(begins)
    newlines = np.append(np.flatnonzero(raw == _NEWLINE), len(raw))
    line, first = np.unique(np.searchsorted(newlines, places), return_index=True)
    # One from the first comment of a line to the line's end, which stays.
    inside = np.zeros(len(raw) + 1, np.int8)
    inside[places[first]] = 1
    inside[newlines[line]] -= 1
    kept: Bytes = raw[np.add.accumulate(inside[:-1], dtype=np.int8) == 0]
    return kept.tobytes()


def readable(data: bytes) -> str:
    """A short piece of a file for an error."""
    text = data.decode("utf-8", "replace").strip()
    return repr(text if len(text) <= 60 else f"{text[:57]}...")


def spaces(text: bytes) -> NDArray[np.bool_]:
    """Which bytes stand between words."""
    return _SPACES[np.frombuffer(text, np.uint8)]


def words_per_line(text: bytes, *, with_blank: bool = True) -> NDArray[np.int64]:
    """How many words each line has, blank lines among them or not; every line ends in a newline."""
    raw = np.frombuffer(text, np.uint8)
    found = []
    after_space, left = True, 0
    for place in range(0, len(raw), _PIECE):
        part = raw[place : place + _PIECE]
        space = _SPACES[part]
        begins = ~space
        begins[1:] &= space[:-1]
        begins[0] &= after_space
        after_space = bool(space[-1])
        edges = np.concatenate([[0], np.flatnonzero(part == _NEWLINE) + 1])
        if len(edges) > 1:
            counts = np.add.reduceat(begins[: edges[-1]], edges[:-1], dtype=np.int64)
            counts[0] += left
            found.append(counts if with_blank else counts[counts > 0])
            left = 0
        left += int(begins[edges[-1] :].sum())
    return np.concatenate(found) if found else np.zeros(0, np.int64)


def plain_numbers(text: bytes, dtype: Any = np.float64) -> NDArray[Any]:
    """The numbers at the beginning of a text; fewer than its words where one of them is no number."""
    if len(text) <= _PIECE and (alone := _parsed_numbers(text, dtype)) is not None:
        return alone
    # Grows in place: to join pieces would take as much again.
    found, count, place = np.empty(min(len(text), _PIECE), dtype), 0, 0
    while place < len(text):
        # Pieces, since nothing interrupts the parser.
        end = _SPACE.search(text, place + _PIECE)
        piece = text[place : len(text) if end is None else end.start()]
        place += len(piece)
        if piece.isspace():
            continue
        values = _parsed_numbers(piece, dtype)
        parsed = _first_numbers(piece, dtype) if values is None else values
        if count + len(parsed) > len(found):
            found.resize(max(2 * len(found), count + len(parsed)), refcheck=False)
        found[count : count + len(parsed)] = parsed
        count += len(parsed)
        if values is None:
            break
    found.resize(count, refcheck=False)
    return found


def _first_numbers(text: bytes, dtype: Any) -> NDArray[Any]:
    """The numbers before the first word that is none."""
    kind = float if np.dtype(dtype).kind == "f" else int
    for word in re.finditer(rb"\S+", text):
        if first_that_is_no_number([word[0]], kind) is not None:
            found = _parsed_numbers(text[: word.start()], dtype)
            return np.zeros(0, dtype) if found is None else found
    return np.zeros(0, dtype)


def _parsed_numbers(text: bytes, dtype: Any) -> NDArray[Any] | None:
    """The numbers of a text; None where one of its words is none."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)
        try:
            return np.fromstring(text, dtype=dtype, sep=" ")
        except (ValueError, DeprecationWarning):
            return None


def first_that_is_no_number(words: list[bytes], kind: type[int] | type[float]) -> int | None:
    """The place of the first word that is no number."""
    for place, word in enumerate(words):
        try:
            if b"_" in word:
                return place  # digits in groups are Python's alone
            kind(word)
        except ValueError:
            return place
    return None
