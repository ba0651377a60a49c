"""Wavefront OBJ: polygons by material, in the order that trimesh has them.

Source: Wavefront, Advanced Visualizer manual, appendix B1, version 3.0. Curves, surfaces, lines and points are left
out and counted. The fourth coordinate of a vertex weighs rational curves; polygons have no use for it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import LoadError
from ..alpha_test import AlphaTest
from ..gathered import Gathered
from .blockwise import gathered_rows
from .given import Given
from .limits import check_limit
from .mtl import AlphaTexture, Opacities, alpha_test_of, library_of
from .obj_faces import ObjFaces, faces_of
from .obj_lines import ObjLines
from .obj_words import BARE, FACE, FREE_FORM, LIBRARY, MATERIAL, STROKE, UNKNOWN, VERTEX, VERTEX_TEXTURE
from .polygons import Indices, Points, triangulated
from .split_corners import split_corners
from .words import readable


def read_obj(given: Given) -> Gathered:
    """The polygons of an OBJ file.

    Raises
    ------
    LoadError
        For a line that cannot be read, an index that points nowhere, or where there is no face.
    """
    lines = ObjLines.of(given)
    found = Gathered()
    materials, libraries = _uses_of_materials(given, lines)
    left_out = [(STROKE, "line or point element"), (FREE_FORM, "free-form element")]
    counted = [(int(lines.counts[kind]), what) for kind, what in left_out]
    notes = [f"{count:,} {what}{'s' if count > 1 else ''}" for count, what in counted if count]
    if unknown := int(lines.counts[UNKNOWN]):
        first = lines.number_at(lines.unknown)
        notes.append(f"{unknown:,} lines that are no statements of OBJ (the first is line {first})")
    if not lines.counts[FACE]:
        what = ", ".join(notes) or f"{lines.counts[VERTEX]:,} vertices alone"
        raise LoadError(f"{given.name}: expected faces, got {what}; export polygons")
    found.left_out += notes
    points, widths = lines.rows(VERTEX, 3, 4, "vertex")
    weighted = np.isin(widths, (4, 7))
    if weighted.any() and bool((points[weighted, 3] != 1).any()):
        found.notes.append("the fourth coordinate of vertices, a weight of rational curves, is not used")
    points = np.ascontiguousarray(points[:, :3])
    faces = faces_of(given, lines)
    groups = _by_material(faces, materials)
    textures = library_of(given, libraries, found) if libraries and materials else {}
    opacities = Opacities(given)
    coordinates = cache(lambda: lines.rows(VERTEX_TEXTURE, 1, 2, "texture coordinates")[0])
    # The last material comes first, as in trimesh.
    for name, chosen in reversed(groups.items()):
        label = readable(name)[1:-1] if name is not None else "faces"
        material = textures.get(name) if name is not None else None

        def alpha(uv: Indices, material: AlphaTexture | None = material, label: str = label) -> AlphaTest | None:
            if material is None:
                return None
            return alpha_test_of(opacities, material, label, coordinates(), uv, found)

        _add_group(found, (label, len(found.meshes)), label, points, faces, chosen, alpha)
    return found


def _uses_of_materials(given: Given, lines: ObjLines) -> tuple[list[tuple[int, bytes]], list[bytes]]:
    """Lines that begin a material with its name, and material libraries."""
    bare = lines.of_kind(BARE)
    if len(bare):
        line = int(bare[0])
        raise lines.refusal(line, f"numbers after {readable(lines.line(line))[1:-1]}", "none")
    begins = lines.of_kind(MATERIAL)
    # Of several in a row the last one counts.
    begins = begins[np.diff(begins, append=-1) != 1]
    named = [(line, lines.line(line).split(None, 1)[1:]) for line in begins.tolist()]
    libraries = (lines.line(line).split(None, 1)[1:] for line in lines.of_kind(LIBRARY).tolist())
    distinct = list(dict.fromkeys(name for rest in libraries for name in rest))
    check_limit(given.limits, given.name, "entries", len(distinct), "material libraries")
    return [(line, rest[0] if rest else b"") for line, rest in named], distinct


def _by_material(faces: ObjFaces, materials: list[tuple[int, bytes]]) -> dict[bytes | None, Indices]:
    """Faces of each material, in the order of first use."""
    names: list[bytes | None] = [None, *(name for _, name in materials)]
    numbers: dict[bytes | None, int] = {}
    label = np.array([numbers.setdefault(name, len(numbers)) for name in names])
    segment = np.searchsorted(np.array([line for line, _ in materials], np.int64), faces.lines)
    material = label[segment]
    # Faces sorted by material, each material from its first face on.
    order = np.argsort(material, kind="stable")
    begins = np.flatnonzero(np.diff(material[order], prepend=-1))
    groups = np.split(order, begins[1:])
    by_number = list(numbers)
    return {by_number[material[group[0]]]: group for group in sorted(groups, key=lambda group: int(group[0]))}


def _add_group(
    found: Gathered,
    key: Any,
    label: str,
    points: Points,
    faces: ObjFaces,
    chosen: Indices,
    alpha: Callable[[Indices], AlphaTest | None],
) -> None:
    """Adds the faces of a material as a mesh; `alpha` is asked with the row of texture coordinates of each vertex."""
    counts = faces.counts[chosen]
    vertex, texture, normal = faces.vertex, faces.texture, faces.normal
    if len(chosen) < len(faces.counts):
        inner = np.arange(int(counts.sum())) - np.repeat(np.cumsum(counts) - counts, counts)
        corners = np.repeat(faces.starts[chosen], counts) + inner
        vertex, texture, normal = vertex[corners], texture[corners], normal[corners]
    size = int(counts[0])
    # Faces of one size keep trimesh's order of halves of quads; mixed ones keep that of the file.
    even = bool((counts == size).all()) and size > 2
    triangles = triangulated(points, vertex, counts, in_place=not even)
    found.degenerate += triangles.degenerate
    at = triangles.at
    if not even:
        vertex, texture, normal = vertex[at].reshape(-1), texture[at].reshape(-1), normal[at].reshape(-1)
        at = np.arange(len(vertex)).reshape(-1, 3)
    uv = np.zeros(0, np.int64)
    if not len(at):
        return
    has_texture, has_normal = bool((texture >= 0).all()), bool((normal >= 0).all())
    split = [index for index, has in ((texture, has_texture), (normal, has_normal)) if has]
    if split:
        # A vertex for each combination of indices.
        corner, (rows, *others) = split_corners([vertex, *split])
        uv = others[0] if has_texture else uv
        found.add(key, label, gathered_rows(points, rows), gathered_rows(corner, at), alpha=alpha(uv))
    else:
        rows, corner = _used(vertex, len(points))
        found.add(key, label, gathered_rows(points, rows), gathered_rows(corner, at), alpha=alpha(uv))
    found.place(key, np.eye(4))


def _used(vertex: NDArray[np.int32], count: int) -> tuple[Indices, Indices]:
    """The vertices that are used, ascending, and the place of each corner's among them."""
    if len(vertex) < count // 16:
        rows, corner = np.unique(vertex, return_inverse=True)
        return rows.astype(np.int64), corner.reshape(-1)
    used = np.zeros(count, bool)
    used[vertex] = True
    return np.flatnonzero(used), gathered_rows(np.cumsum(used) - 1, vertex)
