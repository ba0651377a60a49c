"""Techniques, maps and notes of `_core`, which exports them."""

from collections.abc import Sequence
from typing import Any, Literal, TypeAlias, final

import numpy as np
import numpy.typing as npt

from ._core_scene import Camera, DirectionalLight, GBuffer, PointLight, Scene, SpotLight
from ._core_types import ConventionLike, Matrices, NoteKind

_Float: TypeAlias = npt.NDArray[np.float64]
_Light: TypeAlias = "DirectionalLight | SpotLight | PointLight"
# The value of a technique's parameter: a number, a flag, a word, a technique within it, or several of these.
_Setting: TypeAlias = "bool | float | str | Technique | Sequence[float | str | Technique] | npt.NDArray[Any]"
_Selection: TypeAlias = Literal["depth", "containment"]

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
    """One map of a parameterization."""

    @property
    def matrix(self) -> _Float:
        """(4, 4) float64: shadow clip from world."""
    @property
    def lift(self) -> _Float | None:
        """(4, 4) float64: light space from world, the first factor of ``matrix == fit @ warp @ lift``.

        Rows x, y and w of a point are the light's ray through it, row z is its place along the ray. Under a directional light:
        across, along the warp axis and along the light, in world units, w = 1. Under a spot: the light's perspective, w the
        depth along its axis, z = -1. None of matrices from elsewhere.
        """
    @property
    def warp(self) -> _Float | None:
        """(4, 4) float64: provisional clip space from light space, the second factor of ``matrix == fit @ warp @ lift``.

        Rows x, y and w are the homography on the light's rays that makes the technique; the identity of a uniform map. Row z is
        the depth before the crop. None of matrices from elsewhere.
        """
    @property
    def fit(self) -> _Float | None:
        """(4, 4) float64: clip space from provisional clip space, the third factor of ``matrix == fit @ warp @ lift``.

        The affine crop to receivers and casters, with the border, times a positive factor. None of matrices from elsewhere.
        """
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
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class Parameterization:
    """The maps of a technique for one scene, camera and light: plain data."""

    @staticmethod
    def from_matrix(
        matrix: Matrices,
        *,
        convention: ConventionLike | str | None = None,
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
    def to(self, convention: ConventionLike | str) -> _Float:
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
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
