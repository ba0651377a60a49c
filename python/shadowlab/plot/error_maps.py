"""The error of every pixel on axes, with its scale."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..aliasing.footprints import AVERTED, NO_MAP, Footprint
from ..error_pictures import BEST_PX, GREYS, SCALE, TICKS, WORDS, WORST_PX, error_picture, middle_grey, rgb
from .axes import _picture, legend_below

HATCHES = {NO_MAP: "\\\\\\\\", AVERTED: "/////"}


def error_map(
    footprint: Footprint,
    ax: Any = None,
    *,
    values: Any = None,
    title: str = "",
    aspect: float | None = None,
    gbuffer: Any = None,
    light: Any = None,
    colorbar: bool = True,
    label: str = "longest extent of a texel, pixels per texel",
) -> Any:
    """Axes with the error of every pixel: pale blue below 1 pixel a texel, green at 1, dark red from 10 on.

    The colours are those of Lloyd et al. [lloyd2008] with lightness that falls all the way; see `error_pictures`. Pixels
    without a texel are grey, and a legend says why for each reason that occurs.

    Parameters
    ----------
    footprint : Footprint
        Of an image.
    ax : matplotlib axes, optional
        Made where none are given.
    values : (H, W) array_like, optional
        Errors to draw, pixels per texel; ``footprint.major`` where none are given.
    title : str
    aspect : float, optional
        Of the camera; square pixels where none is given.
    gbuffer, light : optional
        Both: a pale eye view in the pixels without a texel.
    colorbar : bool
        Whether the scale is drawn beside the picture.
    label : str
        What the scale says.

    Returns
    -------
    matplotlib axes

    Raises
    ------
    ArgumentError
        For a footprint of points, values of another shape or that are no errors, and a G-buffer without a light.

    Examples
    --------
    >>> import shadowlab as sl
    >>> s = sl.library.scene("robots")
    >>> g = sl.Renderer("cpu").gbuffer(s, s.camera, size=(160, 90))
    >>> p = sl.technique("lispsm").parameterize(s, s.camera, s.light)
    >>> e = sl.aliasing.footprint(g, s.camera, s.light, p)
    >>> ax = sl.plot.error_map(e, gbuffer=g, light=s.light, title="LiSPSM")
    """
    picture = error_picture(footprint, values=values, gbuffer=gbuffer, light=light)
    ax = _picture(ax, picture, title, aspect or picture.shape[1] / picture.shape[0])
    if colorbar:
        _scale(ax, label)
    _explain_greys(ax, footprint.map)
    return ax


def _scale(ax: Any, label: str) -> None:
    """The scale to the right of axes."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, LogNorm
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    colours = ListedColormap(SCALE / 255.0, name="error")
    mappable = ScalarMappable(LogNorm(BEST_PX, WORST_PX), colours)
    bar = ax.figure.colorbar(mappable, ax=ax, extend="both", label=label, fraction=0.05, pad=0.02, aspect=22)
    bar.ax.yaxis.set_major_locator(FixedLocator(list(TICKS)))
    bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
    bar.ax.yaxis.set_minor_locator(NullLocator())
    bar.ax.axhline(1.0, color="#333333", linewidth=1.2)


def _explain_greys(ax: Any, codes: Any) -> None:
    """A legend below the picture of why pixels have no error."""
    from matplotlib.patches import Patch

    present = [code for code in GREYS if (np.asarray(codes) == code).any()]
    if not present:
        return
    patches = []
    for code in present:
        grey, hatch = middle_grey(code), GREYS[code][2]
        face, edge = rgb((grey,) * 3), rgb((grey - hatch - 40,) * 3)
        patches.append(Patch(facecolor=face, edgecolor=edge, hatch=HATCHES.get(code), label=WORDS[code], linewidth=0.5))
    legend_below(ax, patches, ncols=len(present), handlelength=1.6)
