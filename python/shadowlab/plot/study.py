"""Views of one run, the curve and the figure of a study."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .. import pictures
from ..errors import ArgumentError
from ..experiments.run import done
from ..experiments.study import Study
from ..pictures.eye import difference, shade
from ..pictures.maps import chosen_picture, mosaic, pictures_of
from ..text import reason_of, share_text
from ..text.arrays import bounded
from ..text.checked import A_CAMERA, a_gbuffer, a_light, a_text, checked, instance, numbers_in
from .arguments import an_aspect, columns_of
from .axes import MARKERS, SERIES, _axes, _picture

if TYPE_CHECKING:
    from collections.abc import Iterable

    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .._core import Camera, GBuffer
    from ..types import Light

# Letters of a label that fit over a picture of the figure.
WIDEST_TITLE = 40


@checked(gbuffer=a_gbuffer, light=a_light, mask=numbers_in(np.float32, None, None), title=a_text, aspect=an_aspect)
def eye_view(
    gbuffer: GBuffer,
    light: Light,
    mask: np.ndarray,
    ax: Axes | None = None,
    *,
    title: str = "",
    aspect: float | None = None,
) -> Axes:
    """Axes with the eye view under a shadow mask (H, W); square pixels where no `aspect` of the camera is given."""
    picture = shade(gbuffer, light, mask)
    return _picture(ax, picture, title, aspect or picture.shape[1] / picture.shape[0])


@checked(title=a_text, aspect=an_aspect)
def difference_view(
    gbuffer: GBuffer,
    light: Light,
    truth: np.ndarray,
    image: np.ndarray,
    ax: Axes | None = None,
    *,
    title: str = "",
    aspect: float | None = None,
    width: int = 1,
) -> Axes:
    """Axes with the wrong pixels in colour, each drawn `width` pixels wide, over a grey eye view; see `difference`."""
    picture = difference(gbuffer, light, truth, image, width=width)
    return _picture(ax, picture, title, aspect or picture.shape[1] / picture.shape[0])


@checked(gbuffer=a_gbuffer, light=a_light, chosen=numbers_in(np.int64, None, None), title=a_text, aspect=an_aspect)
def chosen_view(
    gbuffer: GBuffer,
    light: Light,
    mask: np.ndarray,
    chosen: np.ndarray,
    ax: Axes | None = None,
    *,
    title: str = "",
    aspect: float | None = None,
) -> Axes:
    """Axes with the eye view in the colours of the maps that its pixels ask; see `Renderer.chosen_map`."""
    picture = chosen_picture(gbuffer, light, mask, chosen)
    return _picture(ax, picture, title, aspect or picture.shape[1] / picture.shape[0])


@checked(depth=numbers_in(np.float32, None, None), title=a_text)
def shadow_map(depth: np.ndarray, ax: Axes | None = None, *, title: str = "") -> Axes:
    """Axes with a shadow map (H, W) as the light sees it, in NDC: x to the right and y up, both from -1 to 1."""
    ax = _axes(ax)
    ax.imshow(
        pictures.relief(pictures.reduced(np.asarray(depth), 1024)), extent=(-1, 1, -1, 1), interpolation="antialiased"
    )
    ax.set(title=title, xticks=[], yticks=[], xlim=(-1, 1), ylim=(-1, 1))
    return ax


@checked(camera=A_CAMERA)
def frustum(
    shadow_clip_from_world: np.ndarray,
    camera: Camera,
    ax: Axes | None = None,
    *,
    depths: Iterable[float] | None = None,
    **style: Any,
) -> Axes:
    """Axes of a shadow map (NDC) with the camera frustum's edges added. `style` goes to matplotlib's LineCollection."""
    from matplotlib.collections import LineCollection

    segments = list(pictures.frustum_segments(shadow_clip_from_world, camera, depths))
    ax = _axes(ax)
    looks: dict[str, Any] = {"colors": [np.array(pictures.FRUSTUM_RGB) / 255], "linewidths": 1.5}
    try:
        looks |= {name: bounded(value) for name, value in style.items()}
        lines = LineCollection(segments, **looks)
        ax.add_collection(lines)
    except Exception as error:  # noqa: BLE001 - matplotlib raises whatever a property of a line raises
        raise ArgumentError(
            f"style: expected what matplotlib's LineCollection takes, got {', '.join(style)} ({reason_of(error)}); "
            'try color="red"'
        ) from None
    return ax


def error_curve(table: pd.DataFrame, ax: Axes | None = None) -> Axes:
    """Axes with the share of wrong pixels over the resolution of the map, both logarithmic, one line a technique."""
    columns_of(table, ["technique", "resolution", "share", "failure"])
    ax = _axes(ax)
    measured = table[(table["failure"] == "") & table["share"].notna()]
    for i, (label, rows) in enumerate(measured.groupby("technique", sort=False)):
        rows = rows.sort_values("resolution")
        ax.plot(rows["resolution"], 100 * rows["share"], marker=MARKERS[i % 6], color=SERIES[i % 6], label=label)
    ax.set(xscale="log", xlabel="texels along each side of the map", ylabel="wrong pixels, % of those compared")
    ax.set_yscale("log" if (measured["share"] > 0).all() and len(measured) else "linear")
    ax.set_xscale("log", base=2)
    ax.set_xticks(
        sorted(measured["resolution"].unique()), [f"{r}" for r in sorted(measured["resolution"].unique())], minor=False
    )
    ax.grid(True, which="major", alpha=0.3)
    ax.spines[["top", "right"]].set_visible(False)
    if len(measured):
        ax.legend(frameon=False)
    return ax


@checked(study=instance(Study, "a Study", "sl.compare makes one"))
def study_figure(study: Study) -> Figure:
    """A figure with a row a run that succeeded: eye view, difference from the truth, map with the camera frustum."""
    import matplotlib.pyplot as plt

    runs = [run for run in study.runs if run.mask is not None]
    several = any(run.chosen is not None for run in runs)
    columns = 2 + (study.truth is not None) + several
    shape = (max(1, len(runs)), columns)
    aspect = study.camera.aspect
    ratios = [aspect] * (columns - 1) + [1.0]  # so that all pictures of a row are equally high
    figure, grid = plt.subplots(
        *shape, figsize=(13.0, 13.5 / sum(ratios) * shape[0]), width_ratios=ratios, layout="constrained", squeeze=False
    )
    for row, run in zip(grid, runs, strict=False):
        name = run.label if len(run.label) <= WIDEST_TITLE else f"{run.label[: WIDEST_TITLE - 13]}…{run.label[-12:]}"
        eye_view(study.gbuffer, study.light, done(run.mask), row[0], title=f"{name}, {run.resolution}²", aspect=aspect)
        if run.errors is not None:
            title = f"{run.errors.count:,} wrong ({share_text(run.errors.fraction)})"
            shown = (study.gbuffer, study.light, done(study.truth), run.errors.image, row[1])
            # A picture of the figure is about 400 pixels wide on a screen; single pixels of a larger one would fade.
            difference_view(*shown, title=title, aspect=aspect, width=max(1, round(max(study.size) / 400)))
        if run.chosen is not None:
            chosen_view(
                study.gbuffer,
                study.light,
                done(run.mask),
                run.chosen,
                row[-2],
                title="the map that is asked",
                aspect=aspect,
            )
        elif several:
            row[-2].set_axis_off()
        p, maps = done(run.parameterization), done(run.maps)
        parts = p.partitions
        if len(parts) == 1 and parts[0].post_warp == "none":
            shadow_map(maps, row[-1], title="from the light")
            frustum(np.asarray(p.matrices)[0], study.camera, row[-1])
        else:
            picture = mosaic(pictures_of(maps, p, study.camera, max(1, 1024 // round(len(parts) ** 0.5))))
            title = "from the light" if len(parts) == 1 else f"{len(parts)} maps from the light"
            _picture(row[-1], picture, title, picture.shape[1] / picture.shape[0])
    if not runs:
        for ax in grid.ravel():
            ax.set_axis_off()
    return figure
