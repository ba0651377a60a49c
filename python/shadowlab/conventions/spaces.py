"""Matrices for points of a camera's spaces, and a matrix of the camera confused with its inverse.

With S a matrix from the world to a space of the camera, and m a map of the world: m S^-1 is the map for points of that
space, and m S is where S was multiplied in instead of its inverse. From the other side of the pair each looks like the
other, so both are readings of one product; `evidence` says which of the two matrices is the map of the world.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .convention import Convention
from .fields import AXES
from .lights import plain_conventions
from .pair import SAME_TEXELS, Pair
from .search import USUAL_AXES

if TYPE_CHECKING:
    from .._core import Camera


NDC_DEPTHS = "z in [-1, 1]"


@dataclass(frozen=True)
class Space:
    """A space of a camera, the matrix that takes the world there, and the names of both."""

    name: str
    matrix: str
    from_world: np.ndarray
    rigid: bool = True


@dataclass(frozen=True)
class Mended:
    """A mistake that theirs may have: the words for it, theirs without it, and whether a rigid motion undid it."""

    words: str
    matrices: np.ndarray
    rigid: bool


def spaces_of(camera: Camera) -> list[Space]:
    """View and clip space in all the ways that engines write them, the simplest first."""
    view, clip = np.asarray(camera.view), np.asarray(camera.clip_from_world)
    made = [
        Space("the camera's view space", "view matrix", view),
        Space("a left-handed view space of the camera", "left-handed view matrix", np.diag([1.0, 1, -1, 1]) @ view),
    ]
    for words, ndc in clip_spaces(camera, clip):
        more = f" ({', '.join(words)})" if words else ""
        made.append(
            Space(f"the camera's clip space ({', '.join(('NDC', *words))})", f"clip_from_world{more}", ndc, False)
        )
    return made


def image_spaces_of(camera: Camera) -> list[Space]:
    """Clip space in the coordinates of an image and of its depth buffer, from which shaders rebuild positions."""
    made = []
    for words, ndc in clip_spaces(camera, np.asarray(camera.clip_from_world)):
        # Depths of [-1, 1] lie in [0, 1] in a buffer.
        if NDC_DEPTHS not in words:
            image = np.array([0.5 * (ndc[0] + ndc[3]), 0.5 * (ndc[1] + ndc[3]), ndc[2], ndc[3]])
            name = f"the camera's clip space ({', '.join(('texture coordinates', *words))})"
            made.append(Space(name, "", image, False))
    return made


def clip_spaces(camera: Camera, clip: np.ndarray) -> Iterator[tuple[tuple[str, ...], np.ndarray]]:
    """What sets each clip space apart from ours, in words, and clip_from_world."""
    planes = {"": clip[2]}
    if np.any(clip[3, :3]) and np.isfinite(camera.far):
        # Row w is the depth d before the eye, and with far at infinity z / w = (d - near) / d.
        planes["infinite far plane"] = clip[3] - np.array([0.0, 0.0, 0.0, camera.near])
    ranges = {"": (1.0, 0.0), NDC_DEPTHS: (2.0, -1.0), "reversed z": (-1.0, 1.0)}
    for (plane, z), (depths, (slope, start)), y in itertools.product(planes.items(), ranges.items(), ("", "y down")):
        ndc = np.array([clip[0], -clip[1] if y else clip[1], slope * z + start * clip[3], clip[3]])
        yield tuple(filter(None, (depths, y, plane))), ndc


def mended_by(pair: Pair, camera: Camera) -> Iterator[Mended]:
    """Ways that theirs could be mistaken in, whose mending leaves at most flips, ranges and crops of our map."""
    ways = list(ways_of(pair, camera))
    factors = np.array([factor for _, _, factor, _ in ways])
    for row, clips in enumerate((pair.theirs, pair.theirs.transpose(0, 2, 1))):
        # The way back: theirs for column vectors, times what undoes the mistake, times what undoes their axes.
        seen = clips[None] @ factors[:, None]
        for i in np.flatnonzero(along_axes(pair, seen)):
            words, rigid, _, world = ways[i]
            left = seen[i] @ world
            yield Mended(words, left.transpose(0, 2, 1) if row else left, rigid)


def ways_of(pair: Pair, camera: Camera) -> Iterator[tuple[str, bool, np.ndarray, np.ndarray]]:
    """Words, whether the mistake is a rigid motion, what undoes their axes and the mistake, and those axes again."""
    worlds = [c.world_from_their_world for c in plain_conventions() if c.vectors == "column" and usual(c)]
    spaces = spaces_of(camera)
    apart = np.eye(4)
    apart[:3, 3] = -np.asarray(camera.eye)
    for world in worlds:
        for space in (*spaces, *image_spaces_of(camera)):
            words = f"{pair.who} is for points of {space.name}, not of the world"
            yield words, space.rigid, world.T @ space.from_world, world
        words = f"{pair.who} is for points relative to the camera: the world's origin is moved to its eye"
        yield words, True, world.T @ apart, world
        for space in spaces:
            name = space.matrix
            words = f"{pair.who} is multiplied by the camera's {name} where its inverse belongs: the two are confused"
            # A camera's matrix takes points of their world, or of ours where another writing was made of the product.
            yield words, space.rigid, np.linalg.inv(space.from_world @ world) @ world.T, world
            yield words, space.rigid, world.T @ np.linalg.inv(space.from_world), world


def usual(convention: Convention) -> bool:
    """Whether a convention has our axes or those of an engine."""
    return convention.axes == AXES or convention.axes in USUAL_AXES


def along_axes(pair: Pair, stacks: np.ndarray) -> np.ndarray:
    """(C,) whether x and y of each of (C, K, 4, 4) stacks are our x and y, scaled and shifted, to the tolerance."""
    q = pair.project_all(stacks)
    likely: np.ndarray = np.isfinite(q).all(axis=(1, 2))
    for k, axis in itertools.product(range(len(pair.ours)), (0, 1)):
        here = pair.map_of == k
        mine, theirs = pair.ndc[here, axis], np.where(likely[:, None], q[:, here, axis], 0.0)
        span = mine.max() - mine.min()
        if not span > 0.0:
            continue
        slope = (theirs[:, mine.argmax()] - theirs[:, mine.argmin()]) / span
        start = theirs[:, mine.argmin()] - slope * mine.min()
        left = np.abs(slope[:, None] * mine + start[:, None] - theirs).max(axis=1)
        # A line through two points is off by up to three times what the best one leaves.
        likely &= left * pair.half <= 3.0 * SAME_TEXELS * np.abs(slope)
    return likely
