r"""The light's view before any warp: a plane across the light, and where the texel lattice of a map lies on it.

All points of a ray of light share a place in every map, and each ray meets the plane once; so a map is a homography of
the plane, and lines of the lattice are straight on it.

    sun                          spot or point
      | | | |  rays                  x
      | | | |                       /|\  rays
    --+-+-+-+--  plane           --+-+-+--  plane at distance 1
    x, y from the eye, world     x, y tangents of the angle from the axis

y follows the view as far as the light lets it, x is to the right as the light sees it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .._core import DirectionalLight, PointLight
from ..errors import ArgumentError
from ..text.checked import (
    A_CAMERA,
    A_PARTITION,
    a_length,
    a_number,
    any_numbers,
    checked,
    finite_numbers,
    items_of,
    optional,
)
from ..text.checks import check_light
from ..travel import Value
from .frustum import frustum_edges

if TYPE_CHECKING:
    from collections.abc import Iterable

    import numpy.typing as npt

    from .._core import Camera, Partition
    from ..types import Light

# A ray counts as ahead of the projection where its w is no less than this share of the largest on the line: lines end
# this side of the horizon, at a thousand times the distance of their near end.
HORIZON = 1e-3
POINTS = any_numbers(None, 3)
PLACES = items_of(a_number, "places in the map, NDC", "give a list of numbers")
LIMITS = finite_numbers(2)
# Share of the light's range at which its own view begins; derived from what float32 depths tell apart beyond.
NEAR_SHARE = 1e-3


@dataclass(frozen=True, eq=False)
class LightPlane(Value):
    """A plane across the light with axes x, y.

    Attributes
    ----------
    from_world : (3, 4) float64
        Homogeneous x, y and w of the plane from world points; w is above 0 for what the light's rays reach ahead.
    to_world : (4, 3) float64
        World points from (x, y, 1).
    forward : (3,) float64
        Unit way of the light through the plane's middle.
    directional : bool
        Whether rays are parallel, and lengths world units; otherwise they are tangents.
    """

    from_world: NDArray[np.float64]
    to_world: NDArray[np.float64]
    forward: NDArray[np.float64]
    directional: bool

    @classmethod
    @checked(camera=A_CAMERA, partition=optional(A_PARTITION))
    def of(cls, light: Light, camera: Camera, partition: Partition | None = None) -> LightPlane:
        """The plane of a light; of a point light, the one ahead of a map's middle.

        Raises
        ------
        ArgumentError
            For something else than a light, and a point light without a map.
        """
        check_light(light)
        if isinstance(light, PointLight):
            if partition is None:
                raise ArgumentError("partition: expected the map of a point light whose middle the plane is ahead of")
            m = np.asarray(partition.matrix, np.float64)
            # The rays through x = 0 and y = 0 of the map.
            forward = np.cross(m[0, :3], m[1, :3])
            forward = forward * (np.sign(m[3, :3] @ forward) or 1.0)
        else:
            forward = np.asarray(light.direction, np.float64)
        forward = forward / np.linalg.norm(forward)
        up = _across(camera.forward, forward)
        if np.linalg.norm(up) < np.sqrt(np.finfo(np.float32).eps):
            up = _across(camera.up, forward)  # the light along the view: up in the image is up
        up = up / np.linalg.norm(up)
        right = np.cross(forward, up)
        sun = isinstance(light, DirectionalLight)
        origin = np.asarray(camera.eye if isinstance(light, DirectionalLight) else light.position, np.float64)
        rows = np.zeros((3, 4))
        rows[:, :3] = right, up, np.zeros(3) if sun else forward
        rows[:, 3] = -rows[:, :3] @ origin
        rows[2, 3] = 1.0 if sun else rows[2, 3]
        columns = np.zeros((4, 3))
        columns[:3] = np.stack([right, up, origin + (0.0 if sun else 1.0) * forward], axis=1)
        columns[3, 2] = 1.0
        return cls(rows, columns, forward, sun)

    @checked(points=POINTS)
    def project(self, points: npt.ArrayLike) -> NDArray[np.float64]:
        """Homogeneous x, y, w (N, 3) of world points (N, 3)."""
        p = np.asarray(points, np.float64)
        return p @ self.from_world[:, :3].T + self.from_world[:, 3]

    @checked(partition=A_PARTITION, xs=PLACES, ys=PLACES)
    def lattice(self, partition: Partition, xs: Iterable[float], ys: Iterable[float]) -> NDArray[np.float64]:
        """Lines of a map on the plane: (N, 2, 2) x, y of both ends, straight between.

        Parameters
        ----------
        partition : Partition
        xs, ys : sequence of float
            NDC of lines up and across the map. Each is cut where it passes behind the projection.

        Raises
        ------
        ArgumentError
            For a map that is edge on to the plane, or all at one depth under a logarithm.
        """
        segments = []
        ends = [((x, -1.0), (x, 1.0)) for x in xs] + [((-1.0, y), (1.0, y)) for y in ys]
        for a, b in ends:
            places = visible(self._back(partition, a), self._back(partition, b))
            if places is not None:
                segments.append(places)
        return np.array(segments).reshape(-1, 2, 2)

    def _back(self, partition: Partition, ndc: tuple[float, float]) -> NDArray[np.float64]:
        """Homogeneous x, y, w on the plane of a place in a map."""
        h = np.asarray(partition.matrix, np.float64)[[0, 1, 3]] @ self.to_world
        x, y = ndc
        try:
            if partition.post_warp == "log":
                # y = scale log(w) + offset says w, and x w the first row; two lines that meet in one point.
                terms = partition.post_warp_terms
                w = np.exp((y - terms["offset"]) / terms["scale"])
                place = np.linalg.solve(h[[0, 2], :2], [x * w - h[0, 2], w - h[2, 2]])
                return np.append(place, 1.0)
            if partition.post_warp_knots is not None:
                x, y = (before(knots, at) for knots, at in zip(partition.post_warp_knots, ndc, strict=True))
            back = np.asarray(np.linalg.solve(h, [x, y, 1.0]), np.float64)
        except np.linalg.LinAlgError:
            raise ArgumentError(
                "parameterization: expected a map in which each ray of the light has a place of its own, got a matrix "
                "that is singular across the light; see whether matrix and light belong together"
            ) from None
        return back

    @checked(x=LIMITS, y=LIMITS, bounds=finite_numbers(2, 3), reach=a_length)
    def clip_from_world(
        self, x: tuple[float, float], y: tuple[float, float], bounds: npt.ArrayLike, reach: float
    ) -> NDArray[np.float64]:
        """The matrix (4, 4) that renders this view between limits of x and y, depths from those of the bounds."""
        matrix = np.zeros((4, 4))
        w = self.from_world[2]
        for row, (low, high) in enumerate((x, y)):
            matrix[row] = (2.0 * self.from_world[row] - (low + high) * w) / (high - low)
        matrix[3] = w
        if self.directional:
            along = corners(bounds) @ self.forward
            slack = 1e-3 * float(np.ptp(along)) + np.finfo(np.float32).eps * float(np.abs(along).max()) or 1.0
            near, far = float(along.min()) - slack, float(along.max()) + slack
            matrix[2, :3] = self.forward / (far - near)
            matrix[2, 3] = -near / (far - near)
        else:
            near = NEAR_SHARE * reach
            matrix[2] = reach / (reach - near) * w
            matrix[2, 3] -= reach * near / (reach - near)
        return matrix

    @checked(bounds=finite_numbers(2, 3))
    def box(self, bounds: npt.ArrayLike) -> NDArray[np.float64]:
        """The edges (N, 2, 2) of a box on the plane."""
        c = corners(bounds)
        edges = [(i, i | bit) for i in range(8) for bit in (1, 2, 4) if not i & bit]
        return self.segments((c[i], c[j]) for i, j in edges)

    @checked(camera=A_CAMERA)
    def frustum(self, camera: Camera, depths: Iterable[float] | None = None) -> NDArray[np.float64]:
        """The edges (N, 2, 2) of a camera's frustum on the plane."""
        return self.segments((a[:3], b[:3]) for a, b in frustum_edges(camera, depths))

    @checked(ends=items_of(finite_numbers(2, 3), "pairs of points", "give a list of pairs"))
    def segments(self, ends: Iterable[tuple[NDArray[np.float64], NDArray[np.float64]]]) -> NDArray[np.float64]:
        """World segments on the plane (N, 2, 2), cut where they pass behind the light."""
        found = [visible(*self.project(np.stack(pair))) for pair in ends]
        return np.array([s for s in found if s is not None]).reshape(-1, 2, 2)


