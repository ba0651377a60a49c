from collections.abc import Callable, Sequence
from typing import Any, Literal, NoReturn, TypeAlias, final

import numpy as np
import numpy.typing as npt
from typing_extensions import Self

from ._core_camera import Camera as Camera
from ._core_camera import GBuffer as GBuffer
from ._core_lookups import Bias as Bias
from ._core_lookups import bias_distance as bias_distance
from ._core_lookups import blended as blended
from ._core_lookups import causes as causes
from ._core_lookups import compared as compared
from ._core_lookups import filter_kinds as filter_kinds
from ._core_lookups import filter_reach as filter_reach
from ._core_lookups import filter_text as filter_text
from ._core_lookups import look_up as look_up
from ._core_lookups import reads as reads
from ._core_lookups import texel_coordinates as texel_coordinates
from ._core_maps import Note as Note
from ._core_maps import Parameterization as Parameterization
from ._core_maps import Partition as Partition
from ._core_maps import Technique as Technique
from ._core_samples import Samples as Samples
from ._core_scene import DirectionalLight as DirectionalLight
from ._core_scene import Mesh as Mesh
from ._core_scene import PointLight as PointLight
from ._core_scene import Scene as Scene
from ._core_scene import SpotLight as SpotLight
from ._core_stored import Stored as Stored
from ._core_stored import depth_rows as depth_rows
from ._core_stored import depth_steps as depth_steps
from ._core_summary import cause_counts as cause_counts
from ._core_summary import causes_by_depth as causes_by_depth
from ._core_summary import compared_depths as compared_depths
from ._core_summary import summarize as summarize
from ._core_summary import summarize_bands as summarize_bands
from ._core_trace import face_corners as face_corners
from ._core_trace import first_hit as first_hit
from ._core_trace import moved_gbuffer as moved_gbuffer
from ._core_trace import occluded as occluded
from ._core_trace import same_instances as same_instances
from ._core_trace import shadows_at as shadows_at
from ._core_trace import trace_memory as trace_memory
from ._core_trace import trace_shadow_mask as trace_shadow_mask
from ._core_trace import trace_shadow_masks as trace_shadow_masks
from ._core_types import Cull, FootprintLike, Matrices

__version__: str
__all__ = [
    "Bias",
    "Camera",
    "DirectionalLight",
    "GBuffer",
    "Mesh",
    "Misclassified",
    "Note",
    "Parameterization",
    "Partition",
    "PointLight",
    "Renderer",
    "Samples",
    "Scene",
    "SpotLight",
    "Stored",
    "Technique",
    "__version__",
    "adapters",
    "bias_distance",
    "blended",
    "blur",
    "cause_counts",
    "causes",
    "causes_by_depth",
    "compared",
    "compared_depths",
    "depth_rows",
    "depth_steps",
    "drawn_samples",
    "face_corners",
    "filter_kinds",
    "filter_reach",
    "filter_text",
    "first_hit",
    "footprint",
    "footprint_at",
    "library_build",
    "library_specs",
    "look_up",
    "mapped_states",
    "misclassified",
    "moved_gbuffer",
    "occluded",
    "predict_wrong",
    "reads",
    "renamed_words",
    "restore",
    "same_instances",
    "set_threads",
    "shadows_at",
    "summarize",
    "summarize_bands",
    "technique_specs",
    "texel_coordinates",
    "threads",
    "trace_memory",
    "trace_shadow_mask",
    "trace_shadow_masks",
]

