"""The light of a shadow matrix, and whether two matrices have the same.

A map's light is the point that its rows x, y and w send to zero: at infinity for a directional light. No flip, range or
crop of the map moves it, and no warp; a transposed matrix, turned axes of the world and another light do.
"""

from __future__ import annotations

import itertools
from functools import lru_cache

import numpy as np

from .convention import Convention
from .fields import AXES, all_axes
from .pair import SAME_TEXELS, Pair


@lru_cache(maxsize=1)
def plain_conventions() -> tuple[Convention, ...]:
    """Rows or columns with all world axes, columns first, ours first in each."""
    choices = itertools.product(("column", "row"), all_axes())
    return tuple(Convention(vectors=vectors, axes=axes) for vectors, axes in choices)  # type: ignore[arg-type]


def unwound(theirs: np.ndarray) -> np.ndarray:
    """(96, K, 4, 4): their matrices as ours under each of the plain conventions."""
    worlds = np.array([convention.world_from_their_world for convention in plain_conventions()[:48]])
    stacks = [clip[None] @ worlds.transpose(0, 2, 1)[:, None] for clip in (theirs, theirs.transpose(0, 2, 1))]
    return np.concatenate(stacks)


def light_points(matrices: np.ndarray) -> np.ndarray:
    """(..., 4) homogeneous points of length 1, either way round, of (..., 4, 4) matrices."""
    rows = matrices[..., [0, 1, 3], :]
    rows = rows / np.linalg.norm(rows, axis=-1, keepdims=True)
    points: np.ndarray = np.linalg.svd(rows)[2][..., -1, :]
    return points


def same_lights(pair: Pair, stacks: np.ndarray) -> np.ndarray:
    """(C,) whether each of (C, K, 4, 4) stacks of matrices in our convention has the light of ours."""
    seen = np.einsum("kij,ckj->cki", pair.ours, light_points(stacks))
    # Along a ray of theirs through all depths of ours, places and w may change by no more than what counts as none.
    drift = np.abs(seen[..., [0, 1, 3]]).max(axis=-1) * pair.half
    found: np.ndarray = np.all(drift <= SAME_TEXELS * np.abs(seen[..., 2]), axis=-1)
    return found


def same_light(pair: Pair, convention: Convention) -> bool:
    """Whether the light is the same once the rows or columns and the axes of a convention are undone."""
    return bool(same_lights(pair, convention.to_ours(pair.theirs)[None])[0])


def depth_forward(pair: Pair, convention: Convention) -> bool:
    """Whether depths of theirs grow where those of mine do, along the light rays that both share."""
    theirs = convention.to_ours(pair.theirs)
    rays = light_points(pair.ours)
    growth = [np.einsum("ki,ki->k", m[:, 2], rays) for m in (pair.ours, theirs)]
    sides = []
    for m in (pair.ours, theirs):
        w = np.einsum("ni,ni->n", m[pair.map_of, 3], pair.points)
        sides.append(np.array([np.sum(w[pair.map_of == k]) for k in range(len(m))]))
    return bool(np.sum(np.sign(growth[0] * growth[1] * sides[0] * sides[1])) > 0)


def mirrored(pair: Pair, convention: Convention) -> bool:
    """Whether theirs exchanges left and right of (x, y, depth) against mine."""
    theirs = convention.to_ours(pair.theirs)
    return bool(np.linalg.det(theirs[0]) * np.linalg.det(pair.ours[0]) < 0)


def convention_of_light(pair: Pair) -> Convention | None:
    """Rows or columns and axes under which both have one light; None where no choice does, or several that differ."""
    alike = [plain_conventions()[i] for i in np.flatnonzero(same_lights(pair, unwound(pair.theirs)))]
    for convention in alike:
        if convention.axes == AXES:
            return convention
    found = [c for c in alike if not mirrored(pair, c) and depth_forward(pair, c)]
    return found[0] if len(found) == 1 else None


def angle_between(pair: Pair) -> float | None:
    """Degrees between the directions of both lights, the larger where there are several; None for placed lights."""
    directions = []
    for matrices in (pair.ours, pair.theirs):
        points = light_points(matrices)
        far = np.linalg.norm(points[:, :3], axis=1)
        # Directions are told apart from places as far as single precision does.
        if np.any(np.abs(points[:, 3]) > np.finfo(np.float32).eps * far):
            return None
        directions.append(points[:, :3] / far[:, None])
    cosine = np.abs(np.einsum("ki,ki->k", *directions))
    sine = np.linalg.norm(np.cross(*directions), axis=1)
    return float(np.degrees(np.arctan2(sine, cosine)).max())
