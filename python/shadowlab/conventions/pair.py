"""Two shadow matrices side by side: where each puts the same points, and what a convention makes of that."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from .convention import NDC_RANGE, TEXTURE_RANGE, WHOLE_TILE, Convention
from .fields import AXES, Tiles

#: The two matrices by the names that the caller gave them.
Side: TypeAlias = Literal["mine", "theirs"]

# The grid on which hardware rasterises, in texels: a smaller difference moves no triangle.
SAME_TEXELS = 1.0 / 256.0
# One step of the coarsest depth buffer in use, 16 bits.
SAME_DEPTH = 2.0**-16


@dataclass(frozen=True)
class Explanation:
    """A convention, and what it leaves over.

    `whole` says that nothing is left of places in the map, `named` that what is left has a name in `differences`,
    `crop` that depths may still differ by what is to be told, `mistaken` that the name is that of a mistake.
    """

    convention: Convention
    differences: tuple[str, ...]
    texels: float
    depth: float
    whole: bool
    named: bool = True
    cost: float = 0.0
    crop: bool = True
    mistaken: bool = False


class Pair:
    """Two stacks of matrices and the points at which they are compared: (K, 4, 4), and (N, 4) a map.

    `ours` is taken to be in our convention, and what sets `theirs` apart is looked for. `names` are theirs and ours by
    the names that the caller gave them.
    """

    def __init__(
        self,
        ours: np.ndarray,
        theirs: np.ndarray,
        points: Sequence[np.ndarray],
        resolution: int,
        tile: Tiles | None = None,
        names: tuple[Side, Side] = ("theirs", "mine"),
    ):
        self.ours, self.theirs, self.half, self.tile = ours, theirs, 0.5 * resolution, tile
        self.who, self.whose = names
        self.map_of = np.repeat(np.arange(len(points)), [len(p) for p in points])
        self.points = np.concatenate(points)
        self.ndc = self.project(ours)

    def with_theirs(self, theirs: np.ndarray) -> Pair:
        """The same with other matrices of theirs."""
        made = copy(self)
        made.theirs = theirs
        return made

    def project(self, matrices: np.ndarray) -> np.ndarray:
        """(N, 3) coordinates of the points in their maps; infinity where w changes its sign or vanishes."""
        found: np.ndarray = self.project_all(matrices[None])[0]
        return found

    def project_all(self, stacks: np.ndarray) -> np.ndarray:
        """(C, N, 3) coordinates as `project` gives them, for each of (C, K, 4, 4) stacks of matrices."""
        clip = np.einsum("cnij,nj->cni", stacks[:, self.map_of], self.points)
        # Homogeneous points of a unit cube may have any sign; what counts is that both matrices see them alike.
        w = clip[..., 3] * np.sign(np.einsum("nj,nj->n", self.ours[self.map_of, 3], self.points))
        seen = np.all(w > 0, axis=1) | np.all(w < 0, axis=1)
        found: np.ndarray = np.full((*clip.shape[:2], 3), np.inf)
        found[seen] = clip[seen, :, :3] / clip[seen, :, 3:]
        return found


@dataclass(frozen=True)
class Seen:
    """Their coordinates q (N, 3) under one choice of rows or columns and world axes."""

    convention: Convention
    q: np.ndarray
    cost: float


def plain_places(pair: Pair, seen: Seen) -> Iterator[Explanation]:
    """Flips of x and y, and the range of both."""
    for xy_range, x, y in itertools.product((NDC_RANGE, TEXTURE_RANGE), ("right", "left"), ("up", "down")):
        convention = seen.convention.changed(xy_range=xy_range, x=x, y=y)
        left = undone(convention, seen.q) - pair.ndc[:, :2]
        words = words_of(convention)
        cost = seen.cost + (xy_range == TEXTURE_RANGE) + 2 * (x == "left") + (y == "down")
        yield Explanation(convention, words, float(np.abs(left).max()) * pair.half, 0.0, True, cost=cost)


def undone(convention: Convention, q: np.ndarray, map_of: npt.NDArray[np.int64] | None = None) -> np.ndarray:
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


def affine_fit(mine: np.ndarray, q: np.ndarray) -> tuple[np.ndarray, float, int]:
    """(3, 2) rows of L^T and o of the affine map nearest to q = L m + o, its largest residual, and its rank."""
    design = np.column_stack([mine, np.ones(len(mine))])
    solution, _, rank, _ = np.linalg.lstsq(design, q, rcond=None)
    return solution, float(np.abs(design @ solution - q).max()), int(rank)


def with_texture_range(convention: Convention, scales: np.ndarray, offsets: np.ndarray, half: float) -> Convention:
    """The convention with x and y in [0, 1] where a shift alone, or a size alone, is then left of q = scale m + offset.

    Every other crop is as likely one in NDC.
    """
    centred = bool(np.abs(offsets - 0.5).max() * half <= SAME_TEXELS)
    halved = bool(np.abs(scales - 0.5).max() * half <= SAME_TEXELS and np.abs(offsets - 0.5).max() < 0.25)
    return convention.changed(xy_range=TEXTURE_RANGE) if centred or halved else convention
