"""Common mistakes by their name: each is undone, and told where the maps are then the same.

The inverse instead of the matrix; maps in another order; points of view space, or relative to the camera, taken for
points of the world; a world in other units, or about another origin.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from .convention import NDC_RANGE, TEXTURE_RANGE, Convention
from .fields import AXES
from .pair import SAME_DEPTH, SAME_TEXELS, Explanation, Pair, words_of
from .search import USUAL_AXES, explain, measured

if TYPE_CHECKING:
    from .._core import Camera

# A world scaled by less is a matter of rounding: what is left of single precision after a few products.
SAME_UNITS = 1e-5


def mistake(pair: Pair, found: Explanation, camera: Camera | None) -> Explanation | None:
    """The first mistake after which the maps are the same, in place of what was found without."""
    for words, convention in mistakes(pair, found, camera):
        own = [*words_of(convention), *depth_words(convention)]
        left = Explanation(convention, (words, *own), 0.0, 0.0, whole=False, crop=False)
        return replace(measured(pair, left), named=True)
    return None


def mistakes(pair: Pair, found: Explanation, camera: Camera | None) -> Iterator[tuple[str, Convention]]:
    """Mistakes that explain everything, each with the convention of the rest."""
    yield from another_order(pair)
    yield from after(pair, np.linalg.inv(pair.theirs), "the inverse matrix: it takes the map to the world")
    if camera is not None:
        yield from of_camera(pair, camera)
    yield from of_world(pair, moved=not found.named)


def after(pair: Pair, mended: np.ndarray, words: str) -> Iterator[tuple[str, Convention]]:
    """The words, where the mended matrices are the same maps in some convention."""
    found = explain(pair.with_theirs(mended))
    if found.whole and found.depth <= SAME_DEPTH:
        yield words, found.convention


def another_order(pair: Pair) -> Iterator[tuple[str, Convention]]:
    """Maps of several in another order."""
    count = len(pair.ours)
    if count < 2:
        return
    for convention in usual_conventions():
        theirs = convention.to_ours(pair.theirs)
        order: list[int] = []
        for k in range(count):
            alike = [j for j in range(count) if j not in order and is_map(pair, theirs[j], k)]
            if not alike:
                break
            order.append(alike[0])
        if len(order) == count and order != sorted(order):
            yield f"maps in another order: mine are theirs number {', '.join(map(str, order))}", convention
            return


def is_map(pair: Pair, matrix: np.ndarray, k: int) -> bool:
    """Whether a matrix in our convention is map k of ours."""
    here = pair.map_of == k
    clip = pair.points[here] @ matrix.T
    with np.errstate(divide="ignore", invalid="ignore"):
        left = np.abs(clip[:, :3] / clip[:, 3:] - pair.ndc[here])
    return bool(left[:, :2].max() * pair.half <= SAME_TEXELS and left[:, 2].max() <= SAME_DEPTH)


def of_camera(pair: Pair, camera: Camera) -> Iterator[tuple[str, Convention]]:
    """Points that are given relative to the camera, turned with it or not."""
    view = np.asarray(camera.view)
    apart = np.eye(4)
    apart[:3, 3] = -np.asarray(camera.eye)
    kinds = {
        "for points of the camera's view space, not of the world": view,
        "for points of a left-handed view space of the camera, not of the world": np.diag([1.0, 1, -1, 1]) @ view,
        "for points relative to the camera: the world's origin is moved to its eye": apart,
    }
    for words, moved in kinds.items():
        yield from after(pair, pair.theirs @ moved, words)
        yield from after(pair, moved.T @ pair.theirs, words)


def of_world(pair: Pair, moved: bool) -> Iterator[tuple[str, Convention]]:
    """A world in other units; where it may be `moved`, one about another origin."""
    inverses = np.linalg.inv(pair.ours)
    for convention in usual_conventions():
        theirs = convention.to_ours(pair.theirs)
        with np.errstate(divide="ignore", invalid="ignore"):
            world = inverses[0] @ theirs[0]
            world = world / world[3, 3]
        if not np.isfinite(world).all():
            continue
        units, shift = float(np.trace(world[:3, :3]) / 3.0), world[:3, 3]
        if not units > 0.0:
            continue
        scale, move = np.diag([1.0, 1.0, 1.0, units]), np.eye(4)
        move[:3, 3] = -shift
        if abs(units - 1.0) > SAME_UNITS:
            if all(is_map(pair, m @ scale, k) for k, m in enumerate(theirs)):
                yield f"a world in other units: a length of 1 in theirs is {units:.6g} in mine", convention
                return
        elif moved and all(is_map(pair, m @ move, k) for k, m in enumerate(theirs)):
            place = ", ".join(f"{-x:.6g}" for x in shift)
            yield f"a world about another origin: points of theirs are mine moved by ({place})", convention
            return


@lru_cache(maxsize=1)
def usual_conventions() -> tuple[Convention, ...]:
    """Conventions of engines without an atlas, those with the fewest changes first."""
    made = [
        Convention(vectors=vectors, axes=axes, xy_range=xy_range, y=y, z_range=z_range, reversed_z=reverse)  # type: ignore[arg-type]
        for vectors, axes, xy_range, y, z_range, reverse in itertools.product(
            ("column", "row"),
            (AXES, *USUAL_AXES),
            (NDC_RANGE, TEXTURE_RANGE),
            ("up", "down"),
            (TEXTURE_RANGE, NDC_RANGE),
            (False, True),
        )
    ]
    return tuple(sorted(made, key=lambda c: len(words_of(c)) + len(depth_words(c))))


def depth_words(convention: Convention) -> tuple[str, ...]:
    """The range and the direction of depths, in words, where they are not ours."""
    words = ("z in [-1, 1]",) * (convention.z_range == NDC_RANGE)
    return words + ("reversed z: 1 nearest the light",) * convention.reversed_z
