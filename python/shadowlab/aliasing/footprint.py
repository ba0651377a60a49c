"""What a texel of the shadow map looks like in the image, at every pixel.

Source: theory.md E.2, (E.5) and (E.6); after the error m of Lloyd, Govindaraju, Quammen, Molnar, Manocha 2008
[lloyd2008], and the Jacobian of Chong and Gortler 2007 [chong2007]. See `Footprint` for what each number means.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..conventions.doubts import doubt_about
from ..errors import ArgumentError, ShadowlabWarning
from ..text import reason_of, shown
from ..text.arrays import checked_array
from ..text.checked import A_PARAMETERIZATION, checked
from ..text.checks import check_camera, check_light, pair, whole
from ..travel import Value
from .codes import NoTexel
from .extent import UNDERSAMPLED_FROM_PX, largest_extent
from .summary import Summary

if TYPE_CHECKING:
    import numpy.typing as npt

    from ..types import Floats, Light, Maps, Size

# Codes of `Footprint.map` below 0, and what they mean.
NO_MAP, AVERTED, NOTHING = NoTexel
UNMEASURED = {
    NO_MAP: "held by no map",
    AVERTED: "facing away from the light, or beyond its cone or range",
    NOTHING: "showing nothing",
}


@dataclass(frozen=True, eq=False, repr=False)
class Footprint(Value):
    """The footprint of a texel at each pixel: how large a texel of the shadow map is in the image.

    Arrays are NaN where `map` is negative: nothing is looked up there, so there is no texel. Shapes are (H, W) of an
    image or (N,) of points; float32 of images, float64 of points.

    Attributes
    ----------
    major : (H, W) float
        Longest extent of a texel in the image, pixels: the larger singular value of the Jacobian. Above 1 texels show
        as stairs: the pixel is undersampled.
    perspective : (H, W) float
        Area of a texel by perspective alone, square pixels: on a surface that halves the angle between eye and light,
        whose slope adds nothing. A better parameterization can lower it.
    perspective_ts : (H, W, 2) float
        Lengths of one texel along the map's x (t) and y (s) on that surface, pixels.
    projection : (H, W) float
        What the slope of the surface adds: cos(normal, eye) / cos(normal, light). No parameterization can lower it.
    jacobian : (H, W, 2, 2) float
        d(pixel) / d(texel): column 0 is what one texel along the map's x does to pixel x (right) and y (down), column
        1 what one texel along its y (down) does.
    map : (H, W) int16
        The map that serves the pixel; -1 where no map holds it (it is lit then), -2 where it faces away from the
        light or is beyond its reach, -3 where nothing is seen: `NoTexel`.
    depth : (H, W) float
        Depth along the view, world units.
    resolution : (int, int)
        Width and height of each map, texels.
    size : (int, int)
        Width and height of the image, pixels.
    maps : int
        How many maps there are.

    References
    ----------
    Lloyd, Govindaraju, Quammen, Molnar, Manocha 2008 [lloyd2008] (error m, up to its norm).
    Chong, Gortler 2007 [chong2007] (the Jacobian of a map and a camera on a surface).
    """

    jacobian: Floats
    major: Floats
    perspective: Floats
    perspective_ts: Floats
    projection: Floats
    map: NDArray[np.int16]
    depth: Floats
    resolution: tuple[int, int]
    size: tuple[int, int]
    maps: int

    @classmethod
    @checked(parameterization=A_PARAMETERIZATION)
    def of_arrays(
        cls,
        arrays: Mapping[str, NDArray[Any]],
        parameterization: _core.Parameterization,
        resolution: tuple[int, int],
        depth: Floats | None = None,
        size: tuple[int, int] | None = None,
    ) -> Footprint:
        """One of the core's arrays; the depth comes with those of images."""
        try:
            planes, which = (np.asarray(arrays[name]) for name in ("planes", "map"))
            if planes.shape[1:] != which.shape or len(planes) < (9 if depth is not None else 10):
                raise ValueError(f"shapes {planes.shape} and {which.shape}")
        except Exception as error:  # noqa: BLE001 - what callers give may raise whatever it likes
            raise ArgumentError(
                f"arrays: expected planes and map of the core, got {shown(arrays)} ({reason_of(error)}); "
                "sl.aliasing.footprint(...) makes a Footprint"
            ) from None
        jacobian = np.moveaxis(planes[:4].reshape(2, 2, *which.shape), (0, 1), (-2, -1))
        return cls(
            jacobian,
            planes[4],
            planes[5],
            np.moveaxis(planes[6:8], 0, -1),
            planes[8],
            which,
            depth=planes[9] if depth is None else depth,
            resolution=sides_of("resolution", resolution),
            size=cast("tuple[int, int]", which.shape[::-1]) if size is None else sides_of("size", size),
            maps=len(parameterization.partitions),
        )

    @property
    def measured(self) -> NDArray[np.bool_]:
        """(H, W) bool: where a texel is looked up."""
        return np.greater_equal(self.map, 0)

    @property
    def undersampled(self) -> NDArray[np.bool_]:
        """(H, W) bool: where a texel is longer than a pixel."""
        return np.greater(self.major, UNDERSAMPLED_FROM_PX)  # NaN is not greater

    @cached_property
    def area(self) -> Floats:
        """(H, W): area of a texel in the image, square pixels: perspective times projection."""
        return np.multiply(self.perspective, self.projection)

    @cached_property
    def minor(self) -> Floats:
        """(H, W): extent of a texel across its longest, pixels: the smaller singular value of the Jacobian."""
        return np.divide(self.area, self.major)

    @cached_property
    def perspective_major(self) -> Floats:
        """(H, W): `major` by perspective alone, pixels."""
        return largest_extent(self.perspective_ts, self.perspective)

    @cached_property
    def texels_per_pixel(self) -> Floats:
        """(H, W): texels in the area of a pixel; many are waste, less than one too few. Infinite seen edge on."""
        with np.errstate(divide="ignore"):
            return np.reciprocal(self.area)

    @cached_property
    def m_s(self) -> Floats:
        """(H, W): length in the image of one texel along the map's y, the axis of warps; pixels."""
        return np.hypot(self.jacobian[..., 0, 1], self.jacobian[..., 1, 1])

    @cached_property
    def m_t(self) -> Floats:
        """(H, W): length in the image of one texel along the map's x, across the axis of warps; pixels."""
        return np.hypot(self.jacobian[..., 0, 0], self.jacobian[..., 1, 0])

    @cached_property
    def direction(self) -> Floats:
        """(H, W, 2): unit direction in the image (x right, y down) in which a texel is longest; either sign."""
        return self._principal(np.matmul(self.jacobian, np.swapaxes(self.jacobian, -1, -2)))

    @cached_property
    def texel_direction(self) -> Floats:
        """(H, W, 2): unit direction in the map (x right, y down) that becomes the longest; either sign."""
        return self._principal(np.matmul(np.swapaxes(self.jacobian, -1, -2), self.jacobian))

    @staticmethod
    def _principal(squares: Floats) -> Floats:
        """The eigenvector of the larger eigenvalue of symmetric 2 x 2 matrices."""
        angle = 0.5 * np.arctan2(2 * squares[..., 0, 1], squares[..., 0, 0] - squares[..., 1, 1])
        return np.stack([np.cos(angle), np.sin(angle)], axis=-1)

    def summary(self, *, bands: int | npt.ArrayLike = 6) -> Summary:
        """The numbers of the whole image, and of bands of camera depth.

        Parameters
        ----------
        bands : int or (B + 1,) array_like
            How many bands, even in the logarithm of depth between the nearest and the farthest measured pixel; or their
            limits, world units, rising.

        Returns
        -------
        Summary
            Empty, and saying so, where nothing is measured.

        Raises
        ------
        ArgumentError
            For less than one band, or limits that do not rise.
        """
        return Summary.of(self, bands)

    def counts(self) -> dict[str, int]:
        """Pixels by what is known of them: measured, and why the others are not."""
        return {
            "measured": int(np.count_nonzero(self.map >= 0)),
            **{why: int(np.count_nonzero(self.map == code)) for code, why in UNMEASURED.items()},
        }

    def __repr__(self) -> str:
        counts = self.counts()
        of = " x ".join(map(str, self.size))
        head = f"Footprint({of}, maps={self.maps}, resolution={self.resolution[0]} x {self.resolution[1]}"
        if counts["measured"] == 0:
            return f"{head}, nothing measured)"
        major = self.major[self.measured]
        median, p95 = np.percentile(major, (50, 95))
        share = np.count_nonzero(self.undersampled) / counts["measured"]
        return (
            f"{head}, measured={counts['measured']}, median={median:.4g} px, p95={p95:.4g} px, "
            f"max={major.max():.4g} px, undersampled={share:.1%})"
        )

    def _repr_html_(self) -> str:
        return f"<p>{escape(repr(self))}</p>{self.summary()._repr_html_()}"


