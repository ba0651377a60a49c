"""Bias, filters and lookups into maps of `_core`, which exports them."""

from typing import final

import numpy as np
import numpy.typing as npt

from ._core_camera import Camera, GBuffer
from ._core_maps import Maps, Parameterization
from ._core_scene import Light, Scene
from ._core_stored import StoredLike
from ._core_types import Filter, Float, RendererLike, Size, TechniqueLike, ViewLike

@final
class Bias:
    """How much nearer to the light a receiver is moved before it is compared. The parts add up.

    Parameters
    ----------
    world : float
        World units along the light ray.
    texels : float
        World size of a shadow texel at the receiver, across the light ray.
    ndc : float
        NDC depth.
    slope : float
        Times the depth that the receiver's own plane gains over the filter's reach: 1 removes all acne of a plane.
    slope_limit : float
        Upper limit of the slope part, world sizes of a shadow texel along the light ray; infinity for none. It limits the
        plane part, too.
    plane : float
        1: a texel is compared with the depth of the receiver's own plane at its centre, which is exact for planes; 0: with
        the depth of the receiver; a part of the way between.
    normal : float
        World sizes of a shadow texel by which the receiver is moved along its normal before anything else.
    factor : float
        As graphics APIs define it for their polygon offset: times the larger change of the depth of the receiver's plane by a
        texel, along x or y. The slope limit holds it, too.
    units : float
        As they define it: steps of the format of what is stored, at the receiver's depth.
    """
    def __new__(
        cls,
        *,
        world: float | None = None,
        texels: float | None = None,
        ndc: float | None = None,
        slope: float | None = None,
        slope_limit: float | None = None,
        plane: float | None = None,
        normal: float | None = None,
        factor: float | None = None,
        units: float | None = None,
    ) -> Bias: ...
    @staticmethod
    def none() -> Bias:
        """No bias at all: acne everywhere."""
    @staticmethod
    def polygon_offset(factor: float, units: float) -> Bias:
        """The polygon offset of graphics APIs: factor max(|dz/dX|, |dz/dY|) + units r is taken off the depth, and nothing else.

        X and Y are texels, z the depth that is stored, and r is a step of its format: 2^-16 and 2^-24 of `unorm16` and `unorm24`
        (to a part in their number), 2^(e - 23) of `f32` and 2^(e - 10) of `f16` with the exponent e of the receiver's depth. APIs add
        it to casters when a map is drawn; here the receiver's own plane has it, which is the same where that is what the map holds.

        Parameters
        ----------
        factor, units : float
            As in ``glPolygonOffset(factor, units)``; ``depthBiasSlopeScale`` and ``depthBias`` of WebGPU, Vulkan and Direct3D.

        Raises
        ------
        ArgumentError
            For what is no finite number.

        References
        ----------
        theory.md (13.11); OpenGL 4.6, section 14.6.5.
        """
    @property
    def world(self) -> float:
        """World units along the light ray."""
    @property
    def texels(self) -> float:
        """World sizes of a shadow texel at the receiver, across the light ray."""
    @property
    def ndc(self) -> float:
        """NDC depth."""
    @property
    def slope(self) -> float:
        """Times the depth that the receiver's own plane gains over the filter's reach."""
    @property
    def slope_limit(self) -> float:
        """Upper limit of the slope part, world sizes of a shadow texel along the light ray; infinity for none."""
    @property
    def plane(self) -> float:
        """How much of the way to its own plane at the texel's centre the receiver is moved."""
    @property
    def normal(self) -> float:
        """World sizes of a shadow texel along the normal."""
    @property
    def factor(self) -> float:
        """Times the larger change of the depth of the receiver's plane by a texel."""
    @property
    def units(self) -> float:
        """Steps of the format of what is stored."""
    def at(
        self,
        view: ViewLike,
        technique: TechniqueLike | Parameterization | str,
        resolution: int = 1024,
        *,
        filter: Filter = "nearest",
        renderer: RendererLike | str | None = None,
    ) -> npt.NDArray[np.float32]:
        """How far this bias carries each pixel of a view towards the light.

        Parameters
        ----------
        view : View
            With one light.
        technique : str, Technique, Preset or Parameterization
            Whose maps are looked up; no map is drawn.
        resolution : int
            Texels along each side of the maps.
        filter : str
            How they are read: the slope part covers its reach.
        renderer : Renderer or str, optional
            Draws the eye view.

        Returns
        -------
        (H, W) float32
            World units along the light ray, at the texel that the pixel falls into; NaN where nothing is compared. A bias past
            the near plane or the light counts up to there. With `plane` it is negative where the receiver's plane is farther
            from the light at the texel's centre than at the pixel.

        Examples
        --------
        >>> import numpy as np, shadowlab as sl
        >>> scene = sl.library.scene("robots")
        >>> view = sl.View(scene, scene.camera, scene.light, size=(160, 90))
        >>> distance = sl.Bias(world=0.01, texels=0, ndc=0, slope=0, plane=0).at(view, "uniform", 512, renderer="cpu")
        >>> bool(np.allclose(distance[~np.isnan(distance)], 0.01, rtol=1e-4))
        True
        """
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

