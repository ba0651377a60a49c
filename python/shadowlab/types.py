"""Names for what signatures take and return: unions of lights, protocols of renderers and techniques, arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from ._core import (
    Bias,
    Camera,
    DirectionalLight,
    GBuffer,
    Parameterization,
    PointLight,
    Scene,
    SpotLight,
)

__all__ = [
    "RGB",
    "FootprintLike",
    "Light",
    "Maps",
    "Mask",
    "Picture",
    "RendererLike",
    "Size",
    "TechniqueLike",
    "TruthImage",
]

Light: TypeAlias = DirectionalLight | SpotLight | PointLight
#: A parameterization, or somebody's own matrices (4, 4) or (K, 4, 4).
Maps: TypeAlias = "Parameterization | npt.ArrayLike"
#: A side, or width and height.
Size: TypeAlias = "int | tuple[int, int] | Sequence[int]"

#: A colour in sRGB bytes.
RGB: TypeAlias = tuple[int, int, int]
#: (H, W, 3) of such colours.
Picture: TypeAlias = npt.NDArray[np.uint8]
#: (H, W) share of the light that arrives: 1 lit, 0 in shadow, NaN where nothing is seen.
Mask: TypeAlias = npt.NDArray[np.float32]
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
        self, scene: Scene, camera: Camera, light: Light, *, resolution: int = 1024, samples: GBuffer | None = None
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

    def gbuffer(self, scene: Scene, camera: Camera, *, size: Size) -> GBuffer:
        """What the camera sees."""

    def shadow_map(
        self, scene: Scene, parameterization: Maps, *, resolution: Size | None = None
    ) -> npt.NDArray[np.float32]:
        """The maps (H, W) or (K, H, W): depths in [0, 1], 1 where empty."""

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
        filter: str = "nearest",
    ) -> Mask:
        """The light that arrives at each pixel."""


class FootprintLike(Protocol):
    """The arrays of an `aliasing.Footprint` of which its summary is made; shapes and units are documented there."""

    @property
    def major(self) -> npt.NDArray[Any]:
        """Longest extent of a texel."""

    @property
    def perspective(self) -> npt.NDArray[Any]:
        """Area of a texel by perspective alone."""

    @property
    def perspective_ts(self) -> npt.NDArray[Any]:
        """Lengths of one texel along the map's x and y by perspective alone."""

    @property
    def projection(self) -> npt.NDArray[Any]:
        """What the slope of the surface adds."""

    @property
    def map(self) -> npt.NDArray[np.int16]:
        """The map that serves each pixel; below 0 where none does."""

    @property
    def depth(self) -> npt.NDArray[Any]:
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