def footprint(
    gbuffer: _core.GBuffer,
    camera: _core.Camera,
    light: Light,
    parameterization: Maps,
    *,
    resolution: Size | None = None,
) -> Footprint:
    """The size of a shadow texel in the image, at every pixel that looks one up.

    Parameters
    ----------
    gbuffer : GBuffer
        What the camera sees: positions and true normals.
    camera : Camera
        The one it was rendered with.
    light : DirectionalLight, SpotLight or PointLight
    parameterization : Parameterization, or (4, 4) or (K, 4, 4) array_like
        Of a technique, or somebody's own matrices.
    resolution : int or (int, int), optional
        Texels of each map: a side, or width and height. The parameterization's own where none is given.

    Returns
    -------
    Footprint

    Raises
    ------
    ArgumentError
        For arguments of another type, and matrices that are not finite.

    Warns
    -----
    ShadowlabWarning
        Where somebody's own matrices are no map of this light on what is seen: their texels mean little then.

    Examples
    --------
    >>> import shadowlab as sl
    >>> scene = sl.library.scene("robots")
    >>> g = sl.Renderer("cpu").gbuffer(scene, scene.camera, size=(320, 180))
    >>> p = sl.technique("lispsm").parameterize(scene, scene.camera, scene.light, resolution=512)
    >>> e = sl.aliasing.footprint(g, scene.camera, scene.light, p)
    >>> e.major.shape
    (180, 320)
    """
    found = footprint_of(gbuffer, camera, light, parameterization, resolution)
    p, _ = as_maps(parameterization, resolution)
    if p.technique == "matrix":
        doubt = doubt_about(p.matrices, light, gbuffer, p.partitions)
        if doubt is not None:
            warnings.warn(str(doubt), ShadowlabWarning, stacklevel=2)
    return found


