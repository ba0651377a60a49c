"""Polygons as triangles: fans where those are right, ear clipping where they are not.

Ears are clipped by mapbox_earcut, in the plane of the polygon's normal after Newell (Sutherland, Sproull and
Schumacker, ACM Computing Surveys 6(1), 1974, section on plane equations). Fans come first, and in the order of
trimesh, so that faces of convex polygons are those that trimesh makes.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import SceneError
from .blockwise import concatenated, gathered_rows

#: Share of a polygon's area by which triangles may overlap or lie outside: what seven digits of text leave open.
NEGLIGIBLE = 1e-6
#: Corners of a concave polygon that are clipped at most: the time grows with their square, about 2 s here.
MOST_CORNERS = 50_000
#: Corners of polygons that are looked at together: what is computed for them, 200 bytes each, stays small.
CORNERS_AT_ONCE = 1 << 17

Indices = NDArray[np.int64]
Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Triangles:
    """The triangles of polygons.

    Attributes
    ----------
    at : (T, 3) int64
        Places in the list of corners, so that texture coordinates and normals of corners follow.
    degenerate : int
        Polygons with fewer than three distinct corners in a row, which have no triangle.
    """

    at: Indices
    degenerate: int = 0


def polygon_faces(points: NDArray[Any], corners: NDArray[Any], counts: Indices) -> tuple[NDArray[Any], int]:
    """Triangles of polygons as rows of points, and how many polygons have none; see `triangulated`."""
    if len(counts) and bool((counts == 3).all()):
        faces = corners.reshape(-1, 3)
        a, b, c = faces.T
        repeated = (a == b) | (b == c) | (c == a)
        return (faces[~repeated], int(repeated.sum())) if repeated.any() else (faces, 0)
    triangles = triangulated(points, corners, counts)
    return gathered_rows(corners, triangles.at), triangles.degenerate


def triangulated(points: NDArray[Any], corners: NDArray[Any], counts: Indices, *, in_place: bool = False) -> Triangles:
    """Triangles of simple polygons, convex or not.

    Corners that repeat the one before are passed over, and so are those that only stand in its place where ear clipping
    stumbles over them. Polygons that cross or overlap themselves, and those without area, become fans from their first
    corner.

    Parameters
    ----------
    points : (V, 3) float
    corners : (C,) int
        Rows of `points`, polygon after polygon.
    counts : (P,) int64
        Corners of each polygon.
    in_place : bool
        Whether triangles keep the order of polygons. Otherwise triangles come first, then the first halves of quads,
        their second halves, and larger polygons.
    """
    if len(counts) and bool((counts == 3).all()):
        a, b, c = corners.reshape(-1, 3).T
        if bool(((a != b) & (b != c) & (c != a)).all()):
            return Triangles(np.arange(len(corners)).reshape(-1, 3))
    # Block after block: an interruption need not wait for all, and what is computed on the way stays small.
    groups: list[list[Indices]] = [[], [], [], []]
    degenerate = 0
    ends = np.cumsum(counts)
    wanted = np.arange(CORNERS_AT_ONCE, len(corners) + CORNERS_AT_ONCE, CORNERS_AT_ONCE)
    edges = np.unique(np.searchsorted(ends, wanted, "left") + 1)
    for begin, end in pairwise([0, *np.minimum(edges, len(counts)).tolist(), len(counts)]):
        if begin < end:
            first = int(ends[begin - 1]) if begin else 0
            parts, without = _of_block(points, corners[first : int(ends[end - 1])], counts[begin:end], in_place)
            for group, part in zip(groups, parts, strict=True):
                group.append(part + first)
            degenerate += without
    return Triangles(concatenated([np.zeros((0, 3), np.int64), *chain.from_iterable(groups)]), degenerate)


def _of_block(
    points: NDArray[Any], corners: NDArray[Any], counts: Indices, in_place: bool
) -> tuple[list[Indices], int]:
    """Triangles, first and second halves of quads, and triangles of larger polygons; how many polygons have none.

    With `in_place` all of them, in the order of polygons, stand in the last place.
    """
    places = np.arange(len(corners))
    owner = np.repeat(np.arange(len(counts)), counts)
    starts = np.cumsum(counts) - counts
    if len(corners):
        before = places - 1
        begins = starts[counts > 0]
        before[begins] = begins + counts[counts > 0] - 1
        repeated = corners == corners[before]
        if repeated.any():
            places, owner = places[~repeated], owner[~repeated]
    sizes = np.bincount(owner, minlength=len(counts))
    starts = np.cumsum(sizes) - sizes
    made: list[list[Indices]] = [[], [], [], []]
    of: list[Indices] = []
    for size in np.unique(sizes[sizes >= 3]):
        faces = np.flatnonzero(sizes == size)
        triangles, rows = _of_one_size(points, corners, places[starts[faces, None] + np.arange(size)])
        halves = np.split(triangles, 2) if size == 4 and not in_place else [triangles]
        kind = 3 if in_place or size > 4 else int(size) - 3
        for k, part in enumerate(halves):
            made[kind + k].append(part)
        of.append(faces[rows])
    if not of:
        return [np.zeros((0, 3), np.int64)] * 4, len(counts)
    kinds = [np.concatenate([np.zeros((0, 3), np.int64), *parts]) for parts in made]
    # Larger polygons stand in the order of the file among themselves.
    of_face = np.concatenate(of)
    order = np.argsort(of_face[len(of_face) - len(kinds[3]) :], kind="stable")
    kinds[3] = kinds[3][order]
    of_face[len(of_face) - len(order) :] = of_face[len(of_face) - len(order) :][order]
    kept = []
    for part in kinds:
        a, b, c = corners[part].T
        kept.append((a != b) & (b != c) & (c != a))
    distinct = np.concatenate(kept)
    with_some = _distinct_count(of_face[distinct], len(counts))
    return [part[chosen] for part, chosen in zip(kinds, kept, strict=True)], len(counts) - with_some


def _distinct_count(values: Indices, size: int) -> int:
    seen = np.zeros(size, bool)
    seen[values] = True
    return int(seen.sum())


def _of_one_size(points: NDArray[Any], corners: NDArray[Any], at: Indices) -> tuple[Indices, Indices]:
    """Triangles of polygons with as many corners each, and the row of `at` that each belongs to."""
    count, size = at.shape
    if size == 3:
        return at, np.arange(count)
    rows = np.arange(count)
    fan = np.stack([np.zeros(size - 2, np.int64), np.arange(1, size - 1), np.arange(2, size)], axis=1)
    if size == 4:
        # As trimesh divides quads: (0, 1, 2) and (2, 3, 0).
        fan[1] = 2, 3, 0
    step = max(1, CORNERS_AT_ONCE // size)
    parts = [slice(begin, begin + step) for begin in range(0, count, step)]
    wrong = np.concatenate([_fan_is_wrong(points[corners[at[part]]].astype(np.float64)) for part in parts])
    if size > 4:
        made = [at[:, fan].reshape(-1, 3)]
        rows = np.repeat(rows, size - 2)
        bent = np.flatnonzero(wrong)
        for begin in range(0, len(bent), step):
            bad = bent[begin : begin + step]
            local, simple = clipped(points[corners[at[bad]]].astype(np.float64))
            blocks = made[0].reshape(count, size - 2, 3)
            inner = np.take_along_axis(at[bad], local.reshape(len(bad), -1), axis=1).reshape(local.shape)
            blocks[bad[simple]] = inner[simple]
            for row in bad[~simple]:
                local_of_one = _without_repeats(points[corners[at[row]]].astype(np.float64))
                if local_of_one is not None:
                    blocks[row] = at[row][local_of_one]
        return made[0], rows
    halves = at[:, fan]
    if wrong.any():
        # Concave at corner 1 or 3: the other diagonal is the inner one.
        halves[wrong] = at[wrong][:, [[1, 2, 3], [3, 0, 1]]]
    return np.concatenate([halves[:, 0], halves[:, 1]]), np.concatenate([rows, rows])


def _fan_is_wrong(polygons: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether fans from the first corner turn over somewhere, and another triangulation does not. Shape (P, n, 3)."""
    with np.errstate(all="ignore"):
        rays = polygons[:, 1:] - polygons[:, :1]
        rays /= np.abs(rays).max(axis=(1, 2), keepdims=True)
        doubled = np.cross(rays[:, :-1], rays[:, 1:])
        normal = doubled.sum(axis=1)
        squared = np.einsum("ij,ij->i", normal, normal)
        along = np.einsum("ijk,ik->ij", doubled, normal)
        wrong = along.min(axis=1) < -NEGLIGIBLE * squared
        if polygons.shape[1] == 4:
            # A quad that crosses itself turns over along both diagonals; what trimesh does stays.
            first, second, third = rays.swapaxes(0, 1)
            for half in (np.cross(second - first, third - first), np.cross(first, third)):
                wrong &= np.einsum("ij,ij->i", half, normal) >= -NEGLIGIBLE * squared
    return np.asarray(wrong & np.isfinite(squared) & (squared > 0))


