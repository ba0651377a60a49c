"""Faces of Wavefront OBJ files as indices: of vertices, of texture coordinates and of normals."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property, partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .blockwise import concatenated
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
    before = cache(lambda kind: np.cumsum(lines.kinds == kind))
    counts, vertices = [], []
    more: dict[int, list[NDArray[np.int32] | None]] = {VERTEX_TEXTURE: [], VERTEX_NORMAL: []}
    for here, text in lines.blocks(FACE):
        many, stated, others = _stated(given, text, lines, here)
        vertex = _absolute(stated, partial(before, VERTEX), here, many)
        _check(lines, here, many, vertex, stated)
        counts.append(many)
        vertices.append(vertex)
        for kind, index in zip((VERTEX_TEXTURE, VERTEX_NORMAL), others, strict=True):
            more[kind].append(None if index is None else _absolute(index, partial(before, kind), here, many))
    texture, normal = (_of_blocks(parts, counts) for parts in more.values())
    return ObjFaces(lines.of_kind(FACE), np.concatenate(counts), concatenated(vertices), texture, normal)


class _Stated(NamedTuple):
    counts: Indices
    vertex: Indices
    others: tuple[Indices | None, Indices | None]


def _stated(given: Given, text: bytes, lines: ObjLines, here: Indices) -> _Stated:
    """How many corners each face has, and their indices as the text has them: 0 where one is missing, None for all."""
    counts = words_per_line(text)
    check_limit(given.limits, given.name, "corners", int(counts.max()), "corners of a polygon")
    if b"/" not in text:
        values = plain_numbers(text, np.int64)
        if len(values) != int(counts.sum()):
            raise _first_wrong(lines, here)
        return _Stated(counts, values, (None, None))
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
    second, third = (np.where(slashes >= k, values[np.where(slashes >= k, at + k, 0)], 0) for k in (1, 2))
    return _Stated(counts, values[at], (second, third))


def _absolute(index: Indices, before: Callable[[], Indices], here: Indices, counts: Indices) -> NDArray[np.int32]:
    """Indices from 0, -1 for none; negative ones count back from the last one before the line of the face."""
    back = np.flatnonzero(index < 0)
    if len(back):
        index = index.copy()
        absolute = index[back] + 1 + np.repeat(before()[here], counts)[back]
        index[back] = np.where(absolute > 0, absolute, 0)
    # What does not fit is no index, but must not become one.
    return (np.minimum(index, _MOST) - 1).astype(np.int32)


def _check(lines: ObjLines, here: Indices, counts: Indices, vertex: NDArray[np.int32], stated: Indices) -> None:
    """Raises for a vertex that does not exist."""
    total = int(lines.counts[VERTEX])
    outside = (vertex < 0) | (vertex >= total)
    if outside.any():
        corner = int(outside.argmax())
        line, wrong = int(np.repeat(here, counts)[corner]), int(stated[corner])
        what = "indices from 1, or negative ones" if wrong == 0 else f"a vertex from 1 to {total:,}, or -1 back"
        raise lines.refusal(line, what, f"{wrong} in {readable(lines.line(line))}")


def _of_blocks(parts: list[NDArray[np.int32] | None], counts: list[Indices]) -> NDArray[np.int32]:
    """The indices of all blocks; -1 where a block has none."""
    sizes = [int(many.sum()) for many in counts]
    if all(part is None for part in parts):
        return np.broadcast_to(np.int32(-1), sum(sizes))
    none = (np.full(size, -1, np.int32) for size in sizes)
    return concatenated([other if part is None else part for part, other in zip(parts, none, strict=True)])


def _first_wrong(lines: ObjLines, here: Indices) -> Exception:
    for line in here.tolist():
        for word in lines.line(line).split()[1:]:
            parts = word.split(b"/")
            if len(parts) > 3 or not all(part.lstrip(b"+-").isdigit() for part in [parts[0], *filter(None, parts[1:])]):
                return lines.refusal(line, "corners such as 1, 1/2, 1//3 or 1/2/3", readable(word))
    return lines.refusal(int(here[0]), "corners such as 1, 1/2, 1//3 or 1/2/3", "others")
