"""What kind of scene it is: a thing to look at from outside, or a place that one can stand in, and where its ground is.

A place is flat for its width and has floors nearly everywhere: a town, a terrain, a hall. A thing that stands on a
ground much wider than itself is a thing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .columns import Columns, Coordinates, Surfaces, floors_of, median
from .framing import bounds_above, padded_bounds

# Height by width up to which a scene is a place wherever it has surfaces at all (towns, terrains), and up to which it
# is one where it has them everywhere (halls, rooms). Things that are flatter than the first are rare: a plate.
FLAT_RATIO, ROOM_RATIO = 0.12, 0.75
# Share of the columns with a surface that must have a floor, and share of all columns that a hall must cover.
LEAST_FLOORS, LEAST_COVER = 0.7, 0.9
# A ground is level where this share of the floors lies within this share of the scene's height.
LEVEL_SHARE, LEVEL_SPREAD = 0.4, 0.1
# What stands higher than this share of the scene's height stands on the ground and is no part of it.
GROUND_SHARE = 0.02
# A thing on a ground covers less than this share of both of its sides.
THING_SHARE = 1 / 3
# Height of a person's eyes, metres, where the scene's proportions suggest that its unit is a metre: things between the
# height of a room and that of a tall house stand in it, or it is bare and as wide as terrains in one file are.
EYE_M = 1.7
ROOM_M, TOWER_M = 2.4, 100.0
BARE_LEAST_M, BARE_MOST_M = 100.0, 20_000.0
# Elsewhere: a share of the height of what stands there (a person by a house of five floors), of the free height under a
# roof, of the relief of bare terrain.
THINGS_SHARE, ROOM_SHARE, RELIEF_SHARE = 0.1, 0.5, 0.02
# Sides that differ by less are equally long.
SQUARE_RATIO = 1.25


@dataclass(frozen=True, eq=False)
class Place:
    """A scene that one can stand in.

    Attributes
    ----------
    columns : Columns
        The floors of the part of it where things are.
    level : float or None
        Height of the ground where it is level, world units.
    things : float
        Height of what stands on the ground, world units.
    center : (2,) float64
        The middle of the covered columns, x and z.
    sides : tuple of ((2,) float64, float)
        Unit directions in x and z and the lengths of the scene along them, the long side first.
    """

    columns: Columns
    level: float | None
    things: float
    center: Coordinates
    sides: tuple[tuple[Coordinates, float], ...]

    @property
    def long_sides(self) -> tuple[tuple[Coordinates, float], ...]:
        """The long side, or both of a place that is about as wide as long."""
        (_, long), (_, short) = self.sides
        return self.sides if long < SQUARE_RATIO * short else self.sides[:1]

    @property
    def room(self) -> float:
        """The usual free height over the floor, world units; infinite where most of the place is under the open sky."""
        rooms = self.columns.room[self.columns.known]
        return median(rooms) if rooms.size else math.inf

    @property
    def eye_height(self) -> float:
        """Height of a standing person's eyes over the floor, world units."""
        known = self.columns.known
        if self.things > 0:
            share = ROOM_SHARE * self.room if math.isfinite(self.room) else THINGS_SHARE * self.things
            return EYE_M if ROOM_M <= self.things <= TOWER_M else share
        relief = float(np.ptp(self.columns.floor[known]))
        return EYE_M if BARE_LEAST_M <= self.sides[0][1] <= BARE_MOST_M else RELIEF_SHARE * relief


def place_in(surfaces: Surfaces) -> tuple[Place | None, float]:
    """The place that a scene is, or None, and the height above which things stand on level ground, else -inf."""
    scene = surfaces.scene
    bounds = np.asarray(scene.bounds, np.float64)
    if not np.array_equal(bounds, padded_bounds(scene)):
        return None, -math.inf  # a point: rays would not tell its surfaces apart
    width, height = float(max(np.ptp(bounds, axis=0)[[0, 2]])), float(np.ptp(bounds[:, 1]))
    columns = floors_of(surfaces, bounds)
    floors, cover = columns.known.sum() / max(1, columns.covered.sum()), columns.covered.mean()
    flat = height <= FLAT_RATIO * width or (height <= ROOM_RATIO * width and cover >= LEAST_COVER)
    # On a bare plane there is nothing to look at.
    if not flat or floors < LEAST_FLOORS or height <= np.finfo(np.float32).eps * width:
        return None, -math.inf
    level = level_of(columns, height)
    if level is None:
        things = float(np.percentile((columns.top - columns.floor)[columns.known], 99))
        return Place(
            columns, None, things if things > GROUND_SHARE * height else 0.0, *principal_sides(columns)
        ), -math.inf
    things = float(bounds[1, 1]) - level
    if things <= GROUND_SHARE * height:
        return None, -math.inf
    above = level + GROUND_SHARE * things
    part = bounds_above(scene, above)
    if np.all(np.ptp(part, axis=0)[[0, 2]] < THING_SHARE * np.ptp(bounds, axis=0)[[0, 2]]):
        return None, above
    part[:, 1] = bounds[:, 1]
    columns = floors_of(surfaces, part)
    return Place(columns, level, things, *principal_sides(columns)), above


def level_of(columns: Columns, height: float) -> float | None:
    """The height of the level ground; None where floors lie at all heights, as on hills, or there are none."""
    floors = np.sort(columns.floor[columns.known])
    if not len(floors):
        return None
    ends = np.searchsorted(floors, floors + LEVEL_SPREAD * height, side="right")
    start = int((ends - np.arange(len(floors))).argmax())
    within = floors[start : ends[start]]
    return median(within) if len(within) >= LEVEL_SHARE * len(floors) else None


def principal_sides(columns: Columns) -> tuple[Coordinates, tuple[tuple[Coordinates, float], ...]]:
    """The middle of the covered columns, and their extents along their principal axes, the longer first.

    Where no direction stands out, the axes are those of the scene.
    """
    i, j = np.nonzero(columns.covered)
    points = np.column_stack([columns.x[i], columns.z[j]])
    values, vectors = np.linalg.eigh(np.cov(points.T)) if len(points) > 2 else (np.ones(2), np.eye(2))
    # Lengths go with roots of variances.
    axes = vectors.T if values[1] > SQUARE_RATIO**2 * values[0] else np.eye(2)
    cell = max(np.ptp(columns.x), np.ptp(columns.z)) / (len(columns.x) - 1)
    found = []
    center = np.zeros(2)
    for axis in axes:
        along = points @ axis
        center += 0.5 * (along.min() + along.max()) * axis
        found.append((axis if axis[np.abs(axis).argmax()] > 0 else -axis, float(np.ptp(along) + cell)))
    return center, tuple(sorted(found, key=lambda side: -side[1]))
