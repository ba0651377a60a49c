"""Where one can stand in a scene: its floors, found by rays straight down through a grid of columns.

  |   |   |   |        a ray goes on below what it hits; the floor of a column is the lowest level surface
  v   v   v   v        that has room above it
--+---+-  |   |
  |   |   v   |
__v___v_______v__
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .. import _core

Coordinates = npt.NDArray[np.float64]

# Columns along each side of the box: the streets of a town two dozen blocks wide still have one each.
GRID_SIDE = 48
# Surfaces that a column goes through: floors, ceilings and roofs of houses, and what stands in them.
LAYERS = 12
# Least cosine between a floor and straight up: slopes up to 60 degrees, as of mountains.
LEAST_FLOOR_COSINE = 0.5
# How far below a hit a ray goes on, as a share of the box's largest extent: above the rounding of a vertex in single
# precision, below anything that one could stand under.
STEP_SHARE = 1e-5
# Free height over a floor, as a share of the scene's height: a slab or a table is none.
LEAST_ROOM_SHARE = 0.1
# Share of the columns whose highest surface shows its front to the sky, from which on fronts are taken to be outside.
# Files that orient their faces at random have about half.
TRUSTED_SHARE = 0.9


def median(values: Coordinates) -> float:
    """The median of some numbers; `np.median` loads masked arrays, which takes a quarter of the time of all numpy."""
    ordered = np.sort(values, axis=None)
    return float(0.5 * (ordered[(ordered.size - 1) // 2] + ordered[ordered.size // 2]))


class Surfaces:
    """What rays meet in a scene: how far away, and which way it faces."""

    def __init__(self, scene: _core.Scene):
        self.scene = scene
        self._meshes = scene.meshes
        self._index, self._transforms = np.asarray(scene.mesh_index), np.asarray(scene.transforms)
        self._arrays: dict[int, tuple[Coordinates, npt.NDArray[np.integer]]] = {}

    def hit(
        self, origins: Coordinates, directions: Coordinates
    ) -> tuple[Coordinates, Coordinates, npt.NDArray[np.bool_]]:
        """Distances (N,) along unit directions, infinite where nothing is; unit normals (N, 3); what was hit (N,).

        Normals stand on the front: the side from which the corners of a face run counter-clockwise. Meshes with dropped
        faces do not say which of the others was hit; of those they point to where the ray comes from.
        """
        t, triangle, instance = _core.first_hit(self.scene, origins, directions)
        met = instance >= 0
        normals = np.zeros((len(t), 3))
        rays = np.flatnonzero(met)
        meshes = self._index[instance[rays]]
        order = np.argsort(meshes, kind="stable")
        rays, corners = rays[order], np.zeros((len(rays), 3, 3))
        found, begins = np.unique(meshes[order], return_index=True)
        for mesh, begin, end in zip(found, begins, [*begins[1:], len(rays)], strict=False):
            if self._meshes[mesh].dropped_faces:
                normals[rays[begin:end]] = -directions[rays[begin:end]]
            else:
                corners[begin:end] = self._corners_of(int(mesh), triangle[rays[begin:end]])
        placed = self._transforms[instance[rays], :3, :3]
        a, b = (np.einsum("nij,nj->ni", placed, corners[:, i] - corners[:, 0]) for i in (1, 2))
        # Scaled before the product, which would underflow for tiny triangles.
        a, b = (v / np.maximum(np.abs(v).max(axis=1, keepdims=True), np.finfo(np.float64).tiny) for v in (a, b))
        normals[rays] += np.cross(a, b) * np.where(np.linalg.det(placed) < 0, -1.0, 1.0)[:, None]
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        return t, normals / np.where(length > 0, length, 1.0), met

    def _corners_of(self, mesh: int, triangles: npt.NDArray[np.integer]) -> Coordinates:
        """The corners (N, 3, 3) of some triangles of a mesh, in its own axes."""
        if mesh not in self._arrays:
            of = self._meshes[mesh]
            self._arrays[mesh] = np.asarray(of.vertices, np.float64), np.asarray(of.faces)
        vertices, faces = self._arrays[mesh]
        corners: Coordinates = vertices[faces[triangles]]
        return corners


@dataclass(frozen=True, eq=False)
class Columns:
    """The floors of a scene in a grid of columns.

    Attributes
    ----------
    x, z : (N,) float64
        Middles of the columns along both axes, world units.
    floor : (N, N) float64
        Height of the floor at [x, z], world units; the bottom of the box where there is none.
    room : (N, N) float64
        Free height over the floor; infinite under the open sky, 0 where there is no floor.
    top : (N, N) float64
        Height of the highest surface; the bottom of the box where there is none.
    known : (N, N) bool
        Where there is a floor.
    covered : (N, N) bool
        Where there is any surface.
    """

    x: Coordinates
    z: Coordinates
    floor: Coordinates
    room: Coordinates
    top: Coordinates
    known: npt.NDArray[np.bool_]
    covered: npt.NDArray[np.bool_]


def floors_of(surfaces: Surfaces, bounds: Coordinates) -> Columns:
    """The floors within a box (2, 3), which is no higher than the scene."""
    low, high = bounds
    size = float((high - low).max())
    share = (np.arange(GRID_SIDE) + 0.5) / GRID_SIDE
    x, z = (low[axis] + share * (high[axis] - low[axis]) for axis in (0, 2))
    places = np.stack(np.meshgrid(x, z, indexing="ij"), axis=-1).reshape(-1, 2)
    count = len(places)
    origins = np.column_stack([places[:, 0], np.full(count, high[1] + size), places[:, 1]])
    heights, upward = np.full((LAYERS, count), -np.inf), np.zeros((LAYERS, count))
    going = np.arange(count)
    for layer in range(LAYERS):
        t, normals, met = surfaces.hit(origins[going], np.tile([0.0, -1.0, 0.0], (len(going), 1)))
        going = going[met]
        if not len(going):
            break
        heights[layer, going] = origins[going, 1] - t[met]
        upward[layer, going] = normals[met, 1]
        origins[going, 1] = heights[layer, going] - STEP_SHARE * size
    hit = heights > -np.inf
    fronts = (upward[0][hit[0]] > 0).mean() if hit[0].any() else 0.0
    level = upward >= LEAST_FLOOR_COSINE if fronts >= TRUSTED_SHARE else np.abs(upward) >= LEAST_FLOOR_COSINE
    above = np.vstack([np.full(count, np.inf), heights[:-1]])
    room = np.where(hit, above - np.where(hit, heights, 0.0), 0.0)
    standing = hit & level & (room >= LEAST_ROOM_SHARE * float(high[1] - low[1]))
    known = standing.any(axis=0)
    lowest = (LAYERS - 1 - standing[::-1].argmax(axis=0), np.arange(count))
    floor, free = np.where(known, heights[lowest], low[1]), np.where(known, room[lowest], 0.0)
    top, grid = np.where(hit[0], heights[0], low[1]), (GRID_SIDE, GRID_SIDE)
    return Columns(
        x, z, floor.reshape(grid), free.reshape(grid), top.reshape(grid), known.reshape(grid), hit[0].reshape(grid)
    )
