"""The eye of somebody who stands in a place and looks along it, chosen among a few by what they see.

  long side of the place                Candidates stand near both ends, on the ground and beside its middle
+-------------------------+             line, and look along the side or towards the middle. Each looks once
|  x>                 <x  |             with a few rays. The best one sees far and near, things and ground, and
| x>                   <x |             no wall right before it; the light is then chosen among a few from the
|  x>                 <x  |             side (or from ahead) by the shadows that are in the picture.
+-------------------------+
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from .. import _core
from .columns import LEAST_FLOOR_COSINE, Coordinates, Surfaces, median
from .framing import DEPTH_MARGIN, FOV_Y_RAD, corners_of_box, padded_bounds
from .place import Place
from .sunlight import (
    ALL_ANGLES,
    ALL_ELEVATIONS,
    ELEVATIONS,
    GOOD_LIGHT,
    JUDGED,
    NOTICED,
    SIDE_ANGLES,
    Sun,
    best_sun,
    level_ways,
    ways_of_light,
)

# Where candidates stand: distance from the end as a share of the long side, place across as a share of the other.
ALONG = (0.04, 0.12, 0.2, 0.3)
ACROSS = (0.5, 0.4, 0.6, 0.28, 0.72)
# How far towards the middle line a candidate aims at the far end: not at all, or most of the way.
TURNS = (0.0, 0.7)
# Below the horizon, as a person looks who walks; and how steep a view may be where the ground falls or rises.
PITCH_RAD, STEEPEST_RAD = math.radians(-4.0), math.radians(12.0)
# Eyes that look down on a room, as a share of its free height, and how far down they look.
UNDER_CEILING, DOWN_RAD = 0.85, math.radians(-22.0)
# Nobody stands where the free height is less than that of the eyes over this share.
ROOM_FOR_EYES = 0.9
# Nobody stands on what is higher over a level ground than this share of the eyes' height: not on a table or a roof.
CLIMBED_SHARE = 0.3
# A spot nearer to the border of a column than this share of its width is on it.
BORDER_SHARE = 1e-3
# Digits of a score: symmetrical candidates are equal, whatever their rounding, and the earlier one is taken.
SCORE_DIGITS = 2
# Pixels of the pictures by which views are chosen: a post or a tree at some distance is still one wide.
LOOK = (48, 27)
# Candidates whose rays are traced together: 83,000 rays, some megabytes.
TOGETHER = 64
# Pixels of the picture in which the nearest surface is found.
CLOSE_LOOK = (192, 108)
# What is nearer than this many heights of the eye and no floor is right before it.
BEFORE_HEIGHTS = 4.0
# Entropy of the depths in octaves, in bits, of a picture with depths of all kinds: bare level ground has 2.
DEPTH_BITS = 3.3
# Candidates that look at shadows after all have looked at surfaces, and how much of the score shadows make up.
FINALISTS, SHADOWS_COUNT = 6, 0.7
# Near planes stand at this share of the nearest distance seen: what stands between two rays may be nearer.
NEAREST_SHARE = 0.5
# Far over near is at most this: what a depth map of 24 bits still separates.
MOST_DEPTH_RATIO = 2.0**16


@dataclass(frozen=True, eq=False)
class Stand:
    """A candidate: an eye (3,), the unit way that it looks (3,), its height and the free height over the floor."""

    eye: Coordinates
    forward: Coordinates
    height: float
    room: float

    def raised(self) -> Stand:
        """The same place and way from under the ceiling, looking down."""
        ahead, _ = level_ways(self.forward)
        height = UNDER_CEILING * self.room if math.isfinite(self.room) else self.height
        eye = self.eye + np.array([0.0, height - self.height, 0.0])
        return Stand(eye, math.cos(DOWN_RAD) * ahead + np.array([0.0, math.sin(DOWN_RAD), 0.0]), height, self.room)


def stands(place: Place) -> Iterator[Stand]:
    """The candidates, those in the middle of an end first."""
    columns, height = place.columns, place.eye_height
    for index, (axis, length) in enumerate(place.long_sides):
        across, width = place.sides[1 - index]
        for along in ALONG:
            for aside in ACROSS:
                for sign in (1.0, -1.0):
                    at = place.center - sign * (0.5 - along) * length * axis + (aside - 0.5) * width * across
                    i, j = nearest_column(place, at)
                    floor = float(columns.floor[i, j])
                    raised = place.level is not None and abs(floor - place.level) > CLIMBED_SHARE * height
                    room = float(columns.room[i, j])
                    if room * ROOM_FOR_EYES < height or raised:
                        continue
                    spot = np.array([columns.x[i], columns.z[j]])
                    for turn in TURNS:
                        end = place.center + sign * 0.5 * length * axis + (1 - turn) * (aside - 0.5) * width * across
                        eye = np.array([spot[0], floor + height, spot[1]])
                        yield Stand(eye, way(place, spot, end), height, room)


def nearest_column(place: Place, spot: Coordinates) -> tuple[int, int]:
    """The indices of the column at a spot (x, z); on the border of two, that with the larger index at any rounding."""
    i, j = (
        int(np.abs(middles - at - BORDER_SHARE * (middles[1] - middles[0])).argmin())
        for middles, at in ((place.columns.x, spot[0]), (place.columns.z, spot[1]))
    )
    return i, j


def way(place: Place, spot: Coordinates, end: Coordinates) -> Coordinates:
    """The unit way from a spot to a point (x, z), a little below the horizon; over slopes, as they fall or rise."""
    level = (end - spot) / np.linalg.norm(end - spot)
    ahead = (place.columns.x[:, None] - spot[0]) * level[0] + (place.columns.z - spot[1]) * level[1]
    pitch = PITCH_RAD
    if place.level is None:
        # Towards the middle height of the floors that lie ahead.
        i, j = nearest_column(place, spot)
        before = place.columns.known & (ahead > 0.1 * np.linalg.norm(end - spot))
        if before.any():
            rise = median(place.columns.floor[before]) - float(place.columns.floor[i, j])
            pitch += float(np.clip(math.atan2(rise, median(ahead[before])), -STEEPEST_RAD, STEEPEST_RAD))
    x, z = math.cos(pitch) * level
    return np.array([x, math.sin(pitch), z])


def rays_of(stand: Stand, aspect: float, size: tuple[int, int]) -> Coordinates:
    """Unit directions (N, 3) through the middles of the pixels of a small picture, row by row."""
    right = np.cross(stand.forward, (0.0, 1.0, 0.0))
    right /= np.linalg.norm(right)
    up = np.cross(right, stand.forward)
    width, height = size
    tangent = math.tan(0.5 * FOV_Y_RAD)
    x = tangent * aspect * ((np.arange(width) + 0.5) * 2 / width - 1)
    y = tangent * (1 - (np.arange(height) + 0.5) * 2 / height)
    ways = stand.forward + x[None, :, None] * right + y[:, None, None] * up
    unit: Coordinates = (ways / np.linalg.norm(ways, axis=-1, keepdims=True)).reshape(-1, 3)
    return unit


def between(value: float, nothing: float, enough: float, most: float, too_much: float) -> float:
    """1 from `enough` to `most`, falling to 0 on both sides."""
    return float(np.clip(min((value - nothing) / (enough - nothing), (too_much - value) / (too_much - most)), 0.0, 1.0))


def sight_score(place: Place, stand: Stand, ways: Coordinates, distances: Coordinates, normals: Coordinates) -> float:
    """How much a candidate's picture shows, from 0 to 1, by the ways (N, 3), distances (N,) and normals of its rays."""
    seen = np.isfinite(distances)
    if not seen.any():
        return 0.0
    level = (np.abs(normals[:, 1]) >= LEAST_FLOOR_COSINE) & (ways[:, 1] < 0)
    before = np.mean(seen & ~level & (distances < BEFORE_HEIGHTS * stand.height))
    _, counts = np.unique(np.floor(np.log2(distances[seen] / stand.height)), return_counts=True)
    shares = counts / counts.sum()
    depth = min(1.0, float(-(shares * np.log2(shares)).sum()) / DEPTH_BITS)
    standing = np.mean(seen & ~level)
    things = between(float(standing), 0.0, 0.12, 0.6, 1.0) if place.things > 0 else 1.0
    sky = between(float(seen.mean()), 0.2, 0.5, 1.0, 2.0)
    return float((1 - before) ** 4 * depth * (0.25 + 0.75 * things) * (0.25 + 0.75 * sky))


