"""Common mistakes by their name: each is undone, and told where the maps are then the same.

The inverse instead of the matrix; maps in another order; points of a camera's space, or relative to the camera, taken
for points of the world; a camera's matrix confused with its inverse; a world in other units, or about another origin.
Either of the two matrices can be the one with the mistake, so each is looked for from both sides.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from .convention import NDC_RANGE, TEXTURE_RANGE, Convention
from .evidence import sees_world
from .fields import AXES
from .pair import SAME_DEPTH, SAME_TEXELS, Explanation, Pair, words_of
from .search import USUAL_AXES, explain, measured
from .spaces import Mended, mended_by

if TYPE_CHECKING:
    from .._core import Camera, Scene

# A world scaled by less is a matter of rounding: what is left of single precision after a few products.
SAME_UNITS = 1e-5


#: The pair whose `theirs` has a mistake, the words for it, and the convention of the rest.
Reading = tuple[Pair, str, Convention]


@dataclass(frozen=True)
class KnownView:
    """What is known of the view beside the matrices."""

    camera: Camera | None
    scene: Scene | None


def mistake(
    pairs: Sequence[Pair], found: Sequence[Explanation], camera: Camera | None, scene: Scene | None
) -> tuple[Pair, Explanation] | None:
    """The first mistake after which the maps are the same, and the pair whose `theirs` has it.

    `pairs` are one pair, or the same from both sides with the likelier one first, and `found` is what explains them
    without a mistake.
    """
    for pair, words, convention in mistakes(pairs, found, KnownView(camera, scene)):
        own = [*words_of(convention), *depth_words(convention)]
        left = Explanation(convention, (words, *own), 0.0, 0.0, whole=False, crop=False)
        return pair, replace(measured(pair, left), named=True)
    return None


def mistakes(pairs: Sequence[Pair], found: Sequence[Explanation], view: KnownView) -> Iterator[Reading]:
    """Mistakes that explain everything, the likeliest first."""
    for pair in pairs:
        yield from another_order(pair)
    yield from inverse(pairs, view)
    if view.camera is not None:
        yield from of_camera(pairs, view, view.camera)
    for pair, explanation in zip(pairs, found, strict=True):
        yield from of_world(pair, moved=not explanation.named)


def rest_of(pair: Pair, mended: np.ndarray) -> Convention | None:
    """The convention under which the mended matrices are the same maps; None where there is none."""
    found = explain(pair.with_theirs(mended))
    return found.convention if found.whole and found.depth <= SAME_DEPTH else None


def inverse(pairs: Sequence[Pair], view: KnownView) -> Iterator[Reading]:
    """The inverse matrix."""
    words = "{} is the inverse matrix: it takes the map to the world"
    readings = []
    for pair in pairs:
        convention = rest_of(pair, np.linalg.inv(pair.theirs))
        if convention is not None:
            readings.append((pair, words.format(pair.who), convention))
    yield from likelier(readings, f", or {pairs[-1].who} is", view, rigid=False)


def of_camera(pairs: Sequence[Pair], view: KnownView, camera: Camera) -> Iterator[Reading]:
    """Points of a space of the camera, or one of its matrices confused with its inverse."""
    readings = []
    rigid = True
    for pair in pairs:
        for mended, convention in exact(pair, mended_by(pair, camera)):
            readings.append((pair, mended.words, convention))
            rigid = mended.rigid
            break
    other = f", or {readings[1][1]}" if len(readings) == 2 else ""
    yield from likelier(readings, other, view, rigid)


def exact(pair: Pair, ways: Iterator[Mended]) -> Iterator[tuple[Mended, Convention]]:
    """Those that leave nothing over, with the convention of the rest."""
    for mended in ways:
        convention = rest_of(pair, mended.matrices)
        if convention is not None:
            yield mended, convention


def likelier(readings: Sequence[Reading], other: str, view: KnownView, rigid: bool) -> Iterator[Reading]:
    """The likelier of one or two readings; the first with the words for the `other` where nothing decides."""
    if len(readings) < 2:
        yield from readings
        return
    pair, words, convention = readings[0]
    evidence = sees_world(pair.ours, pair.theirs, view.camera, view.scene, rigid)
    if evidence:
        yield readings[0 if evidence > 0 else 1]
    else:
        yield pair, words + other, convention


def another_order(pair: Pair) -> Iterator[Reading]:
    """Maps of several in another order."""
    count = len(pair.ours)
    if count < 2:
        return
    stacks = usual_maps(pair.theirs)
    # Of each convention, which of theirs (rows) is which of ours.
    alike = np.stack([are_map(pair, stacks, k) for k in range(count)], axis=2)
    for i in np.flatnonzero(np.all(np.any(alike, axis=1), axis=1)):
        order: list[int] = []
        for k in range(count):
            free = [j for j in np.flatnonzero(alike[i, :, k]).tolist() if j not in order]
            order += free[:1]
        if len(order) == count and order != sorted(order):
            numbers = ", ".join(map(str, order))
            words = f"maps in another order: {pair.whose} are {pair.who} number {numbers}"
            yield pair, words, usual_conventions()[i]
            return


def are_map(pair: Pair, stacks: np.ndarray, k: int) -> np.ndarray:
    """(C, J) whether each of (C, J, 4, 4) matrices in our convention is map k of ours."""
    here = pair.map_of == k
    clip = np.einsum("cjab,nb->cjna", stacks, pair.points[here])
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        left = np.abs(clip[..., :3] / clip[..., 3:] - pair.ndc[here]).max(axis=2)
        found: np.ndarray = (left[..., :2].max(axis=-1) * pair.half <= SAME_TEXELS) & (left[..., 2] <= SAME_DEPTH)
    return found


def of_world(pair: Pair, moved: bool) -> Iterator[Reading]:
    """A world in other units; where it may be `moved`, one about another origin."""
    stacks = usual_maps(pair.theirs)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        worlds = np.linalg.inv(pair.ours[0]) @ stacks[:, 0]
        worlds = worlds / worlds[:, 3:, 3:]
        units = np.trace(worlds[:, :3, :3], axis1=1, axis2=2) / 3.0
        likely = np.isfinite(worlds).all(axis=(1, 2)) & (units > 0.0)
        scaled = likely & (np.abs(units - 1.0) > SAME_UNITS)
    back = np.tile(np.eye(4), (len(stacks), 1, 1))
    back[scaled, 3, 3] = units[scaled]
    shifted = likely & ~scaled & moved
    back[shifted, :3, 3] = -worlds[shifted, :3, 3]
    mended = stacks @ back[:, None]
    same = (scaled | shifted) & np.all([are_map(pair, mended[:, k : k + 1], k)[:, 0] for k in range(len(pair.ours))], 0)
    for i in np.flatnonzero(same)[:1]:
        if scaled[i]:
            words = f"a world in other units: a length of 1 in {pair.who} is {units[i]:.6g} in {pair.whose}"
        else:
            place = ", ".join(f"{x:.6g}" for x in back[i, :3, 3])
            words = f"a world about another origin: points of {pair.who} are {pair.whose} moved by ({place})"
        yield pair, words, usual_conventions()[i]


def usual_maps(theirs: np.ndarray) -> np.ndarray:
    """(C, K, 4, 4): their matrices as ours under each of the usual conventions."""
    rows, to_ndc, to_world = usual_factors()
    clips = np.where(rows[:, None, None, None], theirs.transpose(0, 2, 1), theirs)
    found: np.ndarray = to_ndc[:, None] @ clips @ to_world[:, None]
    return found


@lru_cache(maxsize=1)
def usual_factors() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of each usual convention, whether it has rows, (C, 4, 4) our NDC from their map, and their world from ours."""
    conventions = usual_conventions()
    return (
        np.array([c.vectors == "row" for c in conventions]),
        np.linalg.inv([c.map_from_ndc[0] for c in conventions]),
        np.array([c.world_from_their_world.T for c in conventions]),
    )


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
