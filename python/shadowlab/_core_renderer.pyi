"""`_core.Renderer`."""

from collections.abc import Iterable
from typing import Any, Literal, NoReturn, final

import numpy as np
import numpy.typing as npt
from typing_extensions import Self

from ._core_camera import Camera, GBuffer
from ._core_lookups import Bias
from ._core_maps import Maps
from ._core_scene import Light, Scene
from ._core_stored import StoredLike
from ._core_types import Cull, Filter, FootprintLike, Size

@final
class Renderer:
    """A renderer: "cpu" (always there), "gpu" (wgpu), or "auto" (a hardware adapter where there is one, else the CPU).

    Parameters
    ----------
    backend : str
    adapter : str, optional
        Part of the name of the graphics adapter to use.

    Raises
    ------
    DeviceError
        No such adapter. Every method raises it where a renderer on a device is used in a process that was forked after it was
        made.
    UnknownNameError
        No such backend.
    """
    def __new__(cls, backend: Literal["cpu", "gpu", "auto"] = "auto", *, adapter: str | None = None) -> Renderer: ...
    @property
    def backend(self) -> Literal["cpu", "gpu"]:
        """Kind of renderer: "cpu" or "gpu"."""
    @property
    def adapter(self) -> str:
        """The device in words."""
    def release(self) -> None:
        """Gives back the memory that the renderer keeps between calls.

        On a device these are the geometry of the scenes drawn last (at most 1 GiB) and images and buffers that wait for calls of
        the same sizes (at most 64 of each and 512 MiB together); on the processor the scratch memory of finished calls. The next
        call makes them anew. Everything goes with the renderer, too.

        Raises
        ------
        DeviceError
            The device was lost.
        """
    def shadow_map(
        self,
        scene: Scene,
        parameterization: Maps,
        *,
        resolution: Size | None = None,
        stored: StoredLike = None,
        cull: Literal["volume", "none"] = "volume",
    ) -> npt.NDArray[np.float32]:
        """The shadow map: what is stored of each light ray, the depth of the nearest caster unless `stored` says otherwise.

        Parameters
        ----------
        scene : Scene
        parameterization : Parameterization, or (4, 4) or (K, 4, 4) array_like
        resolution : int or (int, int), optional
            Texels: a side, or width and height. The parameterization's own where none is given.
        stored : Stored or str, optional
            What the map stores. By default the nearest surface, as NDC depth in single precision.
        cull : str
            Which instances are drawn: "volume", those whose box has a part in the map's volume; "none", all. The map is the same.
            What is "seen" takes a picture: see `seen_map`.

        Returns
        -------
        (H, W) or, of several maps, (K, H, W) float32
            The stored values, in [0, 1]; 1 where no caster is.

        Warns
        -----
        ShadowlabWarning
            Open meshes where `stored` needs closed ones ("back", "second", "midpoint"), with the number of their border edges.
        """
    def seen_map(
        self,
        scene: Scene,
        gbuffer: GBuffer,
        camera: Camera,
        light: Light,
        parameterization: Maps,
        *,
        resolution: Size | None = None,
        bias: Bias | None = None,
        filter: Filter = "nearest",
        blend: float = 0.0,
        stored: StoredLike = None,
    ) -> npt.NDArray[np.float32]:
        """The shadow maps as far as the pixels of a picture look them up.

        Casters whose shadow reaches no pixel are not drawn: texels that no pixel reads may be empty, and texels that are read
        may store something farther than what was left out, as long as no comparison changes. `sl.aliasing.look_up` with the
        same settings gives the mask of whole maps, bit for bit.

        Parameters
        ----------
        scene : Scene
        gbuffer : GBuffer
            The picture.
        camera, light, parameterization, resolution, bias, filter, blend, stored
            As they will be looked up: as in `shadow_mask`.

        Returns
        -------
        (H, W) or, of several maps, (K, H, W) float32
            As `shadow_map`.

        Warns
        -----
        ShadowlabWarning
            As `shadow_map`.

        Notes
        -----
        The "cpu" renderer leaves out casters over texels that no pixel reads, and those behind all receivers that read their
        texels. Behind a receiver counts where the map stores the front, back or second surface with projective spacing. The
        "gpu" renderer leaves out the former alone.
        """
    def casters(
        self,
        scene: Scene,
        parameterization: Maps,
        *,
        resolution: Size | None = None,
        cull: Cull = "volume",
        gbuffer: GBuffer | None = None,
        camera: Camera | None = None,
        light: Light | None = None,
        bias: Bias | None = None,
        filter: Filter = "nearest",
        blend: float = 0.0,
        stored: StoredLike = None,
    ) -> Any:
        """What becomes of the instances of a scene where this renderer draws maps: which are drawn, and which rule left out the
        others.

        Parameters
        ----------
        scene : Scene
        parameterization : Parameterization, or (4, 4) or (K, 4, 4) array_like
        resolution : int or (int, int), optional
            Texels: a side, or width and height. The parameterization's own where none is given.
        cull : str
            "volume", "seen" or "none", as in `shadow_mask`. "seen" takes `gbuffer`, `camera` and `light`.
        gbuffer : GBuffer, optional
            The picture whose pixels look up the maps.
        camera, light, bias, filter, blend, stored
            As its pixels look them up: as in `shadow_mask`.

        Returns
        -------
        shadowlab.aliasing.Casters

        Raises
        ------
        ArgumentError
            For "seen" without a picture, its camera or its light.

        Examples
        --------
        >>> import shadowlab as sl
        >>> s = sl.library.scene("forest", trees=500)
        >>> p = sl.technique("lispsm").parameterize(s, s.camera, s.light)
        >>> found = sl.Renderer("cpu").casters(s, p)
        >>> found.drawn + found.culled == s.instance_count
        True
        """
    def gbuffer(self, scene: Scene, camera: Camera, *, size: Size) -> GBuffer:
        """What the camera sees.

        Parameters
        ----------
        scene : Scene
        camera : Camera
        size : int or (int, int)
            Pixels: a side, or width and height.

        Returns
        -------
        GBuffer
        """
    def shadow_mask(
        self,
        scene: Scene,
        camera: Camera,
        light: Light,
        parameterization: Maps,
        *,
        size: Size,
        resolution: Size | None = None,
        bias: Bias | None = None,
        filter: Filter = "nearest",
        blend: float = 0.0,
        stored: StoredLike = None,
        cull: Cull = "volume",
    ) -> npt.NDArray[np.float32]:
        """The light that arrives at each pixel, through the shadow map.

        Parameters
        ----------
        scene, camera, light, parameterization
            As in `shadow_map` and `gbuffer`.
        resolution : int or (int, int), optional
            Texels of the shadow map.
        size : int or (int, int)
            Pixels of the image.
        bias : Bias, optional
        filter : str
            One of `sl.filters()` with its settings, such as "nearest", "bilinear", "pcf:size=3", "tent:size=3px" or
            "poisson:count=16,radius=2,seed=0"; lengths in texels, or with px in pixels.
        blend : float
            The last share of each map's range of eye depth over which the light of the next map is mixed in, where that map
            holds the receiver (`overlap` of z_partition sees to that); of maps that are chosen because they hold a receiver,
            the share of the map at its border. 0 for none.
        stored : Stored or str, optional
            What the map stores, as in `shadow_map`. The ndc part of the bias is in units of what is stored.
        cull : str
            Which instances are drawn into the map: "volume", those whose box has a part in its volume; "seen", of these the
            ones whose shadow may reach a pixel (`seen_map`; on a device as "volume"); "none", all. The mask is the same.

        Returns
        -------
        (H, W) float32
            1 lit, 0 in shadow (also what faces away from the light), NaN where nothing is.

        Warns
        -----
        ShadowlabWarning
            As `shadow_map`.
        """
    def shadow_states(
        self,
        scene: Scene,
        camera: Camera,
        lights: Iterable[Light],
        parameterizations: Iterable[Maps],
        *,
        size: Size,
        resolution: Size | None = None,
        bias: Bias | None = None,
        filter: Filter = "nearest",
        blend: float = 0.0,
        stored: StoredLike = None,
        cull: Cull = "volume",
    ) -> npt.NDArray[np.uint32]:
        """At which pixels each of several lights arrives, a bit per light.

        The eye view is drawn once for all lights. On the processor all lights with one map each are looked up in one pass
        over the pixels.

        Parameters
        ----------
        scene, camera
            As in `shadow_mask`.
        lights : sequence of DirectionalLight, SpotLight or PointLight
        parameterizations : sequence of Parameterization, or (4, 4) or (K, 4, 4) array_like
            The maps of each light.
        size, resolution, bias, filter, blend, stored, cull
            As in `shadow_mask`, the same for all lights.

        Returns
        -------
        (H, W) or, of more than 32 lights, (P, H, W) uint32
            Bit ``i % 32`` of picture ``i // 32``, counted from the lowest, is 1 where at least half of light `i` arrives, as
            `aliasing.misclassified` judges its mask; 0 in shadow and where nothing is.

        Raises
        ------
        ArgumentError
            No light, another number of parameterizations than of lights, and as `shadow_mask`.

        References
        ----------
        Chong, Gortler 2007, section 3: the shadow states of up to 32 lights in the four bytes of a pixel.

        Examples
        --------
        >>> import shadowlab as sl
        >>> s = sl.library.scene("robots")
        >>> lights = [s.light, sl.PointLight((0, 6, 0), range=40.0)]
        >>> maps = [sl.technique("uniform").parameterize(s, s.camera, light, resolution=256) for light in lights]
        >>> states = sl.Renderer("cpu").shadow_states(s, s.camera, lights, maps, size=(160, 90))
        >>> lit_by_lamp = (states >> 1) & 1 == 1
        >>> lit_by_lamp.shape
        (90, 160)
        """
    def chosen_map(
        self,
        scene: Scene,
        camera: Camera,
        light: Light,
        parameterization: Maps,
        *,
        size: Size,
        resolution: Size | None = None,
    ) -> npt.NDArray[np.int16]:
        """Which map each pixel asks, where there are several.

        Parameters
        ----------
        scene, camera, light, parameterization, size, resolution
            As in `shadow_mask`.

        Returns
        -------
        (H, W) int16
            Index into `parameterization.partitions`; -1 where nothing is seen, where the surface faces away from the light or
            is beyond its reach, and where no map holds the point (which is lit then).
        """
    def footprint(
        self,
        scene: Scene,
        camera: Camera,
        light: Light,
        parameterization: Maps,
        *,
        size: Size,
        resolution: Size | None = None,
    ) -> FootprintLike:
        """What a texel of the shadow map looks like at each pixel, computed where this renderer draws.

        Parameters
        ----------
        scene, camera, light, parameterization, size, resolution
            As in `shadow_mask`.

        Returns
        -------
        shadowlab.aliasing.Footprint
        """
    def __reduce__(self) -> NoReturn:
        """Refused with a StateError: a device stays in its process."""
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, _memo: Any) -> Self: ...

def looking_pays(scene: Scene, size: Size) -> bool:
    """Whether maps of what a picture of `size` pixels sees are drawn sooner than whole ones."""