def before(knots: NDArray[np.float64], after: float) -> float:
    """Where the ascending function through knots (N, 2), linear between and beyond them, has a value."""
    piece = int(np.searchsorted(knots[1:-1, 1], after, side="right"))
    (x, y), (next_x, next_y) = knots[piece], knots[piece + 1]
    return float(x + (after - y) * (next_x - x) / (next_y - y))


def _across(direction: npt.ArrayLike, forward: NDArray[np.float64]) -> NDArray[np.float64]:
    """What of a direction is across the light."""
    d = np.asarray(direction, np.float64)
    return d - (d @ forward) * forward


def visible(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Places x, y (2, 2) of the ends of a homogeneous segment where w is above 0; None where it never is."""
    least = HORIZON * max(a[2], b[2])
    if not least > 0:
        return None
    ends = []
    for here, there in ((a, b), (b, a)):
        if here[2] < least:
            here = here + (least - here[2]) / (there[2] - here[2]) * (there - here)
        ends.append(here[:2] / here[2])
    return np.array(ends)


def corners(bounds: npt.ArrayLike) -> NDArray[np.float64]:
    """The corners (8, 3) of a box (2, 3); bit 0 of the index is x."""
    low, high = np.asarray(bounds, np.float64)
    return np.array([[(low, high)[i >> axis & 1][axis] for axis in range(3)] for i in range(8)])
