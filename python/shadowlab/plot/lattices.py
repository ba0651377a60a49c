"""The texel lattice on the receivers, as the eye sees it."""

from __future__ import annotations

from typing import Any

from ..error_pictures import rgb
from ..lattice_pictures import DARKER, lattice_picture
from ..map_pictures import map_colour
from .axes import MOST_NAMED, _picture, legend_below


def lattice(
    gbuffer: Any,
    camera: Any,
    light: Any,
    parameterization: Any,
    ax: Any = None,
    *,
    every: int = 16,
    resolution: Any = None,
    mask: Any = None,
    width_px: float = 1.3,
    title: str = "",
    aspect: float | None = None,
) -> Any:
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

    shown = {"every": every, "resolution": resolution, "mask": mask, "width_px": width_px}
    picture = lattice_picture(gbuffer, camera, light, parameterization, **shown)
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
