"""Lines of Wavefront OBJ files by their kind, and the numbers in them.

Source: Wavefront, Advanced Visualizer manual, appendix B1, "Object files (.obj)", version 3.0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...errors import LoadError
from .given import Given
from .words import first_that_is_no_number, plain_numbers, plain_text, readable, without_comments, words_per_line

BLANK, VERTEX, VERTEX_TEXTURE, VERTEX_NORMAL, FACE, STROKE, OTHER = range(7)
#: Bytes of the words that begin the lines of each kind.
_WORDS = {VERTEX: b"v", VERTEX_TEXTURE: b"vt", VERTEX_NORMAL: b"vn", FACE: b"f"}
#: Beyond the end of a file, so that its last line has a second and a third letter.
_PADDING = b"\n\n\n"


@dataclass(frozen=True, eq=False)
class ObjLines:
    """The lines of a file.

    Attributes
    ----------
    name : str
        The file, for errors.
    text : bytes
        Its text without comments, continued lines joined.
    starts : (L + 1,) int64
        Where each line begins, and the end.
    kinds : (L,) int8
    joined : (J,) int64
        Where lines were joined.
    """

    name: str
    text: bytes
    starts: NDArray[np.int64]
    kinds: NDArray[np.int8]
    joined: NDArray[np.int64]

    @classmethod
    def of(cls, given: Given) -> ObjLines:
        """The lines of a file."""
        text = without_comments(plain_text(given.data))
        joined = np.zeros(0, np.int64)
        if b"\\\n" in text:
            text = text.replace(b"\\\n", b" \x01") + b"\n"
            joined = np.flatnonzero(np.frombuffer(text, np.uint8) == 1)
            text = text.replace(b"\x01", b" ")
        raw = np.frombuffer(text + _PADDING, np.uint8)
        ends = np.flatnonzero(raw[: len(text)] == 10)
        starts = np.concatenate([[0], ends + 1])
        first = _after_spaces(raw, starts[:-1])
        a, b, c = raw[first], raw[first + 1], raw[first + 2]
        gap_b, gap_c = (b == 32) | (b == 9), (c == 32) | (c == 9)
        kinds = np.full(len(ends), OTHER, np.int8)
        kinds[a == 10] = BLANK
        v = a == ord("v")
        kinds[v & gap_b] = VERTEX
        kinds[v & (b == ord("t")) & gap_c] = VERTEX_TEXTURE
        kinds[v & (b == ord("n")) & gap_c] = VERTEX_NORMAL
        kinds[(a == ord("f")) & gap_b] = FACE
        kinds[((a == ord("l")) | (a == ord("p"))) & gap_b] = STROKE
        return cls(given.name, text, starts, kinds, joined)

    def number_of(self, line: int) -> int:
        """The number of a line as editors count them."""
        return int(line) + 1 + int(np.searchsorted(self.joined, self.starts[line]))

    def line(self, line: int) -> bytes:
        """The text of a line."""
        return self.text[self.starts[line] : self.starts[line + 1]].strip()

    def of_kind(self, kind: int) -> NDArray[np.int64]:
        """The lines of a kind."""
        return np.flatnonzero(self.kinds == kind)

    def block(self, kind: int) -> bytes:
        """The text of all lines of a kind, without the word that they begin with."""
        chosen = self.kinds == kind
        edges = np.flatnonzero(np.diff(chosen, prepend=False, append=False))
        begins, ends = self.starts[edges[::2]].tolist(), self.starts[edges[1::2]].tolist()
        text = b"\n" + b"".join([self.text[begin:end] for begin, end in zip(begins, ends, strict=True)])
        word = _WORDS[kind]
        if b"\n " in text or b"\n\t" in text:
            lines = [line.strip().removeprefix(word) for line in text.split(b"\n")[1:-1]]
            return b"\n".join([*lines, b""])
        return text.replace(b"\n" + word, b"\n")[1:]

    def rows(self, kind: int, least: int, most: int, what: str) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """The first numbers of every line of a kind, missing ones 0, and how many each line has.

        Raises
        ------
        LoadError
            For a line with fewer than `least` numbers, or with a word that is none.
        """
        lines = self.of_kind(kind)
        text = self.block(kind)
        counts = words_per_line(text)
        values = plain_numbers(text)
        if len(values) != int(counts.sum()):
            for line in lines.tolist():
                words = self.line(line).split()[1:]
                wrong = first_that_is_no_number(words, float)
                if wrong is not None:
                    raise self.refusal(line, f"numbers for its {what}", readable(words[wrong]))
            raise LoadError(f"{self.name}: expected plain decimal numbers for each {what}; check the file")
        if not len(counts):
            return np.zeros((0, most)), counts
        if int(counts.min()) < least:
            line = int(lines[counts.argmin()])
            raise self.refusal(line, f"{least} numbers for its {what}", readable(self.line(line)))
        width = int(counts[0])
        if bool((counts == width).all()):
            rows = values.reshape(-1, width)[:, :most]
        else:
            at = np.cumsum(counts) - counts
            column = np.arange(most)
            inside = column < counts[:, None]
            rows = np.where(inside, values[np.where(inside, at[:, None] + column, 0)], 0.0)
        return rows, counts

    def refusal(self, line: int, expected: str, got: str) -> LoadError:
        """The error for one line."""
        return LoadError(f"{self.name}: line {self.number_of(line)}: expected {expected}, got {got}; check the file")


def _after_spaces(raw: NDArray[np.uint8], starts: NDArray[np.int64]) -> NDArray[np.int64]:
    """Where the first letter of each line stands."""
    blank = (raw == 32) | (raw == 9)
    if not blank[starts].any():
        return starts
    letters = np.flatnonzero(~blank)
    return np.asarray(letters[np.searchsorted(letters, starts)])
