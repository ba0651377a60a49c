"""How somebody else writes a shadow matrix, and the way there and back.

A matrix of ours is shadow_clip_from_world for column vectors: NDC x to the right and y up in [-1, 1], z in [0, 1] with
0 nearest the light, a right-handed world with y up. Every other convention is one invertible linear map away::

    theirs = map_from_ndc @ ours @ world_from_their_world      (transposed for row vectors)

The handedness of a view space leaves no trace in such a matrix: x to the right, y up and depth away is what both kinds
of view space end in. What does leave one is the world's axes.

Sources of the presets: the specifications of OpenGL 4.6 (clip volume -w <= z <= w), Vulkan 1.3 (0 <= z <= w, y down),
Direct3D 11.3 (0 <= z <= w; DirectXMath multiplies rows) and WebGPU ("Coordinate Systems"); Everitt, Rege, Cebenoyan
2001 [everitt2001], "Hardware shadow mapping", for the bias matrix; Unity, Universal RP, ShadowUtils.GetShadowTransform.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar, Literal, cast

import numpy as np
import numpy.typing as npt

from ..errors import ArgumentError, UnknownNameError
from ..text import format_value, parse_spec, shown
from ..text.checks import whole
from ..travel import Value
from .fields import AXES, LEFT_HANDED_AXES, Tile, Tiles, axes_of, check_word, matrices_of, range_of, tiles_of

if TYPE_CHECKING:
    from collections.abc import Sequence

NDC_RANGE = (-1.0, 1.0)
TEXTURE_RANGE = (0.0, 1.0)
WHOLE_TILE: Tile = (0.0, 0.0, 1.0, 1.0)

# Tiles of an atlas: more than a renderer draws maps of.
MOST_TILES = 32_767


@dataclass(frozen=True, eq=False, kw_only=True)
class Convention(Value):
    """How a shadow matrix is written.

    Parameters
    ----------
    vectors : "column" or "row"
        What the matrix acts on: ``m @ p``, or ``p @ m``, whose rows and columns are exchanged.
    z_range : (float, float)
        Depths of the map, lowest and highest: (0, 1), or (-1, 1) as in OpenGL.
    reversed_z : bool
        Whether the highest depth is nearest the light.
    xy_range : (float, float)
        x and y at the map's edges: (-1, 1) for NDC, (0, 1) for texture coordinates (a bias matrix is folded in).
    x : "right" or "left"
        Where x grows in the map as the light sees it.
    y : "up" or "down"
        Where y grows in the map as the light sees it.
    axes : (str, str, str) or str
        Their world's x, y and z axes in terms of ours: ("x", "-z", "y") is a right-handed world with z up, ("x", "y",
        "-z") a left-handed one with y up. From `handedness` where none are given.
    handedness : "right" or "left"
        Of their world; follows from `axes` where these are given.
    tile : (u, v, width, height), or several
        The map's place in an atlas, in shares of the atlas; v grows as `y` does. Several are for as many maps.

    Raises
    ------
    ArgumentError
        For a value that is none of these, or axes that contradict the handedness.

    Examples
    --------
    >>> import numpy as np, shadowlab as sl
    >>> sl.Convention.opengl().from_ours(np.eye(4))[2]
    array([ 0.,  0.,  2., -1.])
    """

    vectors: Literal["column", "row"] = "column"
    z_range: tuple[float, float] = TEXTURE_RANGE
    reversed_z: bool = False
    xy_range: tuple[float, float] = NDC_RANGE
    x: Literal["right", "left"] = "right"
    y: Literal["up", "down"] = "up"
    axes: tuple[str, str, str] = None  # type: ignore[assignment]  # filled in from the handedness
    handedness: Literal["right", "left"] = None  # type: ignore[assignment]  # filled in from the axes
    tile: Tiles = WHOLE_TILE

    if TYPE_CHECKING:
        # What may be given is more than what is kept.
        def __init__(
            self,
            *,
            vectors: Literal["column", "row"] = "column",
            z_range: Sequence[float] = TEXTURE_RANGE,
            reversed_z: bool = False,
            xy_range: Sequence[float] = NDC_RANGE,
            x: Literal["right", "left"] = "right",
            y: Literal["up", "down"] = "up",
            axes: Sequence[str] | None = None,
            handedness: Literal["right", "left"] | None = None,
            tile: Tile | Sequence[Tile] = WHOLE_TILE,
        ) -> None: ...

    PRESETS: ClassVar[tuple[str, ...]] = (
        "webgpu", "metal", "opengl", "opengl_bias", "direct3d", "direct3d_texture", "vulkan", "reversed_z", "unity",
    )  # fmt: skip

    def __post_init__(self) -> None:
        def settle(name: str, value: object) -> None:
            object.__setattr__(self, name, value)

        check_word("vectors", self.vectors, ("column", "row"))
        check_word("x", self.x, ("right", "left"))
        check_word("y", self.y, ("up", "down"))
        if not isinstance(self.reversed_z, (bool, np.bool_)):
            raise ArgumentError(
                f"reversed_z: expected True or False, got {shown(self.reversed_z)}; try reversed_z=True"
            )
        settle("reversed_z", bool(self.reversed_z))
        settle("z_range", range_of("z_range", self.z_range))
        settle("xy_range", range_of("xy_range", self.xy_range))
        if self.handedness is not None:
            check_word("handedness", self.handedness, ("right", "left"))
        default = LEFT_HANDED_AXES if self.handedness == "left" else AXES
        settle("axes", axes_of(default if self.axes is None else self.axes))
        found = "right" if np.linalg.det(self.world_from_their_world[:3, :3]) > 0 else "left"
        if self.handedness is not None and self.handedness != found:
            raise ArgumentError(
                f"handedness: expected {found!r}, which the axes {','.join(self.axes)} are, got {self.handedness!r}; "
                "give one of the two"
            )
        settle("handedness", found)
        settle("tile", tiles_of(self.tile))

    @classmethod
    def webgpu(cls) -> Convention:
        """Ours: WebGPU's, and Metal's."""
        return cls()

    @classmethod
    def metal(cls) -> Convention:
        """Metal's, which is ours."""
        return cls()

    @classmethod
    def opengl(cls) -> Convention:
        """OpenGL's: depths in [-1, 1]."""
        return cls(z_range=(-1.0, 1.0))

    @classmethod
    def opengl_bias(cls) -> Convention:
        """OpenGL's with the bias matrix: x, y and depths in [0, 1], as textures are read."""
        return cls(xy_range=TEXTURE_RANGE)

    @classmethod
    def direct3d(cls) -> Convention:
        """Direct3D's with row vectors, as DirectXMath and D3DX write them."""
        return cls(vectors="row")

    @classmethod
    def direct3d_texture(cls) -> Convention:
        """Direct3D's with row vectors and texture coordinates: x, y in [0, 1], y down."""
        return cls(vectors="row", xy_range=TEXTURE_RANGE, y="down")

    @classmethod
    def vulkan(cls) -> Convention:
        """Vulkan's: y down."""
        return cls(y="down")

    @classmethod
    def reversed_z_buffer(cls) -> Convention:
        """Ours with a reversed depth buffer: 1 nearest the light."""
        return cls(reversed_z=True)

    @classmethod
    def unity(cls) -> Convention:
        """Unity's world-to-shadow matrix: a left-handed world, x, y and depths in [0, 1], reversed z."""
        return cls(handedness="left", xy_range=TEXTURE_RANGE, reversed_z=True)

    @classmethod
    def of(cls, value: object) -> Convention:
        """The convention that a text or a convention means.

        Parameters
        ----------
        value : Convention or str
            A preset's name, with changes if need be: "opengl", "vulkan:vectors=row", "webgpu:axes=(x,-z,y)".

        Raises
        ------
        UnknownNameError
            For a preset or a field that does not exist.
        ArgumentError
            For anything else.
        """
        if isinstance(value, Convention):
            return value
        if not isinstance(value, str):
            raise ArgumentError(
                f"convention: expected a Convention or the name of one, got {type(value).__name__}; "
                f"the names are {', '.join(cls.PRESETS)}"
            )
        name, changes = parse_spec(value, "convention")
        known = name.replace("-", "_")
        if known not in cls.PRESETS:
            raise UnknownNameError(f"convention: unknown name {shown(name)}; expected one of {', '.join(cls.PRESETS)}")
        made: Convention = getattr(cls, "reversed_z_buffer" if known == "reversed_z" else known)()
        return made.changed(**changes) if changes else made

    def changed(self, **changes: Any) -> Convention:
        """The same with other values of some fields; axes and handedness replace each other.

        Raises
        ------
        UnknownNameError
            For a field that does not exist.
        ArgumentError
            As the constructor.
        """
        names = [f.name for f in fields(self)]
        for name in changes:
            if name not in names:
                raise UnknownNameError(f"convention: unknown field {name!r}; expected some of {', '.join(names)}")
        kept = {name: getattr(self, name) for name in names if name != "handedness"}
        if "handedness" in changes and changes["handedness"] != self.handedness:
            kept["axes"] = None
        return Convention(**{**kept, **changes})

    def in_atlas(self, columns: int, rows: int = 1) -> Convention:
        """The same with as many maps side by side in an atlas as there are tiles, row after row.

        Raises
        ------
        ArgumentError
            For anything but whole numbers above 0.
        """
        columns, rows = whole("columns", columns), whole("rows", rows)
        if columns * rows > MOST_TILES:
            raise ArgumentError(
                f"columns, rows: expected at most {MOST_TILES} tiles, got {shown(columns)} x {shown(rows)}; use fewer"
            )
        tiles = [(i / columns, j / rows, 1 / columns, 1 / rows) for j in range(rows) for i in range(columns)]
        return self.changed(tile=tiles)

    @property
    def tiles(self) -> tuple[Tile, ...]:
        """The tiles, one where all maps share it."""
        several = isinstance(self.tile[0], tuple)
        return cast("tuple[Tile, ...]", self.tile if several else (self.tile,))

    @property
    def keeps_x(self) -> bool:
        """Whether x of the map is that of our NDC."""
        return self._keeps(0)

    @property
    def keeps_y(self) -> bool:
        """Whether y of the map is that of our NDC."""
        return self._keeps(1)

    def _keeps(self, axis: int) -> bool:
        return bool(np.array_equal(self.map_from_ndc[:, axis], np.tile(np.eye(4)[axis], (len(self.tiles), 1))))

    @property
    def map_from_ndc(self) -> npt.NDArray[np.float64]:
        """(T, 4, 4) float64: their map coordinates from our NDC, one a tile."""
        made = np.tile(np.eye(4), (len(self.tiles), 1, 1))
        low, high = self.xy_range
        for m, (u, v, width, height) in zip(made, self.tiles, strict=True):
            for axis, sign, start, share in ((0, self.x == "right", u, width), (1, self.y == "up", v, height)):
                # [-1, 1] to the tile's part of [0, 1], and that to the range of x and y.
                m[axis, axis] = (0.5 if sign else -0.5) * share * (high - low)
                m[axis, 3] = low + (high - low) * (start + 0.5 * share)
        near, far = self.z_range[::-1] if self.reversed_z else self.z_range
        made[:, 2, 2], made[:, 2, 3] = far - near, near
        return made

    @property
    def world_from_their_world(self) -> npt.NDArray[np.float64]:
        """(4, 4) float64: our world coordinates from theirs."""
        made = np.eye(4)
        # Row i of the inverse says which of our axes their axis i is; the inverse of such a matrix is its transpose.
        for column, name in enumerate(self.axes):
            made[:3, column] = 0.0
            made[AXES.index(name[-1]), column] = -1.0 if name[0] == "-" else 1.0
        return made

    def from_ours(self, matrix: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """The matrix or matrices as this convention writes them.

        Parameters
        ----------
        matrix : (4, 4) or (K, 4, 4) array_like
            shadow_clip_from_world of ours.

        Returns
        -------
        (4, 4) or (K, 4, 4) float64

        Raises
        ------
        ArgumentError
            For another shape, numbers that are not finite, or another number of maps than of tiles.
        """
        ours = self._checked(matrix)
        theirs: npt.NDArray[np.float64] = self.map_from_ndc @ ours.reshape(-1, 4, 4) @ self.world_from_their_world
        theirs = theirs.transpose(0, 2, 1).copy() if self.vectors == "row" else theirs
        return theirs.reshape(ours.shape)

    def to_ours(self, matrix: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """The matrix or matrices of this convention as ours; what `from_ours` takes back.

        Parameters
        ----------
        matrix : (4, 4) or (K, 4, 4) array_like

        Returns
        -------
        (4, 4) or (K, 4, 4) float64

        Raises
        ------
        ArgumentError
            As `from_ours`.
        """
        theirs = self._checked(matrix)
        stack = theirs.reshape(-1, 4, 4)
        clip = stack.transpose(0, 2, 1) if self.vectors == "row" else stack
        moved = self.map_from_ndc
        ours: npt.NDArray[np.float64] = clip @ self.world_from_their_world.T
        # The inverse of a scale and an offset an axis, without the rounding of a general one.
        for axis in range(3):
            ours[:, axis] = (ours[:, axis] - moved[:, axis, 3, None] * ours[:, 3]) / moved[:, axis, axis, None]
        return ours.reshape(theirs.shape)

    def __str__(self) -> str:
        """The text that `of` reads back."""
        texts = []
        for name in self.PRESETS:
            preset = Convention.of(name)
            changes = [
                f"{f.name}={format_value(getattr(self, f.name))}"
                for f in fields(self)
                if getattr(self, f.name) != getattr(preset, f.name) and f.name != "handedness"
            ]
            texts.append((len(changes), f"{name}:{','.join(changes)}" if changes else name))
        # The nearest preset, the first of those that are as near.
        return min(texts, key=lambda text: text[0])[1]

    def _checked(self, matrix: npt.ArrayLike) -> npt.NDArray[np.float64]:
        found = matrices_of("matrix", matrix)
        maps = 1 if found.ndim == 2 else len(found)
        if len(self.tiles) not in (1, maps):
            raise ArgumentError(
                f"tile: expected one, or as many as maps ({maps}), got {len(self.tiles)}; give each map its tile"
            )
        return found
