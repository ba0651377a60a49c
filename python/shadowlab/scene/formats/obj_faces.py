"""Faces of Wavefront OBJ files as indices: of vertices, of texture coordinates and of normals."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .given import Given
from .limits import check_limit
from .obj_lines import ObjLines
from .obj_words import FACE, VERTEX, VERTEX_NORMAL, VERTEX_TEXTURE
from .polygons import Indices
from .words import plain_numbers, readable, spaces, words_per_line

_SLASH = ord("/")


@dataclass(frozen=True, eq=False)
class ObjFaces:
    """The faces of a file, corner after corner.

    Attributes
    ----------
    lines : (F,) int64
        The line of each face.
    counts : (F,) int64
        Corners of each face.
    vertex, texture, normal : (C,) int64
        Indices from 0; -1 where a corner has none.
    """

    lines: Indices
    counts: Indices
    vertex: Indices
    texture: Indices
    normal: Indices

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
    face = np.repeat(np.arange(len(counts)), counts)
    made = []
    for kind, column in ((VERTEX, 0), (VERTEX_TEXTURE, 1), (VERTEX_NORMAL, 2)):
        index = np.concatenate([block.indices[column] for block in blocks])
        made.append((_absolute(lines, kind, index, here, face), index))
    (vertex, stated), (texture, _), (normal, _) = made
    total = int(lines.counts[VERTEX])
    outside = (vertex < 0) | (vertex >= total)
    if outside.any():
        corner = int(outside.argmax())
        line, wrong = int(here[face[corner]]), int(stated[corner])
        what = "indices from 1, or negative ones" if wrong == 0 else f"a vertex from 1 to {total:,}, or -1 back"
        raise lines.refusal(line, what, f"{wrong} in {readable(lines.line(line))}")
    return ObjFaces(here, counts, vertex, texture, normal)


@dataclass(frozen=True, eq=False)
class _Corners:
    """The corners of some faces: how many each has, and the three indices of each corner, missing ones 0."""

    counts: Indices
    indices: tuple[Indices, Indices, Indices]

    @classmethod
    def of(cls, given: Given, text: bytes, lines: ObjLines, here: Indices) -> _Corners:
        """The corners in the text of some faces."""
        counts = words_per_line(text)
        check_limit(given.limits, given.name, "corners", int(counts.max()), "corners of a polygon")
        if b"/" not in text:
            values = plain_numbers(text, np.int64)
            if len(values) != int(counts.sum()):
                raise _first_wrong(lines, here)
            none = np.broadcast_to(np.int64(0), len(values))
            return cls(counts, (values, none, none))
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


def _absolute(lines: ObjLines, kind: int, index: Indices, here: Indices, face: Indices) -> Indices:
    """Indices from 0; negative ones count back from the last one before the line of the face."""
    found = index - 1
    back = index < 0
    if back.any():
        before = np.cumsum(lines.kinds == kind)[here]
        found[back] = before[face[back]] + index[back]
        found[back & (found < 0)] = -1
    return found


def _first_wrong(lines: ObjLines, here: Indices) -> Exception:
    for line in here.tolist():
        for word in lines.line(line).split()[1:]:
            parts = word.split(b"/")
            if len(parts) > 3 or not all(part.lstrip(b"+-").isdigit() for part in [parts[0], *filter(None, parts[1:])]):
                return lines.refusal(line, "corners such as 1, 1/2, 1//3 or 1/2/3", readable(word))
    return lines.refusal(int(here[0]), "corners such as 1, 1/2, 1//3 or 1/2/3", "others")
