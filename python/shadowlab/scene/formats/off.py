"""OFF: polygons as text.

Source: Phillips et al., "Geomview Manual", 1.6, section 4.2.5, "OFF: vertices, edges and faces". Of the letters before
OFF, ST, C and N announce more numbers for each vertex; 4 and n announce vertices of other dimensions, which are
refused, as is the binary form. The word OFF may be missing.
"""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from ...errors import LoadError
from ..gathered import Gathered
from .given import Given
from .limits import check_limit
from .polygons import polygon_faces
from .running import Rows, running_counts
from .words import plain_numbers, plain_text, readable, without_comments, words_per_line

_KEYWORD = re.compile(rb"\s*(?:((?:ST)?C?N?)(4?)(n?)(?:OFF|off)\b[ \t]*(BINARY)?|(?=[0-9]))", re.ASCII)
#: Numbers for each vertex beside its coordinates, by the letter that announces them. Colours may have three or four.
_MORE = {"ST": 2, "N": 3}


def _in_lines(counts: NDArray[np.int64], vertices: int, faces: int, width: int) -> bool:
    """Whether lines with so many numbers may be the vertices, with `width` numbers or more, and the faces."""
    return len(counts) > vertices + faces and not (counts[1 : 1 + vertices] < width).any()


def read_off(given: Given) -> Gathered:
    """The faces of an OFF file as one mesh.

    Raises
    ------
    LoadError
        For another kind of OFF, a file that is cut short, or an index that points nowhere.
    """
    name = given.name
    text = without_comments(plain_text(given.data))
    keyword = _KEYWORD.match(text)
    if keyword is None:
        raise LoadError(f"{name}: expected an OFF file, which begins with OFF, got {readable(text[:16])}")
    letters = (keyword[1] or b"").decode()
    if keyword[2] or keyword[3] or keyword[4]:
        kind = keyword[0].strip().decode()
        raise LoadError(f"{name}: expected vertices of three coordinates as text, got {kind}; export plain OFF")
    text = text[keyword.end() :]
    counts = words_per_line(text, with_blank=False)
    starts = np.concatenate([[0], np.cumsum(counts)])
    values = plain_numbers(text)
    if not len(counts) or len(values) < 2 or counts[0] < 2:
        raise LoadError(f"{name}: expected the numbers of vertices and faces after {letters}OFF; check the file")
    vertex_count, face_count = values[0], values[1]
    for count, what in ((vertex_count, "vertices"), (face_count, "faces")):
        if not (count >= 0 and count == np.floor(count)):
            raise LoadError(f"{name}: expected a whole number of {what}, got {count:g}; check the file")
        check_limit(given.limits, name, "elements", float(count), what)
    v, f = int(vertex_count), int(face_count)
    width = 3 + sum(_MORE[letter] for letter in _MORE if letter in letters)
    if not _in_lines(counts, v, f, width) and "C" not in letters and len(values) == starts[-1]:
        # Numbers may stand in any lines, although nearly all programs write a line for each vertex and face.
        groups = [Rows(1, (False,) * 3), Rows(v, (False,) * width), Rows(f, (True,))]
        if (running := running_counts(values, groups)) is not None:
            counts, starts = running, np.concatenate([[0], np.cumsum(running)])
    if 1 + v + f > len(counts) or starts[1 + v + f] > len(values):
        raise LoadError(
            f"{name}: expected {v:,} vertices and {f:,} faces, each with its line of numbers, found fewer; "
            "the file is cut short or holds other words"
        )
    if v and counts[1 : 1 + v].min() < 3:
        raise LoadError(f"{name}: expected three coordinates of each vertex, got fewer; check the file")
    points = values[starts[1 : 1 + v][:, None] + np.arange(3)] if v else np.zeros((0, 3))
    begins = starts[1 + v : 1 + v + f]
    sizes = values[begins]
    if f and not ((sizes >= 0) & (sizes < counts[1 + v : 1 + v + f]) & (sizes == np.floor(sizes))).all():
        raise LoadError(f"{name}: expected each face to begin with its number of vertices; check the file")
    many = sizes.astype(np.int64)
    check_limit(given.limits, name, "corners", int(many.max(initial=0)), "corners of a polygon")
    inner = np.arange(int(many.sum())) - np.repeat(np.cumsum(many) - many, many)
    indices = values[np.repeat(begins + 1, many) + inner]
    wrong = ~((indices >= 0) & (indices < v) & (indices == np.floor(indices)))
    if wrong.any():
        value = indices[int(wrong.argmax())]
        raise LoadError(f"{name}: expected vertices from 0 to {v - 1:,} in faces, got {value:g}; check the file")
    if not f:
        raise LoadError(f"{name}: expected faces, got {v:,} vertices alone; export a mesh, not points")
    corners = indices.astype(np.int64)
    triangles, degenerate = polygon_faces(points, corners, many)
    found = Gathered(degenerate=degenerate)
    found.add("mesh", "the mesh", points, triangles)
    found.place("mesh", np.eye(4))
    return found