def batches(candidates: Iterator[Stand]) -> Iterator[list[Stand]]:
    """The candidates in groups of at most `TOGETHER`."""
    while some := list(itertools.islice(candidates, TOGETHER)):
        yield some


def best_stand(place: Place, surfaces: Surfaces, aspect: float) -> Stand | None:
    """The candidate whose picture shows most under light from the side; None where nobody can stand."""
    found = []
    for some in batches(stands(place)):
        # Rays of many candidates at once: a call for each took half of the time of the choice.
        ways = np.concatenate([rays_of(stand, aspect, LOOK) for stand in some])
        eyes = np.repeat([stand.eye for stand in some], len(ways) // len(some), axis=0)
        distances, normals, _ = surfaces.hit(eyes, ways)
        looks = (np.split(of, len(some)) for of in (ways, distances, normals))
        for stand, *look in zip(some, *looks, strict=True):
            found.append((round(sight_score(place, stand, *look), SCORE_DIGITS), stand))
    best, most = None, -1.0
    for sight, stand in sorted(found, key=lambda scored: -scored[0])[:FINALISTS]:
        sun = sun_of(stand, surfaces, aspect, SIDE_ANGLES)
        score = round(sight * (1 - SHADOWS_COUNT + SHADOWS_COUNT * sun.score), SCORE_DIGITS)
        if score > most:
            best, most = stand, score
    return best


def sun_of(stand: Stand, surfaces: Surfaces, aspect: float, angles: Sequence[float]) -> Sun:
    """The light at one of these angles to the view (degrees) under which a candidate's shadows show best.

    Where all of them leave the picture dark, as in a hall with windows, it comes from where light enters.
    """
    ways = rays_of(stand, aspect, JUDGED)
    distances, fronts, _ = surfaces.hit(np.tile(stand.eye, (len(ways), 1)), ways)
    normals = fronts * -np.sign((fronts * ways).sum(axis=1, keepdims=True))
    near, far = planes_by_depth(distances * (ways @ stand.forward), surfaces, stand)
    camera = _core.Camera.look_at(
        stand.eye, stand.eye + far * stand.forward, fov_y=FOV_Y_RAD, aspect=aspect, near=near, far=far
    )
    ahead = tuple(angle for angle in ALL_ANGLES if angle > 90)
    sun = best_sun(camera, surfaces, normals, ways_of_light(stand.forward, angles, ELEVATIONS))
    for some in (ahead, ALL_ANGLES) if min(angles) > 90 else (ALL_ANGLES,):
        if sun.score >= GOOD_LIGHT:
            break
        other = best_sun(camera, surfaces, normals, ways_of_light(stand.forward, some, ALL_ELEVATIONS))
        sun = other if other.score > sun.score + NOTICED else sun
    return sun


def planes_by_depth(depths: Coordinates, surfaces: Surfaces, stand: Stand) -> tuple[float, float]:
    """Near and far planes of a candidate: before the nearest depth (N,) in its picture, and behind the whole scene."""
    corners = corners_of_box(padded_bounds(surfaces.scene))
    far = float(((corners - stand.eye) @ stand.forward).max()) * (1 + DEPTH_MARGIN)
    near = NEAREST_SHARE * float(depths[np.isfinite(depths)].min(initial=far))
    return max(near, far / MOST_DEPTH_RATIO), far


def planes_of(stand: Stand, surfaces: Surfaces, aspect: float) -> tuple[float, float]:
    """Near and far planes of a candidate, by a closer look."""
    ways = rays_of(stand, aspect, CLOSE_LOOK)
    distances, _, _ = surfaces.hit(np.tile(stand.eye, (len(ways), 1)), ways)
    return planes_by_depth(distances * (ways @ stand.forward), surfaces, stand)
