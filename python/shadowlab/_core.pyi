from collections.abc import Callable, Sequence
from typing import Any, Literal, NoReturn, TypeAlias, final

import numpy as np
import numpy.typing as npt
from typing_extensions import Self

from ._core_scene import Camera as Camera
from ._core_scene import DirectionalLight as DirectionalLight
from ._core_scene import Mesh as Mesh
from ._core_scene import PointLight as PointLight
from ._core_scene import Scene as Scene
from ._core_scene import SpotLight as SpotLight
from ._core_types import ConventionLike, FootprintLike, NoteKind

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
    "Scene",
    "SpotLight",
    "Technique",
    "__version__",
    "adapters",
    "causes",
    "first_hit",
    "footprint",
    "footprint_at",
    "library_build",
    "library_specs",
    "look_up",
    "misclassified",
    "occluded",
    "reads",
    "restore",
    "set_threads",
    "technique_specs",
    "texel_coordinates",
    "threads",
    "trace_memory",
    "trace_shadow_mask",
]

_Float: TypeAlias = npt.NDArray[np.float64]
_Size: TypeAlias = int | tuple[int, int] | Sequence[int]
_Light: TypeAlias = "DirectionalLight | SpotLight | PointLight"
_Maps: TypeAlias = "Parameterization | npt.ArrayLike"

@final
class Technique:
    def __new__(cls, name: str, **params: Any) -> Technique: ...
    @property
    def name(self) -> str: ...
    @property
    def settings(self) -> dict[str, Any]: ...
    @property
    def needs_samples(self) -> bool: ...
    def parameterize(
        self, scene: Scene, camera: Camera, light: _Light, *, resolution: int = 1024, samples: GBuffer | None = None
    ) -> Parameterization: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class Note:
    KINDS: dict[str, tuple[str, ...]]
    def __new__(
        cls,
        kind: NoteKind,
        details: Sequence[str] | None = None,
        values: dict[str, float] | dict[str, float | tuple[float, float]] | None = None,
        maps: Sequence[int] | None = None,
    ) -> Note: ...
    @property
    def kind(self) -> NoteKind: ...
    @property
    def details(self) -> tuple[str, ...]: ...
    @property
    def reasons(self) -> tuple[str, ...]: ...
    @property
    def values(self) -> dict[str, float | tuple[float, float]]: ...
    @property
    def maps(self) -> tuple[int, ...] | None: ...
    def about(self, maps: Sequence[int] | None) -> Note: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class Partition:
    @property
    def matrix(self) -> _Float: ...
    @property
    def eye_depth(self) -> tuple[float, float]: ...
    @property
    def post_warp(self) -> Literal["none", "log"]: ...
    @property
    def post_warp_terms(self) -> dict[str, float]: ...
    @property
    def region(self) -> _Float: ...
    @property
    def technique(self) -> str: ...
    @property
    def values(self) -> dict[str, float]: ...
    @property
    def notes(self) -> tuple[Note, ...]: ...
    def project(self, points: npt.ArrayLike) -> tuple[_Float, _Float]: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class Parameterization:
    @staticmethod
    def from_matrix(
        matrix: npt.ArrayLike,
        *,
        convention: ConventionLike | str | None = None,
        resolution: int = 1024,
        eye_depth: npt.ArrayLike | None = None,
        selection: str = "depth",
        post_warp: Sequence[tuple[str, float, float] | None] | None = None,
        regions: Sequence[npt.ArrayLike] | None = None,
    ) -> Parameterization: ...
    def to(self, convention: ConventionLike | str) -> _Float: ...
    @property
    def selection(self) -> Literal["depth", "containment"]: ...
    @property
    def technique(self) -> str: ...
    @property
    def settings(self) -> dict[str, Any]: ...
    @property
    def values(self) -> dict[str, float]: ...
    @property
    def notes(self) -> tuple[Note, ...]: ...
    @property
    def resolution(self) -> int: ...
    @property
    def border_texels(self) -> int: ...
    @property
    def partitions(self) -> list[Partition]: ...
    @property
    def matrix(self) -> _Float: ...
    @property
    def matrices(self) -> _Float: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class Bias:
    def __new__(
        cls,
        *,
        world: float | None = None,
        texels: float | None = None,
        ndc: float | None = None,
        slope: float | None = None,
        slope_limit: float | None = None,
    ) -> Bias: ...
    @staticmethod
    def none() -> Bias: ...
    @property
    def world(self) -> float: ...
    @property
    def texels(self) -> float: ...
    @property
    def ndc(self) -> float: ...
    @property
    def slope(self) -> float: ...
    @property
    def slope_limit(self) -> float: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class GBuffer:
    @property
    def size(self) -> tuple[int, int]: ...
    @property
    def depth(self) -> npt.NDArray[np.float32]: ...
    @property
    def position(self) -> _Float: ...
    @property
    def position_relative(self) -> npt.NDArray[np.float32]: ...
    @property
    def origin(self) -> _Float: ...
    @property
    def normal(self) -> npt.NDArray[np.float32]: ...
    @property
    def triangle(self) -> npt.NDArray[np.int32]: ...
    @property
    def instance(self) -> npt.NDArray[np.int32]: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class Renderer:
    def __new__(cls, backend: str = "auto", *, adapter: str | None = None) -> Renderer: ...
    @property
    def backend(self) -> Literal["cpu", "gpu"]: ...
    @property
    def adapter(self) -> str: ...
    def shadow_map(
        self, scene: Scene, parameterization: _Maps, *, resolution: _Size | None = None
    ) -> npt.NDArray[np.float32]: ...
    def gbuffer(self, scene: Scene, camera: Camera, *, size: _Size) -> GBuffer: ...
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
        filter: str = "nearest",
    ) -> npt.NDArray[np.float32]: ...
    def chosen_map(
        self,
        scene: Scene,
        camera: Camera,
        light: _Light,
        parameterization: _Maps,
        *,
        size: _Size,
        resolution: _Size | None = None,
    ) -> npt.NDArray[np.int16]: ...
    def footprint(
        self,
        scene: Scene,
        camera: Camera,
        light: _Light,
        parameterization: _Maps,
        *,
        size: _Size,
        resolution: _Size | None = None,
    ) -> FootprintLike: ...
    def __reduce__(self) -> NoReturn:
        """Refused with a StateError: a device stays in its process."""
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, _memo: Any) -> Self: ...

