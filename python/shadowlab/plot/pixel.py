r"""An explained pixel in three views: the picture around it, the map around its texel, and a cut along the light's ray.

eye view                 the map                    cut through the receiver, along its normal and the ray
+-----------+            +-----------+                   \      \ stored
|   [pixel] |            | [] [] []  |              ------\------x------- reference depth
|  /texel/  |            | [] [x] [] |                     o bias \
+-----------+            +-----------+              ________\______\_____ receiver's plane
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core, pictures
from ..aliasing.codes import Difference
from ..errors import ArgumentError
from ..experiments.pixel_explanation import PixelExplanation
from ..experiments.run import done
from ..text import shown
from .axes import say
from .pixel_cut import CUT_BLOCKER, CUT_FIRST, CUT_PIXEL, CUT_STORED, CUT_TEXEL, cut_view

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from ..aliasing.pixel_surface import Met, PixelSurface

CASING: dict[str, Any] = {"color": "white", "linewidth": 4.0, "solid_joinstyle": "miter"}
# Pixels and texels around: at least and at most, each way.
LEAST_PX, MOST_PX = 8, 60
TEXELS_AROUND = 9
SIZE_INCHES, LEGENDS = (13.5, 5.6), 0.1


def pixel_figure(explanation: PixelExplanation) -> Figure:
    """A figure of an explained pixel: the eye view and the map around it, and a cut along the light's ray.

    Parameters
    ----------
    explanation : PixelExplanation
        From `sl.explain_pixel`.

    Returns
    -------
    matplotlib figure
        Left the picture as the map draws it, with wrong pixels dotted, the pixel and the outline of its texel. In the
        middle the map around the texel, with the triangles of receiver, blocker, and of what is stored: of depths
        between two surfaces both. Right a cut in the plane of the receiver's normal and the ray, with stored depth,
        what light meets before that, reference depth and bias as lengths.

    Raises
    ------
    ArgumentError
        For anything else.

    Examples
    --------
    >>> import shadowlab as sl
    >>> scene = sl.library.scene("robots")
    >>> view = sl.View(scene, scene.camera, scene.light, size=(160, 90))
    >>> found = sl.explain_pixel(view, "uniform", 80, 60, resolution=64, renderer="cpu", trials=False)
    >>> figure = sl.plot.pixel_figure(found)
    """
    if not isinstance(explanation, PixelExplanation):
        raise ArgumentError(
            f"explanation: expected a PixelExplanation, got {shown(explanation)}; sl.explain_pixel(...) makes one"
        )
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    # Room for the legends below.
    figure = Figure(figsize=SIZE_INCHES, layout=ConstrainedLayoutEngine(rect=(0.0, LEGENDS, 1.0, 1.0 - LEGENDS)))
    eye, light, cut = figure.subplots(1, 3, width_ratios=(1.0, 1.0, 1.25))
    figure.suptitle(headline(explanation), fontsize="medium", x=0.01, ha="left")
    eye_crop(explanation, eye)
    map_crop(explanation, light)
    cut_view(explanation, cut)
    return figure


def headline(found: PixelExplanation) -> str:
    """The pixel, what is wrong with it, and its cause."""
    what = found.verdict if found.cause is None else f"{found.verdict}, cause: {found.cause}"
    stored = found.run.stored
    said = "" if stored == _core.Stored() or "stored=" in found.technique else f", {stored} stored"
    return f"pixel ({found.x}, {found.y}), {found.technique} at {found.run.resolution}²{said}: {what}"


def eye_crop(found: PixelExplanation, ax: Axes) -> Axes:
    """The picture around the pixel on axes, with the outline of its texel."""
    from matplotlib.ticker import MaxNLocator

    run, view = found.run, found.run.view
    width, height = view.size
    corners = None if found.texel is None else found.texel.corners_px
    middle = np.array([found.x + 0.5, found.y + 0.5])
    reach = 0.0 if corners is None else float(np.abs(corners - middle).max())
    around = int(min(max(math.ceil(1.25 * reach) + 1, LEAST_PX), MOST_PX))
    x0, x1 = max(0, found.x - around), min(width, found.x + around + 1)
    y0, y1 = max(0, found.y - around), min(height, found.y + around + 1)
    part = done(run.gbuffer).crop(x0, y0, x1 - x0, y1 - y0)
    mask = np.asarray(done(run.mask))[y0:y1, x0:x1]
    picture = pictures.shade(part, view.lights[0], mask)
    ax.imshow(picture, extent=(x0, x1, y1, y0), interpolation="nearest")
    wrong = np.asarray(done(run.errors).image)[y0:y1, x0:x1]
    marks = {Difference.FALSE_SHADOW: pictures.FALSE_SHADOW_RGB, Difference.FALSE_LIGHT: pictures.FALSE_LIGHT_RGB}
    for code, rgb in marks.items():
        rows, columns = np.nonzero(wrong == code)
        name = code.name.lower().replace("_", " ")
        if len(rows):
            ax.plot(
                columns + x0 + 0.5, rows + y0 + 0.5, ".", color=np.array(rgb) / 255, label=name,
                markersize=max(2.0, 60.0 / around),
            )  # fmt: skip
    outlined(ax, middle + 0.5 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]), CUT_PIXEL, "the pixel")
    if corners is not None:
        outlined(ax, corners, CUT_TEXEL, "its texel")
    ax.set(xlim=(x0, x1), ylim=(y1, y0), title="eye view, as the map draws it", xlabel="pixels")
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(MaxNLocator(6, integer=True))
    legend_under(ax)
    return ax


def map_crop(found: PixelExplanation, ax: Axes) -> Axes:
    """The map around the texel on axes, with the triangles of receiver, stored surface and blocker."""
    ax.set(title="the map around the texel", xticks=[], yticks=[])
    texel, chain = found.texel, found.chain
    if texel is None or chain is None or found.map is None:
        say(ax, "no map is asked")
        return ax
    maps = np.asarray(done(found.run.maps))
    layer = maps if maps.ndim == 2 else maps[found.map]
    height, width = layer.shape
    x0, x1 = max(0, texel.column - TEXELS_AROUND), min(width, texel.column + TEXELS_AROUND + 1)
    y0, y1 = max(0, texel.row - TEXELS_AROUND), min(height, texel.row + TEXELS_AROUND + 1)
    ax.imshow(pictures.relief(layer[y0:y1, x0:x1]), extent=(x0, x1, y1, y0), interpolation="nearest")
    scene = found.run.view.scene
    named: list[tuple[str, str, PixelSurface | Met | None, Any]] = [
        (CUT_PIXEL, "receiver", found.surface, "-"),
        *stored_triangles(found),
        (CUT_BLOCKER, "blocker", found.blocker, (0, (4, 2))),
    ]
    for colour, name, which, line in named:
        corners = None if which is None else _core.face_corners(scene, which.instance, which.triangle)
        places = triangle_in_map(found, corners)
        if places is not None:
            ring = np.vstack([places, places[:1]])
            ax.plot(*ring.T, color="white", linewidth=3.0, alpha=0.8)
            ax.plot(*ring.T, color=colour, linewidth=1.6, linestyle=line, label=f"{name}'s triangle")
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) + np.array([texel.column, texel.row])
    outlined(ax, square, CUT_TEXEL, "the texel")
    ax.plot(*chain.place, "o", color=CUT_PIXEL, markeredgecolor="white", markersize=6, label="the pixel's point")
    ax.plot(texel.column + 0.5, texel.row + 0.5, "+", color=CUT_TEXEL, markersize=9, markeredgewidth=2)
    ax.set(xlim=(x0, x1), ylim=(y1, y0), xlabel=f"texels of {'the map' if found.maps == 1 else f'map {found.map + 1}'}")
    ax.set_xticks([x0, texel.column, x1])
    ax.set_yticks([y0, texel.row, y1])
    legend_under(ax)
    return ax


def stored_triangles(found: PixelExplanation) -> list[tuple[str, str, Met, Any]]:
    """The triangles that the texel's depth comes from, and the one that the light meets before them, if any."""
    held = found.held
    if held is None:
        return []
    lines = ("-", (0, (1, 1)))
    names = ("stored surface",) if len(held.surfaces) < 2 else ("first surface", "second surface")
    made = [(CUT_STORED, name, met, line) for name, met, line in zip(names, held.surfaces, lines, strict=False)]
    own = [(met.instance, met.triangle) for met in held.surfaces]
    if held.first is not None and (held.first.instance, held.first.triangle) not in own:
        made.append((CUT_FIRST, "first surface", held.first, (0, (1, 1))))
    return made


