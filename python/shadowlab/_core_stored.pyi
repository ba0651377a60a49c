"""Bias and what a map stores, of `_core`, which exports them."""

from typing import Literal, TypeAlias, final

import numpy as np
import numpy.typing as npt

from ._core_maps import Maps

@final
class Stored:
    """What a shadow map stores: which surface, how its depth is spaced, in which format.

    Parameters
    ----------
    surface : str
        "front": the surface nearest to the light. "back": the nearest that faces away from it, by the winding of its mesh.
        "second": the nearest depth beyond the first. "midpoint": the middle of both along the ray. "dual": the first depth
        moved by half of the way to the second, at most by `limit`. A ray without a second depth stores 1 for "second" and
        "midpoint", and the first depth plus `limit` for "dual". Or the text of all settings, as `str` gives it:
        "back:spacing=linear,format=unorm16".
    spacing : str
        "projective": z / w of the map's matrix. "linear": distance along the light, of a directional light along its own
        direction, of another along the map's central ray; 0 at the nearest and 1 at the farthest corner of the map.
    format : str
        "f32", "f16", "unorm16" or "unorm24"; stored depths are rounded to the nearest number of the format.
    limit : float
        Upper limit of how far "dual" moves the first depth along the ray, world sizes of a shadow texel at the surface, across
        the ray; infinity for none.

    Raises
    ------
    ArgumentError
        A limit that is negative, or a text that does not read.
    UnknownNameError
        No such surface, spacing or format.

    References
    ----------
    theory.md 13. Wang and Molnar 1994 (second depth), Woo 1992 (midpoint), Weiskopf and Ertl 2003 (dual).

    Examples
    --------
    >>> import shadowlab as sl
    >>> sl.Stored("back", format="unorm16")
    Stored('back', spacing='projective', format='unorm16', limit=8.0)
    >>> str(sl.Stored("back:spacing=linear"))
    'back:spacing=linear'
    """
    def __new__(
        cls,
        surface: str = "front",
        *,
        spacing: Literal["projective", "linear"] = "projective",
        format: Literal["f32", "f16", "unorm16", "unorm24"] = "f32",
        limit: float = 8.0,
    ) -> Stored: ...
    @property
    def surface(self) -> Literal["front", "back", "second", "midpoint", "dual"]:
        """Which depth of a ray: "front", "back", "second", "midpoint" or "dual"."""
    @property
    def spacing(self) -> Literal["projective", "linear"]:
        """How depth is spaced: "projective" or "linear"."""
    @property
    def format(self) -> Literal["f32", "f16", "unorm16", "unorm24"]:
        """The numbers that depths are rounded to: "f32", "f16", "unorm16" or "unorm24"."""
    @property
    def limit(self) -> float:
        """Of "dual": how far at most the first depth is moved along the ray, world sizes of a shadow texel."""
    def step(self, parameterization: Maps, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """The size of one step of the format at points, world units along the light ray.

        Parameters
        ----------
        parameterization : Parameterization, or (4, 4) or (K, 4, 4) array_like
        points : (N, 3) array_like
            World points. The first map that holds a point counts.

        Returns
        -------
        (N,) float64
            The distance along the ray over which the stored depth changes by one step of the format.

        Raises
        ------
        ArgumentError
            A point that no map holds, or a map that has no points before its projection centre, where depth is linear.

        References
        ----------
        theory.md (13.10); docs/bias.md has a table.
        """
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

def depth_rows(parameterization: Maps, origin: npt.ArrayLike, stored: StoredLike) -> npt.NDArray[np.float64]:
    """What the numbers of each map measure of points (p, 1) relative to an origin: (K, 2, 4) float64, the rows whose products with a
    point are divided by each other. Of projective depth those are z and w of the matrix.
    """

def depth_steps(stored: StoredLike, depths: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """The distance to the next number of the format at stored depths (N,): (N,) float64."""

StoredLike: TypeAlias = Stored | str | None
