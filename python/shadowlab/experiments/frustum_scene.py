"""The case that papers compute with: a view whose whole frustum is full of receivers.

Source: Wimmer, Scherzer, Purgathofer 2004 [wimmer2004], section 4; Lloyd, Tuft, Yoon, Manocha 2006 [lloyd2006]. No real
scene is so, but no map can have smaller largest errors in one than in this, and closed forms exist for it.

```
    +----------------------------------+
    |                     _ - |        |    a box so large that the frustum lies in its middle: what the view and the
    |            e  _ - -     |        |    scene have in common is the frustum, all eight corners of it
    |               - _ _     |        |
    |                     - _ |        |    `aliasing.outline` has its corners, and points on the edges between
    +----------------------------------+
```
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ..aliasing.frustum_body import corners_at
from ..errors import ArgumentError
from ..scene.scenes import Scene
from ..text.checks import check_camera

if TYPE_CHECKING:
    from .._core import Camera

# The box's half side over the distance from the eye to the frustum's farthest corner. Chosen because planes of the box
# then touch the frustum nowhere, whatever the view direction.
ROOM = 2.0
# Of the unit cube, outward.
QUADS = ((0, 2, 6, 4), (1, 5, 7, 3), (0, 4, 5, 1), (2, 3, 7, 6), (0, 1, 3, 2), (4, 6, 7, 5))


def frustum_scene(camera: Camera) -> Scene:
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
        For something else than a camera, and for one without a far plane.

    Examples
    --------
    >>> import shadowlab as sl
    >>> camera = sl.Camera.look_at((0, 2, 9), (0, 0, 0), near=1, far=100)
    >>> body = sl.aliasing.frustum_scene(camera)
    >>> p = sl.technique("lispsm").by_body().parameterize(body, camera, sl.DirectionalLight((0, -1, 0)))
    >>> len(p.partitions), p.notes
    (1, ())
    """
    check_camera(camera)
    if math.isinf(camera.far):
        raise ArgumentError("camera: expected a far plane, got one at infinity; camera.replace(far=...) moves it")
    corners = np.concatenate([corners_at(camera, depth) for depth in (camera.near, camera.far)])
    reach = float(np.linalg.norm(corners - camera.eye, axis=1).max())
    signs = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    faces = [face for a, b, c, d in QUADS for face in ([a, b, c], [a, c, d])]
    return Scene.from_arrays(np.asarray(camera.eye) + ROOM * reach * signs, faces)
