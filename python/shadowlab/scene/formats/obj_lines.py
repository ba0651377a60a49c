"""Lines of Wavefront OBJ files by their kind, and the numbers in them.

Source: Wavefront, Advanced Visualizer manual, appendix B1, "Object files (.obj)", version 3.0. Lines that say nothing
about polygons are counted and not kept, so that what is kept does not grow with them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...errors import LoadError
from ...text.progress import tell
from .blockwise import concatenated
from .given import Given
from .obj_words import FACE, KEPT_KINDS, UNKNOWN, VERTEX, VERTEX_NORMAL, VERTEX_TEXTURE, kinds_of
from .words import (
    Bytes,
    first_that_is_no_number,
    line_pieces,
    plain_numbers,
    plain_text,
    readable,
    without_comments,
    words_per_line,
)

#: Words that begin the lines of each kind.
_WORDS = {VERTEX: b"v", VERTEX_TEXTURE: b"vt", VERTEX_NORMAL: b"vn", FACE: b"f"}
#: Bytes that are divided into lines at once.
_BLOCK = 1 << 18
#: Blanks before a line's first letter that are passed over for many lines at once.
_FEW_BLANKS = 8
#: Stands where lines were joined, until their places are known.
_JOINT = b"\x01"
_LETTER = re.compile(rb"[^ \t]")
#: A line that goes on, with blanks after the mark that do not belong there.
_GOES_ON = re.compile(rb"(?<=[0-9/ \t])\\[ \t]+\n")
#: Faces with an outline, which version 3.0 reads as faces.
_OUTLINED = re.compile(rb"(?m)^([ \t]*f)o(?=[ \t])")


@dataclass(frozen=True, eq=False)
class ObjLines:
    """The lines of a file.

    Attributes
    ----------
    name : str
        The file, for errors.
    text : bytes
        Its text without comments, continued lines joined.
    starts, ends : (L,) int64
        Where each line begins, and its newline.
    kinds : (L,) int8
    joined : (J,) int64
        Where lines were joined.
    counts : (KINDS,) int64
        How many lines of each kind there are; those of most kinds are not kept.
    unknown : int
        Where the first line of no known word begins; -1 where there is none.
    """

    name: str
    text: bytes
    starts: NDArray[np.int64]
    ends: NDArray[np.int64]
    kinds: NDArray[np.int8]
    joined: NDArray[np.int64]
    counts: NDArray[np.int64]
    unknown: int

    @classmethod
    def of(cls, given: Given) -> ObjLines:
        """The lines of a file."""
        text = without_comments(plain_text(given.data))
        if any(mark in text for mark in (b"\\", b"fo ", b"fo\t")):
            text = b"".join([_marked(piece) for piece in line_pieces(text)])
        joined = np.zeros(0, np.int64)
        if _JOINT in text:
            text += b"\n"
            joined = np.flatnonzero(np.frombuffer(text, np.uint8) == _JOINT[0])
            text = text.replace(_JOINT, b" ")
        kept: list[tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int8]]] = []
        counts, unknown = np.zeros(UNKNOWN + 1, np.int64), -1
        for starts, ends in _blocks(text):
            kinds = kinds_of(np.frombuffer(text, np.uint8), _after_blanks(text, starts))
            counts += np.bincount(kinds, minlength=len(counts))
            if unknown < 0 and (kinds == UNKNOWN).any():
                unknown = int(starts[(kinds == UNKNOWN).argmax()])
            chosen = np.flatnonzero(kinds < KEPT_KINDS)
            kept.append((starts[chosen], ends[chosen], kinds[chosen]))
        starts, ends, kinds = (concatenated(arrays) for arrays in zip(*kept, strict=True))
        return cls(given.name, text, starts, ends, kinds, joined, counts, unknown)

    def number_at(self, place: int) -> int:
        """The number of the line that begins at a place, as editors count them."""
        return self.text.count(b"\n", 0, place) + 1 + int(np.searchsorted(self.joined, place))

    def line(self, line: int) -> bytes:
        """The text of a line."""
        return self.text[self.starts[line] : self.ends[line]].strip()

    def of_kind(self, kind: int) -> NDArray[np.int64]:
        """The lines of a kind that is kept."""
        return np.flatnonzero(self.kinds == kind)

    def blocks(self, kind: int) -> Iterator[tuple[NDArray[np.int64], bytes]]:
        """All lines of a kind with their text, without the word that they begin with, block after block."""
        word = _WORDS[kind]
        lines = self.of_kind(kind)
        starts, ends = self.starts[lines], self.ends[lines] + 1
        # Runs of lines that stand together, divided where they are long.
        new = np.ones(len(lines), bool)
        new[1:] = (ends[:-1] != starts[1:]) | (np.diff(ends // _BLOCK) > 0)
        first = np.flatnonzero(new)
        begins, stops = starts[first], ends[np.append(first[1:], len(lines))[: len(first)] - 1]
        row = 0
        # As many runs together as make a block.
        divided = np.flatnonzero(np.diff(np.cumsum(stops - begins) // _BLOCK, prepend=0)) if len(first) else first
        for runs in np.split(np.arange(len(first)), divided):
            if not len(runs):
                continue
            pairs = zip(begins[runs].tolist(), stops[runs].tolist(), strict=True)
            text = b"\n" + b"".join([self.text[begin:stop] for begin, stop in pairs])
            if b"\n " in text or b"\n\t" in text:
                stripped = [line.strip().removeprefix(word) for line in text.split(b"\n")[1:-1]]
                text = b"\n".join([*stripped, b""])
            else:
                text = text.replace(b"\n" + word, b"\n")[1:]
            count = text.count(b"\n")
            # Kinds mostly come one after the other.
            tell(int(stops[runs[-1]]), len(self.text))
            yield lines[row : row + count], text
            row += count

    def rows(self, kind: int, least: int, most: int, what: str) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """The first numbers of every line of a kind, missing ones 0, and how many each line has.

        Raises
        ------
        LoadError
            For a line with fewer than `least` numbers, or with a word that is none.
        """
        lines = self.of_kind(kind)
        table = np.zeros((len(lines), most))
        widths = np.zeros(len(lines), np.int64)
        row = 0
        for of, text in self.blocks(kind):
            counts = words_per_line(text)
            values = plain_numbers(text)
            if len(values) != int(counts.sum()):
                raise self._no_number(of, what)
            if int(counts.min()) < least:
                line = int(of[counts.argmin()])
                raise self.refusal(line, f"{least} numbers for its {what}", readable(self.line(line)))
            made, width = table[row : row + len(counts)], int(counts[0])
            if bool((counts == width).all()):
                made[:, :width] = values.reshape(-1, width)[:, :most]
            else:
                at, column = np.cumsum(counts) - counts, np.arange(most)
                inside = column < counts[:, None]
                made[inside] = values[(at[:, None] + column)[inside]]
            widths[row : row + len(counts)] = counts
            row += len(counts)
        return table, widths

    def _no_number(self, lines: NDArray[np.int64], what: str) -> LoadError:
        """The error for the first of some lines that has a word that is no number."""
        for line in lines.tolist():
            words = self.line(line).split()[1:]
            wrong = first_that_is_no_number(words, float)
            if wrong is not None:
                return self.refusal(line, f"numbers for its {what}", readable(words[wrong]))
        return LoadError(f"{self.name}: expected plain decimal numbers for each {what}; check the file")

    def refusal(self, line: int, expected: str, got: str) -> LoadError:
        """The error for one line."""
        number = self.number_at(int(self.starts[line]))
        return LoadError(f"{self.name}: line {number}: expected {expected}, got {got}; check the file")


def _marked(text: bytes) -> bytes:
    """Lines with those that go on joined by a mark, and faces with outlines as faces."""
    if b"\\" in text:
        text = _GOES_ON.sub(b" " + _JOINT, text).replace(b"\\\n", b" " + _JOINT)
    if b"fo " in text or b"fo\t" in text:
        text = _OUTLINED.sub(rb"\1 ", text)
    return text


def _blocks(text: bytes) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Where lines begin and end, block after block; the text ends in a newline."""
    raw: Bytes = np.frombuffer(text, np.uint8)
    begin = 0
    for place in range(0, len(raw), _BLOCK):
        ends = np.flatnonzero(raw[place : place + _BLOCK] == 10) + place
        if len(ends):
            yield np.concatenate([[begin], ends[:-1] + 1]), ends
            begin = int(ends[-1]) + 1


def _after_blanks(text: bytes, starts: NDArray[np.int64]) -> NDArray[np.int64]:
    """Where the first letter of each line stands."""
    raw = np.frombuffer(text, np.uint8)
    found = starts.copy()
    for _ in range(_FEW_BLANKS):
        letters = raw[found]
        blank = (letters == 32) | (letters == 9)
        if not blank.any():
            return found
        found[blank] += 1
    letters = raw[found]
    for line in np.flatnonzero((letters == 32) | (letters == 9)).tolist():
        match = _LETTER.search(text, int(found[line]))
        found[line] = len(text) - 1 if match is None else match.start()
    return found