def triangle_in_map(found: PixelExplanation, corners: NDArray[np.float64] | None) -> NDArray[np.float64] | None:
    """Places (3, 2) of a triangle's corners in the pixel's map, texels; None where one is not before its centre."""
    if corners is None or found.map is None:
        return None
    part = done(found.run.parameterization).partitions[found.map]
    ndc, w = part.project(corners)
    if not (w > 0).all() or not np.isfinite(ndc).all():
        return None
    made: NDArray[np.float64] = np.column_stack([0.5 + 0.5 * ndc[:, 0], 0.5 - 0.5 * ndc[:, 1]]) * found.run.resolution
    return made


def outlined(ax: Axes, corners: NDArray[np.float64], colour: str, label: str) -> None:
    """A closed outline with a pale casing that shows it on any ground."""
    ring = np.vstack([corners, corners[:2]])
    ax.plot(*ring.T, **CASING)
    ax.plot(*ring.T, color=colour, linewidth=2.0, solid_joinstyle="miter", label=label)


def legend_under(ax: Axes) -> None:
    """The names of what is drawn, below the axes."""
    handles, _ = ax.get_legend_handles_labels()
    ax.legend(
        loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2 if len(handles) < 5 else 3, frameon=False,
        fontsize="small", columnspacing=1.2, handlelength=1.6,
    )  # fmt: skip
