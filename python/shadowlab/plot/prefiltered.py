"""Prefiltered formats side by side: where each is wrong, and where it leaks."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .._core import misclassified
from ..errors import ArgumentError
from ..experiments.prefiltered import PrefilteredMaps
from ..pictures.eye import FALSE_LIGHT_RGB, FALSE_SHADOW_RGB, difference, widened
from ..scene.view import light_of
from ..text import shown
from .axes import _picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Of [okabe2008], apart from the colours of false shadow and false light for all kinds of colour vision.
LEAK_RGB = (240, 228, 66)
FORMATS_IN_A_ROW, WIDTH_INCHES, HEADING_INCHES, KEY_INCHES = 3, 13.0, 0.55, 0.4
# A picture of the figure is about 400 pixels wide on a screen; single pixels of a larger one would fade.
PICTURE_PX = 400


def prefiltered_figure(found: PrefilteredMaps) -> Figure:
    """A figure with a picture per format: false shadow, false light, and in a third colour the leaks among it.

    Parameters
    ----------
    found : PrefilteredMaps
        As `sl.prefiltered_maps` returns it.

    Returns
    -------
    matplotlib figure

    Raises
    ------
    ArgumentError
        For something else than a `PrefilteredMaps`.

    Examples
    --------
    >>> import shadowlab as sl
    >>> scene = sl.library.scene("robots")
    >>> view = sl.View(scene, scene.camera, scene.light, size=(160, 90))
    >>> formats = ("depth:pcf", "variance:unorm16")
    >>> found = sl.prefiltered_maps(view, memory="64 KiB", formats=formats, renderer="cpu", progress=False)
    >>> figure = sl.plot.prefiltered_figure(found)
    """
    if not isinstance(found, PrefilteredMaps):
        raise ArgumentError(
            f"found: expected a PrefilteredMaps, got {shown(found)}; sl.prefiltered_maps(...) makes one"
        )
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    view, light = found.view, light_of(found.view)
    gbuffer, truth, aspect = view.gbuffer(), view.truth(), view.camera.aspect
    columns = min(FORMATS_IN_A_ROW, len(found.table))
    rows = math.ceil(len(found.table) / columns)
    height = rows * (WIDTH_INCHES / FORMATS_IN_A_ROW / aspect + HEADING_INCHES) + KEY_INCHES
    figure = Figure(figsize=(WIDTH_INCHES * columns / FORMATS_IN_A_ROW, height), layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    for ax in grid[len(found.table) :]:
        ax.set_axis_off()
    width = max(1, round(max(view.size) / PICTURE_PX))
    for ax, row, mask, leaking in zip(grid, found.table.itertuples(), found.masks, found.leaking, strict=False):
        picture = difference(gbuffer, light, truth, np.asarray(misclassified(mask, truth).image), width=width)
        picture[widened(leaking, width)] = LEAK_RGB
        title = f"{row.format}, {row.resolution}²\n{row.misclassified:,} wrong, {row.leaks:,} of them leaks"
        _picture(ax, picture, title, aspect)
    kinds = ((FALSE_SHADOW_RGB, "false shadow"), (FALSE_LIGHT_RGB, "false light"), (LEAK_RGB, "leak"))
    patches = [
        Patch(facecolor="#{:02X}{:02X}{:02X}".format(*rgb), edgecolor="#555555", label=words) for rgb, words in kinds
    ]
    figure.legend(handles=patches, loc="outside lower center", ncols=3, frameon=False)
    return figure
