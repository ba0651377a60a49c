from collections.abc import Sequence
from typing import Any, Literal, final

import numpy as np
import numpy.typing as npt

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
from ._core_maps import Maps
from ._core_maps import Note as Note
from ._core_maps import Parameterization as Parameterization
from ._core_maps import Partition as Partition
from ._core_maps import Technique as Technique
from ._core_renderer import Renderer as Renderer
from ._core_renderer import looking_pays as looking_pays
from ._core_samples import Samples as Samples
from ._core_scene import DirectionalLight as DirectionalLight
from ._core_scene import Light
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
from ._core_types import Size

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
    "looking_pays",
    "mapped_gaps",
    "mapped_states",
    "misclassified",
    "moved_gbuffer",
    "occluded",
    "predict_wrong",
    "reads",
    "renamed_words",
    "restore",
    "same_instances",
    "samples_under",
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
    gbuffer: GBuffer, camera: Camera, light: Light, parameterization: Maps, *, resolution: Size | None = None
) -> dict[str, npt.NDArray[Any]]:
    """What a texel looks like at each pixel of a G-buffer; see `shadowlab.aliasing.footprint`."""

def footprint_at(
    points: npt.ArrayLike,
    normals: npt.ArrayLike,
    camera: Camera,
    light: Light,
    parameterization: Maps,
    *,
    size: Size,
    resolution: Size | None = None,
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

def library_build(name: str, seed: int, params: Sequence[tuple[str, float]]) -> tuple[Scene, Camera, Light]:
    """The library scene of that name, its camera and its light."""

def mapped_states(scene: Scene, camera: Camera, light: Light, gbuffer: GBuffer) -> npt.NDArray[np.int8]:
    """Which pixels are in shadow by one uniform map of 1024 x 1024 texels over the body: (H, W) int8."""

def samples_under(
    samples: Samples, gbuffer: GBuffer, light: Light, shadows: npt.NDArray[np.int8], count: int
) -> Samples:
    """Samples that `from_gbuffer` made of this G-buffer without shadows, under a light; `shadows` and `count` as there. They share
    positions and normals.
    """

def mapped_gaps(scene: Scene, camera: Camera, light: Light, gbuffer: GBuffer) -> npt.NDArray[np.float32]:
    """How far before what each pixel shows, towards the light, what shades it lies by that map: (H, W) float32, world units; 0 where
    that is lit, faces away from the light, or is nothing.
    """

def drawn_samples(scene: Scene, camera: Camera, light: Light, gbuffer: GBuffer | None = None) -> Samples:
    """The samples with shadow states that a technique draws for itself where none are given: of a picture of about 128 by 128
    pixels, or of one that is there.
    """

def predict_wrong(
    samples: Samples,
    parameterization: Maps,
    gaps: npt.ArrayLike,
    *,
    resolution: Size | None = None,
    bias: Bias | None = None,
) -> float:
    """Wrong pixels foretold from samples for maps of a resolution (10.9); `gaps` (H, W) float32 as of `mapped_gaps`, of their picture."""

def png(picture: npt.NDArray[np.uint8]) -> bytes:
    """The picture (H, W, 3) uint8 as the bytes of a PNG file. Threads may encode side by side."""

def shade(
    normal: npt.ArrayLike,
    triangle: npt.ArrayLike,
    mask: npt.ArrayLike,
    *,
    ways: npt.ArrayLike,
    material: npt.ArrayLike,
    sky: npt.ArrayLike,
    coded: npt.ArrayLike,
) -> npt.NDArray[np.uint8]:
    """The eye view (H, W, 3) uint8 of normals (H, W, 3) float32 and triangles (H, W) int32 under a mask (H, W) float32; see
    `shadowlab.pictures.eye.shade`.

    Ways that the light travels (1, 1, 3) or (H, W, 3) float32; linear light (3, 3) float32 of each channel, of a face that
    looks down, what one adds that looks up, and what the light adds; the sky (H, 3) uint8; the bytes (65536,) uint8 of linear
    light from 0 to 1.
    """

def renamed_words() -> list[tuple[str, str, str, str]]:
    """Words of parameters that have another name now: technique, parameter, the old word and the new one."""
