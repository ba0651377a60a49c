"""Scenes of thin, repeating casters: a fence and a truss of bars, over a floor."""

from __future__ import annotations

import numpy as np

import shadowlab as sl

CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
FACES = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
     [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
)  # fmt: skip
FLOOR = np.array([[-20.0, 0, 20], [20, 0, 20], [20, 0, -20], [-20, 0, -20]])


def bar(start, end, width):
    """Vertices (8, 3) of a bar of square section from one point to another."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    along = end - start
    helper = (1, 0, 0) if abs(along[1]) > 0.9 * np.linalg.norm(along) else (0, 1, 0)
    across = np.cross(along, helper)
    across *= width / np.linalg.norm(across)
    other = np.cross(along, across)
    other *= width / np.linalg.norm(other)
    return CORNERS @ np.array([along, across, other]) + 0.5 * (start + end)


def on_floor(bars):
    """The scene of bars over a floor at y = 0."""
    vertices = np.concatenate([FLOOR, *bars])
    faces = [[[0, 1, 2], [0, 2, 3]], *(FACES + 4 + 8 * k for k in range(len(bars)))]
    return sl.Scene.from_arrays(vertices, np.concatenate(faces))


def fence(width, height=2.0, length=8.0):
    """Upright bars three widths apart, with two rails."""
    places = np.arange(-length / 2, length / 2, 3 * width)
    bars = [bar((x, 0, 0), (x, height, 0), width) for x in places]
    rails = [bar((-length / 2, y, 0), (length / 2, y, 0), width) for y in (0.2 * height, 0.9 * height)]
    return on_floor(bars + rails)


def truss(width, bays=8, low=2.0):
    """A space truss of unit bays, well above the floor."""
    bars = []
    for x in np.arange(bays) - bays / 2:
        for z in (-0.5, 0.5):
            ends = [((0, 0), (1, 0)), ((0, 1), (1, 1)), ((0, 0), (1, 1)), ((0, 0), (0, 1))]
            bars += [bar((x + a, low + b, z), (x + c, low + d, z), width) for (a, b), (c, d) in ends]
        bars += [bar((x, low, -0.5), (x, low, 0.5), width), bar((x, low + 1, -0.5), (x + 1, low + 1, 0.5), width)]
    return on_floor(bars)
