"""Points of the world at which two shadow matrices are held against each other."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

    from .._core import Camera, Scene

# Corners of a box by the low or high end of each axis, and its edges by the corners they join.
CORNERS = np.array(list(itertools.product((0, 1), repeat=3)))
EDGES = [(i, j) for i, j in itertools.combinations(range(8), 2) if np.abs(CORNERS[i] - CORNERS[j]).sum() == 1]

# Points that reach less far in NDC, such as the corners of a near plane close to the eye, are an affine image of each
# other under any two maps, nearly. Chosen because it is a thousand times what counts as the same, 1/256 of a texel.
LEAST_SPREAD = 0.01


def frustum_corners(camera: Camera, near: float, far: float) -> np.ndarray:
    """(8, 3) corners of the part of a camera's frustum between two depths."""
    tan_y = np.tan(0.5 * camera.fov_y)
    depth = np.array([near, far])[CORNERS[:, 2]]
    x = (2.0 * CORNERS[:, 0] - 1.0) * tan_y * camera.aspect * depth
    y = (2.0 * CORNERS[:, 1] - 1.0) * tan_y * depth
    axes = np.array([camera.right, camera.up, camera.forward])
    corners: np.ndarray = np.asarray(camera.eye) + np.column_stack([x, y, depth]) @ axes
    return corners


def box_corners(bounds: npt.ArrayLike) -> np.ndarray:
    """(8, 3) corners of a box of (2, 3) bounds."""
    low, high = np.asarray(bounds, dtype=np.float64)
    corners: np.ndarray = np.where(CORNERS == 0, low, high)
    return corners


def inward_planes(corners: np.ndarray) -> np.ndarray:
    """(6, 4) planes of a body of eight corners in the order of `CORNERS`, not negative inside."""
    middle = corners.mean(axis=0)
    planes = []
    for axis, end in itertools.product(range(3), (0, 1)):
        face = corners[CORNERS[:, axis] == end]
        normal = np.cross(face[1] - face[0], face[2] - face[0])
        normal = normal if normal @ (middle - face[0]) >= 0 else -normal
        planes.append(np.append(normal, -normal @ face[0]))
    return np.array(planes)


def common_corners(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """(N, 3) points that span what two bodies of eight corners share: each one's edges, cut by the other's planes."""
    found = []
    for corners, planes in ((first, inward_planes(second)), (second, inward_planes(first))):
        for i, j in EDGES:
            a, b = corners[i], corners[j]
            at_a, at_b = planes[:, :3] @ a + planes[:, 3], planes[:, :3] @ b + planes[:, 3]
            if np.any((at_a < 0) & (at_b < 0)):
                continue
            with np.errstate(divide="ignore", invalid="ignore"):
                cuts = at_a / (at_a - at_b)
            start = max([0.0, *cuts[at_a < 0]])
            end = min([1.0, *cuts[at_b < 0]])
            if start <= end:
                found += [a + start * (b - a), a + end * (b - a)]
    return np.array(found).reshape(-1, 3)


def volume_spread(points: np.ndarray) -> float:
    """How far points (N, 3) reach along the direction in which they reach least: 0 where they lie in one plane."""
    return float(np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[-1])


def unit_cube_corners(shadow_clip_from_world: np.ndarray) -> np.ndarray:
    """(8, 4) homogeneous world points, w not made 1, of the corners of a map's unit cube, with clip w above 0."""
    ndc = np.column_stack([2.0 * CORNERS[:, :2] - 1.0, CORNERS[:, 2], np.ones(8)])
    corners: np.ndarray = np.linalg.solve(shadow_clip_from_world, ndc.T).T
    return corners


def points_of_map(
    matrix: np.ndarray, texel: float, depths: tuple[float, float], camera: Camera | None, scene: Scene | None
) -> np.ndarray:
    """(N, 4) homogeneous world points of a map: corners of what the camera sees that lie in it, else of its unit cube.

    Parameters
    ----------
    matrix : (4, 4) float
        shadow_clip_from_world of ours.
    texel : float
        Side of a texel in NDC; corners may lie outside by this much.
    depths : (float, float)
        Camera depths that the map serves.
    camera : Camera or None
    scene : Scene or None
        What lies outside of its bounds is left away.
    """
    if camera is not None:
        near, far = max(camera.near, depths[0]), min(camera.far, depths[1])
        corners = frustum_corners(camera, near, far)
        seen = corners if scene is None else common_corners(corners, box_corners(scene.bounds))
        points = np.column_stack([seen, np.ones(len(seen))])
        clip = points @ matrix.T
        inside = (clip[:, 3] > 0) & (np.abs(clip[:, :2]) <= (1.0 + texel) * clip[:, 3:]).all(axis=1)
        if near < far and inside.sum() >= 4 and volume_spread(clip[inside, :3] / clip[inside, 3:]) >= LEAST_SPREAD:
            return np.asarray(points[inside])
    return unit_cube_corners(matrix)