@final
class Misclassified:
    @property
    def count(self) -> int: ...
    @property
    def false_shadow(self) -> int: ...
    @property
    def false_light(self) -> int: ...
    @property
    def compared(self) -> int: ...
    @property
    def undecided(self) -> int: ...
    @property
    def unmatched(self) -> int: ...
    @property
    def fraction(self) -> float: ...
    @property
    def image(self) -> npt.NDArray[np.int8]: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

def misclassified(mask: npt.ArrayLike, truth: npt.ArrayLike) -> Misclassified: ...
def footprint(
    gbuffer: GBuffer, camera: Camera, light: _Light, parameterization: _Maps, *, resolution: _Size | None = None
) -> dict[str, npt.NDArray[Any]]: ...
def footprint_at(
    points: npt.ArrayLike,
    normals: npt.ArrayLike,
    camera: Camera,
    light: _Light,
    parameterization: _Maps,
    *,
    size: _Size,
    resolution: _Size | None = None,
) -> dict[str, npt.NDArray[Any]]: ...
def texel_coordinates(
    gbuffer: GBuffer, camera: Camera, light: _Light, parameterization: _Maps, *, resolution: _Size | None = None
) -> tuple[_Float, npt.NDArray[np.int16]]: ...
def reads(
    gbuffer: GBuffer,
    camera: Camera,
    light: _Light,
    parameterization: _Maps,
    *,
    resolution: _Size | None = None,
    filter: str = "nearest",
) -> npt.NDArray[np.uint32]: ...
def look_up(
    maps: npt.ArrayLike,
    gbuffer: GBuffer,
    camera: Camera,
    light: _Light,
    parameterization: _Maps,
    *,
    bias: Bias | None = None,
    filter: str = "nearest",
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.int16]]: ...
def causes(
    scene: Scene,
    camera: Camera,
    light: _Light,
    parameterization: _Maps,
    differences: npt.ArrayLike,
    truth: npt.ArrayLike,
    *,
    gbuffer: GBuffer,
    maps: npt.ArrayLike,
    bias: Bias | None = None,
    filter: str = "nearest",
) -> tuple[npt.NDArray[np.int8], npt.NDArray[np.float32]]: ...
def restore(*parts: Any) -> Any:
    """The value that was pickled: what `__reduce__` of every class names, with its state as arguments.

    Raises StateError for a state that is damaged, or that a newer version wrote.
    """

def adapters() -> list[dict[str, str]]: ...
def set_threads(n: int | None) -> None:
    """Sets how many threads parallel work has from now on, in this process and in those forked from it later.

    Results do not depend on it. Work that another thread has begun ends with the threads it has. No thread is started
    before there is parallel work.

    Parameters
    ----------
    n : int or None
        Threads, 1 to 1024. None goes back to the default: what the environment variable SHADOWLAB_THREADS says, else as
        many as there are cores that this process may use.

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

def technique_specs() -> list[dict[str, Any]]: ...
def library_specs() -> list[dict[str, Any]]: ...
def library_build(
    name: str, seed: int, params: Sequence[tuple[str, float]]
) -> tuple[list[Mesh], npt.NDArray[np.int64], _Float, Camera, _Light]: ...
def trace_shadow_mask(
    scene: Scene,
    camera: Camera,
    light: _Light,
    *,
    size: _Size,
    progress: Callable[[int, int], object] | None = None,
) -> npt.NDArray[np.int8]: ...
def first_hit(
    scene: Scene, origins: npt.ArrayLike, directions: npt.ArrayLike
) -> tuple[_Float, npt.NDArray[np.int32], npt.NDArray[np.int32]]: ...
def occluded(
    scene: Scene, origins: npt.ArrayLike, directions: npt.ArrayLike, t_max: npt.ArrayLike | None = None
) -> npt.NDArray[np.bool_]: ...
def trace_memory(scene: Scene) -> int: ...
