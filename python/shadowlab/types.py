"""Names for what signatures take and return: unions of lights, protocols of renderers and techniques, arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, Protocol, TypeAlias, TypeVar, get_args

import numpy as np
import numpy.typing as npt

from ._core import (
    Bias,
    Camera,
    DirectionalLight,
    GBuffer,
    Parameterization,
    PointLight,
    Samples,
    Scene,
    SpotLight,
)

__all__ = [
    "CULLS",
    "RGB",
    "Backend",
    "BiasPart",
    "BlurStrength",
    "ConventionLike",
    "Cull",
    "Filter",
    "Floats",
    "FootprintLike",
    "Item",
    "Labelled",
    "Light",
    "Maps",
    "Mask",
    "Matrices",
    "PerLight",
    "PostWarp",
    "RendererArgument",
    "RendererLike",
    "SceneLike",
    "Setting",
    "ShadowMaps",
    "Size",
    "TechniqueArgument",
    "TechniqueLike",
    "Techniques",
    "TruthImage",
    "Up",
    "Vector",
    "ViewName",
]

T = TypeVar("T")

#: What a renderer or technique takes for a scene: that of the core, of which `sl.Scene` is one.
SceneLike: TypeAlias = Scene
Light: TypeAlias = DirectionalLight | SpotLight | PointLight
#: Somebody's own matrices (4, 4) or (K, 4, 4); `npt.ArrayLike` would take texts, too.
Matrices: TypeAlias = (
    npt.NDArray[Any] | Sequence[npt.NDArray[Any]] | Sequence[Sequence[float]] | Sequence[Sequence[Sequence[float]]]
)
#: A parameterization, or such matrices.
Maps: TypeAlias = Parameterization | Matrices
#: What follows a matrix, as `Parameterization.from_matrix` takes it: ("log", scale, offset) or ("rectilinear", x, y).
PostWarp: TypeAlias = tuple[Literal["log"], float, float] | tuple[Literal["rectilinear"], npt.ArrayLike, npt.ArrayLike]
#: A side, or width and height.
Size: TypeAlias = int | tuple[int, int] | Sequence[int]

#: How a map is read: the text of one of `sl.filters()`, such as "bilinear", "pcf:size=3" or "tent:size=3px".
Filter: TypeAlias = str
#: One part of a bias, by its unit.
BiasPart: TypeAlias = Literal["world", "texels", "ndc", "slope"]
#: Which instances are drawn into a map: all, those in its volume, or of these the ones whose shadow may reach a pixel.
Cull: TypeAlias = Literal["none", "volume", "seen"]
CULLS: tuple[Cull, ...] = get_args(Cull)
#: Where a blur is wide: near the viewer, as wide in the world everywhere; or as wide in the picture everywhere.
BlurStrength: TypeAlias = Literal["depth", "even"]
#: The axis of a file that points up.
Up: TypeAlias = Literal["y", "z"]
#: A view that is chosen for a scene: along it at eye level, the whole from above, along it against the light.
ViewName: TypeAlias = Literal["along", "above", "against"]
#: A renderer by its name; "auto" takes a graphics adapter where there is one.
Backend: TypeAlias = Literal["cpu", "gpu", "auto"]

#: Of a view with one light this, of a view with several a tuple of them. `Any` stands for the tuple, so that nobody
#: has to rule out several lights where there is one.
PerLight: TypeAlias = "T | Any"

#: One, several, or several by their labels.
Labelled: TypeAlias = "T | Sequence[T] | Mapping[str, T]"

#: Numbers of an image in float32, of points in float64.
Floats: TypeAlias = npt.NDArray[np.floating[Any]]
#: A point, a vector or several: (3,), (4,) or (N, 3) float64.
Vector: TypeAlias = npt.NDArray[np.float64]
#: A colour in sRGB bytes.
RGB: TypeAlias = tuple[int, int, int]
#: (H, W) share of the light that arrives: 1 lit, 0 in shadow, NaN where nothing is seen.
Mask: TypeAlias = npt.NDArray[np.float32]
#: (H, W) or (K, H, W) depths in [0, 1], 1 where empty.
ShadowMaps: TypeAlias = npt.NDArray[np.float32]
#: (H, W) traced truth: 1 lit, 0 in shadow, -1 undecided, -2 nothing.
TruthImage: TypeAlias = npt.NDArray[np.int8]


class TechniqueLike(Protocol):
    """What makes maps for a view: a `Technique`, or a `Preset` that stands for one."""

    @property
    def name(self) -> str:
        """Its name in the registry."""

    @property
    def settings(self) -> Mapping[str, Any]:
        """All its parameters."""

    @property
    def needs_samples(self) -> bool:
        """Whether it looks at the receivers that the camera sees."""

    def parameterize(
        self,
        scene: SceneLike,
        camera: Camera,
        light: Light,
        *,
        resolution: int = 1024,
        samples: Samples | GBuffer | None = None,
    ) -> Parameterization:
        """The maps for a scene, camera and light."""


class RendererLike(Protocol):
    """What draws: a `Renderer`, or anything that does the same."""

    @property
    def backend(self) -> str:
        """What kind of renderer it is, as "cpu" or "gpu"."""

    @property
    def adapter(self) -> str:
        """The device behind it."""

    def gbuffer(self, scene: SceneLike, camera: Camera, *, size: Size) -> GBuffer:
        """What the camera sees."""

    def shadow_map(self, scene: SceneLike, parameterization: Maps, *, resolution: Size | None = None) -> ShadowMaps:
        """The maps (H, W) or (K, H, W): depths in [0, 1], 1 where empty."""

    def shadow_mask(
        self,
        scene: SceneLike,
        camera: Camera,
        light: Light,
        parameterization: Maps,
        *,
        size: Size,
        resolution: Size | None = None,
        bias: Bias | None = None,
        filter: Filter = "nearest",
    ) -> Mask:
        """The light that arrives at each pixel."""


class ConventionLike(Protocol):
    """How somebody writes a shadow matrix: a `Convention`, or anything that turns matrices both ways."""

    def from_ours(self, matrix: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """The matrix (4, 4) or matrices (K, 4, 4) as the convention writes them."""

    def to_ours(self, matrix: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """The way back."""


#: What an experiment evaluates: something that makes maps, or maps that are there.
Item: TypeAlias = TechniqueLike | Parameterization
#: The same, or the text that names it.
TechniqueArgument: TypeAlias = Item | str
#: One, several, or several by their labels.
Techniques: TypeAlias = "Labelled[TechniqueArgument]"
#: The value of a technique's parameter: a number, a flag, a word, a technique within it, or several of these.
Setting: TypeAlias = bool | float | str | TechniqueLike | Sequence[float | str | TechniqueLike] | npt.NDArray[Any]
#: A renderer, one by its name, or None for the best there is.
RendererArgument: TypeAlias = RendererLike | Backend | None


class FootprintLike(Protocol):
    """The arrays of an `aliasing.Footprint` of which its summary is made; shapes and units are documented there."""

    @property
    def major(self) -> Floats:
        """Longest extent of a texel."""

    @property
    def perspective(self) -> Floats:
        """Area of a texel by perspective alone."""

    @property
    def perspective_ts(self) -> Floats:
        """Lengths of one texel along the map's x and y by perspective alone."""

    @property
    def projection(self) -> Floats:
        """What the slope of the surface adds."""

    @property
    def map(self) -> npt.NDArray[np.int16]:
        """The map that serves each pixel; below 0 where none does."""

    @property
    def depth(self) -> Floats:
        """Depth along the view."""

    @property
    def resolution(self) -> tuple[int, int]:
        """Width and height of each map."""

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the image."""

    @property
    def maps(self) -> int:
        """How many maps there are."""

    @property
    def measured(self) -> npt.NDArray[np.bool_]:
        """Where a texel is looked up."""

    def counts(self) -> dict[str, int]:
        """Pixels by what is known of them."""
