"""Which of two matrices takes points of the world to a map, where each could be the other with a mistake in it.

A matrix for points of view space is one of the world times the inverse view matrix, so the latter is the former times
the view matrix, and nothing in that says which is which. What does is how maps are made: one of the world is level
there, runs along the view or holds what the camera sees. In another space that happens only by chance.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .lights import light_points

if TYPE_CHECKING:
    from .._core import Camera, Scene

# Directions are told apart as far as products of single-precision matrices keep them: a few 2^-24.
SAME_DIRECTION = 1e-6
# Cells of a map along x and y, and of its depths, that are looked at. Chosen because more change no answer.
CELLS, DEPTHS = 12, 24
# How much more of one map than of the other has to be seen. Chosen because in 500 random views that was wrong in 2 % of
# the maps at the most, and in 7 % with half as much.
MORE_SEEN = 2.0


def sees_world(ours: np.ndarray, theirs: np.ndarray, camera: Camera | None, scene: Scene | None, rigid: bool) -> int:
    """1 where ours speaks for being the map of the world, -1 where theirs does, 0 where neither or both do.

    Parameters
    ----------
    ours, theirs : (K, 4, 4) float
        Two stacks of matrices in one convention, one of which is for another space than the world.
    camera : Camera or None
    scene : Scene or None
    rigid : bool
        Whether the other space is the world moved and turned. It may then see as much of the view by chance, so without
        a scene that is no evidence.
    """
    marks = marks_of(ours, camera).astype(int) - marks_of(theirs, camera)
    found = int(np.sign(marks.sum()))
    if found or camera is None or (rigid and scene is None):
        return found
    mine, other = seen_share(ours, camera, scene), seen_share(theirs, camera, scene)
    return int(mine > MORE_SEEN * other) - int(other > MORE_SEEN * mine)


def marks_of(matrices: np.ndarray, camera: Camera | None) -> np.ndarray:
    """Bools that each speak for a map of the world: far light, square, level, along the view."""
    marks = [far_light(matrices), *np.all([frame_marks(m) for m in matrices], axis=0)]
    if camera is not None:
        marks.append(all(along_view(m, camera) for m in matrices))
    return np.array(marks)


def far_light(matrices: np.ndarray) -> bool:
    """Whether the light is at infinity, as far as single precision says."""
    points = light_points(matrices)
    return bool(np.all(np.abs(points[:, 3]) <= np.finfo(np.float32).eps * np.linalg.norm(points[:, :3], axis=1)))


def frame_marks(matrix: np.ndarray) -> tuple[bool, bool]:
    """Whether the map's axes stand at right angles, as without a warp, and whether then one of x and y is level."""
    x, y, along = matrix[0, :3], matrix[1, :3], matrix[3, :3]
    if np.linalg.norm(along) > SAME_DIRECTION * np.linalg.norm(x):
        # A crop of a perspective map adds multiples of w to x and y.
        along = along / np.linalg.norm(along)
        x, y = x - (x @ along) * along, y - (y @ along) * along
    sizes = np.linalg.norm(x), np.linalg.norm(y)
    if not min(sizes) > 0.0:
        return False, False
    square = bool(abs(x @ y) <= SAME_DIRECTION * sizes[0] * sizes[1])
    return square, square and bool(min(abs(x[1]) / sizes[0], abs(y[1]) / sizes[1]) <= SAME_DIRECTION)


def along_view(matrix: np.ndarray, camera: Camera) -> bool:
    """Whether one of x and y is constant along the view direction through the eye: where warps of far lights run."""
    eye, forward = np.append(camera.eye, 1.0), np.append(camera.forward, 0.0)
    at = matrix @ eye
    for row in (0, 1):
        slope = matrix[row] * at[3] - matrix[3] * at[row]
        if abs(slope @ forward) <= SAME_DIRECTION * np.linalg.norm(slope[:3]):
            return True
    return False


def seen_share(matrices: np.ndarray, camera: Camera, scene: Scene | None) -> float:
    """The share of the maps in which there is something of the camera's frustum, and of the scene's bounds."""
    across = (np.arange(CELLS) + 0.5) / (0.5 * CELLS) - 1.0
    depth = (np.arange(DEPTHS) + 0.5) / DEPTHS
    ndc = np.stack(np.meshgrid(across, across, depth, [1.0], indexing="ij"), axis=-1).reshape(-1, 4)
    shares = []
    for m in matrices:
        points = np.linalg.solve(m, ndc.T).T
        x, y, z, w = (points @ np.asarray(camera.clip_from_world).T).T
        seen = (points[:, 3] > 0) & (w > 0) & (np.abs(x) <= w) & (np.abs(y) <= w) & (z >= 0) & (z <= w)
        if scene is not None:
            low, high = (np.asarray(corner) * points[:, 3:] for corner in scene.bounds)
            seen &= ((low <= points[:, :3]) & (points[:, :3] <= high)).all(axis=1)
        shares.append(seen.reshape(-1, DEPTHS).any(axis=1).mean())
    return float(np.mean(shares))