def bias_distance(
    gbuffer: GBuffer,
    camera: Camera,
    light: Light,
    parameterization: Maps,
    *,
    resolution: Size | None = None,
    bias: Bias | None = None,
    filter: Filter = "nearest",
    stored: StoredLike = None,
) -> npt.NDArray[np.float32]:
    """The bias of each pixel, (H, W) float32, world units along its light ray; NaN where nothing is compared."""

def texel_coordinates(
    gbuffer: GBuffer, camera: Camera, light: Light, parameterization: Maps, *, resolution: Size | None = None
) -> tuple[Float, npt.NDArray[np.int16]]:
    """Where each pixel's receiver lies in its map: (H, W, 2) float64 and (H, W) int16."""

def reads(
    gbuffer: GBuffer,
    camera: Camera,
    light: Light,
    parameterization: Maps,
    *,
    resolution: Size | None = None,
    filter: Filter = "nearest",
) -> tuple[npt.NDArray[np.uint32], int]:
    """How many pixels read each texel: (K, H, W) uint32; and how many pixels do."""

def filter_reach(
    gbuffer: GBuffer,
    camera: Camera,
    light: Light,
    parameterization: Maps,
    *,
    resolution: Size | None = None,
    filter: Filter = "nearest",
) -> Float:
    """How far from the point the centre of a texel that each pixel compares can lie, along the map's x and y, texels: (H, W, 2)
    float64, NaN where no map serves it.
    """

def filter_kinds() -> list[tuple[str, str, str]]:
    """The kinds of filter: name, settings with examples of values, and what each is."""

def filter_text(filter: Filter) -> str:
    """A filter's text as it is written by itself: checked, with all of its settings."""

def look_up(
    maps: npt.ArrayLike,
    gbuffer: GBuffer,
    camera: Camera,
    light: Light,
    parameterization: Maps,
    *,
    bias: Bias | None = None,
    filter: Filter = "nearest",
    blend: float = 0.0,
    stored: StoredLike = None,
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.int16]]:
    """The shadow mask of surfaces through maps that are there: (H, W) float32, and which map each pixel asks (H, W) int16."""

def compared(
    gbuffer: GBuffer,
    camera: Camera,
    light: Light,
    parameterization: Maps,
    pixels: npt.ArrayLike,
    *,
    resolution: Size | None = None,
    bias: Bias | None = None,
    filter: Filter = "nearest",
    stored: StoredLike = None,
    map: int | None = None,
) -> tuple[npt.NDArray[np.int16], Float, Float, npt.NDArray[np.int64], Float, Float]:
    """What pixels are compared with: the map (N,) int16, as `Footprint.map`; the place in it (N, 2) float64, texels; the biased depth
    at the texel that it falls into (N,) float64, NaN where the pixel is lit without a look at the map; then the texels that are
    read, (N, T, 2) int64, held to the map, their weights (N, T) float64, 0 behind a pixel's last, and the biased depth that each
    is compared with (N, T) float64, NaN as before and where there is no texel. `map` is the index of a map that is asked in place
    of the one that a pixel chooses.
    """

def blended(
    gbuffer: GBuffer,
    camera: Camera,
    light: Light,
    parameterization: Maps,
    pixels: npt.ArrayLike,
    blend: float,
) -> tuple[npt.NDArray[np.int16], Float]:
    """The map whose light is mixed in at each pixel, (N,) int16, -1 for none, and its share (N,) float64."""

def causes(
    scene: Scene,
    camera: Camera,
    light: Light,
    parameterization: Maps,
    differences: npt.ArrayLike,
    *,
    gbuffer: GBuffer,
    maps: npt.ArrayLike,
    bias: Bias | None = None,
    filter: Filter = "nearest",
    blend: float = 0.0,
    stored: StoredLike = None,
) -> tuple[npt.NDArray[np.int8], npt.NDArray[np.float32]]:
    """Why pixels are wrong: (H, W) int8 causes, and (H, W) float32 how far a displaced edge lies from each pixel, in pixels; see
    `shadowlab.aliasing.causes`.
    """
