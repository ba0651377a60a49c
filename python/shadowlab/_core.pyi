from collections.abc import Callable, Sequence
from typing import Any, Literal, Protocol, TypeAlias, final

import numpy as np
import numpy.typing as npt
from typing_extensions import disjoint_base

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
_NoteKind: TypeAlias = Literal[
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
    "covers_samples",
    "border_outside",
    "face_unseen",
    "check_matrix",
]
_Maps: TypeAlias = "Parameterization | npt.ArrayLike"

# What the extension takes and makes of the package's own: `shadowlab.Convention`, `shadowlab.aliasing.Footprint`.
class _Convention(Protocol):
    def from_ours(self, matrix: Any) -> npt.NDArray[Any]: ...
    def to_ours(self, matrix: Any) -> npt.NDArray[Any]: ...

class _Footprint(Protocol):
    @property
    def major(self) -> npt.NDArray[Any]: ...
    @property
    def minor(self) -> npt.NDArray[Any]: ...
    @property
    def perspective(self) -> npt.NDArray[Any]: ...
    @property
    def perspective_ts(self) -> npt.NDArray[Any]: ...
    @property
    def projection(self) -> npt.NDArray[Any]: ...
    @property
    def jacobian(self) -> npt.NDArray[Any]: ...
    @property
    def map(self) -> npt.NDArray[np.int16]: ...
    @property
    def depth(self) -> npt.NDArray[Any]: ...
    @property
    def resolution(self) -> tuple[int, int]: ...
    @property
    def size(self) -> tuple[int, int]: ...
    @property
    def maps(self) -> int: ...
    @property
    def measured(self) -> npt.NDArray[np.bool_]: ...
    def summary(self, *, bands: Any = 6) -> Any: ...
    def counts(self) -> dict[str, int]: ...

@final
class Mesh:
    def __new__(cls, vertices: npt.ArrayLike, faces: npt.ArrayLike) -> Mesh: ...
    @property
    def triangle_count(self) -> int: ...
    @property
    def vertex_count(self) -> int: ...
    @property
    def dropped_faces(self) -> int: ...
    @property
    def memory(self) -> int: ...
    @property
    def vertices(self) -> _Float: ...
    @property
    def faces(self) -> npt.NDArray[np.int32]: ...

@disjoint_base
class Scene:
    def __new__(cls, meshes: Sequence[Mesh], mesh_index: npt.ArrayLike, transforms: npt.ArrayLike) -> Scene: ...
    @property
    def meshes(self) -> list[Mesh]: ...
    @property
    def mesh_index(self) -> npt.NDArray[np.int64]: ...
    @property
    def transforms(self) -> _Float: ...
    @property
    def bounds(self) -> _Float: ...
    @property
    def origin(self) -> _Float: ...
    @property
    def triangle_count(self) -> int: ...
    @property
    def instance_count(self) -> int: ...
    @property
    def mesh_count(self) -> int: ...
    @property
    def dropped_faces(self) -> int: ...
    def to_arrays(self) -> tuple[_Float, npt.NDArray[np.int32]]: ...

@final
class Camera:
    @staticmethod
    def look_at(
        eye: npt.ArrayLike,
        target: npt.ArrayLike,
        *,
        up: npt.ArrayLike | None = None,
        fov_y: float = ...,
        aspect: float = ...,
        near: float = 0.1,
        far: float = 1000.0,
    ) -> Camera: ...
    @property
    def eye(self) -> _Float: ...
    @property
    def right(self) -> _Float: ...
    @property
    def up(self) -> _Float: ...
    @property
    def forward(self) -> _Float: ...
    @property
    def fov_y(self) -> float: ...
    @property
    def aspect(self) -> float: ...
    @property
    def near(self) -> float: ...
    @property
    def far(self) -> float: ...
    @property
    def view(self) -> _Float: ...
    @property
    def projection(self) -> _Float: ...
    @property
    def clip_from_world(self) -> _Float: ...
    def depth(self, points: npt.ArrayLike) -> _Float: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...

@final
class DirectionalLight:
    def __new__(cls, direction: npt.ArrayLike) -> DirectionalLight: ...
    @property
    def direction(self) -> _Float: ...
    @property
    def kind(self) -> Literal["directional"]: ...
    @property
    def point(self) -> _Float: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...

@final
class SpotLight:
    def __new__(
        cls, position: npt.ArrayLike, direction: npt.ArrayLike, *, cone_angle: float, range: float
    ) -> SpotLight: ...
    @property
    def position(self) -> _Float: ...
    @property
    def direction(self) -> _Float: ...
    @property
    def cone_angle(self) -> float: ...
    @property
    def range(self) -> float: ...
    @property
    def kind(self) -> Literal["spot"]: ...
    @property
    def point(self) -> _Float: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...

@final
class PointLight:
    def __new__(cls, position: npt.ArrayLike, *, range: float) -> PointLight: ...
    @property
    def position(self) -> _Float: ...
    @property
    def range(self) -> float: ...
    @property
    def kind(self) -> Literal["point"]: ...
    @property
    def point(self) -> _Float: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...

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

@final
class Note:
    KINDS: dict[str, tuple[str, ...]]
    def __new__(
        cls,
        kind: _NoteKind,
        details: Sequence[str] | None = None,
        values: dict[str, float] | dict[str, float | tuple[float, float]] | None = None,
        maps: Sequence[int] | None = None,
    ) -> Note: ...
    @property
    def kind(self) -> _NoteKind: ...
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

@final
class Parameterization:
    @staticmethod
    def from_matrix(
        matrix: npt.ArrayLike,
        *,
        convention: _Convention | str | None = None,
        resolution: int = 1024,
        eye_depth: npt.ArrayLike | None = None,
        selection: str = "depth",
        post_warp: Sequence[tuple[str, float, float] | None] | None = None,
        regions: Sequence[npt.ArrayLike] | None = None,
    ) -> Parameterization: ...
    def to(self, convention: _Convention | str) -> _Float: ...
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
    def __ne__(self, other: object, /) -> bool: ...

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
    ) -> _Footprint: ...

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
