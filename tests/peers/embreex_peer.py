"""First hits and occlusion by Embree through embreex: single precision, made comparable.

embreex takes float32 rays and vertices. Vertices are moved so that the scene's middle is the origin, and rays are
*rounded* to what embreex will trace: ask :meth:`EmbreexScene.rounded` for them and give another tracer exactly these,
so that the difference between two answers is arithmetic inside the tracers and nothing else.

embreex runs on the calling thread alone, one ray at a time. Its OCCLUDED query says 0 for blocked and -1 for free.
"""

from __future__ import annotations

import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh


class EmbreexScene:
    """World triangles in Embree."""

    def __init__(self, vertices, faces, robust: bool = True):
        vertices = np.asarray(vertices, np.float64)
        self.origin = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
        # Robust mode keeps rays from slipping between triangles that share an edge, as ours does.
        self._scene = rtcore_scene.EmbreeScene(robust=robust)
        self.vertices_local = (vertices - self.origin).astype(np.float32)
        self.faces = np.ascontiguousarray(faces, np.int32)
        TriangleMesh(self._scene, self.vertices_local, self.faces)

    def rounded(self, origins, directions) -> tuple[np.ndarray, np.ndarray]:
        """(N, 3) float32 origins relative to the middle and directions: the rays that are traced."""
        local = (np.asarray(origins, np.float64) - self.origin).astype(np.float32)
        return np.ascontiguousarray(local), np.ascontiguousarray(directions, np.float32)

    def first_hit(self, origins_local: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(N,) float32 distance in lengths of the direction and (N,) int32 triangle; infinite and -1 for none."""
        hit = self._scene.run(origins_local, directions, output=1)
        t = np.where(hit["primID"] < 0, np.float32(np.inf), hit["tfar"])
        return t, hit["primID"]

    def triangle(self, origins_local: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """(N,) int32 triangle of the first hit, -1 for none: the least that embreex can be asked for."""
        return self._scene.run(origins_local, directions)

    def occluded(self, origins_local: np.ndarray, directions: np.ndarray, t_max: np.ndarray) -> np.ndarray:
        """(N,) bool: something lies between 0 and t_max lengths of the direction (float32)."""
        reach = np.minimum(np.asarray(t_max, np.float64), 1e37).astype(np.float32)
        return self._scene.run(origins_local, directions, dists=reach, query="OCCLUDED") == 0
