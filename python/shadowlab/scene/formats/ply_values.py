"""Values of PLY elements, from text and from bytes, lists of any lengths among them."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from ...errors import LoadError
from .blockwise import gathered_rows
from .given import Given
from .ply_header import PlyElement, PlyHeader, PlyProperty
from .running import Rows, running_counts
from .words import plain_numbers, plain_text, words_per_line

PlyArray = NDArray[Any]
#: Letters of `struct` for numpy's types.
_LETTERS = {
    "i1": "b",
    "u1": "B",
    "i2": "h",
    "u2": "H",
    "i4": "i",
    "u4": "I",
    "i8": "q",
    "u8": "Q",
    "f2": "e",
    "f4": "f",
    "f8": "d",
}


@dataclass(frozen=True, eq=False)
class PlyLists:
    """Lists, one for each element: their lengths, and all their values in a row."""

    counts: NDArray[np.int64]
    values: PlyArray


#: Values of the properties of an element by name.
PlyValues = dict[str, "PlyArray | PlyLists"]


def ply_values(given: Given, header: PlyHeader) -> dict[str, PlyValues]:
    """The values of all elements by name.

    Raises
    ------
    LoadError
        For a file that is cut short, or whose numbers cannot be read.
    """
    body = memoryview(given.data)[header.begins :]
    if not header.is_text:
        return _all_of(_Bytes(given, body), header)
    source = _Text(given, plain_text(bytes(body)))
    try:
        return _all_of(source, header)
    except LoadError:
        # Elements that do not stand in lines of their own, as some programs write and many read them.
        if not source.run_on(header):
            raise
        return _all_of(source, header)


def _all_of(source: _Text | _Bytes, header: PlyHeader) -> dict[str, PlyValues]:
    found = {}
    for element in header.elements:
        source.expect(element)
        values = source.even(element)
        found[element.name] = source.uneven(element) if values is None else values
    return found


class _Bytes:
    """Elements of a binary file."""

    def __init__(self, given: Given, body: memoryview):
        self.name, self.body, self.at = given.name, body, 0

    def expect(self, element: PlyElement) -> None:
        least = element.count * sum(one.least_bytes for one in element.properties)
        if least > len(self.body) - self.at:
            raise _cut_short(self.name, element)

    def even(self, element: PlyElement) -> PlyValues | None:
        """The values where all lists of a property are as long as its first one."""
        fields: list[Any] = []
        offset = self.at
        for one in element.properties:
            if one.length:
                if not element.count or offset + one.least_bytes > len(self.body):
                    return None
                count = int(np.frombuffer(self.body, one.length, 1, offset)[0])
                left = len(self.body) - offset
                if not 0 <= count * np.dtype(one.type).itemsize <= left:
                    return None
                fields += [(f"n {one.name}", one.length), (one.name, one.type, (count,))]
                offset += one.least_bytes + count * np.dtype(one.type).itemsize
            else:
                fields.append((one.name, one.type))
                offset += one.least_bytes
        if len({field[0] for field in fields}) < len(fields):
            raise LoadError(
                f"{self.name}: expected properties of {element.name} with different names; check the header"
            )
        row = np.dtype(fields)
        if element.count * row.itemsize > len(self.body) - self.at:
            return None
        table = np.frombuffer(self.body, row, element.count, self.at)
        found: PlyValues = {}
        for one in element.properties:
            if one.length:
                counts = table[f"n {one.name}"].astype(np.int64)
                if not (counts == row[one.name].shape[0]).all():
                    return None
                found[one.name] = PlyLists(counts, table[one.name].reshape(-1))
            else:
                found[one.name] = table[one.name]
        self.at += element.count * row.itemsize
        return found

    def uneven(self, element: PlyElement) -> PlyValues:
        """The values one by one."""
        steps = [_step(one) for one in element.properties]
        counts: list[list[int]] = [[] for _ in steps]
        begins: list[list[int]] = [[] for _ in steps]
        at, end = self.at, len(self.body)
        try:
            for _ in range(element.count):
                for k, (size, unpack, length) in enumerate(steps):
                    count = 1
                    if unpack is not None:
                        count = int(unpack(self.body, at)[0])
                        at += length
                        if count < 0:
                            raise _cut_short(self.name, element)
                        counts[k].append(count)
                    begins[k].append(at)
                    at += count * size
                if at > end:
                    raise _cut_short(self.name, element)
        except (struct.error, ValueError, OverflowError) as e:
            raise _cut_short(self.name, element) from e
        self.at = at
        raw = np.frombuffer(self.body, np.uint8)
        found: PlyValues = {}
        for one, (size, _, _), starts, lengths in zip(element.properties, steps, begins, counts, strict=True):
            many = np.array(lengths, np.int64) if one.length else np.ones(element.count, np.int64)
            total = int(many.sum())
            inner = np.arange(total) - np.repeat(np.cumsum(many) - many, many)
            places = np.repeat(np.array(starts, np.int64), many) + inner * size
            bytes_of = gathered_rows(sliding_window_view(raw, size), places) if total else np.zeros(0, np.uint8)
            values = bytes_of.reshape(-1).view(one.type)
            found[one.name] = PlyLists(many, values) if one.length else values
        return found


class _Text:
    """Elements of a text file: each has a line, whose other numbers are passed over, unless they run on."""

    def __init__(self, given: Given, text: bytes):
        self.name, self.row = given.name, 0
        self.counts = words_per_line(text, with_blank=False)
        self.starts = np.concatenate([[0], np.cumsum(self.counts)])
        self.values = plain_numbers(text)

    def run_on(self, header: PlyHeader) -> bool:
        """Takes numbers as they come, wherever lines end; whether they are as many as the header says."""
        groups = [Rows(one.count, tuple(bool(each.length) for each in one.properties)) for one in header.elements]
        counts = running_counts(self.values, groups) if len(self.values) == self.starts[-1] else None
        if counts is not None:
            self.row, self.counts = 0, counts
            self.starts = np.concatenate([[0], np.cumsum(counts)])
        return counts is not None

    def expect(self, element: PlyElement) -> None:
        if element.count > len(self.counts) - self.row:
            raise _cut_short(self.name, element)
        if self.starts[self.row + element.count] > len(self.values):
            raise LoadError(f"{self.name}: expected numbers alone for its {element.name} elements; check the file")
        if element.count and int(self.counts[self.row : self.row + element.count].min()) < len(element.properties):
            raise _cut_short(self.name, element)

    def even(self, element: PlyElement) -> PlyValues | None:
        """The values where all lists of a property are as long as its first one."""
        counts = self.counts[self.row : self.row + element.count]
        width = int(counts[0]) if len(counts) else len(element.properties)
        if not bool((counts == width).all()):
            return None
        begin = self.starts[self.row]
        table = self.values[begin : begin + element.count * width].reshape(element.count, width)
        found: PlyValues = {}
        place = 0
        for one in element.properties:
            count = 1
            if one.length:
                lengths = table[:, place]
                if not (len(lengths) and 0 <= lengths[0] < width - place and (lengths == int(lengths[0])).all()):
                    return None
                count = int(lengths[0])
                place += 1
            if place + count > width:
                return None
            values = _typed(table[:, place : place + count].reshape(-1), one)
            found[one.name] = PlyLists(np.full(element.count, count), values) if one.length else values
            place += count
        self.row += element.count
        return found

    def uneven(self, element: PlyElement) -> PlyValues:
        """The values one by one."""
        if len(element.properties) == 1 and element.properties[0].length:
            return self._lists_alone(element)
        begin, end = self.starts[self.row], self.starts[self.row + element.count]
        values = self.values[begin:end].tolist()
        starts = (self.starts[self.row : self.row + element.count + 1] - begin).tolist()
        counts: list[list[int]] = [[] for _ in element.properties]
        taken: list[list[float]] = [[] for _ in element.properties]
        for at, stop in pairwise(starts):
            for k, one in enumerate(element.properties):
                count = 1
                if one.length:
                    if at >= stop or not (0 <= values[at] < stop - at):
                        raise _cut_short(self.name, element)
                    count = int(values[at])
                    at += 1
                    counts[k].append(count)
                taken[k] += values[at : at + count]
                at += count
            if at > stop:
                raise _cut_short(self.name, element)
        self.row += element.count
        found: PlyValues = {}
        for one, many, row in zip(element.properties, counts, taken, strict=True):
            typed = _typed(np.array(row, np.float64), one)
            found[one.name] = PlyLists(np.array(many, np.int64), typed) if one.length else typed
        return found

    def _lists_alone(self, element: PlyElement) -> PlyValues:
        """The values of an element that is one list."""
        rows = slice(self.row, self.row + element.count)
        begins = self.starts[:-1][rows]
        lengths = self.values[begins]
        if not ((lengths >= 0) & (lengths < self.counts[rows])).all():
            raise _cut_short(self.name, element)
        many = lengths.astype(np.int64)
        # From where a list begins among all of them to where it begins in the text.
        shift = np.repeat(begins + 1 - (np.cumsum(many) - many), many)
        shift += np.arange(len(shift))
        self.row += element.count
        one = element.properties[0]
        return {one.name: PlyLists(many, _typed(gathered_rows(self.values, shift), one))}


def _typed(values: NDArray[np.float64], one: PlyProperty) -> PlyArray:
    """Numbers of a text in the type that the header gives; whole numbers stay what they are."""
    with np.errstate(all="ignore"):
        typed = values.astype(one.type)
    # Cast silently where it fits; indices that do not fit must not become others.
    return typed if typed.dtype.kind == "f" or bool((typed == values).all()) else values


def _step(one: PlyProperty) -> tuple[int, Callable[..., tuple[Any, ...]] | None, int]:
    """Bytes of a value; how to read the length of a list, and its bytes."""
    size = np.dtype(one.type).itemsize
    if not one.length:
        return size, None, 0
    order = one.length[0]
    return size, struct.Struct(order + _LETTERS[one.length[1:]]).unpack_from, np.dtype(one.length).itemsize


def _cut_short(name: str, element: PlyElement) -> LoadError:
    return LoadError(
        f"{name}: expected {element.count:,} {element.name} elements as its header says, found fewer; "
        "the file is cut short"
    )
