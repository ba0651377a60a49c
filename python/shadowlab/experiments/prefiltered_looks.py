"""One drawn map of a view, stored in prefiltered formats and looked up in each, and in depths by comparisons.

```
    maps (K, H, W), NDC depth
      |  LightDistance       distances along the light, 0 to 1 over the range of each map
      |  stored, blurred     what a texel holds, rounded twice
      v  read_between, light at each pixel, the receiver moved towards the light by its bias
    mask of the format       beside it the mask of comparisons over the same kernel
```
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..aliasing.box_kernel import bands, blurred, compared, read_between
from ..aliasing.light_distance import LightDistance
from ..aliasing.pixel_held import SNAP_TEXELS
from ..scene.view import light_of

if TYPE_CHECKING:
    from ..aliasing.prefiltered_formats import PrefilteredFormat
    from ..scene.view import View
    from ..types import Mask, RendererLike, Vector

# As of `Bias`: the part in texels, the limit of what the slope adds in texels along the ray, and the rounding of depths
# in single precision as a share of the range.
BIAS_TEXELS, SLOPE_LIMIT, BIAS_DEPTH = 0.1, 16.0, 1e-6
# Of comparisons over the kernel: the part of the way to the receiver's plane at the texel, a share of what that plane
# gains over the kernel's reach, and the part in texels. Chosen on ten scenes at 512² and 1024² among 14 triples: 13,369
# wrong pixels. The whole plane alone leaves 18,747, for curved surfaces turn dark, and the whole reach alone 17,595.
PCF_PLANE, PCF_SLOPE, PCF_TEXELS = 0.75, 0.25, 0.5


@dataclass(frozen=True, eq=False)
class _Receivers:
    """The pixels that look up one map: all arrays have a row per pixel.

    Attributes
    ----------
    pixels : (N, 2) int64
        Rows and columns.
    places : (N, 2) float64
        Texels, x to the right and y down.
    depth : (N,) float64
        Distances along the light, 0 to 1, moved towards the light by the bias that all formats have.
    side : (N,) float64
        The longer side of a texel across the light, in the unit of depths.
    gradients : (N, 2) float64
        What the depth of the receiver's plane gains by a texel to the right and by a texel down.
    stored : (H, W) float64
        The map: depths 0 to 1, and 1 where no caster is.
    """

    pixels: NDArray[np.int64]
    places: Vector
    depth: Vector
    side: Vector
    gradients: Vector
    stored: Vector


class PrefilteredLooks:
    """The maps of one resolution and what each format makes of them.

    Parameters
    ----------
    view : View
        With one light.
    parameterization : Parameterization
    resolution : int
    renderer : Renderer
    kernel : int
        Side of the box, texels, odd.
    """

    def __init__(
        self, view: View, parameterization: _core.Parameterization, resolution: int, renderer: RendererLike, kernel: int
    ):
        self._view, self._kernel = view, kernel
        self._parameterization, self._resolution = parameterization, resolution
        self._gbuffer, self._light = view.gbuffer(renderer), light_of(view)
        self._maps = renderer.shadow_map(view.scene, parameterization, resolution=resolution)

    @cached_property
    def nearest(self) -> Mask:
        """(H, W): one comparison with the default bias, as `Renderer.shadow_mask`."""
        return self._nearest[0]

    @cached_property
    def pcf(self) -> Mask:
        """(H, W): the weighted share of the kernel's texels that are not before the receiver's plane."""
        found = self._unfiltered()
        for of in self._receivers:
            # The farthest centre that the kernel reads is half of its n + 1 texels away, along each axis.
            reach = 0.5 * (self._kernel + 1) * np.abs(of.gradients).sum(axis=1)
            depth = of.depth - (PCF_TEXELS - BIAS_TEXELS) * of.side - PCF_SLOPE * reach
            light = np.empty(len(depth))
            for part in bands(len(light), 1):
                slopes = PCF_PLANE * of.gradients[part]
                light[part] = compared(of.stored, of.places[part], depth[part], slopes, self._kernel)
            _put(found, of, light)
        return found

    @property
    def covered(self) -> NDArray[np.bool_]:
        """(H, W): where no comparison of the kernel lets light through, so that light of a format is a leak."""
        found: NDArray[np.bool_] = (self.pcf == 0.0) & (self._nearest[1] >= 0)
        return found

    def mask(self, format: PrefilteredFormat, reduction: float) -> Mask:
        """(H, W): the light that a prefiltered format lets through; as `Renderer.shadow_mask` elsewhere."""
        found = self._unfiltered()
        for of in self._receivers:
            height, width = of.stored.shape
            texels = None
            for rows in bands(height, width):
                made = format.stored(of.stored[rows])
                if texels is None:
                    texels = np.empty((height, width, made.shape[-1]), made.dtype)
                texels[rows] = made
            assert texels is not None, "a map has rows"
            texels = blurred(texels, format, self._kernel)
            light = np.empty(len(of.depth))
            for part in bands(len(light), 1):
                averages = read_between(texels, format, of.places[part])
                light[part] = format.light(averages, of.depth[part], reduction)
            _put(found, of, light)
        return found

    def _unfiltered(self) -> Mask:
        """The pixels that look up no map: background, what faces away, and what no map holds."""
        mask, chosen = self._nearest
        return np.where(chosen >= 0, np.float32(0.0), mask)

    @cached_property
    def _nearest(self) -> tuple[Mask, NDArray[np.int16]]:
        return _core.look_up(self._maps, self._gbuffer, self._view.camera, self._light, self._parameterization)

    @cached_property
    def _receivers(self) -> list[_Receivers]:
        """The pixels of each map that is looked up at all."""
        looks = (self._gbuffer, self._view.camera, self._light, self._parameterization)
        places, chosen = _core.texel_coordinates(*looks, resolution=self._resolution)
        maps = self._maps.reshape(-1, *self._maps.shape[-2:])
        found = []
        for k, partition in enumerate(self._parameterization.partitions):
            pixels = np.argwhere((chosen == k) & (self._nearest[1] == k))
            if len(pixels):
                along = LightDistance(partition, self._light, self._gbuffer.origin, maps.shape[:0:-1])
                found.append(self._of_map(along, maps[k], pixels, places[tuple(pixels.T)]))
        return found

    def _of_map(
        self, along: LightDistance, depths: NDArray[np.float32], pixels: NDArray[np.int64], places: Vector
    ) -> _Receivers:
        stored, near, far = np.empty(depths.shape), np.inf, -np.inf
        for rows in bands(*depths.shape):
            stored[rows] = along.of_texels(depths[rows], rows.start)
            held = stored[rows][np.isfinite(stored[rows])]
            near, far = float(held.min(initial=near)), float(held.max(initial=far))
        distance, side, gradients = np.empty(len(pixels)), np.empty(len(pixels)), np.empty((len(pixels), 2))
        for part in bands(len(pixels), 1):
            at = tuple(pixels[part].T)
            points = self._gbuffer.position_relative[at].astype(np.float64)
            normals = self._gbuffer.normal[at].astype(np.float64)
            distance[part], ways = along.of_points(points), along.directions(points)
            # Sizes of a texel across the light, and what the receiver's plane gains over it, along the light.
            sides = np.linalg.norm(along.texel_steps(points, ways), axis=2)
            gains = np.einsum("nij,nj->ni", along.texel_steps(points, normals), ways)
            gradients[part] = np.clip(gains, -SLOPE_LIMIT * sides, SLOPE_LIMIT * sides)
            side[part] = sides.max(axis=1)
        near, far = min(near, float(distance.min())), max(far, float(distance.max()))
        whole = far - near or 1.0
        bias = BIAS_TEXELS * side + SNAP_TEXELS * np.abs(gradients).sum(axis=1) + BIAS_DEPTH * whole
        depth = (distance - near - bias) / whole
        for rows in bands(*depths.shape):
            stored[rows] = np.minimum((stored[rows] - near) / whole, 1.0)
        return _Receivers(pixels, places, depth, side / whole, gradients / whole, stored)


def _put(mask: Mask, of: _Receivers, light: Vector) -> None:
    mask[tuple(of.pixels.T)] = np.clip(light, 0.0, 1.0)
