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
_Matrices: TypeAlias = (
    npt.NDArray[Any] | Sequence[npt.NDArray[Any]] | Sequence[Sequence[float]] | Sequence[Sequence[Sequence[float]]]
)
_Maps: TypeAlias = "Parameterization | _Matrices"
# The value of a technique's parameter: a number, a flag, a word, a technique within it, or several of these.
_Setting: TypeAlias = "bool | float | str | Technique | Sequence[float | str | Technique] | npt.NDArray[Any]"
_Filter: TypeAlias = Literal["nearest", "pcf2x2"]
_Selection: TypeAlias = Literal["depth", "containment"]

# What the extension takes and makes of the package's own: `shadowlab.Convention`, `shadowlab.aliasing.Footprint`.
class _Convention(Protocol):
    """How somebody writes a shadow matrix: `shadowlab.Convention`."""
    def from_ours(self, matrix: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """The matrix or matrices as the convention writes them."""
    def to_ours(self, matrix: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """The way back."""

class _Footprint(Protocol):
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

@final
class Mesh:
    """A triangle mesh, stored once however often it is placed."""
    def __new__(cls, vertices: npt.ArrayLike, faces: npt.ArrayLike) -> Mesh: ...
    @property
    def triangle_count(self) -> int:
        """Triangles."""
    @property
    def vertex_count(self) -> int:
        """Vertices."""
    @property
    def dropped_faces(self) -> int:
        """Faces left out because a vertex of theirs is not finite."""
    @property
    def memory(self) -> int:
        """Bytes that the mesh takes."""
    @property
    def vertices(self) -> _Float:
        """(V, 3) float64, the mesh's own frame, as every consumer sees them (24 bits of the mesh's extent)."""
    @property
    def faces(self) -> npt.NDArray[np.int32]:
        """(M, 3) int32."""

@disjoint_base
class Scene:
    """Meshes and their instances; the package's `Scene` adds loading and joining."""
    def __new__(cls, meshes: Sequence[Mesh], mesh_index: npt.ArrayLike, transforms: npt.ArrayLike) -> Scene: ...
    @property
    def meshes(self) -> list[Mesh]:
        """The meshes, each once."""
    @property
    def mesh_index(self) -> npt.NDArray[np.int64]:
        """(I,) int64: which mesh each instance places."""
    @property
    def transforms(self) -> _Float:
        """(I, 4, 4) float64: world from mesh."""
    @property
    def bounds(self) -> _Float:
        """(2, 3) float64: smallest and largest corner of the vertices that triangles use."""
    @property
    def origin(self) -> _Float:
        """(3,) float64: the middle of the bounds, which single-precision positions are relative to."""
    @property
    def triangle_count(self) -> int:
        """Triangles, instances counted each time."""
    @property
    def instance_count(self) -> int:
        """Instances."""
    @property
    def mesh_count(self) -> int:
        """Meshes."""
    @property
    def dropped_faces(self) -> int:
        """Faces left out because a vertex of theirs is not finite."""
    def to_arrays(self) -> tuple[_Float, npt.NDArray[np.int32]]:
        """Everything baked into world space: vertices (V, 3) float64, faces (F, 3) int32, in instance order."""

@final
class Camera:
    """A perspective camera (right-handed, looking along -z of its view space, NDC z in [0, 1])."""
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
    ) -> Camera:
        """A camera at `eye` that looks at `target`.

        Parameters
        ----------
        eye, target : (3,) array_like
            Positions, world units.
        up : (3,) array_like
            Any vector not parallel to the view.
        fov_y : float
            Full vertical field of view, radians, in (0, pi).
        aspect : float
            Width by height.
        near, far : float
            Depths along the view direction, 0 < near < far, world units.

        Raises
        ------
        ArgumentError
            For anything not finite or outside its range, and for `up` parallel to the view.
        """
    @property
    def eye(self) -> _Float:
        """(3,) float64: position, world units."""
    @property
    def right(self) -> _Float:
        """(3,) float64, unit: the picture's right."""
    @property
    def up(self) -> _Float:
        """(3,) float64, unit: the picture's up, across the view."""
    @property
    def forward(self) -> _Float:
        """(3,) float64, unit: the way the camera looks."""
    @property
    def fov_y(self) -> float:
        """Full vertical field of view, radians."""
    @property
    def aspect(self) -> float:
        """Width by height."""
    @property
    def near(self) -> float:
        """Depth of the near plane along the view direction, world units."""
    @property
    def far(self) -> float:
        """Depth of the far plane along the view direction, world units."""
    @property
    def view(self) -> _Float:
        """(4, 4) float64: view from world."""
    @property
    def projection(self) -> _Float:
        """(4, 4) float64: clip from view."""
    @property
    def clip_from_world(self) -> _Float:
        """(4, 4) float64: clip from world."""
    def depth(self, points: npt.ArrayLike) -> _Float:
        """Depth along the view direction of world points: (N, 3) -> (N,)."""
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...

@final
class DirectionalLight:
    """A light at infinity that travels along `direction` ((3,), any length above 0)."""
    def __new__(cls, direction: npt.ArrayLike) -> DirectionalLight: ...
    @property
    def direction(self) -> _Float:
        """(3,) float64, unit: the way the light travels."""
    @property
    def kind(self) -> Literal["directional"]:
        """The word "directional"."""
    @property
    def point(self) -> _Float:
        """(4,) float64: the centre of projection as a homogeneous point."""
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...

@final
class SpotLight:
    """A light at a point that shines into a circular cone of full angle `cone_angle` (radians) as far as `range`."""
    def __new__(
        cls, position: npt.ArrayLike, direction: npt.ArrayLike, *, cone_angle: float, range: float
    ) -> SpotLight: ...
    @property
    def position(self) -> _Float:
        """(3,) float64: where the light is, world units."""
    @property
    def direction(self) -> _Float:
        """(3,) float64, unit: the way along the middle of the cone."""
    @property
    def cone_angle(self) -> float:
        """Full angle of the cone, radians."""
    @property
    def range(self) -> float:
        """How far the light reaches, world units."""
    @property
    def kind(self) -> Literal["spot"]:
        """The word "spot"."""
    @property
    def point(self) -> _Float:
        """(4,) float64: the centre of projection as a homogeneous point."""
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...

@final
class PointLight:
    """A light at a point that shines everywhere as far as `range`."""
    def __new__(cls, position: npt.ArrayLike, *, range: float) -> PointLight: ...
    @property
    def position(self) -> _Float:
        """(3,) float64: where the light is, world units."""
    @property
    def range(self) -> float:
        """How far the light reaches, world units."""
    @property
    def kind(self) -> Literal["point"]:
        """The word "point"."""
    @property
    def point(self) -> _Float:
        """(4,) float64: the centre of projection as a homogeneous point."""
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...

@final
class Technique:
    """A technique with its settings."""
    def __new__(cls, name: str, **params: _Setting) -> Technique: ...
    @property
    def name(self) -> str:
        """Name in the registry."""
    @property
    def settings(self) -> dict[str, Any]:
        """Every parameter with its value."""
    @property
    def needs_samples(self) -> bool:
        """Whether it looks at what the camera sees; see `samples` of `parameterize`."""
    def parameterize(
        self, scene: Scene, camera: Camera, light: _Light, *, resolution: int = 1024, samples: GBuffer | None = None
    ) -> Parameterization:
        """The maps of this technique for a scene, camera and light.

        Parameters
        ----------
        scene : Scene
        camera : Camera
        light : DirectionalLight, SpotLight or PointLight
        resolution : int
            Texels along a side of the map; the fit keeps a border of whole texels and `stable` snaps to them.
        samples : GBuffer, optional
            What the camera sees, for techniques that need it (`needs_samples`); they draw a small G-buffer of about 256 by 256
            pixels where none is given. Others leave it unread.

        Returns
        -------
        Parameterization

        Raises
        ------
        UnsupportedError
            The technique does not serve this kind of light, or this view.
        ArgumentError
            An argument of the wrong type or outside its range.
        """

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
    """One map of a parameterization."""
    @property
    def matrix(self) -> _Float:
        """(4, 4) float64: shadow clip from world."""
    @property
    def eye_depth(self) -> tuple[float, float]:
        """(near, far) camera depth this map serves, world units."""
    @property
    def post_warp(self) -> Literal["none", "log"]:
        """What follows the projective part: "none", or "log" for `y = scale ln(w) + offset`."""
    @property
    def post_warp_terms(self) -> dict[str, float]:
        """The terms of what follows the projective part: `scale` and `offset` of "log", nothing of "none"."""
    @property
    def region(self) -> _Float:
        """(N, 4) float64: the rays this map serves, those of points p with `region @ (p, 1) >= 0`; all of them where N is 0."""
    @property
    def technique(self) -> str:
        """Name of the technique that made this map."""
    @property
    def values(self) -> dict[str, float]:
        """Intermediate numbers by name."""
    @property
    def notes(self) -> tuple[Note, ...]: ...
    def project(self, points: npt.ArrayLike) -> tuple[_Float, _Float]:
        """NDC (N, 3) and clip w (N,) of world points (N, 3). NDC means something where w > 0."""

@final
class Parameterization:
    """The maps of a technique for one scene, camera and light: plain data."""
    @staticmethod
    def from_matrix(
        matrix: _Matrices,
        *,
        convention: _Convention | str | None = None,
        resolution: int = 1024,
        eye_depth: npt.ArrayLike | None = None,
        selection: _Selection = "depth",
        post_warp: Sequence[tuple[str, float, float] | None] | None = None,
        regions: Sequence[npt.ArrayLike] | None = None,
    ) -> Parameterization:
        """Somebody else's matrices as a parameterization.

        Parameters
        ----------
        matrix : (4, 4) or (K, 4, 4) array_like
            Shadow clip from world: acts on column vectors; NDC x, y in [-1, 1] with y up, z in [0, 1] with 0 nearest the light;
            or as the convention says.
        convention : Convention or str, optional
            How the matrices are written, "opengl" for example; as ours where none is given.
        resolution : int
            Texels along a side the matrix was made for.
        eye_depth : (K, 2) array_like, optional
            Near and far camera depth that each map serves, world units; all depths where none are given.
        selection : str
            How a receiver finds its map: "depth", by the camera depth, or "containment", the first that holds it.
        post_warp : sequence, optional
            What follows each matrix: None, or ``("log", scale, offset)`` where y is replaced by ``scale ln(w) + offset``.
        regions : sequence of (N, 4) array_like, optional
            The rays that each map serves, those of points p of our world with ``region @ (p, 1) >= 0``; all where N is 0.

        Raises
        ------
        ArgumentError
            For another shape, numbers that are not finite, a singular matrix, depths that are no ranges, or a logarithm in a
            convention that changes y.
        UnknownNameError
            For a convention or a selection that does not exist.
        """
    def to(self, convention: _Convention | str) -> _Float:
        """The matrix, or the matrices where there are several maps, as a convention writes them.

        Parameters
        ----------
        convention : Convention or str
            "opengl" for example.

        Returns
        -------
        (4, 4) or (K, 4, 4) float64

        Raises
        ------
        ArgumentError
            Where a convention changes y, which the logarithm behind a map's matrix replaces.
        UnknownNameError
            For a convention that does not exist.
        """
    @property
    def selection(self) -> _Selection:
        """How a receiver finds its map: "depth" or "containment"."""
    @property
    def technique(self) -> str:
        """Name of the technique, "matrix" for somebody else's."""
    @property
    def settings(self) -> dict[str, Any]:
        """The technique's parameters as used."""
    @property
    def values(self) -> dict[str, float]:
        """Intermediate numbers by name (warp distance, sine of the light angle...) of a single map; of several, each has its own."""
    @property
    def notes(self) -> tuple[Note, ...]: ...
    @property
    def resolution(self) -> int:
        """Texels along a side it was fitted for."""
    @property
    def border_texels(self) -> int:
        """Texels at each side that no receiver maps to."""
    @property
    def partitions(self) -> list[Partition]:
        """The maps, nearest first."""
    @property
    def matrix(self) -> _Float:
        """(4, 4) float64: shadow clip from world, when there is one map."""
    @property
    def matrices(self) -> _Float:
        """(K, 4, 4) float64: shadow clip from world of every map."""

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
        Upper limit of the slope part, world sizes of a shadow texel along the light ray; infinity for none.
    """
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
    def none() -> Bias:
        """No bias at all: acne everywhere."""
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
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...

@final
class GBuffer:
    """What a camera sees, one record a pixel."""
    @property
    def size(self) -> tuple[int, int]:
        """(width, height) in pixels."""
    @property
    def depth(self) -> npt.NDArray[np.float32]:
        """(H, W) float32: NDC depth in [0, 1], 1 where nothing is."""
    @property
    def position(self) -> _Float:
        """(H, W, 3) float64: world positions; the origin where nothing is. Computed at the first look."""
    @property
    def position_relative(self) -> npt.NDArray[np.float32]:
        """(H, W, 3) float32: world positions minus `origin`."""
    @property
    def origin(self) -> _Float:
        """(3,) float64: the world point positions are stored relative to."""
    @property
    def normal(self) -> npt.NDArray[np.float32]:
        """(H, W, 3) float32: unit geometric normals on the side of the eye; zero where nothing is."""
    @property
    def triangle(self) -> npt.NDArray[np.int32]:
        """(H, W) int32: row of the face array the mesh was made from; -1 where nothing is."""
    @property
    def instance(self) -> npt.NDArray[np.int32]:
        """(H, W) int32: index of the instance; -1 where nothing is."""

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
    def shadow_map(
        self, scene: Scene, parameterization: _Maps, *, resolution: _Size | None = None
    ) -> npt.NDArray[np.float32]:
        """The shadow map: depth of the nearest caster along each light ray.

        Parameters
        ----------
        scene : Scene
        parameterization : Parameterization, or (4, 4) or (K, 4, 4) array_like
        resolution : int or (int, int), optional
            Texels: a side, or width and height. The parameterization's own where none is given.

        Returns
        -------
        (H, W) or, of several maps, (K, H, W) float32
            NDC depth in [0, 1], 1 where no caster is.
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
            "nearest" or "pcf2x2".

        Returns
        -------
        (H, W) float32
            1 lit, 0 in shadow (also what faces away from the light), NaN where nothing is.
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
    ) -> _Footprint:
        """What a texel of the shadow map looks like at each pixel, computed where this renderer draws.

        Parameters
        ----------
        scene, camera, light, parameterization, size, resolution
            As in `shadow_mask`.

        Returns
        -------
        shadowlab.aliasing.Footprint
        """

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

