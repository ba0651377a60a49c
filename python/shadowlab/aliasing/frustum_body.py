"""The outline of a camera's frustum: where errors of maps are largest when receivers fill the view.

Source: Wimmer, Scherzer, Purgathofer 2004 [wimmer2004], section 4; Lloyd, Tuft, Yoon, Manocha 2006 [lloyd2006].

```
                          _ - |
                 e  _ - -     |    corners, and points on the edges between
                    - _ _     |
                          - _ |
```
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..errors import ArgumentError
from ..text import shown
from ..text.checked import A_CAMERA, a_length, checked, optional
from ..text.checks import whole

if TYPE_CHECKING:
    from .._core import Camera

# Chosen so that the points fit in memory.
MOST_STEPS = 1_000_000


@checked(camera=A_CAMERA, near=optional(a_length), far=optional(a_length))
def outline(
    camera: Camera, *, near: float | None = None, far: float | None = None, steps: int = 16
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
        Points of each edge, less one: even in the logarithm of depth along the view (in depth, of an orthographic
        camera), even in length across it.

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
    steps = whole("steps", steps)
    if steps > MOST_STEPS:
        raise ArgumentError(f"steps: expected at most {MOST_STEPS:,}, got {steps:,}; 16 are a good start")
    near, far = (float(camera.near) if near is None else near), (float(camera.far) if far is None else far)
    if math.isinf(far) and math.isinf(camera.far):
        raise ArgumentError("far: expected a depth of a camera without an end, got none; camera.bounded(scene) has one")
    least, first = ("", -np.inf) if camera.is_orthographic else ("0 < ", 0.0)
    if not first < near < far < np.inf:
        raise ArgumentError(f"near, far: expected {least}near < far, got {shown((near, far))}; leave both out for all")
    ends = [corners_at(camera, depth) for depth in (near, far)]
    shares = np.arange(1, steps) / steps
    within = near + (far - near) * shares if camera.is_orthographic else near * (far / near) ** shares
    share = (np.arange(1, steps) / steps)[:, None, None]
    along = [corners_at(camera, depth) for depth in within]
    across = [((1 - share) * corners + share * np.roll(corners, -1, axis=0)).reshape(-1, 3) for corners in ends]
    return np.concatenate([*ends, *along, *across])


def corners_at(camera: Camera, depth: float) -> NDArray[np.float64]:
    """The corners (4, 3) of a camera's picture at a depth, in turn around it."""
    found: NDArray[np.float64] = camera.corners(depth)[[0, 1, 3, 2]]
    return found
