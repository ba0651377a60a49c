"""An eye that holds a scene whole: at a three-quarter angle, as near as its field of view allows.

For a fixed orientation each pair of opposite frustum planes bounds the position in closed form, so nothing is searched.

        side view                     the scene touches one pair of planes;
      e .                             the other pair has room to spare, the
        `  .   +------+               same on both sides of the picture
         `   . |      |
          `    +------+
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

    from .._core import Scene

# Chosen because it shows two sides of a box, and leaves room for shadows that fall to the right.
AZIMUTH_RAD = math.radians(30.0)
# A scene along the diagonal is a thin band seen from one side, and fills more seen from the other; the other is taken
# where the scene's rectangle in the picture grows by this factor, so that most scenes are seen from the usual one.
OTHER_SIDE_GAIN = 1.25
# The middle of what painters of architecture and engines use; wide enough that near and far differ.
FOV_Y_DEG = 50.0
FOV_Y_RAD = math.radians(FOV_Y_DEG)
# Share of the picture left free around the scene.
MARGIN = 0.06
# Room between the scene and the near and far planes, as a share of their depth: enough for rounding in any renderer.
DEPTH_MARGIN = 0.05
# Far over near for an eye inside the scene, where nothing else limits near: what engines ship (0.1 m to 100 m).
INSIDE_DEPTH_RATIO = 1000.0
# A scene smaller than this share of its own distance from the origin cannot be told from a point in float64 pictures
# (2^-52 is one step; 2^20 steps are enough for a picture).
SMALLEST_RELATIVE_SIZE = 2.0**-32

# Vertices that are looked at one by one, over all instances: below a second. Beyond it instances are framed by the
# corners of their mesh's box, which holds them with room to spare.
MOST_VERTICES = 2**20
# Vertices at a time, so that memory stays small.
VERTICES_AT_ONCE = 2**13
# Directions in which the outline is sampled, in the plane across and ahead and in the plane up and ahead. What stands
# out between two of them does so by 1 - cos(pi / 64), a thousandth of the scene's radius: far below the margin.
OUTLINE_DIRECTIONS = 64


@dataclass(frozen=True, eq=False)
class Framing:
    """An eye for one orientation: its axes right, up, forward, what it frames, and the area that this takes."""

    axes: tuple[np.ndarray, np.ndarray, np.ndarray]
    outline: np.ndarray
    eye: np.ndarray
    area: float


def framing_of(scene: Scene, elevation: float, aspect: float, above: float = -math.inf) -> Framing:
    """The eye at this elevation (radians) that holds the scene, from the usual side or the one that shows more.

    What lies at the height `above` or below it is left out.
    """
    center = corners_of_box(bounds_above(scene, above)).mean(axis=0)
    usual, other = (
        framing(scene, center, orientation(azimuth, elevation), aspect, above)
        for azimuth in (AZIMUTH_RAD, -AZIMUTH_RAD)
    )
    return other if other.area > OTHER_SIDE_GAIN * usual.area else usual


def framing(
    scene: Scene, center: np.ndarray, axes: tuple[np.ndarray, np.ndarray, np.ndarray], aspect: float, above: float
) -> Framing:
    """The eye of this orientation that holds the scene, and the area of the scene's rectangle in the picture."""
    points = outermost_vertices(scene, center, axes, aspect, above)
    eye = center + fitting_offset(points - center, *axes, FOV_Y_RAD, aspect)
    right, up, forward = axes
    seen = np.column_stack([(points - eye) @ right, (points - eye) @ up]) / ((points - eye) @ forward)[:, None]
    return Framing(axes, points, eye, float(np.ptp(seen, axis=0).prod()))


def height_share(bounds: np.ndarray) -> float:
    """1 for a scene at least half as high as wide, falling to 0 for a flat one."""
    across, height, depth = bounds[1] - bounds[0]
    return min(1.0, 2.0 * float(height) / float(max(across, depth))) if max(across, depth) > 0 else 1.0


