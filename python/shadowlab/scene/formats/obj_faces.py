"""Faces of Wavefront OBJ files as indices: of vertices, of texture coordinates and of normals."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .obj_lines import FACE, VERTEX, VERTEX_NORMAL, VERTEX_TEXTURE, ObjLines
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


def faces_of(lines: ObjLines) -> ObjFaces:
    """The faces of a file.

    Raises
    ------
    LoadError
        For a corner that is no index, for the index 0, and for a vertex that does not exist, with the line.
    """
    text = lines.block(FACE)
    counts = words_per_line(text)
    raw = np.frombuffer(text, np.uint8)
    slashes = np.zeros(int(counts.sum()), np.int64)
    if b"/" in text:
        blank = spaces(text)
        ends = np.flatnonzero(blank[1:] & ~blank[:-1]) + 1
        slashes = np.diff(np.searchsorted(np.flatnonzero(raw == _SLASH), ends), prepend=0)
        text = text.replace(b"//", b"/0/")
        for after in (b" ", b"\t", b"\n"):
            text = text.replace(b"/" + after, b"/0" + after)
        text = text.replace(b"/", b" ")
    values = plain_numbers(text, np.int64)
    at = np.cumsum(slashes + 1) - (slashes + 1)
    if len(values) != int((slashes + 1).sum()) or (len(slashes) and slashes.max() > 2):
        raise _first_wrong(lines)
    face = np.repeat(np.arange(len(counts)), counts)
    here = lines.of_kind(FACE)
    made = []
    for kind, column in ((VERTEX, 0), (VERTEX_TEXTURE, 1), (VERTEX_NORMAL, 2)):
        has = slashes >= column
        index = values[at] if column == 0 else np.where(has, values[np.where(has, at + column, 0)], 0)
        made.append(_absolute(lines, kind, index, here, face))
    total = int((lines.kinds == VERTEX).sum())
    outside = (made[0] < 0) | (made[0] >= total)
    if outside.any():
        corner = int(outside.argmax())
        line, index = int(here[face[corner]]), int(values[at[corner]])
        what = "indices from 1, or negative ones" if index == 0 else f"a vertex from 1 to {total:,}, or -1 back"
        raise lines.refusal(line, what, f"{index} in {readable(lines.line(line))}")
    return ObjFaces(here, counts, *made)


def _absolute(lines: ObjLines, kind: int, index: Indices, here: Indices, face: Indices) -> Indices:
    """Indices from 0; negative ones count back from the last one before the line of the face."""
    found = index - 1
    back = index < 0
    if back.any():
        before = np.cumsum(lines.kinds == kind)[here]
        found[back] = before[face[back]] + index[back]
        found[back & (found < 0)] = -1
    return found


def _first_wrong(lines: ObjLines) -> Exception:
    for line in lines.of_kind(FACE).tolist():
        for word in lines.line(line).split()[1:]:
            parts = word.split(b"/")
            if len(parts) > 3 or not all(part.lstrip(b"+-").isdigit() for part in [parts[0], *filter(None, parts[1:])]):
                return lines.refusal(line, "corners such as 1, 1/2, 1//3 or 1/2/3", readable(word))
    return lines.refusal(int(lines.of_kind(FACE)[0]), "corners such as 1, 1/2, 1//3 or 1/2/3", "others")
