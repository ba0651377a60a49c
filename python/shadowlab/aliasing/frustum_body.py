"""The case that papers compute with: a view whose whole frustum is full of receivers.

Source: Wimmer, Scherzer, Purgathofer 2004 [wimmer2004], section 4; Lloyd, Tuft, Yoon, Manocha 2006 [lloyd2006]. No real
scene is so, but no map can have smaller largest errors in one than in this, and closed forms exist for it.

```
    +----------------------------------+
    |                     _ - |        |    a box so large that the frustum lies in its middle: what the view and the
    |            e  _ - -     |        |    scene have in common is the frustum, all eight corners of it
    |               - _ _     |        |
    |                     - _ |        |    .outline: corners, and points on the edges between
    +----------------------------------+
```
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..errors import ArgumentError
from ..experiments.arguments import whole
from ..scene.scenes import Scene
from ..text import shown

# The box's half side over the distance from the eye to the frustum's farthest corner. Chosen because planes of the box
# then touch the frustum nowhere, whatever the view direction.
ROOM = 2.0
# Chosen so that the points fit in memory.
MOST_STEPS = 1_000_000
# Of the unit cube, outward.
QUADS = ((0, 2, 6, 4), (1, 5, 7, 3), (0, 4, 5, 1), (2, 3, 7, 6), (0, 1, 3, 2), (4, 6, 7, 5))


def frustum_scene(camera: Any) -> Scene:
    """A scene in which the whole frustum of a camera is the body of receivers: a box around it, far larger.

    Parameters
    ----------
    camera : Camera

    Returns
    -------
    Scene
        12 triangles, for `Technique.parameterize`. Its pictures show nothing: all surfaces are beyond the far plane.

    Raises
    ------
    ArgumentError
        For something else than a camera.

    Examples
    --------
    >>> import shadowlab as sl
    >>> camera = sl.Camera.look_at((0, 2, 9), (0, 0, 0), near=1, far=100)
    >>> body = sl.aliasing.frustum_scene(camera)
    >>> p = sl.technique("lispsm").parameterize(body, camera, sl.DirectionalLight((0, -1, 0)))
    >>> len(p.partitions), p.notes
    (1, [])
    """
    _check_camera(camera)
    reach = float(np.linalg.norm(_corners(camera, camera.far) - camera.eye, axis=1).max())
    signs = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    faces = [face for a, b, c, d in QUADS for face in ([a, b, c], [a, c, d])]
    return Scene.from_arrays(np.asarray(camera.eye) + ROOM * reach * signs, faces)


def outline(
    camera: Any, *, near: float | None = None, far: float | None = None, steps: int = 16
) -> NDArray[np.float64]:
    """The corners of a camera's frustum, and points along its edges.

    Errors of maps that rise or fall with depth are largest there.

    Parameters
    ----------
    camera : Camera
    near, far : float, optional
        Ends of the part of the frustum that is meant, such as a depth split, world units; the camera's where none are
        given. Of a split, `near * (1 + 1e-9)` and `far * (1 - 1e-9)` stay within it whatever rounding does.
    steps : int
        Points of each edge, less one: even in the logarithm of depth along the view, even in length across it.

    Returns
    -------
    (12 steps - 4, 3) ndarray
        World positions.

    Raises
    ------
    ArgumentError
        For depths that do not rise, and less than one step.

    Examples
    --------
    >>> import shadowlab as sl
    >>> sl.aliasing.outline(sl.Camera.look_at((0, 0, 0), (0, 0, -1), near=1, far=100), steps=1).shape
    (8, 3)
    """
    _check_camera(camera)
    steps = whole("steps", steps)
    if steps > MOST_STEPS:
        raise ArgumentError(f"steps: expected at most {MOST_STEPS:,}, got {steps:,}; 16 are a good start")
    near, far = (float(camera.near) if near is None else near), (float(camera.far) if far is None else far)
    if not 0 < near < far < np.inf:
        raise ArgumentError(f"near, far: expected 0 < near < far, got {shown((near, far))}; leave both out for all")
    ends = [_corners(camera, depth) for depth in (near, far)]
    within = near * (far / near) ** (np.arange(1, steps) / steps)
    share = (np.arange(1, steps) / steps)[:, None, None]
    along = [_corners(camera, depth) for depth in within]
    across = [((1 - share) * corners + share * np.roll(corners, -1, axis=0)).reshape(-1, 3) for corners in ends]
    return np.concatenate([*ends, *along, *across])


def _corners(camera: Any, depth: float) -> NDArray[np.float64]:
    """The corners (4, 3) of a camera's picture at a depth, in turn around it."""
    height = depth * np.tan(0.5 * camera.fov_y)
    around = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * [height * camera.aspect, height]
    found: NDArray[np.float64] = (
        camera.eye + depth * np.asarray(camera.forward) + around @ np.stack([camera.right, camera.up])
    )
    return found


def _check_camera(camera: Any) -> None:
    """Raises unless it is a camera.

    Raises
    ------
    ArgumentError
        For something else.
    """
    if not isinstance(camera, _core.Camera):
        raise ArgumentError(f"camera: expected a Camera, got {shown(camera)}; sl.Camera.look_at(...) makes one")
