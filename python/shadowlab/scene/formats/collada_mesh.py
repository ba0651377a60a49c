"""Meshes of COLLADA: sources of numbers and the primitives that refer to them.

Source: COLLADA 1.5.0, chapter 5, the elements mesh, polygons, polylist, triangles, trifans, tristrips.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from ...errors import LoadError
from ..gathered import Gathered
from .given import Given
from .limits import check_limit
from .polygons import Indices, triangulated, with_holes
from .strips import fan_triangles, strip_triangles
from .xml import child, children, floats, integers, local

_TRIANGLES = ("polygons", "polylist", "triangles", "trifans", "tristrips")
_OTHERS = ("lines", "linestrips")


def referred(by_id: dict[str, Any], reference: str) -> Any:
    """The element of a reference within the document, percent-encoded or not; None where there is none."""
    name = reference.removeprefix("#")
    return by_id.get(name, by_id.get(unquote(name)))


class ColladaMeshes:
    """The primitives of geometries as meshes, each made once."""

    def __init__(self, given: Given, by_id: dict[str, Any], found: Gathered):
        self.given, self.by_id, self.found = given, by_id, found
        self.made: dict[Any, list[Hashable]] = {}
        self.points: dict[Any, NDArray[np.float64]] = {}

    def keys_of(self, geometry: Any) -> list[Hashable]:
        """The keys of a geometry's meshes, one for each primitive of triangles."""
        if geometry in self.made:
            return self.made[geometry]
        keys: list[Hashable] = []
        self.made[geometry] = keys
        name = geometry.get("id") or geometry.get("name") or "a geometry"
        mesh = child(geometry, "mesh")
        if mesh is None:
            self.found.empty.append(f"{name} ({', '.join(map(local, geometry)) or 'empty'})")
            return keys
        for primitive in mesh:
            kind = local(primitive)
            if kind in _OTHERS:
                self.found.empty.append(f"{name} ({kind})")
            elif kind in _TRIANGLES:
                points = self._points(primitive)
                triangles = self._triangles(primitive, kind, points)
                key = (name, len(self.found.meshes), len(self.found.empty))
                if len(triangles):
                    # A vertex for each corner, as trimesh has them.
                    corners = np.arange(triangles.size).reshape(-1, 3)
                    self.found.add(key, name, points[triangles].reshape(-1, 3), corners)
                    keys.append(key)
        return keys

    def _inputs(self, primitive: Any) -> tuple[Any, int, int]:
        """The input of positions, its place among the indices of a corner, and how many there are."""
        stride, vertex = 1, None
        for one in children(primitive, "input"):
            offset = int(integers(self.given.name, one.get("offset", "0"), "an offset").sum())
            if not 0 <= offset < 1 << 16:
                raise LoadError(f"{self.given.name}: expected offsets from 0, got {offset}; check the file")
            stride = max(stride, offset + 1)
            if one.get("semantic") in ("VERTEX", "POSITION") and vertex is None:
                vertex = one, offset
        if vertex is None:
            raise LoadError(
                f"{self.given.name}: expected an input VERTEX in {local(primitive)}, found none; check the file"
            )
        return vertex[0], vertex[1], stride

    def _points(self, primitive: Any) -> NDArray[np.float64]:
        source = self._referred(self._inputs(primitive)[0])
        if local(source) == "vertices":
            inputs = [one for one in children(source, "input") if one.get("semantic") == "POSITION"]
            if not inputs:
                raise LoadError(
                    f"{self.given.name}: expected an input POSITION in vertices, found none; check the file"
                )
            source = self._referred(inputs[0])
        if source not in self.points:
            self.points[source] = self._source(source)
        return self.points[source]

    def _source(self, source: Any) -> NDArray[np.float64]:
        """The rows of three of a source of numbers."""
        name = self.given.name
        array = next(iter(children(source, "float_array", "int_array")), None)
        accessor = next(source.iter("{*}accessor"), None)
        if accessor is not None and array is None:
            array = referred(self.by_id, accessor.get("source", ""))
        if array is None:
            raise LoadError(f"{name}: expected numbers in the source {source.get('id')!r}, found none; check the file")
        values = floats(name, array.text, "positions")
        stride, offset, count = 3, 0, len(values) // 3
        if accessor is not None:
            stride = int(integers(name, accessor.get("stride", "1"), "a stride").sum())
            offset = int(integers(name, accessor.get("offset", "0"), "an offset").sum())
            if stride < 3 or offset < 0:
                raise LoadError(
                    f"{name}: expected positions of three numbers, got a stride of {stride}; check the file"
                )
            count = int(integers(name, accessor.get("count", str((len(values) - offset) // stride)), "a count").sum())
        if not 0 <= count <= len(values) or (count and offset + (count - 1) * stride + 3 > len(values)):
            raise LoadError(f"{name}: expected {count:,} positions, got {len(values):,} numbers; the file is cut short")
        return np.asarray(values[offset + np.arange(count)[:, None] * stride + np.arange(3)])

    def _triangles(self, primitive: Any, kind: str, points: NDArray[np.float64]) -> Indices:
        """Triangles as rows of `points`."""
        _, offset, stride = self._inputs(primitive)
        lists = [self._corners(one, offset, stride, len(points)) for one in children(primitive, "p")]
        corners = np.concatenate([*lists, np.zeros(0, np.int64)])
        counts = np.array([len(one) for one in lists], np.int64)
        if kind == "tristrips":
            return strip_triangles(corners, counts)
        if kind == "trifans":
            return fan_triangles(corners, counts)
        if kind == "triangles":
            counts = np.full(len(corners) // 3, 3)
        elif kind == "polylist":
            vcount = child(primitive, "vcount")
            counts = integers(self.given.name, None if vcount is None else vcount.text, "vcount")
        if int(counts.sum()) != len(corners) or (len(counts) and counts.min() < 0):
            raise LoadError(
                f"{self.given.name}: expected {int(counts.sum()):,} corners in {kind}, got {len(corners):,}; "
                "check the file"
            )
        most = int(counts.max(initial=0))
        check_limit(self.given.limits, self.given.name, "corners", most, "corners of a polygon")
        made = triangulated(points, corners, counts)
        self.found.degenerate += made.degenerate
        holed = [self._holed(one, offset, stride, points) for one in children(primitive, "ph")]
        return np.concatenate([corners[made.at], *holed])

    def _holed(self, element: Any, offset: int, stride: int, points: NDArray[np.float64]) -> Indices:
        """Triangles of a polygon with holes."""
        rings = [self._corners(one, offset, stride, len(points)) for one in children(element, "p", "h")]
        if not rings:
            return np.zeros((0, 3), np.int64)
        triangles = with_holes(points, rings)
        if triangles is None:
            self.found.notes.append("a polygon with holes that cross its outline was filled")
            made = triangulated(points, rings[0], np.array([len(rings[0])]))
            return rings[0][made.at]
        return triangles

    def _corners(self, element: Any, offset: int, stride: int, count: int) -> Indices:
        """The rows of positions that a list of indices names."""
        indices = integers(self.given.name, element.text, local(element))
        if len(indices) % stride:
            raise LoadError(
                f"{self.given.name}: expected {stride} indices for each corner, got {len(indices):,}; check the file"
            )
        found = indices[offset::stride]
        if len(found) and (found.min() < 0 or found.max() >= count):
            wrong = int(found[(found < 0) | (found >= count)][0])
            raise LoadError(
                f"{self.given.name}: expected vertices from 0 to {count - 1:,}, got {wrong}; check the file"
            )
        return found

    def _referred(self, element: Any) -> Any:
        reference = element.get("source", "")
        found = referred(self.by_id, reference)
        if found is None:
            raise LoadError(f"{self.given.name}: expected the source {reference!r}, found none; check the file")
        return found
