"""The scene of docs/moving.md: 10,000 trees of the library's forest that sway, and robots of the library that walk.

Nothing but the places of instances changes from frame to frame, so that every frame is a `Scene.with_transforms` of one
scene. The motion is periodic: the last frame leads back to the first.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import shadowlab as sl

TREES, ROBOTS = 10_000, 8
# Of a robot, by the order of its instances: what it hangs on.
PELVIS, LEGS, TORSO, HEAD, ARMS = 0, ((1, 2), (3, 4)), 5, 6, ((7, 8), (9, 10))
PARTS = 11
# Sway of a crown by its height, and how the gusts travel: their way and length, m.
SWAY, GUST_WAY, GUST_LENGTH = 0.05, (0.8, 0.6), 60.0
# The ring on which robots walk: radius and distance ahead of the eye, m; steps that each takes in a period.
RING_RADIUS, RING_AHEAD, STEPS = 4.2, 13.0, 4
# How far around the ring no undergrowth is left, m.
CLEARING = 2.5
# Swing of thighs and arms, and bend of knees and elbows, radians.
SWING, KNEE, ARM, ELBOW = 0.5, 0.7, 0.6, 0.5

Matrix = NDArray[np.float64]


def turn(axis: int, angle: float) -> Matrix:
    """A rotation about x, y or z."""
    c, s = math.cos(angle), math.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    made = np.eye(4)
    made[i, i] = made[j, j] = c
    made[j, i], made[i, j] = s, -s
    return made


def shift(way: NDArray[np.float64]) -> Matrix:
    """A translation."""
    made = np.eye(4)
    made[:3, 3] = way
    return made


@dataclass(frozen=True)
class Moving:
    """The scene at rest, and what moves in it."""

    scene: sl.Scene
    camera: sl.Camera
    light: sl.DirectionalLight
    #: Instances that are trees, and those of the robots, one row each.
    trees: NDArray[np.int64]
    robots: NDArray[np.int64]
    #: Parts of a robot relative to what they hang on, unturned, and how far its soles reach below the pelvis.
    joints: Matrix
    #: The terrain alone, and the middle of the ring, x and z.
    terrain: sl.Scene
    ring: NDArray[np.float64]

    @classmethod
    def made(cls, trees: int = TREES, robots: int = ROBOTS) -> Moving:
        """The forest, with robots on a ring in its glade."""
        forest, models = sl.library.scene("forest", trees=trees), sl.library.scene("robots", robots=1)
        camera = forest.camera
        ahead = np.asarray(camera.forward)[[0, 2]]
        ring = np.asarray(camera.eye)[[0, 2]] + RING_AHEAD * ahead / np.linalg.norm(ahead)
        # Terrain, trees and undergrowth, in this order; where robots walk nothing grows.
        away = np.linalg.norm(forest.transforms[:, [0, 2], 3] - ring, axis=1)
        kept = (np.arange(len(away)) <= trees) | (away > RING_RADIUS + CLEARING)
        # The ground of the robots stays behind: it is their first instance.
        index = np.concatenate([forest.mesh_index[kept], *[models.mesh_index[1:] + forest.mesh_count] * robots])
        places = np.concatenate([forest.transforms[kept], *[models.transforms[1:]] * robots])
        scene = sl.Scene(forest.meshes + models.meshes, index, places)
        first = int(kept.sum())
        terrain = sl.Scene(forest.meshes[:1], [0], forest.transforms[:1])
        return cls(
            scene, camera, forest.light, np.arange(1, 1 + trees),
            first + np.arange(robots * PARTS).reshape(robots, PARTS), hanging(models.transforms[1:]), terrain, ring,
        )  # fmt: skip

    def at(self, phase: float) -> sl.Scene:
        """The scene at a phase of the period, from 0 to 1."""
        index = np.concatenate([self.trees, self.robots.ravel()])
        return self.scene.with_transforms(index, np.concatenate([self.swayed(phase), self.walked(phase)]))

    def swayed(self, phase: float) -> Matrix:
        """The trees, sheared about their feet along the gusts."""
        places = self.scene.transforms[self.trees]
        along = places[:, [0, 2], 3] @ np.asarray(GUST_WAY) / GUST_LENGTH
        # No two trees are alike: a part of each phase is the tree's own.
        own = 0.2 * np.sin(12.9898 * np.arange(len(along)))
        lean = SWAY * np.sin(2 * np.pi * (phase - along + own))
        shears = np.tile(np.eye(3), (len(lean), 1, 1))
        shears[:, 0, 1], shears[:, 2, 1] = lean * GUST_WAY[0], lean * GUST_WAY[1]
        places[:, :3, :3] = shears @ places[:, :3, :3]
        return places

    def walked(self, phase: float) -> Matrix:
        """The robots on their ring, in step."""
        count = len(self.robots)
        angles = 2 * np.pi * (np.arange(count) + phase) / count
        found = []
        feet = self.ring + RING_RADIUS * np.column_stack([np.cos(angles), np.sin(angles)])
        heights = ground(self.terrain, feet)
        for k, (angle, (x, z), height) in enumerate(zip(angles, feet, heights, strict=True)):
            parts = self.posed(2 * np.pi * (STEPS / 2 * phase + k / count))
            lowest = min(float(part[1, 3]) for part in soles(parts))
            # The robots look along +z; on the ring they walk along its tangent.
            world = shift(np.array([x, height - lowest, z])) @ turn(1, math.atan2(-math.sin(angle), math.cos(angle)))
            found.append(world @ parts)
        return np.concatenate(found)

    def posed(self, stride: float) -> Matrix:
        """The parts of a robot within its pelvis' frame; a stride of a turn is two steps."""
        made = np.tile(np.eye(4), (PARTS, 1, 1))
        for side, (upper, lower) in enumerate(LEGS):
            swing = stride + np.pi * side
            made[upper] = self.joints[upper] @ turn(0, -SWING * math.sin(swing))
            # The knee bends while the leg comes forward.
            made[lower] = made[upper] @ self.joints[lower] @ turn(0, KNEE * max(0.0, math.cos(swing)))
        made[TORSO] = self.joints[TORSO] @ turn(1, 0.15 * math.sin(stride))
        made[HEAD] = made[TORSO] @ self.joints[HEAD]
        for side, (upper, lower) in enumerate(ARMS):
            swing = stride + np.pi * (1 - side)
            out = turn(2, (1 - 2 * side) * -0.12)
            made[upper] = made[TORSO] @ self.joints[upper] @ out @ turn(0, -ARM * math.sin(swing))
            made[lower] = made[upper] @ self.joints[lower] @ turn(0, -ELBOW)
        return made


def hanging(parts: Matrix) -> Matrix:
    """Parts of a robot relative to what they hang on, as if no joint were turned: translations alone."""
    above = {PELVIS: PELVIS, TORSO: PELVIS, HEAD: TORSO}
    above |= {upper: PELVIS for upper, _ in LEGS} | {upper: TORSO for upper, _ in ARMS}
    above |= {lower: upper for upper, lower in (*LEGS, *ARMS)}
    relative = [np.linalg.inv(parts[above[i]]) @ parts[i] for i in range(PARTS)]
    return np.array([shift(one[:3, 3]) for one in relative])


def soles(parts: Matrix) -> list[Matrix]:
    """Where the soles' middles are, as frames at their lowest points."""
    return [parts[lower] @ shift(np.array([0.0, -0.54, 0.06])) for _, lower in LEGS]


def ground(terrain: sl.Scene, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The height of the land at x and z."""
    top = float(terrain.bounds[1, 1]) + 1
    origins = np.column_stack([points[:, 0], np.full(len(points), top), points[:, 1]])
    t, _, _ = sl.trace.first_hit(terrain, origins, np.tile([0.0, -1.0, 0.0], (len(points), 1)))
    return top - t
