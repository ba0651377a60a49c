"""Scenes and lights of `_core`, which exports them."""

from collections.abc import Sequence
from typing import Any, Literal, TypeAlias, final

import numpy as np
import numpy.typing as npt
from typing_extensions import Never, Self, disjoint_base

from ._core_types import AlphaTestLike, Float

@final
class Mesh:
    """A triangle mesh, stored once however often it is placed."""

    def __new__(cls, vertices: npt.ArrayLike, faces: npt.ArrayLike, *, alpha: AlphaTestLike | None = None) -> Mesh: ...
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
    def alpha(self) -> AlphaTestLike | None:
        """Which points of the triangles exist, with texture coordinates for each of `vertices`; None where all do."""
    @property
    def vertices(self) -> Float:
        """(V, 3) float64, the mesh's own frame, as every consumer sees them (24 bits of the mesh's extent)."""
    @property
    def faces(self) -> npt.NDArray[np.int32]:
        """(M, 3) int32."""
    @staticmethod
    def from_local(positions: npt.ArrayLike, faces: npt.ArrayLike, scale: float, center: npt.ArrayLike) -> Mesh:
        """The mesh of vertices in its stored frame, kept bit for bit: what `positions_local` and `frame` give.

        Parameters
        ----------
        positions : (V, 3) array_like of float32
            In units of `scale`, relative to `center`.
        faces : (M, 3) array_like of int
            Rows of `positions`.
        scale : float
            A power of two.
        center : (3,) array_like

        Raises
        ------
        ArgumentError
            For numbers that are not finite, a scale that is no power of two, or another shape.
        SceneError
            For an index out of range, or no face.
        """

    @property
    def positions_local(self) -> npt.NDArray[np.float32]:
        """(V, 3) float32: vertices as they are stored, relative to the frame's center and in units of its scale."""

    @property
    def frame(self) -> tuple[float, Float]:
        """(scale, center (3,) float64) of the frame in which vertices are stored: `vertices` is center + scale * positions_local."""

    @property
    def content_hash(self) -> str:
        """Hexadecimal hash of all that pictures depend on, the same in every process; see `Scene.content_hash`."""
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, _memo: Any) -> Self: ...

@disjoint_base
class Scene:
    """Meshes and their instances; the package's `Scene` adds loading."""

    def __new__(
        cls,
        meshes: Sequence[Mesh] | Scene,
        mesh_index: npt.ArrayLike | None = None,
        transforms: npt.ArrayLike | None = None,
    ) -> Self: ...
    @property
    def meshes(self) -> list[Mesh]:
        """The meshes, each once."""
    @property
    def mesh_index(self) -> npt.NDArray[np.int64]:
        """(I,) int64: which mesh each instance places."""
    @property
    def transforms(self) -> Float:
        """(I, 4, 4) float64: world from mesh."""
    @property
    def bounds(self) -> Float:
        """(2, 3) float64: smallest and largest corner of the vertices that triangles use."""
    @property
    def origin(self) -> Float:
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
    def with_transforms(self, indices: npt.ArrayLike, matrices: npt.ArrayLike) -> Scene:
        """The scene with some instances placed anew; the package's `Scene` says more.

        Parameters
        ----------
        indices : (K,) array_like of int
            Which instances, each once.
        matrices : (K, 4, 4) array_like of float
            World from mesh, one for each of them.

        Raises
        ------
        ArgumentError
            For another shape or type, an index out of range or given twice, and a matrix that is not affine and finite or
            takes the scene out of the range of 64-bit floats.
        """

    def to_arrays(self) -> tuple[Float, npt.NDArray[np.int32]]:
        """Everything baked into world space: vertices (V, 3) float64, faces (F, 3) int32, in instance order."""
    @property
    def content_hash(self) -> str:
        """Hexadecimal hash of all that pictures depend on: 64 digits, the same in every process, on every machine and for
        every version of Python. Equal scenes have equal hashes.

        Meshes (vertices as stored, faces, and the rows that these had before faces were dropped), their order, and the
        instances with their order and transforms count. Names, `source`, `recipe`, cameras and lights do not. Computed at
        the first use and kept.

        Examples
        --------
        >>> import shadowlab as sl
        >>> a, b = (sl.library.scene("robots") for _ in range(2))
        >>> a.content_hash == b.content_hash, a == b, a is b
        (True, True, False)
        """
    def __add__(self, value: object, /) -> Scene: ...
    def __radd__(self, value: Never, /) -> Scene: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class DirectionalLight:
    """A light at infinity that travels along `direction` ((3,), any length above 0)."""

    def __new__(cls, direction: npt.ArrayLike) -> DirectionalLight: ...
    @staticmethod
    def from_angles(azimuth: float, elevation: float) -> DirectionalLight:
        """The light of a direction in the sky, such as the sun's.

        Parameters
        ----------
        azimuth : float
            Where the light comes from, radians: a turn about the y axis, from +z (0) towards +x (pi/2).
        elevation : float
            How high it stands above the horizon, radians, in [-pi/2, pi/2]; y points up, and pi/2 shines straight down.

        Raises
        ------
        ArgumentError
            For an angle that is not finite, or an elevation outside of its range.

        Examples
        --------
        >>> import numpy as np, shadowlab as sl
        >>> sl.DirectionalLight.from_angles(np.radians(90), np.radians(30)).direction.round(3)
        array([-0.866, -0.5  , -0.   ])
        """

    @property
    def direction(self) -> Float:
        """(3,) float64, unit: the way the light travels."""
    @property
    def kind(self) -> Literal["directional"]:
        """The word "directional"."""
    @property
    def point(self) -> Float:
        """(4,) float64: the centre of projection as a homogeneous point."""
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class SpotLight:
    """A light at a point that shines into a circular cone of full angle `cone_angle` (radians) as far as `range`."""

    def __new__(
        cls, position: npt.ArrayLike, direction: npt.ArrayLike, *, cone_angle: float, range: float
    ) -> SpotLight: ...
    @property
    def position(self) -> Float:
        """(3,) float64: where the light is, world units."""
    @property
    def direction(self) -> Float:
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
    def point(self) -> Float:
        """(4,) float64: the centre of projection as a homogeneous point."""
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class PointLight:
    """A light at a point that shines everywhere as far as `range`."""

    def __new__(cls, position: npt.ArrayLike, *, range: float) -> PointLight: ...
    @property
    def position(self) -> Float:
        """(3,) float64: where the light is, world units."""
    @property
    def range(self) -> float:
        """How far the light reaches, world units."""
    @property
    def kind(self) -> Literal["point"]:
        """The word "point"."""
    @property
    def point(self) -> Float:
        """(4,) float64: the centre of projection as a homogeneous point."""
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

Light: TypeAlias = DirectionalLight | SpotLight | PointLight
