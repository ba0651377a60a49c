from collections.abc import Callable, Sequence
from typing import Any, Literal, NoReturn, TypeAlias, TypedDict, final

import numpy as np
import numpy.typing as npt
from typing_extensions import Self, Unpack, disjoint_base

from .aliasing.footprint import Footprint
from .conventions.convention import Convention

__version__: str
__all__ = [
    "Bias",
    "Camera",
    "DirectionalLight",
    "GBuffer",
    "Mesh",
    "Misclassified",
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
    "technique_specs",
    "texel_coordinates",
    "trace_memory",
    "trace_shadow_mask",
]

_Float: TypeAlias = npt.NDArray[np.float64]
_Size: TypeAlias = int | tuple[int, int] | Sequence[int]
_Light: TypeAlias = "DirectionalLight | SpotLight | PointLight"
_Maps: TypeAlias = "Parameterization | npt.ArrayLike"

class _CameraChanges(TypedDict, total=False):
    eye: npt.ArrayLike
    target: npt.ArrayLike
    forward: npt.ArrayLike
    up: npt.ArrayLike
    fov_y: float
    aspect: float
    near: float
    far: float

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
    @staticmethod
    def from_local(positions: npt.ArrayLike, faces: npt.ArrayLike, scale: float, center: npt.ArrayLike) -> Mesh:
        """The mesh of vertices in its stored frame, kept bit for bit: what `positions_local` and `frame` give."""

    @property
    def positions_local(self) -> npt.NDArray[np.float32]:
        """(V, 3) float32: vertices as stored, relative to the frame's center and in units of its scale."""

    @property
    def frame(self) -> tuple[float, _Float]:
        """(scale, center) of the frame in which vertices are stored: `vertices` is center + scale * positions_local."""

    @property
    def content_hash(self) -> str:
        """Hexadecimal hash of all that pictures depend on, the same in every process; see `Scene.content_hash`."""
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, _memo: Any) -> Self: ...

@disjoint_base
class Scene:
    def __new__(
        cls,
        meshes: Sequence[Mesh] | Scene,
        mesh_index: npt.ArrayLike | None = None,
        transforms: npt.ArrayLike | None = None,
    ) -> Self: ...
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
    @property
    def content_hash(self) -> str:
        """Hexadecimal hash of all that pictures depend on: 64 digits, the same in every process and on every machine.

        Meshes, their order, and the instances with their order and transforms count. Names, `source`, `recipe`, cameras
        and lights do not. Computed at the first use and kept.
        """
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

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
    @staticmethod
    def from_matrices(
        view: npt.ArrayLike,
        projection: npt.ArrayLike,
        convention: Convention | str | None = None,
        *,
        far: float | None = None,
    ) -> Camera:
        """The camera of a view and a perspective projection matrix, written as a convention says.

        `far` is the far plane for a projection without one, which cannot be taken otherwise. Raises ArgumentError for
        orthographic, off-centre, sheared and singular projections, for views that are not a rotation and a translation,
        and for matrices that mirror the world.
        """

    def replace(self, **changes: Unpack[_CameraChanges]) -> Camera:
        """The same camera with other settings: eye, target or forward, up, fov_y, aspect, near, far.

        What is not named stays as it is, bit for bit; a camera that is moved looks the same way. Another
        name raises UnknownNameError.
        """

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
    def __hash__(self) -> int: ...

@final
class DirectionalLight:
    def __new__(cls, direction: npt.ArrayLike) -> DirectionalLight: ...
    @staticmethod
    def from_angles(azimuth: float, elevation: float) -> DirectionalLight:
        """The light that comes from a direction in the sky, radians.

        `azimuth` is a turn about the y axis, from +z (0) towards +x (pi/2); `elevation` the height above the horizon,
        in [-pi/2, pi/2], y up.
        """

    @property
    def direction(self) -> _Float: ...
    @property
    def kind(self) -> Literal["directional"]: ...
    @property
    def point(self) -> _Float: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

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
    def __hash__(self) -> int: ...

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
    def __hash__(self) -> int: ...

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
    def project(self, points: npt.ArrayLike) -> tuple[_Float, _Float]: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class Parameterization:
    @staticmethod
    def from_matrix(
        matrix: npt.ArrayLike,
        *,
        convention: Convention | str | None = None,
        resolution: int = 1024,
        eye_depth: npt.ArrayLike | None = None,
        selection: str = "depth",
        post_warp: Sequence[tuple[str, float, float] | None] | None = None,
        regions: Sequence[npt.ArrayLike] | None = None,
    ) -> Parameterization: ...
    def to(self, convention: Convention | str) -> _Float: ...
    @property
    def selection(self) -> Literal["depth", "containment"]: ...
    @property
    def technique(self) -> str: ...
    @property
    def settings(self) -> dict[str, Any]: ...
    @property
    def values(self) -> dict[str, float]: ...
    @property
    def notes(self) -> list[str]: ...
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
    ) -> Footprint: ...
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
