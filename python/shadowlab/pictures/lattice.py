"""The texel lattice on the receivers of the eye view, as a picture: every k-th line of texels, in its map's colour.

A line is drawn where it lies, from the texel coordinates of each pixel: the distance to the nearest line is that in
texels over the gradient of the coordinate, which is the inverse of the footprint's Jacobian. So lines are as wide on
near surfaces as on far ones, end where a surface ends, and no pixel needs its neighbours.

    Jacobian d(pixel) / d(texel) = (t s), t what one texel along x does, s along y
    |grad x| = |s| / area,  |grad y| = |t| / area

No plotting library here; `plot.lattice` puts the picture on axes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .. import aliasing
from ..aliasing.footprint import Footprint
from ..errors import ArgumentError
from ..text import shown
from ..text.checked import a_length, checked, numbers_in, optional
from .eye import shade
from .maps import MAP_RGB

if TYPE_CHECKING:
    import numpy.typing as npt

    from .._core import Camera, GBuffer
    from ..types import Light, Maps, Size

# Pixels between two lines from which on both are drawn, and below which they fade into a flat tint.
APART_PX, MERGED_PX = 6.0, 2.5
# Strength of the tint where lines are too dense to be drawn.
TINT = 0.3
# Lines are darker than the map's colour in other pictures, since they lie on a lighter ground.
DARKER = 0.72
# How far the eye view is lifted towards white.
PALE = 0.45


@checked(width_px=a_length, mask=optional(numbers_in(np.float32, None, None)))
def lattice_picture(
    gbuffer: GBuffer,
    camera: Camera,
    light: Light,
    parameterization: Maps,
    *,
    every: int = 16,
    resolution: Size | None = None,
    mask: npt.ArrayLike | None = None,
    width_px: float = 1.3,
) -> NDArray[np.uint8]:
    """The eye view with every k-th line of texels on its surfaces: (H, W, 3) uint8.

    Parameters
    ----------
    gbuffer, camera, light, parameterization, resolution
        As in `aliasing.footprint`.
    every : int
        Texels from one line to the next.
    mask : (H, W) array_like of float, optional
        Share of the light that arrives, to shade the eye view; all where none is given.
    width_px : float
        Width of the lines, pixels.

    Returns
    -------
    (H, W, 3) uint8
        Each map's lines in its own colour. Where they lie closer than `MERGED_PX` a flat tint stands for them; no line
        is drawn where no texel is looked up.

    Raises
    ------
    ArgumentError
        For arguments of another type or shape, `every` below 1, and a width that is not positive.
    """
    if isinstance(every, bool) or not isinstance(every, (int, np.integer)) or every < 1:
        raise ArgumentError(f"every: expected a whole number of texels, at least 1, got {shown(every)}; try 16")
    if every >= 1 << 53:
        raise ArgumentError(f"every: expected fewer texels than a map has, got {shown(every)}; try 16")
    lengths = aliasing.footprint(gbuffer, camera, light, parameterization, resolution=resolution)
    texel, which = aliasing.texel_coordinates(gbuffer, camera, light, parameterization, resolution=resolution)
    arrives = np.ones(which.shape, np.float32) if mask is None else np.asarray(mask, np.float32)
    if arrives.shape != which.shape:
        raise ArgumentError(
            f"mask: expected shape {which.shape}, the G-buffer's, got {arrives.shape}; render both at one size"
        )
    ground = shade(gbuffer, light, arrives).astype(np.float32)
    ground += PALE * (255.0 - ground)
    covered = coverage(texel, lengths, int(every), float(width_px))[..., None]
    colours = DARKER * np.array(MAP_RGB, np.float32)[np.maximum(which, 0) % len(MAP_RGB)]
    picture: NDArray[np.uint8] = np.rint(ground + covered * (colours - ground)).astype(np.uint8)
    return picture


def coverage(texel: NDArray[np.float64], lengths: Footprint, every: int, width_px: float) -> NDArray[np.float32]:
    """Share (H, W) of each pixel that the lattice's lines cover; 0 where no texel is looked up."""
    measured = np.asarray(lengths.measured)
    open_ = np.ones(texel.shape[:2])
    for axis, across in ((0, lengths.m_s), (1, lengths.m_t)):
        # Pixels from one texel's line to the next. A surface seen edge on has no width: its lines merge.
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            step = np.asarray(lengths.area, np.float64) / across
        step = np.where(measured & np.isfinite(step), step, 0.0)
        place = np.where(measured, texel[..., axis], 0.0) / every
        distance = np.abs(place - np.rint(place)) * every * step
        drawn = np.clip(0.5 + 0.5 * width_px - distance, 0.0, min(1.0, width_px))
        clear = np.clip((every * step - MERGED_PX) / (APART_PX - MERGED_PX), 0.0, 1.0)
        open_ *= 1.0 - (clear * drawn + (1.0 - clear) * (1.0 - np.sqrt(1.0 - TINT)))
    covered: NDArray[np.float32] = np.where(measured, 1.0 - open_, 0.0).astype(np.float32)
    return covered
