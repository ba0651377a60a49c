"""Text files as bytes: one encoding and one end of line, comments removed; numbers of many lines at once."""

from __future__ import annotations

import re
import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]

_SPACES = np.zeros(256, bool)
_SPACES[[9, 10, 11, 12, 13, 32]] = True


def plain_text(data: bytes) -> bytes:
    """The text with a newline at the end of every line, in an encoding that has ASCII's letters and digits."""
    for mark, encoding in ((b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16")):
        if data.startswith(mark):
            data = data.decode(encoding, "replace").encode()
    data = data.removeprefix(b"\xef\xbb\xbf")
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return data if data.endswith(b"\n") else data + b"\n"


def without_comments(data: bytes) -> bytes:
    """The text without what follows a "#" at the beginning of a word; its lines stay."""
    return _HASH.sub(_kept_text, data) if b"#" in data else data


#: Begins with a letter that can be searched for, which looking back first cannot.
_HASH = re.compile(rb"#[^\n]*")


def _kept_text(match: re.Match[bytes]) -> bytes:
    """What stays of a line from its first "#" on."""
    place = match.start()
    if place == 0 or match.string[place - 1 : place].isspace():
        return b""
    return re.split(rb"\s#", match[0], maxsplit=1)[0]


def readable(data: bytes) -> str:
    """A short piece of a file for an error."""
    text = data.decode("utf-8", "replace").strip()
    return repr(text if len(text) <= 60 else f"{text[:57]}...")


def spaces(text: bytes) -> NDArray[np.bool_]:
    """Which bytes stand between words."""
    return _SPACES[np.frombuffer(text, np.uint8)]


def words_per_line(text: bytes) -> NDArray[np.int64]:
    """How many words each line has; every line ends in a newline."""
    space = spaces(text)
    begins = ~space
    begins[1:] &= space[:-1]
    ends = np.flatnonzero(np.frombuffer(text, np.uint8) == 10)
    if not len(ends):
        return np.zeros(0, np.int64)
    return np.add.reduceat(begins, np.concatenate([[0], ends[:-1] + 1]), dtype=np.int64)


def plain_numbers(text: bytes, dtype: Any = np.float64) -> NDArray[Any]:
    """The numbers at the beginning of a text; fewer than its words where one of them is no number."""
    found = _parsed_numbers(text, dtype)
    if found is not None:
        return found
    kind = float if np.dtype(dtype).kind == "f" else int
    for word in re.finditer(rb"\S+", text):
        if first_that_is_no_number([word[0]], kind) is not None:
            found = _parsed_numbers(text[: word.start()], dtype)
            break
    return np.zeros(0, dtype) if found is None else found


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