_Float: TypeAlias = npt.NDArray[np.float64]
_Size: TypeAlias = int | tuple[int, int] | Sequence[int]
_Light: TypeAlias = "DirectionalLight | SpotLight | PointLight"
_Filter: TypeAlias = str
_Maps: TypeAlias = "Parameterization | Matrices"
_Stored: TypeAlias = "Stored | str | None"

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
        parameterization: _Maps,
        *,
        resolution: _Size | None = None,
        stored: _Stored = None,
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
        light: _Light,
        parameterization: _Maps,
        *,
        resolution: _Size | None = None,
        bias: Bias | None = None,
        filter: _Filter = "nearest",
        blend: float = 0.0,
        stored: _Stored = None,
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
        parameterization: _Maps,
        *,
        resolution: _Size | None = None,
        cull: Cull = "volume",
        gbuffer: GBuffer | None = None,
        camera: Camera | None = None,
        light: _Light | None = None,
        bias: Bias | None = None,
        filter: _Filter = "nearest",
        blend: float = 0.0,
        stored: _Stored = None,
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
    def gbuffer(self, scene: Scene, camera: Camera, *, size: _Size) -> GBuffer:
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
        light: _Light,
        parameterization: _Maps,
        *,
        size: _Size,
        resolution: _Size | None = None,
        bias: Bias | None = None,
        filter: _Filter = "nearest",
        blend: float = 0.0,
        stored: _Stored = None,
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
    def chosen_map(
        self,
        scene: Scene,
        camera: Camera,
        light: _Light,
        parameterization: _Maps,
        *,
        size: _Size,
        resolution: _Size | None = None,
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
        light: _Light,
        parameterization: _Maps,
        *,
        size: _Size,
        resolution: _Size | None = None,
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

@final
class Misclassified:
    """Where a shadow mask and the truth disagree."""
    @property
    def count(self) -> int:
        """Wrong pixels: false shadow plus false light."""
    @property
    def false_shadow(self) -> int:
        """Pixels the map calls shadow and rays call lit."""
    @property
    def false_light(self) -> int:
        """Pixels the map calls lit and rays call shadow."""
    @property
    def compared(self) -> int:
        """Pixels that show something in both and that rays could decide."""
    @property
    def undecided(self) -> int:
        """Pixels whose truth changes with the numerical offset of the ray."""
    @property
    def unmatched(self) -> int:
        """Pixels in which only one of the two saw a surface."""
    @property
    def fraction(self) -> float:
        """Wrong pixels by compared pixels; 0 where nothing was compared."""
    @property
    def image(self) -> npt.NDArray[np.int8]:
        """(H, W) int8: 0 agree, 1 false shadow, 2 false light, -1 not compared."""
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

def misclassified(mask: npt.ArrayLike, truth: npt.ArrayLike) -> Misclassified:
    """The pixels in which a shadow mask (H, W) float and the truth (H, W) int8 of the same view disagree."""

def footprint(
    gbuffer: GBuffer, camera: Camera, light: _Light, parameterization: _Maps, *, resolution: _Size | None = None
) -> dict[str, npt.NDArray[Any]]:
    """What a texel looks like at each pixel of a G-buffer; see `shadowlab.aliasing.footprint`."""

def footprint_at(
    points: npt.ArrayLike,
    normals: npt.ArrayLike,
    camera: Camera,
    light: _Light,
    parameterization: _Maps,
    *,
    size: _Size,
    resolution: _Size | None = None,
) -> dict[str, npt.NDArray[Any]]:
    """What a texel looks like at points (N, 3) of surfaces with normals (N, 3); see `shadowlab.aliasing.footprint_at`."""

def blur(
    mask: npt.ArrayLike,
    gbuffer: GBuffer,
    camera: Camera,
    *,
    iterations: int,
    strength: Literal["depth", "even"] = "depth",
    depth: float | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> npt.NDArray[np.float32]:
    """The mask after the blur: (H, W) float32; see `shadowlab.blur`."""

def restore(*parts: Any) -> Any:
    """The value that was pickled: what `__reduce__` of every class names, with its state as arguments.

    Raises
    ------
    StateError
        For a state that is damaged, or that a newer version wrote.
    """

def adapters() -> list[dict[str, str]]:
    """The graphics adapters of this machine: one dictionary each. Loads the graphics drivers."""

def set_threads(n: int | None) -> None:
    """Sets how many threads parallel work has from now on, in this process and in those forked from it later.

    Results do not depend on it. Work that another thread has begun ends with the threads it has. No thread is started
    before there is parallel work.

    Parameters
    ----------
    n : int or None
        Threads, 1 to 1024. None goes back to the default: what the environment variable SHADOWLAB_THREADS says, else as many
        as there are cores that this process may use.

    Raises
    ------
    ArgumentError
        For another number, 0 included, or what is no whole number.
    """

def threads() -> int:
    """How many threads parallel work has.

    As `set_threads` or the environment variable SHADOWLAB_THREADS says, else as many as there are cores that this
    process may use.

    Returns
    -------
    int

    Raises
    ------
    ArgumentError
        Where SHADOWLAB_THREADS is no whole number from 1 to 1024; so does the first parallel work.
    """

def technique_specs() -> list[dict[str, Any]]:
    """One dictionary a technique: name, title, source, lights, params."""

def library_specs() -> list[dict[str, Any]]:
    """One dictionary a library scene: name, title, shows, params."""

def library_build(name: str, seed: int, params: Sequence[tuple[str, float]]) -> tuple[Scene, Camera, _Light]:
    """The library scene of that name, its camera and its light."""

def mapped_states(scene: Scene, camera: Camera, light: _Light, gbuffer: GBuffer) -> npt.NDArray[np.int8]:
    """Which pixels are in shadow by one uniform map of 1024 x 1024 texels over the body: (H, W) int8."""

def drawn_samples(scene: Scene, camera: Camera, light: _Light, gbuffer: GBuffer | None = None) -> Samples:
    """The samples with shadow states that a technique draws for itself where none are given: of a picture of about 128 by 128
    pixels, or of one that is there.
    """

def predict_wrong(
    samples: Samples, parameterization: Parameterization | Matrices, *, resolution: _Size | None = None
) -> float:
    """Wrong pixels foretold from samples for maps of a resolution (10.9)."""

def renamed_words() -> list[tuple[str, str, str, str]]:
    """Words of parameters that have another name now: technique, parameter, the old word and the new one."""
