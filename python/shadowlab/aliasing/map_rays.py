r"""The light's rays through the places of one map: where a texel lies in the world, and where a depth is on its ray.

light                      A place in the map is one ray of light (theory.md (0.1)). With x and y of the place given,
  \   \                    the rows x, y and w of the matrix give two planes that hold the ray; a third, the
   \   \  stored           receiver's, cuts it in one point. Clip z and w are affine along the ray, so that a depth
____\___\___ receiver      is met where a linear equation says.

The twin of what the core probes (theory.md 14); in double precision, relative to a G-buffer's origin.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from .. import _core
from .map_geometry import along_knots, rows_about, ways_to_light

if TYPE_CHECKING:
    from .._core import Partition
    from ..types import Light, Vector

# Two units in the last place of single precision near 1: of stored depths.
DEPTH_ROUNDING = 2.0 * float(np.finfo(np.float32).eps)


@dataclass(frozen=True, eq=False)
class MapRays:
    """The rays of one map. Points are relative to `origin`, places are in texels: x to the right, y down.

    Attributes
    ----------
    partition : Partition
    light : DirectionalLight, SpotLight or PointLight
    origin : (3,) float64
        World point that points are relative to.
    resolution : (int, int)
        Width and height of the map, texels.
    reach : float
        Length beyond which nothing of the scene lies, world units.
    stored : Stored
        What the map stores; the plain depth where none is given.
    measure : (2, 4) float64 or None
        What its numbers measure: of points (p, 1), the rows whose products are divided by each other. Those of z and w
        where none is given.
    """

    partition: Partition
    light: Light
    origin: Vector
    resolution: tuple[int, int]
    reach: float
    stored: _core.Stored = field(default_factory=_core.Stored)
    measure: Vector | None = None

    @cached_property
    def rows(self) -> Vector:
        """(4, 4): shadow clip from points."""
        return rows_about(self.partition, self.origin)

    def clip(self, point: Vector) -> Vector:
        """(4,): homogeneous clip coordinates of a point."""
        made: Vector = self.rows[:, :3] @ point + self.rows[:, 3]
        return made

    def ndc(self, point: Vector) -> Vector:
        """(3,): NDC of a point with clip w above 0, after what follows the matrix."""
        clip = self.clip(point)
        x, y, z = clip[:3] / clip[3]
        if self.partition.post_warp == "log":
            terms = self.partition.post_warp_terms
            y = terms["scale"] * np.log(clip[3]) + terms["offset"]
        elif self.partition.post_warp_knots is not None:
            of_x, of_y = self.partition.post_warp_knots
            x, y = along_knots(of_x, x), along_knots(of_y, y)
        return np.array([x, y, z])

    def z(self, point: Vector) -> float | None:
        """NDC depth of a point; None behind the centre of the projection."""
        clip = self.clip(point)
        return float(clip[2] / clip[3]) if clip[3] > 0 else None

    @property
    def depth_rows(self) -> Vector:
        """(2, 4): what stored depth measures, as `measure`."""
        return self.rows[2:] if self.measure is None else self.measure

    def depth(self, point: Vector) -> float | None:
        """The depth that the map stores of a point, before it is rounded; None behind the centre of the projection."""
        of, by = self.depth_rows[:, :3] @ point + self.depth_rows[:, 3]
        return float(of / by) if self.clip(point)[3] > 0 else None

    def place(self, point: Vector) -> Vector:
        """(2,): where a point lies in the map, texels."""
        x, y, _ = self.ndc(point)
        return np.array([0.5 + 0.5 * x, 0.5 - 0.5 * y]) * self.resolution

    def on_plane(self, place: Vector, point: Vector, normal: Vector) -> Vector | None:
        """(3,): where the ray of a place meets the plane through a point; None where the plane is seen edge on."""
        width, height = self.resolution
        x, y = 2.0 * place[0] / width - 1.0, 1.0 - 2.0 * place[1] / height
        row_x, row_y, _, row_w = self.rows
        if self.partition.post_warp_knots is not None:
            of_x, of_y = self.partition.post_warp_knots
            x, y = along_knots(of_x[:, ::-1], x), along_knots(of_y[:, ::-1], y)
        across, along = row_x - x * row_w, row_y - y * row_w
        if self.partition.post_warp == "log":
            terms = self.partition.post_warp_terms
            along = row_w.copy()
            along[3] -= np.exp((y - terms["offset"]) / terms["scale"])
        try:
            found: Vector = np.linalg.solve(
                np.stack([across[:3], along[:3], normal]), [-across[3], -along[3], normal @ point]
            )
        except np.linalg.LinAlgError:
            return None
        return found if np.isfinite(found).all() else None

    def to_light(self, point: Vector) -> Vector:
        """(3,): the unit vector from a point to the light; zero at the light."""
        return ways_to_light(self.light, point + self.origin)

    def height(self, point: Vector, depth: float) -> float:
        """How far from a point towards the light stored depth has a value, world units; 0 where it never changes."""
        return self._height(self.depth_rows, point, depth)

    def _height(self, rows: Vector, point: Vector, depth: float) -> float:
        (of, by), (of_way, by_way) = rows[:, :3] @ point + rows[:, 3], rows[:, :3] @ self.to_light(point)
        below = of_way - depth * by_way
        return float((depth * by - of) / below) if below != 0 else 0.0

    def same_depth(self, point: Vector) -> float:
        """How far along its ray from a point rasterisers may give the same depth in single precision, world units."""
        z = self.z(point)
        moved = 0.0 if z is None else abs(self._height(self.rows[2:], point, z - DEPTH_ROUNDING))
        return moved + DEPTH_ROUNDING * float(np.linalg.norm(point))

    def start(self, point: Vector) -> float:
        """How far from a point towards the light its ray begins: at the near plane, or before everything."""
        near = self._height(self.rows[2:], point, 0.0)
        placed = float(np.asarray(self.light.point)[3]) != 0
        way = np.asarray(self.light.point, np.float64)[:3] - (point + self.origin)
        whole = float(np.linalg.norm(way)) if placed else self.reach + float(np.linalg.norm(point))
        return min(near, whole) if near > 0 else whole

    def texel_sides(self, point: Vector, part: float = 1.0) -> tuple[float, float]:
        """Lengths of one texel along the map's x and y at a point, across its ray, world units; 0 of a singular map.

        A small `part` of one gives them as the derivative at the point does.
        """
        place, across = self.place(point), self.to_light(point)
        ends = [self.on_plane(place + step, point, across) for step in part * np.eye(2)]
        x, y = (0.0 if end is None else float(np.linalg.norm(end - point)) / part for end in ends)
        return x, y
