"""STL: triangles, as bytes or as text, where every solid becomes a mesh.

Source: 3D Systems, "StereoLithography Interface Specification", 1989.
"""

from __future__ import annotations

import re

import numpy as np

from ...errors import LoadError
from ..gathered import Gathered
from .given import Given
from .words import line_pieces, plain_numbers, plain_text, readable

_HEADER = 84
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
#: Bytes that show whether a file is text.
_TEXT = 512
#: What stands between the numbers of facets.
_PHRASES = (b"endfacet", b"facet normal", b"outer loop", b"vertex", b"endloop")
#: Ends that some programs write as two words.
_ENDS = re.compile(rb"(?m)^([ \t]*)end[ \t]+(facet|loop|solid)\b")


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
    size = _HEADER + count * _RECORD.itemsize
    if count >= 0 and len(data) == size:
        return _of_records(given, count)
    text = plain_text(data[:_TEXT]).lstrip()
    # The header of a binary file may begin with "solid", but its numbers have zeros, which text has not.
    if text[:5].lower() == b"solid" and b"\0" not in text:
        return _of_text(given, plain_text(data))
    if count < 0:
        raise LoadError(f"{given.name}: expected an STL file, got {readable(data[:16])}; check the file")
    # More records than the count says are a count that lies; other bytes are what programs append.
    if count and size < len(data) < 2 * size and (len(data) - size) % _RECORD.itemsize:
        found = _of_records(given, count)
        found.left_out.append(f"{len(data) - size:,} bytes after the {count:,} triangles of the header")
        return found
    raise LoadError(
        f"{given.name}: expected {size:,} bytes for the {count:,} triangles of its "
        f"header, got {len(data):,}; the file is cut short or is no STL file"
    )


def _of_records(given: Given, count: int) -> Gathered:
    if not count:
        raise LoadError(f"{given.name}: expected triangles, got none; check the file")
    found = Gathered()
    _add(found, "solid", np.frombuffer(given.data, _RECORD, count, _HEADER)["corners"].reshape(-1, 3))
    return found


def _of_text(given: Given, text: bytes) -> Gathered:
    found = Gathered()
    text = text.lower()
    if b"end " in text:
        text = _ENDS.sub(rb"\1end\2", text)
    solids = _solids(text)
    for k, (begin, end) in enumerate(solids):
        if end is None and k + 1 == len(solids):
            raise LoadError(f"{given.name}: expected endsolid, found none; the file is cut short")
        body = text[begin : solids[k + 1][0] if end is None else end]
        if not body.isspace() and body and len(corners := _facets(given, body)):
            _add(found, ("solid", k), corners)
    if not found.meshes and not found.empty:
        raise LoadError(f"{given.name}: expected facets, found none; check the file")
    return found


def _solids(text: bytes) -> list[tuple[int, int | None]]:
    """Where solids begin, after the line with their name, and end; None for an end that is missing."""
    found: list[tuple[int, int | None]] = []
    place = text.find(b"solid")
    while place >= 0:
        line = text.rfind(b"\n", 0, place) + 1
        after = text.find(b"\n", place) + 1 or len(text)
        before = text[line:place].strip()
        if before == b"":
            found.append((after, None))
        elif before == b"end" and found and found[-1][1] is None:
            found[-1] = found[-1][0], line
        # Names of solids may have the word in them.
        place = text.find(b"solid", after)
    return found


def _facets(given: Given, body: bytes) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """The corners of a solid's facets, (3 T, 3) float64."""
    facets = body.count(b"endfacet")
    values = plain_numbers(b"".join([_bare(piece) for piece in line_pieces(body)]))
    if len(values) == 12 * facets:
        return np.ascontiguousarray(values.reshape(-1, 12)[:, 3:]).reshape(-1, 3)
    # Facets without a normal, or with one that is no number, have corners all the same.
    lines = re.findall(rb"\bvertex\b([^\n]*)", body)
    values = plain_numbers(b" ".join(lines))
    if len(lines) != 3 * facets or len(values) != 9 * facets or any(len(line.split()) != 3 for line in lines):
        raise LoadError(f"{given.name}: expected three vertices of three numbers in each facet; check the file")
    return values.reshape(-1, 3)


def _bare(text: bytes) -> bytes:
    """The numbers of facets alone."""
    for phrase in _PHRASES:
        text = text.replace(phrase, b" ")
    return text


def _add(found: Gathered, key: object, corners: np.ndarray[tuple[int, ...], np.dtype[np.floating]]) -> None:
    found.add(key, "the solid", corners, np.arange(len(corners)).reshape(-1, 3))
    found.place(key, np.eye(4))
