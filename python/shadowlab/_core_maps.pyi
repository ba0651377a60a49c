"""Techniques, maps and notes of `_core`, which exports them."""

from collections.abc import Sequence
from typing import Any, Literal, TypeAlias, final

import numpy.typing as npt

from ._core_camera import Camera, GBuffer
from ._core_samples import Samples
from ._core_scene import Light, Scene
from ._core_types import ConventionLike, Float, Matrices, NoteKind, PostWarp

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
    @property
    def needs_shadows(self) -> bool:
        """Whether it looks at which visible surfaces are in shadow."""
    def by_body(self) -> Technique:
        """The same technique with maps for the receivers' body, as papers have it: `range=body` and `fit=exact` where it looks at
        samples, and of a search at visible edges the published warp distance. Techniques inside it likewise.
        """
    @property
    def holds(self) -> Literal["shadow", "seen", "body"]:
        """What all of its maps hold: "shadow", visible receivers in shadow and their neighbours; "seen", all visible receivers; or
        "body", whatever can be seen. Of techniques inside it the most.
        """
    def with_slack(self, slack: float) -> Technique:
        """The same technique with slack around the samples that its maps hold, so that they can be held while the camera moves.
        Techniques inside it likewise.

        Parameters
        ----------
        slack : float
            Factor by which a map is larger, along each side, than what its samples span in it, 1 to 2.

        Raises
        ------
        ArgumentError
            A slack out of range, or a technique that does not fit each of its maps to samples.
        """
    @property
    def text(self) -> str:
        """The text that makes the technique again, with the settings that are not the default: `sl.technique(text)`."""
    def parameterize(
        self,
        scene: Scene,
        camera: Camera,
        light: Light,
        *,
        resolution: int | Sequence[int] = 1024,
        samples: Samples | GBuffer | None = None,
    ) -> Parameterization:
        """The maps of this technique for a scene, camera and light.

        Parameters
        ----------
        scene : Scene
        camera : Camera
        light : DirectionalLight, SpotLight or PointLight
        resolution : int or (int, int), optional
            Texels along the sides of the map, width and height where they differ; 1024 where none are given. The fit keeps a
            border of whole texels and `stable` snaps to them.
        samples : Samples or GBuffer, optional
            What the camera sees, for techniques that need it (`needs_samples`); they draw a G-buffer of about 128 by 128
            pixels, and a uniform map for its shadows, where none is given. Others leave it unread.

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
    """One thing to know about a result: what a technique could not do as asked, or what speaks against a matrix.

    `str(note)` is its text; ``"; ".join(map(str, notes))`` is that of several. Code asks for `kind` and never reads the text.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    details : sequence of str
        What the kind alone does not say; `KINDS` lists the details of each kind.
    values : mapping of str to number or (least, most), optional
        The numbers that this kind with these details has, by name.
    maps : sequence of int, optional
        The maps that the note is about, counted from 0; all maps of the result where none are given.

    Raises
    ------
    UnknownNameError
        For a kind, or a detail of it, that does not exist.
    ArgumentError
        For other numbers than the kind has, and maps that are no indices.

    Notes
    -----
    The kinds, with their numbers (lengths and depths in world units):

    - "nothing_seen", "nothing_lit": the camera sees no part of the scene, or none that the light reaches.
    - "no_warp": the map is a uniform one; `reasons` say why. `sine` of "below_min_sin"; `focus_depth` of "focus_has_share" and
      "focus_before_body"; `samples` of "no_sample"; `plane_x`, `plane_y`, `plane_z`, `plane_d`, `behind` and `corners` of
      "rays_behind_eye"; `samples` and `lost` of "samples_lost".
    - "no_logarithm": a logarithmic map without its logarithm.
    - "warp_distance_raised": from `given` to `least`.
    - "warp_weakened": the strength of XPSM from `given` to `most`, per world unit.
    - "slide_raised": the slide of PSM from `given` to `least`, for depths from `near` to `far`.
    - "light_in_box": a placed light is inside a mesh's box; its map begins at `distance`.
    - "stable": a stable map under a placed light covers all that the light reaches.
    - "cover_unused": a setting of depth splits without effect.
    - "no_lit_sample", "no_shadow": no visible surface faces the light, or none is in shadow.
    - "covers_samples": depth splits cover camera depths `near` to `far` alone.
    - "border_outside": a `border` between depth splits is not between the camera's planes `near` and `far`.
    - "face_unseen": no map for the faces in `details`.
    - "check_matrix": a given matrix is hardly a map of the light; `reasons` say why. `miss` of "misses_light", the sine by which
      its rows miss the light; `share` of "depth_below_zero", per cent of the visible surface.

    Examples
    --------
    >>> import shadowlab as sl
    >>> scene = sl.library.scene("robots")
    >>> along = sl.DirectionalLight(scene.camera.forward)
    >>> note, = sl.technique("lispsm").by_body().parameterize(scene, scene.camera, along).notes
    >>> note.kind, note.details
    ('no_warp', ('light_along_axis',))
    >>> str(note)
    'no warp, a uniform map: the light runs along the view'
    """

    KINDS: dict[str, tuple[str, ...]]
    def __new__(
        cls,
        kind: NoteKind,
        details: Sequence[str] | None = None,
        values: dict[str, float] | dict[str, float | tuple[float, float]] | None = None,
        maps: Sequence[int] | None = None,
    ) -> Note: ...
    @property
    def kind(self) -> NoteKind:
        """What it is about: one of `KINDS`."""
    @property
    def details(self) -> tuple[str, ...]:
        """What the kind alone does not say: why there is no warp, which faces have no map, what speaks against a matrix."""
    @property
    def reasons(self) -> tuple[str, ...]:
        """The text of each detail."""
    @property
    def values(self) -> dict[str, float | tuple[float, float]]:
        """Its numbers by name; (least, most) where they differ between maps."""
    @property
    def maps(self) -> tuple[int, ...] | None:
        """The maps that it is about, counted from 0; None where it is about all maps of the result. The text counts from 1."""
    def about(self, maps: Sequence[int] | None) -> Note:
        """The same note about other maps.

        Parameters
        ----------
        maps : sequence of int or None
            Counted from 0; None for all maps of the result.

        Returns
        -------
        Note

        Raises
        ------
        ArgumentError
            For maps that are no indices, and for none of them.
        """
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class Partition:
    """One map of a parameterization."""

    @property
    def matrix(self) -> Float:
        """(4, 4) float64: shadow clip from world."""
    @property
    def lift(self) -> Float | None:
        """(4, 4) float64: light space from world, the first factor of ``matrix == fit @ warp @ lift``.

        Rows x, y and w of a point are the light's ray through it, row z is its place along the ray. Under a directional light:
        across, along the warp axis and along the light, in world units, w = 1. Under a spot: the light's perspective, w the
        depth along its axis, z = -1. None of matrices from elsewhere.
        """
    @property
    def warp(self) -> Float | None:
        """(4, 4) float64: provisional clip space from light space, the second factor of ``matrix == fit @ warp @ lift``.

        Rows x, y and w are the homography on the light's rays that makes the technique; the identity of a uniform map. Row z is
        the depth before the crop. None of matrices from elsewhere.
        """
    @property
    def fit(self) -> Float | None:
        """(4, 4) float64: clip space from provisional clip space, the third factor of ``matrix == fit @ warp @ lift``.

        The affine crop to receivers and casters, with the border, times a positive factor. None of matrices from elsewhere.
        """
    @property
    def eye_depth(self) -> tuple[float, float]:
        """(near, far) camera depth this map serves, world units."""
    @property
    def post_warp(self) -> Literal["none", "log", "rectilinear"]:
        """What follows the projective part: "none"; "log" for ``y = scale ln(w) + offset``; or "rectilinear", where x and y are
        replaced by ascending functions of themselves.
        """
    @property
    def post_warp_terms(self) -> dict[str, float]:
        """The terms of what follows the projective part: `scale` and `offset` of "log", nothing of the others."""
    @property
    def post_warp_knots(self) -> tuple[Float, Float] | None:
        """((N, 2), (M, 2)) float64: the knots of the two functions of "rectilinear", for x and for y, (before, after) in NDC
        each; None of the others. They are linear between the knots, and beyond the outer ones as next to them.
        """
    @property
    def region(self) -> Float:
        """(N, 4) float64: the rays this map serves, those of points p with `region @ (p, 1) >= 0`; all of them where N is 0."""
    @property
    def technique(self) -> str:
        """Name of the technique that made this map."""
    @property
    def values(self) -> dict[str, float]:
        """Intermediate numbers by name."""
    @property
    def notes(self) -> tuple[Note, ...]:
        """What to know about this map; `str` of a note is its text. What concerns all maps alike is in `Parameterization.notes`."""
    def project(self, points: npt.ArrayLike) -> tuple[Float, Float]:
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
        resolution: int | Sequence[int] = 1024,
        eye_depth: npt.ArrayLike | None = None,
        selection: _Selection = "depth",
        post_warp: Sequence[PostWarp | None] | None = None,
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
        resolution : int or (int, int), optional
            Texels along the sides, width and height where they differ, that the matrix was made for; 1024 where none are given.
        eye_depth : (K, 2) array_like, optional
            Near and far camera depth that each map serves, world units; all depths where none are given.
        selection : str
            How a receiver finds its map: "depth", by the camera depth, or "containment", the first that holds it.
        post_warp : sequence, optional
            What follows each matrix: None; ``("log", scale, offset)`` where y is replaced by ``scale ln(w) + offset``; or
            ``("rectilinear", x, y)`` with knots (N, 2) of two ascending functions, (before, after) in NDC each, linear between
            and beyond them, by which x and y are replaced.
        regions : sequence of (N, 4) array_like, optional
            The rays that each map serves, those of points p of our world with ``region @ (p, 1) >= 0``; all where N is 0.

        Raises
        ------
        ArgumentError
            For another shape, numbers that are not finite, a singular matrix, depths that are no ranges, knots that do not
            ascend, or a convention that changes a coordinate that a post-warp replaces.
        UnknownNameError
            For a convention or a selection that does not exist.
        """
    def to(self, convention: ConventionLike | str) -> Float:
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
            Where a convention changes a coordinate that the post-warp behind a map's matrix replaces.
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
    def notes(self) -> tuple[Note, ...]:
        """What to know about this result; `str` of a note is its text. Equal notes of several maps are one."""
    @property
    def resolution(self) -> int | tuple[int, int]:
        """Texels along the sides it was fitted for: one number, or (width, height) where they differ."""
    @property
    def border_texels(self) -> int:
        """Texels at each side that no receiver maps to."""
    @property
    def partitions(self) -> list[Partition]:
        """The maps, nearest first."""
    @property
    def matrix(self) -> Float:
        """(4, 4) float64: shadow clip from world, when there is one map."""
    @property
    def matrices(self) -> Float:
        """(K, 4, 4) float64: shadow clip from world of every map."""
    def _repr_html_(self) -> str:
        """The maps as a table, for notebooks."""
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

Maps: TypeAlias = Parameterization | Matrices
