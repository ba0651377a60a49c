"""Texels across the light's beam, at their depth in the image: the m_s and m_t that papers tabulate.

Source: theory.md E.1 and E.2; Lloyd, Tuft, Yoon, Manocha 2006 [lloyd2006] (m_s, m_t, storage factor). Closed forms
speak of lengths across the light's ray, over the height of the view at the receiver's depth. That is how long texels
are in the image on the view's axis, on surfaces whose slope adds nothing; off the axis a perspective picture stretches
lengths towards its corners, by 1 / cos of the angle at most: `Footprint` counts that, no formula for a map does.

```
   s ^     /------/      a texel across the ray; a warp shears the sides of constant t
     |    /      /|      along: its slanted side     height: between the sides of constant s
     +-->/------/ |      across: a side of constant s
        t      height
```
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..text.arrays import checked_array
from ..travel import Value
from .footprint import as_maps, footprint_at, halfway_normals, sides_of

if TYPE_CHECKING:
    import numpy.typing as npt

    from .._core import Camera
    from ..types import Floats, Light, Maps, Size


@dataclass(frozen=True, eq=False, repr=False)
class BeamTexels(Value):
    """Texels across the light's beam at points, in pixels at their depth; arrays (N,), NaN where no map holds a point.

    Attributes
    ----------
    along : (N,) float64
        Length of one texel along the map's y, the axis of warps, with the shear that a warp adds off its axis.
    across : (N,) float64
        Length of one texel along the map's x: m_t.
    height : (N,) float64
        Between the sides of constant y: m_s. Area over `across`, and at most `along`.
    depth : (N,) float64
        Along the view, world units.
    map : (N,) int16
        As `Footprint.map`.
    maps : int
        How many maps there are.
    used : float
        Share of a map's sides that receivers may fill, what its border leaves: of two that differ the geometric mean.
    texels_per_pixels : float
        Texels of that share of one map, over pixels of the image.
    """

    along: NDArray[np.float64]
    across: NDArray[np.float64]
    height: NDArray[np.float64]
    depth: NDArray[np.float64]
    map: NDArray[np.int16]
    maps: int
    used: float
    texels_per_pixels: float

    @property
    def storage_factor(self) -> float:
        """Texels per pixel with which no texel is larger than a pixel: max m_s times max m_t, summed over the maps.

        The published one, without shear, and without borders: of the points given, such as those of `outline`. A map
        that holds none of them counts nothing.
        """
        return self._storage(self.height)

    @property
    def storage_factor_sheared(self) -> float:
        """The same of `along`: what it is where sheared texels count with their slanted sides."""
        return self._storage(self.along)

    def _storage(self, lengths: NDArray[np.float64]) -> float:
        of_map = [self.map == k for k in range(self.maps)]
        worst = [lengths[inside].max() * self.across[inside].max() for inside in of_map if inside.any()]
        return float(sum(worst) * self.texels_per_pixels)

    def __repr__(self) -> str:
        held = int(np.count_nonzero(self.map >= 0))
        if held == 0:
            return f"BeamTexels({self.map.size} points, none in a map)"
        return (
            f"BeamTexels({self.map.size} points, {held} in maps: m_s up to {np.nanmax(self.height):.4g} px, m_t up to "
            f"{np.nanmax(self.across):.4g} px, storage factor {self.storage_factor:.4g})"
        )


def beam_texels(
    points: npt.ArrayLike,
    camera: Camera,
    light: Light,
    parameterization: Maps,
    *,
    size: Size,
    resolution: Size | None = None,
) -> BeamTexels:
    """The size of texels across the light's beam at points, in pixels at their depth.

    Parameters
    ----------
    points : (N, 3) array_like
        World positions.
    camera, light, parameterization, size, resolution
        As in `footprint_at`; a pixel is as wide as it is high.

    Returns
    -------
    BeamTexels

    Raises
    ------
    ArgumentError
        As `footprint_at` and `halfway_normals`.

    Examples
    --------
    >>> import numpy as np, shadowlab as sl
    >>> camera = sl.Camera.look_at((0, 0, 0), (0, 0, -1), fov_y=np.radians(60), aspect=1.0, near=1, far=100)
    >>> light = sl.DirectionalLight((0, -1, 0))
    >>> body = sl.aliasing.frustum_scene(camera)
    >>> p = sl.technique("lispsm", near="basic").parameterize(body, camera, light, resolution=512)
    >>> found = sl.aliasing.beam_texels(sl.aliasing.outline(camera), camera, light, p, size=512)
    >>> round(found.storage_factor, 1)
    85.7
    """
    normals = halfway_normals(points, camera, light)
    points = checked_array("points", points)
    e = footprint_at(points, normals, camera, light, parameterization, size=size, resolution=resolution)
    held = e.map >= 0
    found = np.full((3, len(points)), np.nan)
    beam = _beam_from_texel(points[held], normals[held], e.jacobian[held], camera, light, e.size)
    along, across = (np.linalg.norm(beam[:, :, i], axis=1) for i in (1, 0))
    found[:, held] = along, across, np.abs(np.linalg.det(beam)) / across
    # The border is a share of the side for which the matrix was made, whatever the resolution asked for.
    p, texels = as_maps(parameterization, resolution)
    used = math.sqrt(math.prod(1 - 2 * p.border_texels / side for side in sides_of("resolution", p.resolution)))
    return BeamTexels(
        along=found[0],
        across=found[1],
        height=found[2],
        depth=np.asarray(e.depth, np.float64),
        map=e.map,
        maps=e.maps,
        used=used,
        texels_per_pixels=texels[0] * texels[1] * used**2 / (e.size[0] * e.size[1]),
    )


def _beam_from_texel(
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    pixels_from_texel: Floats,
    camera: Camera,
    light: Light,
    size: tuple[int, int],
) -> NDArray[np.float64]:
    """What one texel along the map's x and y is across the ray (N, 2, 2), in pixels at the points' depth."""
    light_point = np.asarray(light.point)
    ray = light_point[3] * points - light_point[:3]
    ray = ray / np.linalg.norm(ray, axis=1, keepdims=True)
    basis = _across(ray)
    # Along the ray onto the surface: T' = T - d (N·T) / (N·d).
    reach = np.einsum("ni,nji->nj", normals, basis) / np.einsum("ni,ni->n", normals, ray)[:, None]
    on_surface = basis - reach[:, :, None] * ray[:, None, :]
    # (E.5): C T' takes the beam to pixels and J texels to pixels, so that (C T')⁻¹ J takes texels to the beam.
    pixels_from_beam = np.einsum("nki,nji->nkj", _pixels_from_world(points, camera, size), on_surface)
    pixels = size[1] / (camera.height * _w(points, camera))
    found: NDArray[np.float64] = np.linalg.solve(pixels_from_beam, pixels_from_texel) * pixels[:, None, None]
    return found


def _across(ray: NDArray[np.float64]) -> NDArray[np.float64]:
    """Two orthonormal vectors (N, 2, 3) across each unit ray (N, 3)."""
    # Crossed with the axis that the ray is farthest from, so that no product is short.
    axis = np.eye(3)[np.abs(ray).argmin(axis=1)]
    first = np.cross(ray, axis)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(ray, first)], axis=1)


def _pixels_from_world(points: NDArray[np.float64], camera: Camera, size: tuple[int, int]) -> NDArray[np.float64]:
    """What a step in the world does to pixel x (right) and y (down), (N, 2, 3)."""
    seen = points - np.asarray(camera.eye)
    w = _w(points, camera)[:, None]
    rows = []
    for axis, pixels, whole in (
        (np.asarray(camera.right), size[0], camera.height * camera.aspect),
        (-np.asarray(camera.up), size[1], camera.height),
    ):
        # Places in the picture of parallel rays do not move with depth.
        place = 0.0 if camera.is_orthographic else (seen @ axis)[:, None] / w
        rows.append((axis - place * np.asarray(camera.forward)) * pixels / (whole * w))
    return np.stack(rows, axis=1)


def _w(points: NDArray[np.float64], camera: Camera) -> NDArray[np.float64]:
    """What places across the view are divided by (N,): the depth, or 1 for parallel rays."""
    return np.ones(len(points)) if camera.is_orthographic else (points - np.asarray(camera.eye)) @ camera.forward
