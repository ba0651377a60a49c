"""Headers of PLY files: elements and their properties.

Source: Turk, "The PLY Polygon File Format", Stanford, 1994; names of types with their sizes as in later programs.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...errors import LoadError
from .given import Given
from .limits import check_limit
from .words import readable

#: Types by name, as numpy's codes.
TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8",
    "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4", "int64": "i8",
    "uint64": "u8", "float16": "f2", "float32": "f4", "float64": "f8",
}  # fmt: skip
#: A header longer than this is none.
_LONGEST = 1 << 20
#: Digits of a count that can be one.
_LONGEST_COUNT = 20


@dataclass(frozen=True)
class PlyProperty:
    """A property: its name, the type of its values, and the type of its length where it is a list; else "".

    Types are numpy's, with their byte order.
    """

    name: str
    type: str
    length: str = ""

    @property
    def least_bytes(self) -> int:
        """What a value takes at least in a binary file."""
        return np.dtype(self.length or self.type).itemsize


@dataclass
class PlyElement:
    """An element: its name, how many there are, and its properties in order."""

    name: str
    count: int
    properties: list[PlyProperty] = field(default_factory=list)


@dataclass(frozen=True)
class PlyHeader:
    """The elements of a file in order, whether they are text, and where they begin."""

    elements: list[PlyElement]
    is_text: bool
    begins: int


def ply_header(given: Given) -> PlyHeader:
    """The header of a PLY file.

    Raises
    ------
    LoadError
        For a header that is none, or that is not complete.
    """
    data = given.data
    if not data[:3].lower() == b"ply" or data[3:4] not in (b"\n", b"\r", b" "):
        raise LoadError(f"{given.name}: expected a PLY file, which begins with 'ply', got {readable(data[:16])}")
    place, elements, encoding = 0, list[PlyElement](), ""
    names: set[str] = set()
    # As the first line ends: where it is a carriage return alone, a line feed may be the first byte of the body.
    first = data[: max(data.find(b"\r", 0, _LONGEST), 0) + 2]
    newline = b"\r" if b"\r" in first and b"\n" not in first else b"\n"
    while True:
        end = data.find(newline, place, _LONGEST)
        if end < 0:
            raise LoadError(f"{given.name}: expected end_header in its header, found none; the file is cut short")
        line = data[place:end]
        place = end + 1
        words = line.decode("utf-8", "replace").split()
        if not words or words[0] in ("ply", "comment", "obj_info"):
            continue
        if words[0] == "end_header":
            break
        if words[0] == "format" and len(words) >= 2:
            encoding = words[1]
        elif words[0] == "element" and len(words) == 3 and words[2].isdecimal() and len(words[2]) < _LONGEST_COUNT:
            count = int(words[2])
            check_limit(given.limits, given.name, "elements", count, f"{words[1]} elements")
            _add_name(given, names, words[1])
            elements.append(PlyElement(words[1], count))
        elif words[0] == "property" and elements and (made := _property(words, encoding)) is not None:
            _add_name(given, names, f"{elements[-1].name}.{made.name}")
            elements[-1].properties.append(made)
        else:
            raise LoadError(f"{given.name}: expected a PLY header, got the line {readable(line)}; check the file")
    if encoding not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise LoadError(
            f"{given.name}: expected the format ascii or binary, got {encoding or 'none'!r}; check the file"
        )
    return PlyHeader(elements, encoding == "ascii", place)


def _add_name(given: Given, names: set[str], name: str) -> None:
    """Keeps the name of an element or of its property."""
    if name in names:
        raise LoadError(f"{given.name}: expected elements and properties with different names, got {name!r} twice")
    names.add(name)


def _property(words: list[str], encoding: str) -> PlyProperty | None:
    order = ">" if encoding == "binary_big_endian" else "<"
    if words[1:2] == ["list"] and len(words) == 5 and words[2] in TYPES and words[3] in TYPES:
        return PlyProperty(words[4], order + TYPES[words[3]], order + TYPES[words[2]])
    if len(words) == 3 and words[1] in TYPES:
        return PlyProperty(words[2], order + TYPES[words[1]])
    return None
