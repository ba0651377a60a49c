"""What the eye sees on axes: the error of every pixel with its scale, and the texel lattice on the receivers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..aliasing.footprint import AVERTED, NO_MAP, Footprint
from ..pictures.errors import BEST_PX, GREYS, SCALE, TICKS, WORDS, WORST_PX, error_picture, middle_grey, rgb
from ..pictures.lattice import DARKER, lattice_picture
from ..pictures.maps import map_colour
from ..text.checked import a_flag, a_text, checked
from .arguments import an_aspect
from .axes import MOST_NAMED, _picture, legend_below

if TYPE_CHECKING:
    import numpy.typing as npt
    from matplotlib.axes import Axes

    from .._core import Camera, GBuffer
    from ..types import Light, Maps, Size

GREY_HATCHES: dict[int, str] = {NO_MAP: "\\\\\\\\", AVERTED: "/////"}


@checked(title=a_text, aspect=an_aspect, colorbar=a_flag, label=a_text)
def error_map(
    footprint: Footprint,
    ax: Axes | None = None,
    *,
    values: npt.ArrayLike | None = None,
    title: str = "",
    aspect: float | None = None,
    gbuffer: GBuffer | None = None,
    light: Light | None = None,
    colorbar: bool = True,
    label: str = "longest extent of a texel, pixels per texel",
) -> Axes:
    """Axes with the error of every pixel: pale blue below 1 pixel a texel, green at 1, dark red from 10 on.

    The colours are those of Lloyd et al. [lloyd2008] with lightness that falls all the way; see `pictures.errors`.
    Pixels without a texel are grey, and a legend says why for each reason that occurs.

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
        _colour_bar(ax, label)
    _explain_greys(ax, footprint.map)
    return ax


def _colour_bar(ax: Axes, label: str) -> None:
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


def _explain_greys(ax: Axes, codes: npt.ArrayLike) -> None:
    """A legend below the picture of why pixels have no error."""
    from matplotlib.patches import Patch

    present = [code for code in GREYS if (np.asarray(codes) == code).any()]
    if not present:
        return
    patches = []
    for code in present:
        grey, hatch = middle_grey(code), GREYS[code][2]
        face, edge = rgb((grey,) * 3), rgb((grey - hatch - 40,) * 3)
        patches.append(
            Patch(facecolor=face, edgecolor=edge, hatch=GREY_HATCHES.get(code), label=WORDS[code], linewidth=0.5)
        )
    legend_below(ax, patches, ncols=len(present), handlelength=1.6)


@checked(title=a_text, aspect=an_aspect)
def lattice(
    gbuffer: GBuffer,
    camera: Camera,
    light: Light,
    parameterization: Maps,
    ax: Axes | None = None,
    *,
    every: int = 16,
    resolution: Size | None = None,
    mask: npt.ArrayLike | None = None,
    width_px: float = 1.3,
    title: str = "",
    aspect: float | None = None,
) -> Axes:
    """Axes with the eye view and every k-th line of texels on its surfaces, in the colour of the map they belong to.

    Parameters
    ----------
    gbuffer, camera, light, parameterization, resolution
        As in `aliasing.footprint`.
    ax : matplotlib axes, optional
        Made where none are given.
    every : int
        Texels from one line to the next.
    mask : (H, W) array_like of float, optional
        Share of the light that arrives, to shade the eye view; all where none is given.
    width_px : float
        Width of the lines, pixels of the image.
    title : str
    aspect : float, optional
        Of the camera; square pixels where none is given.

    Returns
    -------
    matplotlib axes
        A legend below says how many texels lie between two lines, and whose lines they are if there are several maps.

    Raises
    ------
    ArgumentError
        For arguments of another type or shape, `every` below 1, and a width that is not positive.

    Examples
    --------
    >>> import shadowlab as sl
    >>> s = sl.library.scene("robots")
    >>> g = sl.Renderer("cpu").gbuffer(s, s.camera, size=(160, 90))
    >>> p = sl.technique("lispsm").parameterize(s, s.camera, s.light)
    >>> ax = sl.plot.lattice(g, s.camera, s.light, p, every=32)
    """
    from matplotlib.lines import Line2D

    picture = lattice_picture(
        gbuffer, camera, light, parameterization, every=every, resolution=resolution, mask=mask, width_px=width_px
    )
    ax = _picture(ax, picture, title, aspect or picture.shape[1] / picture.shape[0])
    maps = len(getattr(parameterization, "partitions", [None]))
    step = "a line every texel" if every == 1 else f"a line every {every} texels"
    labels = [step] if maps == 1 else [f"map {i}" for i in range(min(maps, MOST_NAMED))]
    handles = [
        Line2D([], [], color=rgb([DARKER * c for c in map_colour(i)]), linewidth=1.8, label=label)
        for i, label in enumerate(labels)
    ]
    legend_below(ax, handles, ncols=4, title=None if maps == 1 else step, title_fontsize="small")
    return ax
