"""STL: triangles, as bytes or as text, where every solid becomes a mesh.

Source: 3D Systems, "StereoLithography Interface Specification", 1989.
"""

from __future__ import annotations

import re

import numpy as np

from ...errors import LoadError
from ..foreign import Gathered
from .given import Given
from .words import numbers, plain, readable, words_per_line

_HEADER = 84
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
#: The words between which the corners of a facet stand.
_SOLID = re.compile(rb"(?im)^[ \t]*solid\b[^\n]*\n")
_END = re.compile(rb"(?im)^[ \t]*endsolid\b[^\n]*$")
_WORDS = re.compile(rb"(?i)\b(?:facet|normal|outer|loop|vertex|endloop|endfacet)\b")


def read_stl(given: Given) -> Gathered:
    """The triangles of an STL file.

    A file is binary where its size is what its count of triangles says, whatever it begins with.

    Raises
    ------
    LoadError
        For a file that is neither text nor as long as it says.
    """
    data = given.data
    count = int.from_bytes(data[80:_HEADER], "little") if len(data) >= _HEADER else -1
    if len(data) == _HEADER + count * _RECORD.itemsize:
        if not count:
            raise LoadError(f"{given.name}: expected triangles, got none; check the file")
        corners = np.frombuffer(data, _RECORD, count, _HEADER)["corners"].reshape(-1, 3)
        found = Gathered()
        _add(found, "solid", corners)
        return found
    if data.lstrip()[:5].lower() == b"solid" or data.startswith(b"\xef\xbb\xbf"):
        return _of_text(given, plain(data))
    if count < 0:
        raise LoadError(f"{given.name}: expected an STL file, got {readable(data[:16])}; check the file")
    raise LoadError(
        f"{given.name}: expected {_HEADER + count * _RECORD.itemsize:,} bytes for the {count:,} triangles of its "
        f"header, got {len(data):,}; the file is cut short or is no STL file"
    )


def _of_text(given: Given, text: bytes) -> Gathered:
    found = Gathered()
    begins = list(_SOLID.finditer(text))
    ends = [match.start() for match in _END.finditer(text)]
    for k, begin in enumerate(begins):
        # Where the next solid begins, the end of this one may be missing; at the end of the file it may not.
        until = begins[k + 1].start() if k + 1 < len(begins) else len(text)
        end = next((one for one in ends if begin.end() <= one <= until), None)
        if end is None and k + 1 == len(begins):
            raise LoadError(f"{given.name}: expected endsolid, found none; the file is cut short")
        body = text[begin.end() : until if end is None else end]
        corners = _facets(given, body)
        if len(corners):
            _add(found, ("solid", k), corners)
    if not found.meshes and not found.empty:
        raise LoadError(f"{given.name}: expected facets, found none; check the file")
    return found


def _facets(given: Given, body: bytes) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """The corners of a solid's facets, (3 T, 3) float64."""
    facets = len(re.findall(rb"(?i)\bendfacet\b", body))
    bare = _WORDS.sub(b" ", body)
    values = numbers(bare)
    words = int(words_per_line(bare + b"\n").sum())
    if words == len(values) == 12 * facets:
        return np.ascontiguousarray(values.reshape(-1, 12)[:, 3:]).reshape(-1, 3)
    # Facets without a normal, or with one that is no number, have corners all the same.
    lines = re.findall(rb"(?i)\bvertex\b([^\n]*)", body)
    values = numbers(b" ".join(lines))
    if len(lines) != 3 * facets or len(values) != 9 * facets or any(len(line.split()) != 3 for line in lines):
        raise LoadError(f"{given.name}: expected three vertices of three numbers in each facet; check the file")
    return values.reshape(-1, 3)


def _add(found: Gathered, key: object, corners: np.ndarray[tuple[int, ...], np.dtype[np.floating]]) -> None:
    found.add(key, "the solid", corners, np.arange(len(corners)).reshape(-1, 3))
    found.place(key, np.eye(4))
