"""What signatures of `_core` are made of, for type checkers alone."""

from collections.abc import Sequence
from typing import Any, Literal, Protocol, TypeAlias, TypedDict

import numpy as np
import numpy.typing as npt

Float: TypeAlias = npt.NDArray[np.float64]
Size: TypeAlias = int | tuple[int, int] | Sequence[int]
Filter: TypeAlias = str

NoteKind: TypeAlias = Literal[
    "nothing_seen",
    "nothing_lit",
    "no_warp",
    "no_logarithm",
    "warp_distance_raised",
    "warp_weakened",
    "slide_raised",
    "light_in_box",
    "stable",
    "cover_unused",
    "no_lit_sample",
    "no_shadow",
    "covers_samples",
    "border_outside",
    "even_splits",
    "end_moves",
    "fewer_maps",
    "face_unseen",
    "check_matrix",
]

# Which instances are drawn into a map.
Cull: TypeAlias = Literal["none", "volume", "seen"]

Matrices: TypeAlias = (
    npt.NDArray[Any] | Sequence[npt.NDArray[Any]] | Sequence[Sequence[float]] | Sequence[Sequence[Sequence[float]]]
)

# ("log", scale, offset), or ("rectilinear", x, y) with knots (N, 2).
PostWarp: TypeAlias = tuple[Literal["log"], float, float] | tuple[Literal["rectilinear"], npt.ArrayLike, npt.ArrayLike]

class CameraChanges(TypedDict, total=False):
    """What `Camera.replace` takes."""

    eye: npt.ArrayLike
    target: npt.ArrayLike
    forward: npt.ArrayLike
    up: npt.ArrayLike
    fov_y: float
    height: float
    aspect: float
    near: float
    far: float
    shift: npt.ArrayLike

# What the extension takes and makes of the package's own: `shadowlab.AlphaTest`, `shadowlab.Convention`, `shadowlab.aliasing.Footprint`.
class AlphaTestLike(Protocol):
    """Which points of a mesh's triangles exist: `shadowlab.AlphaTest`."""

    @property
    def texture(self) -> npt.NDArray[np.uint8] | None:
        """(H, W): alpha by texel, 255 opaque; None: 1 all over."""
    @property
    def uv(self) -> npt.NDArray[np.float32]:
        """(V, 2): texture coordinates by vertex."""
    @property
    def cutoff(self) -> float:
        """Least alpha that exists."""
    @property
    def wrap(self) -> tuple[str, str]:
        """How coordinates outside [0, 1] are read, along u and v."""
    @property
    def factor(self) -> float:
        """What the texture's alpha is multiplied with."""

class ConventionLike(Protocol):
    """How somebody writes a shadow matrix: `shadowlab.Convention`."""

    def from_ours(self, matrix: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """The matrix or matrices as the convention writes them."""
    def to_ours(self, matrix: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """The way back."""

class ViewLike(Protocol):
    """A scene with a camera, a light and a size of its picture: `shadowlab.View`."""

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture."""
    @property
    def label(self) -> str:
        """Its name in tables."""

class TechniqueLike(Protocol):
    """What makes maps for a view: a `Technique`, a `shadowlab.Preset`, or what stands for one."""

    @property
    def name(self) -> str:
        """Its name in the registry."""

class RendererLike(Protocol):
    """What draws: a `Renderer`, or anything that does the same."""

    @property
    def backend(self) -> str:
        """What kind of renderer it is, as "cpu" or "gpu"."""

class MapsLike(Protocol):
    """Maps with their matrices: `Parameterization`."""

    @property
    def matrices(self) -> npt.NDArray[np.float64]:
        """(K, 4, 4) float64: shadow_clip_from_world of each."""

class FootprintLike(Protocol):
    """The size of a texel at every pixel: `shadowlab.aliasing.Footprint`, which documents shapes and units."""

    @property
    def major(self) -> npt.NDArray[np.floating[Any]]:
        """Longest extent of a texel."""
    @property
    def minor(self) -> npt.NDArray[np.floating[Any]]:
        """Extent of a texel across its longest."""
    @property
    def perspective(self) -> npt.NDArray[np.floating[Any]]:
        """Area of a texel by perspective alone."""
    @property
    def perspective_ts(self) -> npt.NDArray[np.floating[Any]]:
        """Lengths of one texel along the map's x and y by perspective alone."""
    @property
    def projection(self) -> npt.NDArray[np.floating[Any]]:
        """What the slope of the surface adds."""
    @property
    def jacobian(self) -> npt.NDArray[np.floating[Any]]:
        """What a step of one texel along x and y does to the pixel."""
    @property
    def map(self) -> npt.NDArray[np.int16]:
        """The map that serves each pixel; below 0 where none does."""
    @property
    def depth(self) -> npt.NDArray[np.floating[Any]]:
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
    def summary(self, *, bands: int | npt.ArrayLike = 6) -> Any:
        """The numbers of the whole image."""
    def counts(self) -> dict[str, int]:
        """Pixels by what is known of them."""
