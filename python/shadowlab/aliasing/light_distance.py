r"""Distances along the light: of what a map's texels store, and of receivers and their planes.

Source: theory.md (19.6). NDC depth is hyperbolic under warps and placed lights, and a logarithm or a rectilinear warp
bends the map. Each texel's ray and depth give one point of the world, exactly, and its distance is linear: along the
direction of a directional light, from a placed light to the point.

All in double precision, relative to a G-buffer's origin.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from .. import _core
from ..types import Floats, Vector
from .map_geometry import along_knots, rows_about, slopes_along_knots, ways_to_light

if TYPE_CHECKING:
    from ..types import Light


@dataclass(frozen=True, eq=False)
class LightDistance:
    """Distances along the light in one map.

    Attributes
    ----------
    partition : Partition
    light : DirectionalLight, SpotLight or PointLight
    origin : (3,) float64
        World point that points are relative to.
    resolution : (int, int)
        Width and height of the map, texels.
    """

    partition: _core.Partition
    light: Light
    origin: Vector
    resolution: tuple[int, int]

    @cached_property
    def rows(self) -> Vector:
        """(4, 4): shadow clip from points."""
        return rows_about(self.partition, self.origin)

    def of_points(self, points: Vector) -> Vector:
        """(...,): distances of points (..., 3), world units."""
        if isinstance(self.light, _core.DirectionalLight):
            along: Vector = points @ np.asarray(self.light.direction, np.float64)
            return along
        away: Vector = np.linalg.norm(points - self._lamp, axis=-1)
        return away

    def directions(self, points: Vector) -> Vector:
        """(N, 3): the way that light travels at points (N, 3), of length 1; zero at the light."""
        return -ways_to_light(self.light, points + self.origin)

    def of_texels(self, depths: Floats, first_row: int) -> Vector:
        """(R, W): distances of stored NDC depths (R, W) in rows of the map from one on; infinite where nothing is.

        NDC depths are those of a drawn map: below 1 where a caster is.
        """
        width, height = self.resolution
        x = (2.0 * np.arange(width) + 1.0) / width - 1.0
        y = 1.0 - (2.0 * (first_row + np.arange(len(depths))) + 1.0) / height
        knots = self.partition.post_warp_knots
        if knots is not None:
            x, y = (along_knots(pair[:, ::-1], v) for pair, v in zip(knots, (x, y), strict=True))
        # Empty texels are taken at the near plane, which is finite, and hold nothing.
        is_held = depths < 1.0
        points = self._points(x[None, :], y[:, None], np.where(is_held, depths, 0.0).astype(np.float64))
        found: Vector = np.where(is_held, self.of_points(points), np.inf)
        return found

    def _points(self, x: Vector, y: Vector, z: Vector) -> Vector:
        """Points (R, W, 3) at NDC x (1, W), y (R, 1) and z (R, W); y is after a logarithm."""
        if self.partition.post_warp == "log":
            # y gives w, and three linear equations the point.
            terms = self.partition.post_warp_terms
            w = np.exp((y - terms["offset"]) / terms["scale"])
            rows = self.rows[[0, 2, 3]]
            clip = np.stack(np.broadcast_arrays(x * w, z * w, w), axis=-1)
            found: Vector = (clip - rows[:, 3]) @ np.linalg.inv(rows[:, :3]).T
            return found
        inverse = np.linalg.inv(self.rows)
        ndc = np.stack(np.broadcast_arrays(x, y, z, 1.0), axis=-1)
        homogeneous = ndc @ inverse.T
        points: Vector = homogeneous[..., :3] / homogeneous[..., 3:]
        return points

    def texel_steps(self, points: Vector, normals: Vector) -> Vector:
        """(N, 2, 3): how far points (N, 3) move on planes with normals (N, 3) by a texel to the right and a texel down.

        Zero where the light sees a plane edge on.
        """
        rows, (width, height) = self.rows.copy(), self.resolution
        if self.partition.post_warp == "log":
            rows[1] = 0.0, 0.0, 0.0, 1.0  # t = 1 / w in place of y
        clip = points @ rows[:, :3].T + rows[:, 3]
        w = clip[:, 3:]
        x, t = (clip[:, :2] / w).T
        grad_x, grad_t = ((rows[i, :3] - value[:, None] * rows[3, :3]) / w for i, value in ((0, x), (1, t)))
        across, along = np.full_like(x, 2.0 / width), np.full_like(t, -2.0 / height)
        if self.partition.post_warp == "log":
            along = -along * t / self.partition.post_warp_terms["scale"]  # y = -scale ln t + offset
        elif (knots := self.partition.post_warp_knots) is not None:
            across, along = across / slopes_along_knots(knots[0], x), along / slopes_along_knots(knots[1], t)
        # A step u has grad_x . u = across, grad_t . u = 0, n . u = 0, and the other way round.
        volume = np.einsum("ij,ij->i", np.cross(grad_x, grad_t), normals)
        steps = np.stack(
            [np.cross(grad_t, normals) * across[:, None], np.cross(normals, grad_x) * along[:, None]], axis=1
        )
        seen = (volume != 0.0)[:, None, None]
        found: Vector = np.divide(steps, volume[:, None, None], out=np.zeros_like(steps), where=seen)
        return found

    @cached_property
    def _lamp(self) -> Vector:
        """(3,): the position of a placed light, relative to the origin."""
        return np.asarray(self.light.point, np.float64)[:3] - self.origin
