"""The search for the simplest convention that turns one shadow matrix into another.

With q the map coordinates that their matrix gives a point, and m those of ours, a convention is one of 2 x 48 choices
of rows or columns and of world axes before the projection, and of a flip, a range and a place in an atlas after it:
q_x = a m_x + b and so on. The choices after the projection are separate for places and for depth, so few are tried.
A convention is told only where it leaves nothing over, or where what is left cannot hide it.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from .convention import NDC_RANGE, TEXTURE_RANGE, Convention
from .crops import affine_of, crop, tiles, turned_map
from .fields import AXES, LEFT_HANDED_AXES
from .lights import convention_of_light, depth_forward, mirrored, plain_conventions, same_light, unwound
from .pair import SAME_DEPTH, SAME_TEXELS, Explanation, Pair, Seen, plain_places, undone, words_of

REVERSED = "reversed z: 1 nearest the light"
OPPOSITE = "the opposite light direction (or x points left and z is reversed, which gives the same matrix)"
# What leaves map coordinates as their matrix gives them.
NO_PLACES = {"xy_range": NDC_RANGE, "x": "right", "y": "up", "z_range": TEXTURE_RANGE, "reversed_z": False}
# World axes that engines use; all others are rarer. Right-handed z up; left-handed z up (x forward, y right).
USUAL_AXES = (LEFT_HANDED_AXES, ("x", "-z", "y"), ("x", "z", "y"), ("-z", "x", "y"))


def explain(pair: Pair) -> Explanation:
    """The simplest explanation; where nothing explains the places, what is known of the light."""
    best: Explanation | None = None
    own_light = same_light(pair, Convention())
    for candidate in sorted(candidates(pair), key=lambda s: s.cost):
        if best is not None and candidate.cost >= best.cost:
            break
        for found in explanations(pair, candidate):
            exact = found.whole and found.depth <= SAME_DEPTH
            # Where the light is the same without them, only a map that is the same needs other axes.
            needed = exact or not own_light or seen_as_it_is(candidate.convention)
            if needed and (best is None or found.cost < best.cost):
                best = found
    return opposite(pair, best) if best is not None else unexplained(pair)


def seen_as_it_is(convention: Convention) -> bool:
    """Whether a convention has columns and our axes."""
    return convention.vectors == "column" and convention.axes == AXES


def candidates(pair: Pair) -> Iterator[Seen]:
    """Rows or columns and world axes that may leave nothing over, with what they make of the points.

    None where a point lies behind a centre, and none that is no affine map of our places.
    """
    conventions = plain_conventions()
    q = pair.project_all(unwound(pair.theirs))
    for i in np.flatnonzero(np.isfinite(q).all(axis=(1, 2)) & about_affine(pair, q)):
        axes = conventions[i].axes
        rare = 0 if axes == AXES else 2 if axes in USUAL_AXES else 3
        yield Seen(conventions[i], q[i], (conventions[i].vectors == "row") + rare)


def about_affine(pair: Pair, q: np.ndarray) -> np.ndarray:
    """(C,) whether places q (C, N, 3) can be an affine map of ours within the tolerance, which no convention exceeds.

    A quick look at all choices at once: each has one design, so one pseudoinverse serves them all.
    """
    likely = np.ones(len(q), bool)
    finite = np.isfinite(q).all(axis=(1, 2))
    places = np.where(finite[:, None, None], q, 0.0)[..., :2]
    for k in range(len(pair.ours)):
        here = pair.map_of == k
        design = np.column_stack([pair.ndc[here, :2], np.ones(here.sum())])
        if np.linalg.matrix_rank(design) < 3:
            continue
        solution = np.linalg.pinv(design) @ places[:, here]
        left = np.abs(design @ solution - places[:, here]).max(axis=(1, 2))
        stretch = np.linalg.norm(solution[:, :2], ord=2, axis=(1, 2))
        # Least squares leave at most √N times the largest residual of any affine map, and no stretch exceeds the norm;
        # twice that leaves room for what the fit moves the stretch.
        likely &= left * pair.half <= 2.0 * np.sqrt(here.sum()) * SAME_TEXELS * stretch
    return likely


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
        for places in (*tiles(pair, seen, maps, offsets), crop(pair, seen, maps, offsets)):
            yield joined(places, depth)
    else:
        yield joined(turned_map(pair, seen, maps, offsets), depth)


def joined(places: Explanation, depth: Explanation) -> Explanation:
    """An explanation of places and one of depths as one."""
    convention = places.convention.changed(z_range=depth.convention.z_range, reversed_z=depth.convention.reversed_z)
    own = len(words_of(places.convention))  # what is no convention is told after all that is
    words = (*places.differences[:own], *depth.differences, *places.differences[own:])
    return replace(places, convention=convention, differences=words, depth=depth.depth, cost=places.cost + depth.cost)


def best_depth(pair: Pair, seen: Seen) -> Explanation:
    """The range and direction of depth: the simplest that is exact, else the direction alone, which is certain."""
    found = []
    for z_range, reverse in itertools.product((TEXTURE_RANGE, NDC_RANGE), (False, True)):
        left = depth_left(pair, seen.q, Convention(z_range=z_range, reversed_z=reverse))
        words = ("z in [-1, 1]",) * (z_range == NDC_RANGE) + (REVERSED,) * reverse
        convention = Convention(z_range=z_range, reversed_z=reverse)
        found.append(Explanation(convention, words, 0.0, left, True, cost=len(words)))
    exact = [f for f in found if f.depth <= SAME_DEPTH]
    if exact:
        return min(exact, key=lambda f: f.cost)
    nearest = found[0 if depth_forward(pair, seen.convention) else 1]
    return replace(nearest, cost=nearest.cost + 3)


def depth_left(pair: Pair, q: np.ndarray, convention: Convention) -> float:
    """How far depths are apart at the most once the range and direction of a convention are undone."""
    low, high = convention.z_range
    z = (q[:, 2] - low) / (high - low)
    return float(np.abs((1.0 - z if convention.reversed_z else z) - pair.ndc[:, 2]).max())


def opposite(pair: Pair, found: Explanation) -> Explanation:
    """The same, or an opposite light: that of which mirrored x and reversed depths leave no trace."""
    convention = found.convention
    if not (convention.x == "left" and convention.reversed_z):
        return found
    words = [word for word in found.differences if word not in ("x points left", REVERSED)]
    plain = convention.changed(x="right", reversed_z=False)
    return measured(pair, replace(found, convention=plain, differences=(OPPOSITE, *words), whole=False))


def measured(pair: Pair, found: Explanation) -> Explanation:
    """The same with the differences that its convention leaves."""
    q = pair.project(found.convention.changed(tile=(0, 0, 1, 1), **NO_PLACES).to_ours(pair.theirs))
    if not np.isfinite(q).all():
        return replace(found, texels=np.inf, depth=np.inf)
    texels = float(np.abs(undone(found.convention, q, pair.map_of) - pair.ndc[:, :2]).max()) * pair.half
    return replace(found, texels=texels, depth=depth_left(pair, q, found.convention))


def unexplained(pair: Pair) -> Explanation:
    """What is certain of maps that differ by more than a crop: rows or columns, axes and directions, from the light."""
    convention = convention_of_light(pair)
    if convention is None:
        return measured(pair, Explanation(Convention(), (), 0.0, 0.0, whole=False, named=False, crop=False))
    mirror, backward = mirrored(pair, convention), not depth_forward(pair, convention)
    if backward and not mirror:
        words: tuple[str, ...] = (OPPOSITE, *words_of(convention))
    else:
        # Left and right exchanged without reversed depths: one of x and y points the other way, most often y.
        convention = convention.changed(reversed_z=backward, y="down" if mirror and not backward else "up")
        words = (*words_of(convention), *(REVERSED,) * backward)
    return measured(pair, Explanation(convention, words, 0.0, 0.0, whole=False, named=False, crop=False))
