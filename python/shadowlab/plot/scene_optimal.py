"""The figures of the scene-optimized shadow maps: the samples in the eye's view, the search, the world in the best map.

Source: Chong, Gortler 2007 [chong2007], figures 3 to 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from .. import _core
from ..errors import ArgumentError
from ..experiments.evaluate import evaluate
from ..experiments.run import done
from ..experiments.scene_optimal_table import CURVES, NORMAL, OPTIMAL, PUBLISHED, SceneOptimalTable
from ..experiments.scene_optimal_views import paper_views
from ..pictures.samples import SAMPLE_STATES, pale_eye_view, pixels_of
from ..scene.view import View, checked_view, light_of
from ..text import share_text, shown
from ..text.arrays import checked_items
from ..text.checked import A_PARAMETERIZATION, a_count, a_flag, a_text, checked
from ..text.checks import renderer_of
from .axes import _axes, _picture, curve_look, legend_below, legend_beside, level, say, series_style
from .light_views import warped_view

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..types import RendererArgument, TechniqueArgument

# Square points.
SAMPLE_AREA = 3.0
#: Columns of the figure of maps where nobody says: the paper's, left to right.
FIGURE_TECHNIQUES = (NORMAL, "lispsm", PUBLISHED, OPTIMAL)
#: Techniques beside each other in a figure, at which names still fit.
MOST_COLUMNS = 12
# Above and below the pictures of a row.
TITLE_INCHES = 0.85
# Names of the values that the published search leaves behind, in order.
STEP_VALUE = "error_step_"


@checked(title=a_text)
def samples_view(
    view: View,
    ax: Axes | None = None,
    *,
    samples: _core.Samples | None = None,
    renderer: RendererArgument = None,
    title: str = "",
) -> Axes:
    """Axes with the eye's view and the samples that a search looks at: those at the edges of shadows.

    Parameters
    ----------
    view : View
        With one light.
    ax : matplotlib axes, optional
        Made where none are given.
    samples : Samples, optional
        Those of the view, `View.samples`, where none are given.
    renderer : Renderer or str, optional
        As of `View.gbuffer`.
    title : str
        The number of samples where none is given.

    Returns
    -------
    matplotlib axes

    Raises
    ------
    ArgumentError
        For a view with several lights.

    Examples
    --------
    >>> import shadowlab as sl
    >>> s = sl.library.scene("robots")
    >>> ax = sl.plot.samples_view(sl.View(s, s.camera, s.light, size=(160, 90)), renderer="cpu")
    """
    checked_view(view)
    light = light_of(view)
    made = view.samples(renderer=renderer) if samples is None else samples
    if not isinstance(made, _core.Samples):
        raise ArgumentError(f"samples: expected Samples, got {shown(made)}; view.samples() makes them")
    picture = pale_eye_view(view.gbuffer(renderer), light, np.asarray(view.truth()))
    at_edge = np.asarray(made.edge_normals).any(axis=1)
    words = title or f"{int(at_edge.sum()):,} samples at the edges of shadows"
    ax = _picture(ax, picture, words, view.camera.aspect)
    pixels = pixels_of(view.camera, view.size, np.asarray(made.positions))
    for state, (name, colour) in SAMPLE_STATES.items():
        x, y = pixels[at_edge & (np.asarray(made.shadow) == state)].T
        ax.scatter(x, y, s=SAMPLE_AREA, color=colour, linewidths=0, label=name)
    legend_below(ax, ncols=len(SAMPLE_STATES), markerscale=2.5, handletextpad=0.1)
    # The limits of the picture, which points at its border would widen.
    height, width = picture.shape[:2]
    ax.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5))
    return ax


@checked(parameterization=A_PARAMETERIZATION, title=a_text)
def search_history(parameterization: _core.Parameterization, ax: Axes | None = None, *, title: str = "") -> Axes:
    """Axes with the objective of the published search before its first step and after each step that it accepts.

    The objective is the mean over samples of the sum of squares of a texel's sides in the picture (10.4).

    Parameters
    ----------
    parameterization : Parameterization
        Of ``scene_optimal:search=published``.
    ax : matplotlib axes, optional
        Made where none are given.
    title : str

    Returns
    -------
    matplotlib axes

    Raises
    ------
    ArgumentError
        For a parameterization without such a search.

    Examples
    --------
    >>> import shadowlab as sl
    >>> s = sl.library.scene("robots")
    >>> p = sl.technique("scene_optimal:search=published").parameterize(s, s.camera, s.light)
    >>> ax = sl.plot.search_history(p)
    """
    values = dict(parameterization.values)
    steps = [values[name] for name in sorted(values) if name.startswith(STEP_VALUE)]
    if not steps:
        raise ArgumentError(
            f"parameterization: expected one of {PUBLISHED}, whose search has a history, got "
            f"{parameterization.technique}"
        )
    ax = _axes(ax)
    ax.plot(range(len(steps)), steps, **series_style(0))
    ax.set(xlabel="accepted steps of the search", ylabel="mean of the squares of a texel's sides, px²", title=title)
    ax.set_xticks(range(len(steps)))
    ax.set_ylim(0.0, 1.12 * max([*steps, values.get("error_uniform", 0.0)]))
    curve_look(ax)
    if "error_uniform" in values:
        level(ax, values["error_uniform"], "uniform map")
    return ax


@checked(resolution=a_count(1, 16384))
def samples_and_maps(
    view: View,
    techniques: str | Sequence[TechniqueArgument] = FIGURE_TECHNIQUES,
    *,
    resolution: int = 256,
    renderer: RendererArgument = None,
) -> Figure:
    """A figure with a row per light: the samples in the eye's view, then the world in the map of each technique.

    Parameters
    ----------
    view : View
        With one light or several.
    techniques : sequence
        As for `sl.compare`; of those with several maps the first is drawn.
    resolution : int
        Texels along each side of the maps that wrong pixels are counted of; the paper's were 256.
    renderer : Renderer or str, optional
        As of `evaluate`.

    Returns
    -------
    matplotlib figure

    Raises
    ------
    ArgumentError
        As of `evaluate`.
    """
    import matplotlib.pyplot as plt

    checked_view(view)
    given = [techniques] if isinstance(techniques, str) else techniques
    entries = checked_items("techniques", given, "techniques or their names", f"try {FIGURE_TECHNIQUES}")
    if not entries:
        raise ArgumentError(f"techniques: expected at least one, got none; try {FIGURE_TECHNIQUES}")
    if len(entries) > MOST_COLUMNS:
        raise ArgumentError(f"techniques: expected at most {MOST_COLUMNS}, got {len(entries)}; make several figures")
    shape = (len(view.views), 1 + len(entries))
    ratios = [view.camera.aspect, *[1.0] * len(entries)]
    height = 14.0 / sum(ratios) + TITLE_INCHES
    figure, grid = plt.subplots(
        *shape, figsize=(14.0, height * shape[0]), width_ratios=ratios, layout="constrained", squeeze=False
    )
    for i, (row, of) in enumerate(zip(grid, view.views, strict=True)):
        samples_view(of, row[0], renderer=renderer, title=f"samples of light {i + 1}" if len(grid) > 1 else "samples")
        for ax, technique in zip(row[1:], entries, strict=True):
            run = evaluate(of, technique, resolution, metrics=["misclassified"], renderer=renderer)
            if run.failure:
                ax.set_axis_off()
                say(ax, f"{run.label}: {run.failure}")
                continue
            p, errors = done(run.parameterization), done(run.errors)
            # Maps are drawn finer than they are counted, to be looked at.
            fine = max(512, resolution)
            depth = evaluate(of, p, fine, metrics=["mask"], renderer=renderer).maps
            warped_view(p, of.camera, ax, depth=depth, every=fine)
            ax.set(xlabel="", ylabel="", xticks=[], yticks=[])
            name = run.label.replace(":", ":\n", 1)
            ax.set_title(f"{name}\n{share_text(errors.fraction)} wrong", fontsize="medium")
    return figure


@checked(by_map=a_flag)
def percent_more(result: SceneOptimalTable, ax: Axes | None = None, *, by_map: bool = False) -> Axes:
    """Axes with how many percent more mistakes the normal map makes than each technique, over the size of the map.

    Sums are over the views that all techniques serve.

    Parameters
    ----------
    result : SceneOptimalTable
    ax : matplotlib axes, optional
        Made where none are given.
    by_map : bool
        By the large normal map that the paper takes for the truth, instead of traced truth.

    Returns
    -------
    matplotlib axes
    """
    if not isinstance(result, SceneOptimalTable):
        raise ArgumentError(
            f"result: expected a SceneOptimalTable, got {type(result).__name__}; sl.scene_optimal_experiment makes one"
        )
    ax = _axes(ax)
    column = "percent_more_by_map" if by_map else "percent_more"
    totals = result.served_by_all.totals
    for i, (technique, rows) in enumerate(totals.groupby("technique", sort=False)):
        ax.plot(rows["single_side"].astype(int), rows[column], label=technique, **series_style(i))
    sides = sorted(set(totals["single_side"].astype(int)))
    ax.set(xlabel="texels along each side of a single map", ylabel="more mistakes of the normal map, %", xticks=sides)
    curve_look(ax)
    ax.axhline(0.0, color="#333333", linewidth=1.0, zorder=1.5)
    legend_beside(ax, fontsize="small")
    return ax


def scene_optimal_figure(result: SceneOptimalTable, name: str) -> Figure:
    """A figure of the experiment: its curves by truth and by map, or one of the paper's settings in the library."""
    if name != CURVES:
        return samples_and_maps(paper_views()[name], renderer=renderer_of(result.backend))
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 2, figsize=(13.0, 4.6), layout="constrained", sharey=True)
    for ax, by_map in zip(axes, (False, True), strict=True):
        percent_more(result, ax, by_map=by_map)
        ax.set_title(f"normal map of {result.reference}² as truth" if by_map else "traced truth")
    axes[0].get_legend().remove()
    axes[1].set_ylabel("")
    return figure