def texel_coordinates(
    gbuffer: GBuffer, camera: Camera, light: _Light, parameterization: _Maps, *, resolution: _Size | None = None
) -> tuple[_Float, npt.NDArray[np.int16]]:
    """Where each pixel's receiver lies in its map: (H, W, 2) float64 and (H, W) int16."""

def reads(
    gbuffer: GBuffer,
    camera: Camera,
    light: _Light,
    parameterization: _Maps,
    *,
    resolution: _Size | None = None,
    filter: _Filter = "nearest",
) -> npt.NDArray[np.uint32]:
    """How many pixels read each texel: (K, H, W) uint32."""

def look_up(
    maps: npt.ArrayLike,
    gbuffer: GBuffer,
    camera: Camera,
    light: _Light,
    parameterization: _Maps,
    *,
    bias: Bias | None = None,
    filter: _Filter = "nearest",
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.int16]]:
    """The shadow mask of surfaces through maps that are there: (H, W) float32, and which map each pixel asks (H, W) int16."""

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
    filter: _Filter = "nearest",
) -> tuple[npt.NDArray[np.int8], npt.NDArray[np.float32]]:
    """Why pixels are wrong: (H, W) int8 causes, and (H, W) float32 the distance in pixels to the nearest pixel whose truth is
    what the map says; see `shadowlab.aliasing.causes`.
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

def technique_specs() -> list[dict[str, Any]]:
    """One dictionary a technique: name, title, source, lights, params."""

def library_specs() -> list[dict[str, Any]]:
    """One dictionary a library scene: name, title, shows, params."""

def library_build(
    name: str, seed: int, params: Sequence[tuple[str, float]]
) -> tuple[list[Mesh], npt.NDArray[np.int64], _Float, Camera, _Light]:
    """The parts of the library scene of that name."""

def trace_shadow_mask(
    scene: Scene,
    camera: Camera,
    light: _Light,
    *,
    size: _Size,
    progress: Callable[[int, int], object] | None = None,
) -> npt.NDArray[np.int8]:
    """(H, W) int8: 1 lit, 0 in shadow, -1 undecided, -2 nothing there."""

def first_hit(
    scene: Scene, origins: npt.ArrayLike, directions: npt.ArrayLike
) -> tuple[_Float, npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """First hits of rays: t (N,) float64 (infinity for none), triangle (N,) int32, instance (N,) int32 (-1 for none)."""

def occluded(
    scene: Scene, origins: npt.ArrayLike, directions: npt.ArrayLike, t_max: npt.ArrayLike | None = None
) -> npt.NDArray[np.bool_]:
    """Whether anything lies at 0 < t < t_max on each ray: (N,) bool."""

def trace_memory(scene: Scene) -> int:
    """Bytes of the acceleration structure (built if it is not there yet)."""