def fitting_depths(scene: Scene, eye: npt.ArrayLike, forward: npt.ArrayLike) -> tuple[float, float]:
    """Near and far planes for an eye of one's own: hugging the scene's box, or in a fixed ratio from inside it."""
    corners = corners_of_box(padded_bounds(scene))
    depths = (corners - np.asarray(eye, float)) @ np.asarray(forward, float)
    # An eye that looks away from everything still needs a valid pair; the scene's size is the only length there is.
    far = float(depths.max()) if depths.max() > 0 else float(np.ptp(corners, axis=0).max())
    near = max(float(depths.min()), far / INSIDE_DEPTH_RATIO)
    return near * (1 - DEPTH_MARGIN), far * (1 + DEPTH_MARGIN)


def orientation(azimuth: float, elevation: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Right, up and forward of an eye at this azimuth (from +z towards -x) and elevation that looks at the middle."""
    forward = np.array(
        [math.sin(azimuth) * math.cos(elevation), -math.sin(elevation), -math.cos(azimuth) * math.cos(elevation)]
    )
    right = np.cross(forward, (0.0, 1.0, 0.0))
    right /= np.linalg.norm(right)
    return right, np.cross(right, forward), forward


def padded_bounds(scene: Scene) -> np.ndarray:
    """The scene's box (2, 3), widened where it is a point or too small for its distance from the origin."""
    bounds: np.ndarray = np.asarray(scene.bounds, dtype=np.float64).reshape(2, 3)
    size = float(np.ptp(bounds, axis=0).max())
    distance = float(np.abs(bounds).max())
    smallest = distance * SMALLEST_RELATIVE_SIZE if distance > 0 else 1.0
    if size >= smallest and size > 0:
        return bounds
    pad = 0.5 * (smallest - size)
    padded: np.ndarray = bounds + np.array([[-pad], [pad]])
    return padded


def is_point(bounds: np.ndarray, whole: np.ndarray) -> bool:
    """Whether a box (2, 3) is too small for a picture: beside one that holds it, or far from the origin."""
    size = float(np.ptp(bounds, axis=0).max())
    return size <= SMALLEST_RELATIVE_SIZE * max(float(np.ptp(whole, axis=0).max()), float(np.abs(bounds).max()))


def corners_of_box(bounds: np.ndarray) -> np.ndarray:
    """The eight corners (8, 3) of a box (2, 3)."""
    return np.array(list(itertools.product(*bounds.T)))


def outermost_vertices(
    scene: Scene, center: np.ndarray, axes: tuple[np.ndarray, np.ndarray, np.ndarray], aspect: float, above: float
) -> np.ndarray:
    """The vertices (K, 3) that stand out furthest: what a picture along these axes must hold to hold the scene."""
    bounds = padded_bounds(scene)
    if not np.array_equal(bounds, np.asarray(scene.bounds)):
        return corners_of_box(bounds)  # a point: its vertices have no outline
    right, up, forward = axes
    turns = np.linspace(0.0, 2 * math.pi, OUTLINE_DIRECTIONS, endpoint=False)
    tan_y = math.tan(0.5 * FOV_Y_RAD) * (1 - MARGIN)
    directions = [
        sign * axis - tangent * forward for axis, tangent in ((right, tan_y * aspect), (up, tan_y)) for sign in (1, -1)
    ]
    directions += [math.cos(t) * axis + math.sin(t) * forward for axis in (right, up) for t in turns]
    outward = np.array(directions)
    furthest = np.empty((0, 3))
    for points in world_points(scene, above):
        candidates = np.concatenate([furthest, points])
        # In order, each once; `np.unique` loads masked arrays.
        furthest = candidates[sorted(set((outward @ (candidates - center).T).argmax(axis=1).tolist()))]
    return furthest


def bounds_above(scene: Scene, above: float) -> np.ndarray:
    """The box (2, 3) of the vertices higher than this; that of all, widened where it is a point, where none is."""
    boxes = (
        [(points.min(axis=0), points.max(axis=0)) for points in world_points(scene, above)] if above > -math.inf else []
    )
    return (
        np.array([np.min([low for low, _ in boxes], axis=0), np.max([high for _, high in boxes], axis=0)])
        if boxes
        else padded_bounds(scene)
    )


def world_points(scene: Scene, above: float) -> Iterator[np.ndarray]:
    """Vertices (N, 3) of all instances that are higher than this, some at a time; where they are many, box corners."""
    meshes = [np.asarray(mesh.vertices, dtype=np.float64) for mesh in scene.meshes]
    index, transforms = np.asarray(scene.mesh_index), np.asarray(scene.transforms)
    counts = np.bincount(index, minlength=len(meshes))
    total = sum(len(vertices) * int(n) for vertices, n in zip(meshes, counts, strict=True))
    for i, vertices in enumerate(meshes):
        if total > MOST_VERTICES and counts[i] > 1:
            vertices = corners_of_box(np.array([vertices.min(axis=0), vertices.max(axis=0)]))
        placed = transforms[index == i]
        for start in range(0, len(vertices), VERTICES_AT_ONCE):
            part = vertices[start : start + VERTICES_AT_ONCE]
            together = max(1, VERTICES_AT_ONCE // len(part))
            for first in range(0, len(placed), together):
                some = placed[first : first + together]
                points = (part @ some[:, :3, :3].transpose(0, 2, 1) + some[:, None, :3, 3]).reshape(-1, 3)
                points = points[points[:, 1] > above]
                if len(points):
                    yield points


def fitting_offset(
    corners: np.ndarray, right: np.ndarray, up: np.ndarray, forward: np.ndarray, fov_y: float, aspect: float
) -> np.ndarray:
    """Where the eye stands, relative to the origin of `corners`, so that they fill the picture up to the margin.

    With eye = x right + y up - d forward, the corner (r, u, f) lies between the right and left planes when
    max(r - t f) <= x + t d and max(-r - t f) <= -x + t d; the sum bounds d. Likewise for y; the larger d is taken.
    """
    depth = corners @ forward
    distance = -math.inf
    tan_y = math.tan(0.5 * fov_y) * (1 - MARGIN)
    for axis, tangent in ((right, tan_y * aspect), (up, tan_y)):
        across = corners @ axis
        high, low = (across - tangent * depth).max(), (-across - tangent * depth).max()
        distance = max(distance, (high + low) / (2 * tangent))
    # Points in a row along the view would have the eye in the first of them.
    distance = max(distance, (depth.max() - INSIDE_DEPTH_RATIO * depth.min()) / (INSIDE_DEPTH_RATIO - 1))
    offset: np.ndarray = (
        centred(corners @ right, depth + distance) * right
        + centred(corners @ up, depth + distance) * up
        - distance * forward
    )
    return offset


def centred(across: np.ndarray, depth: np.ndarray) -> float:
    """The x that minimises max |across - x| / depth: as much room on both sides of the picture.

    The largest of these lines is convex in x, and least where a rising one meets a falling one.
    """
    total = depth[:, None] + depth
    crossings = ((across[:, None] * depth + across * depth[:, None]) / np.where(total > 0, total, 1.0)).ravel()
    # A corner in the eye's own plane has no place in the picture; it is kept out of it by the near plane.
    sizes = np.abs(across[:, None] - crossings) / np.where(depth > 0, depth, np.inf)[:, None]
    return float(crossings[sizes.max(axis=0).argmin()])


def depth_range(
    whole: np.ndarray, inner: np.ndarray, eye: np.ndarray, up: np.ndarray, forward: np.ndarray, fov_y: float
) -> tuple[float, float]:
    """Near and far depths that hold the framed points, the floor at the picture's bottom, and everything behind."""
    near = float(((inner - eye) @ forward).min())
    # The lowest ray of the picture meets the floor of the whole scene nearer than the framed points begin.
    lowest = forward - math.tan(0.5 * fov_y) * up
    floor = float(whole[:, 1].min())
    if whole is not inner and lowest[1] < 0 and eye[1] > floor:
        near = min(near, (floor - eye[1]) / lowest[1])
    far = float(((whole - eye) @ forward).max())
    # Far reaches the corners of a floor, which may be more than the ratio beyond the framed points.
    near = max(near, far / INSIDE_DEPTH_RATIO)
    return near * (1 - DEPTH_MARGIN), far * (1 + DEPTH_MARGIN)
