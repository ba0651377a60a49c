"""PLY: polygons and triangle strips, as text or as bytes of either order.

Source: Turk, "The PLY Polygon File Format", Stanford, 1994. Strips are those of Stanford's own models: one list of
vertices, in which -1 begins a new strip.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import LoadError
from ..gathered import Gathered
from .given import Given
from .limits import check_limit
from .ply_header import ply_header
from .ply_values import PlyLists, PlyValues, ply_values
from .polygons import polygon_faces
from .strips import strip_triangles

#: Names of the list of a face's or strip's vertices.
_INDEX_NAMES = ("vertex_indices", "vertex_index")


def read_ply(given: Given) -> Gathered:
    """The faces and strips of a PLY file as one mesh.

    Raises
    ------
    LoadError
        For a file that is cut short or has no faces, or an index that points nowhere.
    """
    header = ply_header(given)
    values = ply_values(given, header)
    points = _points(given, values)
    found = Gathered()
    faces: list[NDArray[Any]] = []
    if (lists := _lists(given, values, "face")) is not None:
        check_limit(given.limits, given.name, "corners", int(lists.counts.max(initial=0)), "corners of a polygon")
        corners = _indices(given, lists.values, len(points), strips=False)
        triangles, degenerate = polygon_faces(points, corners, lists.counts)
        found.degenerate += degenerate
        faces.append(triangles)
    if (lists := _lists(given, values, "tristrips")) is not None:
        corners = _indices(given, lists.values, len(points), strips=True)
        check_limit(given.limits, given.name, "elements", len(corners), "corners of triangle strips")
        faces.append(strip_triangles(corners, lists.counts))
    count = sum(map(len, faces))
    if not count and not found.degenerate:
        others = ", ".join(f"{one.count:,} {one.name}" for one in header.elements) or "no element"
        raise LoadError(f"{given.name}: expected faces or tristrips, got {others}; export a mesh, not points alone")
    found.add("mesh", "the mesh", points, faces[0] if len(faces) == 1 else np.concatenate(faces))
    found.place("mesh", np.eye(4))
    return found


def _points(given: Given, values: dict[str, PlyValues]) -> NDArray[np.float32] | NDArray[np.float64]:
    columns = [values.get("vertex", {}).get(axis) for axis in "xyz"]
    arrays = [column for column in columns if isinstance(column, np.ndarray)]
    if len(arrays) != 3:
        raise LoadError(f"{given.name}: expected vertex elements with x, y and z; check the header")
    return np.column_stack(arrays)


def _lists(given: Given, values: dict[str, PlyValues], element: str) -> PlyLists | None:
    """The lists of vertices of an element, or None where there is none."""
    found = values.get(element, {})
    lists = {name: value for name, value in found.items() if isinstance(value, PlyLists)}
    for name in _INDEX_NAMES:
        if name in lists:
            return lists[name]
    if len(lists) == 1:
        return next(iter(lists.values()))
    if any(len(value.counts if isinstance(value, PlyLists) else value) for value in found.values()):
        raise LoadError(f"{given.name}: expected a list vertex_indices of each {element}, got {', '.join(found)}")
    return None


def _indices(given: Given, values: NDArray[Any], count: int, *, strips: bool) -> NDArray[Any]:
    """Indices as whole numbers within the vertices."""
    least = -1 if strips else 0
    if values.dtype.kind in "iu" and values.size and least <= int(values.min()) and int(values.max()) < count:
        return values.astype(values.dtype.newbyteorder("="), copy=False)
    with np.errstate(invalid="ignore"):
        whole = np.asarray(values).astype(np.int64)
    wrong = (whole != values) | (whole < least) | (whole >= count)
    if wrong.any():
        value = values[int(wrong.argmax())]
        raise LoadError(f"{given.name}: expected vertices from 0 to {count - 1:,}, got {value}; check the file")
    return whole
