"""The search for the simplest convention that turns one shadow matrix into another.

With q the map coordinates that their matrix gives a point, and m those of ours, a convention is one of 2 x 48 choices
of rows or columns and of world axes before the projection, and of a flip, a range and a place in an atlas after it:
q_x = a m_x + b and so on. The choices after the projection are separate for places and for depth, so few are tried.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from .convention import NDC_RANGE, TEXTURE_RANGE, WHOLE_TILE, Convention
from .convention_fields import AXES, LEFT_HANDED_AXES, all_axes

# The grid on which hardware rasterises, in texels: a smaller difference moves no triangle.
SAME_TEXELS = 1.0 / 256.0
# One step of the coarsest depth buffer in use, 16 bits.
SAME_DEPTH = 2.0**-16
# A difference that no convention explains is told in the simplest one that leaves at most this many times the least.
SIMPLER = 2.0
# The largest tile beside which another one fits.
LARGEST_TILE = 0.5
# Tiles are whole parts of an atlas of at most this many tiles along a side.
TILES_ALONG = 64
# World axes that engines use; all others are rarer. Right-handed z up; left-handed z up (x forward, y right).
USUAL_AXES = (LEFT_HANDED_AXES, ("x", "-z", "y"), ("x", "z", "y"), ("-z", "x", "y"))


@dataclass(frozen=True)
class Explanation:
    """A convention, and what it leaves over.

    `whole` says that nothing is left of places in the map, `named` that what is left has a name in `differences`.
    """

    convention: Convention
    differences: tuple[str, ...]
    texels: float
    depth: float
    whole: bool
    named: bool = True
    cost: float = 0.0


class Pair:
    """Two stacks of matrices and the points at which they are compared: (K, 4, 4), and (N, 4) a map."""

    def __init__(self, ours: np.ndarray, theirs: np.ndarray, points: Sequence[np.ndarray], resolution: int):
        self.ours, self.theirs, self.half = ours, theirs, 0.5 * resolution
        self.map_of = np.repeat(np.arange(len(points)), [len(p) for p in points])
        self.points = np.concatenate(points)
        self.ndc = self.project(ours)

    def project(self, matrices: np.ndarray, points: np.ndarray | None = None) -> np.ndarray:
        """(N, 3) coordinates of the points in their maps; infinity where w changes its sign or vanishes."""
        points = self.points if points is None else points
        clip = np.einsum("nij,nj->ni", matrices[self.map_of], points)
        # Homogeneous points of a unit cube may have any sign; what counts is that both matrices see them alike.
        w = clip[:, 3] * np.sign(np.einsum("nj,nj->n", self.ours[self.map_of, 3], points))
        found: np.ndarray = np.full((len(points), 3), np.inf)
        if np.all(w > 0) or np.all(w < 0):
            found = clip[:, :3] / clip[:, 3:]
        return found

    def along_rays(self, convention: Convention) -> float:
        """How far the ends of light rays of ours are apart in theirs at the most, texels."""
        ndc = np.array([(x, y, z, 1.0) for z in (0.0, 1.0) for x in (-0.5, 0.5) for y in (-0.5, 0.5)])
        matrices = convention.to_ours(self.theirs)
        ends = np.einsum("kij,kjl,nl->kni", matrices, np.linalg.inv(self.ours), ndc)
        with np.errstate(divide="ignore", invalid="ignore"):
            place = ends[..., :2] / ends[..., 3:]
        apart = np.abs(place[:, :4] - place[:, 4:])
        return float(np.nan_to_num(apart, nan=np.inf).max()) * self.half


@dataclass(frozen=True)
class Seen:
    """Their coordinates q (N, 3) under one choice of rows or columns and world axes."""

    convention: Convention
    q: np.ndarray
    cost: float


def explain(pair: Pair) -> Explanation:
    """The simplest explanation; where there is none, the convention that leaves least, and not much simpler ones do."""
    best: Explanation | None = None
    seen = sorted(candidates(pair), key=lambda s: s.cost)
    for candidate in seen:
        if best is not None and candidate.cost >= best.cost:
            break
        for found in explanations(pair, candidate):
            if best is None or found.cost < best.cost:
                best = found
    return best or unexplained(pair, seen)


def candidates(pair: Pair) -> Iterator[Seen]:
    """Rows or columns and world axes with what they make of the points, where none lies behind a centre."""
    for vectors, axes in itertools.product(("column", "row"), all_axes()):
        convention = Convention(vectors=vectors, axes=axes)  # type: ignore[arg-type]
        q = pair.project(convention.to_ours(pair.theirs))
        if np.isfinite(q).all():
            rare = 0 if axes == AXES else 2 if axes in USUAL_AXES else 3
            yield Seen(convention, q, (vectors == "row") + rare)


def explanations(pair: Pair, seen: Seen) -> Iterator[Explanation]:
    """What can follow the projection: a flip and a range; a tile of an atlas; another crop; a turn."""
    depth = best_depth(pair, seen)
    for places in plain_places(pair, seen):
        if places.texels <= SAME_TEXELS:
            yield joined(places, depth)
    affine = affine_of(pair, seen)
    if affine is None:
        return
    maps, offsets = affine
    if np.abs(maps[:, [0, 1], [1, 0]]).max() * pair.half <= SAME_TEXELS * np.abs(maps).max():
        for places in (*tiles(pair, seen, maps, offsets), crop(pair, seen, maps)):
            yield joined(places, depth)
    else:
        yield joined(turned(pair, seen, maps), depth)


def joined(places: Explanation, depth: Explanation) -> Explanation:
    """An explanation of places and one of depths as one."""
    convention = places.convention.changed(z_range=depth.convention.z_range, reversed_z=depth.convention.reversed_z)
    own = len(words_of(places.convention))  # what is no convention is told after all that is
    words = (*places.differences[:own], *depth.differences, *places.differences[own:])
    return replace(places, convention=convention, differences=words, depth=depth.depth, cost=places.cost + depth.cost)


def best_depth(pair: Pair, seen: Seen) -> Explanation:
    """The range and direction of depth: the simplest that is exact, else the nearest at a price."""
    found = []
    for z_range, reverse in itertools.product((TEXTURE_RANGE, NDC_RANGE), (False, True)):
        z = (seen.q[:, 2] - z_range[0]) / (z_range[1] - z_range[0])
        left = float(np.abs((1.0 - z if reverse else z) - pair.ndc[:, 2]).max())
        words = ("z in [-1, 1]",) * (z_range == NDC_RANGE) + ("reversed z: 1 nearest the light",) * reverse
        convention = Convention(z_range=z_range, reversed_z=reverse)
        found.append(Explanation(convention, words, 0.0, left, True, cost=len(words)))
    exact = [f for f in found if f.depth <= SAME_DEPTH]
    if exact:
        return min(exact, key=lambda f: f.cost)
    # A range that begins below 0 shows in depths below 0.
    below = bool(seen.q[:, 2].min() < -SAME_DEPTH)
    possible = found if below else [f for f in found if f.convention.z_range == TEXTURE_RANGE]
    nearest = simplest(possible, lambda f: f.depth)
    return replace(nearest, cost=nearest.cost + 3)


def plain_places(pair: Pair, seen: Seen) -> Iterator[Explanation]:
    """Flips of x and y, and the range of both."""
    for xy_range, x, y in itertools.product((NDC_RANGE, TEXTURE_RANGE), ("right", "left"), ("up", "down")):
        convention = seen.convention.changed(xy_range=xy_range, x=x, y=y)
        left = undone(convention, seen.q) - pair.ndc[:, :2]
        words = words_of(convention)
        cost = seen.cost + (xy_range == TEXTURE_RANGE) + 2 * (x == "left") + (y == "down")
        yield Explanation(convention, words, float(np.abs(left).max()) * pair.half, 0.0, True, cost=cost)


def undone(convention: Convention, q: np.ndarray, map_of: Any = None) -> np.ndarray:
    """(N, 2) places in our NDC of their coordinates."""
    moved = convention.map_from_ndc
    moved = moved[np.zeros(len(q), int) if len(moved) == 1 else map_of]
    places: np.ndarray = (q[:, :2] - moved[:, :2, 3]) / moved[:, [0, 1], [0, 1]]
    return places


def words_of(convention: Convention) -> tuple[str, ...]:
    """The fields that are not ours, in words; without those of depth."""
    words = []
    if convention.vectors == "row":
        words.append("transposed: for row vectors")
    if convention.axes != AXES:
        words.append(f"{convention.handedness}-handed world with axes ({', '.join(convention.axes)})")
    if convention.xy_range == TEXTURE_RANGE:
        words.append("texture bias: x, y in [0, 1]")
    words += ["x points left"] * (convention.x == "left") + ["y points down"] * (convention.y == "down")
    if convention.tile != WHOLE_TILE:
        places = " and ".join(", ".join(f"{share:.6g}" for share in tile) for tile in convention.tiles)
        words.append(f"a tile of an atlas: {places} (u, v, width, height)")
    return tuple(words)


def affine_of(pair: Pair, seen: Seen) -> tuple[np.ndarray, np.ndarray] | None:
    """(K, 2, 2) and (K, 2) with q = L m + o in every map, where that holds to the tolerance."""
    maps, offsets = [], []
    for k in range(len(pair.ours)):
        here = pair.map_of == k
        solution, left, rank = fitted(pair.ndc[here, :2], seen.q[here, :2])
        # Our texels are as large in theirs as the least stretch of the map makes them.
        stretch = np.linalg.svd(solution[:2], compute_uv=False).min()
        if rank < 3 or not left * pair.half <= SAME_TEXELS * stretch:
            return None
        maps.append(solution[:2].T)
        offsets.append(solution[2])
    return np.array(maps), np.array(offsets)


def fitted(mine: np.ndarray, q: np.ndarray) -> tuple[np.ndarray, float, int]:
    """(3, 2) rows of L^T and o of the affine map nearest to q = L m + o, its largest residual, and its rank."""
    design = np.column_stack([mine, np.ones(len(mine))])
    solution, _, rank, _ = np.linalg.lstsq(design, q, rcond=None)
    return solution, float(np.abs(design @ solution - q).max()), int(rank)


def tiles(pair: Pair, seen: Seen, maps: np.ndarray, offsets: np.ndarray) -> Iterator[Explanation]:
    """A tile of an atlas for each map, where there is room for another tile beside it."""
    scales = maps[:, [0, 1], [0, 1]]
    if not (np.all(scales[:, 0] * scales[0, 0] > 0) and np.all(scales[:, 1] * scales[0, 1] > 0)):
        return
    x, y = "right" if scales[0, 0] > 0 else "left", "up" if scales[0, 1] > 0 else "down"
    for xy_range in (TEXTURE_RANGE, NDC_RANGE):
        low, high = xy_range
        start = (offsets - np.abs(scales) - low) / (high - low)
        size = 2.0 * np.abs(scales) / (high - low)
        # As near as a texel's part of the atlas is known.
        known = SAME_TEXELS / (2.0 * pair.half) * size.max()
        place = [tuple(rounded(float(v), known) for v in row) for row in np.column_stack([start, size])]
        fits = all(min(u, v) >= 0 and u + w <= 1 + known and v + h <= 1 + known for u, v, w, h in place)
        if not fits or not all(min(w, h) <= LARGEST_TILE for _, _, w, h in place):
            continue
        place = [(u, v, min(w, 1.0 - u), min(h, 1.0 - v)) for u, v, w, h in place]
        tile = place[0] if len(set(place)) == 1 else tuple(place)
        convention = seen.convention.changed(xy_range=xy_range, x=x, y=y, tile=tile)
        left = float(np.abs(undone(convention, seen.q, pair.map_of) - pair.ndc[:, :2]).max()) * pair.half
        # A bias matrix comes with most tiles.
        cost = seen.cost + (3 if xy_range == TEXTURE_RANGE else 4) + 2 * (x == "left") + (y == "down")
        yield Explanation(convention, words_of(convention), left, 0.0, left <= SAME_TEXELS, cost=cost)


def rounded(value: float, known: float) -> float:
    """The ratio of small whole numbers within what is known, else the value."""
    ratio = float(Fraction(value).limit_denominator(TILES_ALONG))
    return ratio if abs(ratio - value) <= known else value


def crop(pair: Pair, seen: Seen, maps: np.ndarray) -> Explanation:
    """Another crop of the same map: the flips and the range that leave the smallest shift and scale."""
    signs = maps[0, [0, 1], [0, 1]] > 0
    flips = {"x": "right" if signs[0] else "left", "y": "up" if signs[1] else "down"}
    found = []
    for places in plain_places(pair, seen):
        if {"x": places.convention.x, "y": places.convention.y} == flips:
            found.append(places)
    nearest = simplest(found, lambda f: f.texels)
    place = undone(nearest.convention, seen.q)
    words = []
    for k in range(len(pair.ours)):
        here = pair.map_of == k
        parts = []
        for axis, name in enumerate("xy"):
            scale, shift = np.polyfit(pair.ndc[here, axis], place[here, axis], 1)
            moved = f"shifted by {shift * pair.half:.3g} texels" if abs(shift) * pair.half > SAME_TEXELS else ""
            grown = f"scaled by {scale:.6g}" if abs(scale - 1.0) * pair.half > SAME_TEXELS else ""
            if moved or grown:
                parts.append(f"{name} {' and '.join(filter(None, (grown, moved)))}")
        if parts:
            words.append((f"map {k}: " if len(pair.ours) > 1 else "another crop: ") + ", ".join(parts))
    return replace(
        nearest, differences=(*nearest.differences, *words), whole=nearest.texels <= SAME_TEXELS, cost=nearest.cost + 4
    )


def turned(pair: Pair, seen: Seen, maps: np.ndarray) -> Explanation:
    """The same map, turned in its plane, or stretched askew."""
    mirrored = bool(np.linalg.det(maps[0]) < 0)
    flips = {"x": "right", "y": "down" if mirrored else "up"}
    found = [p for p in plain_places(pair, seen) if {"x": p.convention.x, "y": p.convention.y} == flips]
    nearest = simplest(found, lambda f: f.texels)
    words = []
    for m in maps:
        upright = np.diag([1.0, -1.0]) @ m if mirrored else m
        stretches = np.linalg.svd(upright, compute_uv=False)
        if (stretches[0] - stretches[1]) * pair.half > SAME_TEXELS * stretches[0]:
            words.append("turned or sheared in its plane")
        else:
            angle = np.degrees(np.arctan2(upright[1, 0], upright[0, 0]))
            words.append(f"turned by {angle:.4g}° in its plane: another up for the light")
    words = list(dict.fromkeys(words))
    return replace(nearest, differences=(*nearest.differences, *words), whole=False, cost=nearest.cost + 5)


def simplest(found: Sequence[Explanation], left: Any) -> Explanation:
    """The cheapest of those that leave at most `SIMPLER` times the least."""
    least = min(left(f) for f in found)
    near = [f for f in found if left(f) <= SIMPLER * least]
    return min(near, key=lambda f: (f.cost, left(f)))


def unexplained(pair: Pair, seen: Sequence[Seen]) -> Explanation:
    """The convention that leaves least, told as one that leaves something."""
    everything = [(p, s) for s in seen for p in plain_places(pair, s) if not mirrors(pair, s, p.convention)]
    if not everything:  # no choice of axes keeps the points before the projection's centre
        return Explanation(Convention(), (), np.inf, np.inf, whole=False, named=False)
    nearest = simplest([p for p, _ in everything], lambda f: f.texels)
    own = next(s for p, s in everything if p is nearest)
    return replace(joined(nearest, best_depth(pair, own)), whole=False, named=False)


def mirrors(pair: Pair, seen: Seen, convention: Convention) -> bool:
    """Whether a map would be mirrored against ours once the convention is undone, which no warp does."""
    solution, _, _ = fitted(pair.ndc[:, :2], undone(convention, seen.q))
    return bool(np.linalg.det(solution[:2]) < 0)