def clipped(polygons: NDArray[np.float64]) -> tuple[Indices, NDArray[np.bool_]]:
    """Triangles of polygons by ear clipping, every corner in them, and which of the polygons are simple.

    Parameters
    ----------
    polygons : (P, n, 3) float64
        With areas that are not 0.

    Returns
    -------
    triangles : (P, n - 2, 3) int64
        Turning as the polygon does.
    simple : (P,) bool
        Where it is false the triangles are nothing.

    Raises
    ------
    SceneError
        For more corners than can be clipped in seconds.
    """
    import mapbox_earcut

    count, size = polygons.shape[:2]
    if size > MOST_CORNERS:
        raise SceneError(f"expected concave polygons of at most {MOST_CORNERS:,} corners, got {size:,}; divide it")
    flat = _in_plane(polygons)
    ends = np.array([size], np.uint32)
    made = np.zeros((count, size - 2, 3), np.int64)
    simple = np.ones(count, bool)
    for k in range(count):
        found: NDArray[Any] = mapbox_earcut.triangulate_float64(flat[k], ends).reshape(-1, 3)
        if len(found) != size - 2:
            areas = _areas(flat[k], found)
            found = np.where((areas < 0)[:, None], found[:, ::-1], found)
            found = _with_all_corners(found.astype(np.int64), size)
        if len(found) == size - 2:
            made[k] = found
        else:
            simple[k] = False
    whole = _doubled_area(flat)
    areas = _areas(flat, made)
    made = np.where((areas < 0)[..., None], made[..., ::-1], made)
    # Those that cross themselves have triangles that cover each other, or too little.
    simple &= np.abs(np.abs(areas).sum(axis=1) - whole) <= NEGLIGIBLE * np.abs(whole)
    return made, simple


