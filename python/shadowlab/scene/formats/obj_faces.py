"""Faces of Wavefront OBJ files as indices: of vertices, of texture coordinates and of normals."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .given import Given
from .limits import check_limit
from .obj_lines import ObjLines
from .obj_words import FACE, VERTEX, VERTEX_NORMAL, VERTEX_TEXTURE
from .polygons import Indices
from .words import plain_numbers, readable, spaces, words_per_line

_SLASH = ord("/")
_MOST = 2**31 - 1


@dataclass(frozen=True, eq=False)
class ObjFaces:
    """The faces of a file, corner after corner.

    Attributes
    ----------
    lines : (F,) int64
        The line of each face.
    counts : (F,) int64
        Corners of each face.
    vertex, texture, normal : (C,) int32
        Indices from 0; -1 where a corner has none.
    """

    lines: Indices
    counts: Indices
    vertex: NDArray[np.int32]
    texture: NDArray[np.int32]
    normal: NDArray[np.int32]

    @cached_property
    def starts(self) -> Indices:
        """The first corner of each face."""
        return np.asarray(np.cumsum(self.counts) - self.counts)


def faces_of(given: Given, lines: ObjLines) -> ObjFaces:
    """The faces of a file.

    Raises
    ------
    LoadError
        For a corner that is no index, for the index 0, and for a vertex that does not exist, with the line.
    """
    here = lines.of_kind(FACE)
    blocks = [_Corners.of(given, text, lines, of) for of, text in lines.blocks(FACE)]
    counts = np.concatenate([block.counts for block in blocks])
    vertex, texture, normal = (
        _absolute(lines, kind, _column(blocks, column), here, counts)
        for column, kind in enumerate((VERTEX, VERTEX_TEXTURE, VERTEX_NORMAL))
    )
    total = int(lines.counts[VERTEX])
    outside = (vertex < 0) | (vertex >= total)
    if outside.any():
        corner = int(outside.argmax())
        line, wrong = int(here[np.searchsorted(np.cumsum(counts), corner, "right")]), int(_column(blocks, 0)[corner])
        what = "indices from 1, or negative ones" if wrong == 0 else f"a vertex from 1 to {total:,}, or -1 back"
        raise lines.refusal(line, what, f"{wrong} in {readable(lines.line(line))}")
    return ObjFaces(here, counts, vertex, texture, normal)


@dataclass(frozen=True, eq=False)
class _Corners:
    """The corners of some faces: how many each has, and their three indices: 0 where one is missing, None where all are."""

    counts: Indices
    indices: tuple[Indices, Indices | None, Indices | None]

    @classmethod
    def of(cls, given: Given, text: bytes, lines: ObjLines, here: Indices) -> _Corners:
        """The corners in the text of some faces."""
        counts = words_per_line(text)
        check_limit(given.limits, given.name, "corners", int(counts.max()), "corners of a polygon")
        if b"/" not in text:
            values = plain_numbers(text, np.int64)
            if len(values) != int(counts.sum()):
                raise _first_wrong(lines, here)
            return cls(counts, (values, None, None))
        blank = spaces(text)
        ends = np.flatnonzero(blank[1:] & ~blank[:-1]) + 1
        places = np.flatnonzero(np.frombuffer(text, np.uint8) == _SLASH)
        slashes = np.diff(np.searchsorted(places, ends), prepend=0)
        text = text.replace(b"//", b"/0/")
        for after in (b" ", b"\t", b"\n"):
            text = text.replace(b"/" + after, b"/0" + after)
        values = plain_numbers(text.replace(b"/", b" "), np.int64)
        at = np.cumsum(slashes + 1) - (slashes + 1)
        if len(values) != int((slashes + 1).sum()) or (len(slashes) and slashes.max() > 2):
            raise _first_wrong(lines, here)
        second, third = (
            np.where(slashes >= column, values[np.where(slashes >= column, at + column, 0)], 0) for column in (1, 2)
        )
        return cls(counts, (values[at], second, third))


def _column(blocks: list[_Corners], column: int) -> Indices:
    """One of the indices of all corners, as the file has them; missing ones 0."""
    parts = [block.indices[column] for block in blocks]
    if all(part is None for part in parts):
        return np.broadcast_to(np.int64(0), sum(int(block.counts.sum()) for block in blocks))
    zeros = (np.zeros(int(block.counts.sum()), np.int64) for block in blocks)
    return np.concatenate([zero if part is None else part for part, zero in zip(parts, zeros, strict=True)])


def _absolute(lines: ObjLines, kind: int, index: Indices, here: Indices, counts: Indices) -> NDArray[np.int32]:
    """Indices from 0, -1 for none; negative ones count back from the last one before the line of the face."""
    if not index.strides[0]:
        return np.broadcast_to(np.int32(-1), len(index))
    back = np.flatnonzero(index < 0)
    if len(back):
        before = np.cumsum(lines.kinds == kind)[here]
        index = index.copy()
        absolute = index[back] + 1 + before[np.searchsorted(np.cumsum(counts), back, "right")]
        index[back] = np.where(absolute > 0, absolute, 0)
    # What does not fit is no index, but must not become one.
    return (np.minimum(index, _MOST) - 1).astype(np.int32)


def _first_wrong(lines: ObjLines, here: Indices) -> Exception:
    for line in here.tolist():
        for word in lines.line(line).split()[1:]:
            parts = word.split(b"/")
            if len(parts) > 3 or not all(part.lstrip(b"+-").isdigit() for part in [parts[0], *filter(None, parts[1:])]):
                return lines.refusal(line, "corners such as 1, 1/2, 1//3 or 1/2/3", readable(word))
    return lines.refusal(int(here[0]), "corners such as 1, 1/2, 1//3 or 1/2/3", "others")
