"""The way of the light over a scene, chosen by the shadows that a picture has under it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from .. import _core
from .columns import Coordinates, Surfaces
from .framing import height_share

# Elevation of the light over a scene at least half as high as wide, and over a flat one: morning and early morning.
HIGH_SUN_RAD, LOW_SUN_RAD = math.radians(38.0), math.radians(22.0)
# From the side, a little from behind the viewer, and from ahead: angles between the level view and the light.
SIDE_RAD, AHEAD_RAD = math.radians(75.0), math.radians(145.0)
# Under these a place is looked at, the usual one first: from the side as the day goes on, or from ahead.
SIDE_ANGLES = (75.0, 90.0, 60.0, 105.0)
AHEAD_ANGLES = (165.0, 150.0, 180.0, 135.0)
ELEVATIONS = (34.0, 26.0, 18.0, 45.0)
# All around, for a hall or a room that light enters from few sides alone.
ALL_ANGLES = tuple(15.0 * step for step in range(13))
ALL_ELEVATIONS = (34.0, 26.0, 18.0, 45.0, 58.0)
# A picture shows its shadows where light that could reach its surfaces is kept from this share of them; below the first
# and above the last they are not noticed, or all there is.
SHADOWED = (0.0, 0.12, 0.45, 1.0)
# A picture that nothing is lit in is dark; from the second share on it is light enough.
LIT = (0.0, 0.25)
# Scores that differ by less are equal, and the earlier light is taken.
NOTICED = 0.03
# A light that scores this much is good enough: no other is looked at.
BEST_LIGHT = 1 - NOTICED
# A light that scores less leaves nearly all in the dark, and others are looked for all around.
GOOD_LIGHT = 0.2
# Pixels of the pictures by which lights are judged.
JUDGED = (48, 27)


@dataclass(frozen=True, eq=False)
class Sun:
    """A way (3,) that light travels, and how well it shows a picture, from 0 to 1."""

    way: Coordinates
    score: float


def level_ways(forward: Coordinates) -> tuple[Coordinates, Coordinates]:
    """The level view and the way to its right; of a view straight down -z and x."""
    ahead = np.array([forward[0], 0.0, forward[2]])
    length = np.linalg.norm(ahead)
    ahead = ahead / length if length > 0 else np.array([0.0, 0.0, -1.0])
    return ahead, np.cross(ahead, (0.0, 1.0, 0.0))


def travels(forward: Coordinates, angle: float, elevation: float) -> Coordinates:
    """The unit way of light at an angle from the level view, positive to the right, and an elevation; radians."""
    ahead, right = level_ways(forward)
    level = math.cos(angle) * ahead + math.sin(angle) * right
    return math.cos(elevation) * level - math.sin(elevation) * np.array([0.0, 1.0, 0.0])


def side_light(forward: Coordinates, bounds: Coordinates, angle: float = SIDE_RAD) -> Coordinates:
    """The way of a light from the left, a little from behind the viewer, or at another angle (radians).

    Shadows fall to the right across the picture, and most of what the eye sees is lit. The lower a scene is for its
    width, the lower stands the light: hills and towns seen whole have only short shadows under a high one.
    """
    return travels(forward, angle, LOW_SUN_RAD + (HIGH_SUN_RAD - LOW_SUN_RAD) * height_share(bounds))


def ways_of_light(forward: Coordinates, angles: Sequence[float], elevations: Sequence[float]) -> Iterator[Coordinates]:
    """The ways at these angles, on both sides, and elevations; degrees."""
    for angle in angles:
        for elevation in elevations:
            for sign in (1.0, -1.0) if 0 < angle < 180 else (1.0,):
                yield travels(forward, sign * math.radians(angle), math.radians(elevation))


def best_sun(camera: _core.Camera, surfaces: Surfaces, normals: Coordinates, ways: Iterable[Coordinates]) -> Sun:
    """The light under which the shadows of a picture show best.

    Parameters
    ----------
    camera : Camera
    surfaces : Surfaces
    normals : (N, 3) float64
        Unit normals on the side of the eye at the pixels of the picture, row by row; 0 where nothing is seen.
    ways : iterable of (3,) float64
        Those to choose from, the usual one first.
    """
    best = Sun(np.array([0.0, -1.0, 0.0]), -1.0)
    for way in ways:
        if best.score >= BEST_LIGHT:
            break
        truth = _core.trace_shadow_mask(surfaces.scene, camera, _core.DirectionalLight(way), size=JUDGED)
        score = shadow_score(truth.ravel(), normals @ way < 0)
        if score > best.score + NOTICED:
            best = Sun(way, score)
    return best


def shadow_score(truth: np.ndarray, facing: np.ndarray) -> float:
    """How well the shadows in a traced picture (N,) show, from 0 to 1, by what faces the light (N,)."""
    seen, lit = (truth >= 0), (truth == 1)
    could_be_lit = seen & facing
    if not could_be_lit.any():
        return 0.0
    nothing, enough, most, too_much = SHADOWED
    shadowed = 1.0 - float(lit[could_be_lit].mean())
    shown = min((shadowed - nothing) / (enough - nothing), (too_much - shadowed) / (too_much - most), 1.0)
    light = min(1.0, (float(lit.sum()) / float(seen.sum()) - LIT[0]) / (LIT[1] - LIT[0]))
    return max(0.0, shown) * max(0.0, light)
