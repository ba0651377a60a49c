"""The triangles that an explanation names, as points."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .._core import Scene


def triangle_corners(scene: Scene, instance: int, triangle: int) -> NDArray[np.float64] | None:
    """The corners (3, 3) of a triangle, world; None of no triangle, and of meshes that lost faces on the way.

    Rows of such a mesh's `faces` are no longer those of the face array that it was made from, which names triangles.
    """
    if instance < 0 or triangle < 0:
        return None
    mesh = scene.meshes[int(scene.mesh_index[instance])]
    if mesh.dropped_faces:
        return None
    corners = np.asarray(mesh.vertices)[np.asarray(mesh.faces)[triangle]]
    to_world = np.asarray(scene.transforms[instance])
    made: NDArray[np.float64] = corners @ to_world[:3, :3].T + to_world[:3, 3]
    return made