def footprint_of(
    gbuffer: _core.GBuffer, camera: _core.Camera, light: Light, parameterization: Maps, resolution: Size | None = None
) -> Footprint:
    """The same without a word about matrices, for those who have said it."""
    arrays = _core.footprint(gbuffer, camera, light, parameterization, resolution=resolution)
    p, texels = as_maps(parameterization, resolution)
    return Footprint.of_arrays(arrays, p, texels)


def footprint_at(
    points: npt.ArrayLike,
    normals: npt.ArrayLike,
    camera: _core.Camera,
    light: Light,
    parameterization: Maps,
    *,
    size: Size,
    resolution: Size | None = None,
) -> Footprint:
    """The size of a shadow texel in the image at points of surfaces, in double precision.

    Parameters
    ----------
    points : (N, 3) array_like
        World positions.
    normals : (N, 3) array_like
        Normals of any length, on the side that the eye sees. ``halfway_normals`` gives those on which perspective
        acts alone.
    camera, light, parameterization, resolution
        As in `footprint`.
    size : int or (int, int)
        Pixels of the image: a side, or width and height.

    Returns
    -------
    Footprint
        With arrays (N,) float64. A point behind the eye of a perspective camera shows nothing.

    Raises
    ------
    ArgumentError
        For arguments of another type or shape, and numbers that are not finite.
    """
    arrays = _core.footprint_at(points, normals, camera, light, parameterization, size=size, resolution=resolution)
    p, texels = as_maps(parameterization, resolution)
    depth = (checked_array("points", points) - np.asarray(camera.eye)) @ np.asarray(camera.forward)
    return Footprint.of_arrays(arrays, p, texels, depth, sides_of("size", size))


def halfway_normals(points: npt.ArrayLike, camera: _core.Camera, light: Light) -> NDArray[np.float64]:
    """Unit normals (N, 3) that halve the angle between the ways to eye and light: R(N) of (E.6) is an isometry there.

    Parameters
    ----------
    points : (N, 3) array_like
        World positions.
    camera : Camera
    light : DirectionalLight, SpotLight or PointLight

    Raises
    ------
    ArgumentError
        For points at the eye or the light, which have no way there, or between both, where no plane faces either.
    """
    check_camera(camera)
    check_light(light)
    points = checked_array("points", points, shape=(None, 3))
    light_point = np.asarray(light.point)
    to_eye = np.asarray(camera.eye) - points
    if camera.is_orthographic:
        to_eye = np.broadcast_to(-np.asarray(camera.forward), points.shape)
    ways = (to_eye, light_point[:3] - light_point[3] * points)
    lengths = [np.linalg.norm(way, axis=-1, keepdims=True) for way in ways]
    if any((length == 0).any() for length in lengths):
        raise ArgumentError("points: expected points away from eye and light, got one there; leave it out")
    h = sum(way / length for way, length in zip(ways, lengths, strict=True))
    size = np.linalg.norm(h, axis=-1, keepdims=True)
    if (size < np.sqrt(np.finfo(np.float64).eps)).any():
        raise ArgumentError(
            "points: expected none between eye and light, where every plane is seen edge on, got one; leave it out"
        )
    normals: NDArray[np.float64] = h / size
    return normals


def as_maps(parameterization: Maps, resolution: Size | None) -> tuple[_core.Parameterization, tuple[int, int]]:
    """The parameterization that is meant, and width and height of its maps."""
    p = parameterization
    if not isinstance(p, _core.Parameterization):
        matrices = checked_array("parameterization", p)
        try:
            p = _core.Parameterization.from_matrix(matrices)
        except ArgumentError as e:
            raise ArgumentError(f"parameterization: {e}") from e
    return p, sides_of("resolution", p.resolution if resolution is None else resolution)


def sides_of(name: str, sides: Size) -> tuple[int, int]:
    """Width and height of a side or a pair, checked."""
    given: object = sides
    if isinstance(given, np.ndarray) and given.ndim == 0:
        given = given[()]
    width, height = (given, given) if isinstance(given, (int, np.integer)) else pair(name, given)
    return whole(name, width), whole(name, height)