def _without_repeats(polygon: Points) -> Indices | None:
    """Triangles (n - 2, 3) of a polygon without the corners that stand where the one before does.

    Triangles that are missing for that have the first corner three times. None where no corner stands so, or the
    polygon is not simple without them either.
    """
    size = len(polygon)
    kept = np.flatnonzero((polygon != np.roll(polygon, 1, axis=0)).any(axis=1))
    if len(kept) == size or len(kept) < 3:
        return None
    made = np.zeros((size - 2, 3), np.int64)
    if len(kept) == 3:
        made[0] = kept
        return made
    found, simple = clipped(polygon[kept][None])
    made[: len(kept) - 2] = kept[found[0]]
    return made if simple[0] else None


def _in_plane(polygons: Points, outline: int | None = None) -> Points:
    """Coordinates of each polygon in its plane, turning counter-clockwise, about 1 in size; shape (P, n, 2)."""
    local = polygons - polygons[:, :1]
    local = local / np.abs(local).max(axis=(1, 2), keepdims=True)
    ring = local[:, :outline]
    normal = np.cross(ring[:, 1:-1], ring[:, 2:]).sum(axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    side = np.eye(3)[np.abs(normal).argmin(axis=1)]
    u = np.cross(side, normal)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    return np.ascontiguousarray(local @ np.stack([u, np.cross(normal, u)], axis=2))


def _areas(flat: Points, triangles: NDArray[Any]) -> Points:
    """Twice the signed areas of triangles, of one polygon or of one for each."""
    at = triangles.astype(np.int64)[..., None]
    a, b, c = (np.take_along_axis(flat, at[..., k, :], axis=-2) for k in range(3))
    u, v = b - a, c - a
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])


def _with_all_corners(triangles: Indices, size: int) -> Indices:
    """The triangles with those corners, too, that ear clipping passes over: those on a line between others."""
    used = np.unique(triangles)
    if len(used) == size or len(used) < 3:
        return triangles
    between = {}
    for a, b in pairwise([*used.tolist(), int(used[0]) + size]):
        if b - a > 1:
            between[a, b % size] = [k % size for k in range(a + 1, b)]
    made = []
    for triangle in triangles.tolist():
        stack = [tuple(triangle)]
        while stack:
            a, b, c = stack.pop()
            for p, q, r in ((a, b, c), (b, c, a), (c, a, b)):
                chain = between.pop((p, q), None)
                if chain is not None:
                    ends = [p, *chain, q]
                    stack += [(s, t, r) for s, t in pairwise(ends)]
                    break
            else:
                made.append((a, b, c))
    return np.array(made, np.int64).reshape(-1, 3)


def with_holes(points: Points, rings: list[Indices]) -> Indices | None:
    """Triangles of a polygon with holes, as rows of `points`; None where rings cross.

    Parameters
    ----------
    points : (V, 3) float64
    rings : list of (n,) int64
        The outline, and then the holes, turning in any direction.
    """
    import mapbox_earcut

    rings = [ring for ring in rings if len(ring) >= 3]
    if not rings:
        return None
    corners = np.concatenate(rings)
    polygon = points[corners]
    with np.errstate(all="ignore"):
        flat = _in_plane(polygon[None], len(rings[0]))[0]
    if not np.isfinite(flat).all():
        return None
    ends = np.cumsum([len(ring) for ring in rings])
    found = mapbox_earcut.triangulate_float64(flat, ends.astype(np.uint32)).reshape(-1, 3).astype(np.int64)
    areas = _areas(flat, found)
    found[areas < 0] = found[areas < 0][:, ::-1]
    starts = np.concatenate([[0], ends[:-1]])
    shares = [abs(float(_doubled_area(flat[start:end]))) for start, end in zip(starts, ends, strict=True)]
    whole = shares[0] - sum(shares[1:])
    if abs(float(np.abs(areas).sum()) - whole) > NEGLIGIBLE * shares[0]:
        return None
    return np.asarray(corners[found])


def _doubled_area(flat: Points) -> Points:
    """Twice the signed area of polygons, (..., n, 2)."""
    x, y = flat[..., 0], flat[..., 1]
    return np.asarray((x * np.roll(y, -1, axis=-1) - np.roll(x, -1, axis=-1) * y).sum(axis=-1))
