"""The figure of an advice: the error over the light angle, and over memory, a line a candidate.

Each candidate has a colour, a marker and a kind of line, the same in every panel; the winner of a panel is drawn thick.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..experiments.memory import memory_text
from ..experiments.ranking import place_of
from ..experiments.thresholds import BASELINE
from ..experiments.views import SAME_ANGLE, axis_of
from .axes import curve_look, legend_beside, log_axis, padded, say, series_style, short_label

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    from ..experiments.advice import Advice
    from ..experiments.ranking import Standing

# Panels over the views: more budgets than these are told by the panel over memory.
MOST_BUDGETS = 2
ANGLE_LABELS = {
    "light_angle": "angle between light and view (degrees)",
    "light_elevation": "elevation of the light (degrees)",
}
# Letters of a candidate in the legend.
WIDEST_NAME = 52
PANEL_INCHES, HEIGHT_INCHES, LEGEND_INCHES = 4.4, 4.2, 3.0
# Height of a candidate's row, and of what stands above and below all of them.
ROW_INCHES, MARGIN_INCHES = 0.19, 0.8
# Lines in a panel: more could not be told apart by colour, marker and kind of line.
MOST_LINES = 10


def advice_figure(advice: Advice) -> Figure:
    """A matplotlib figure: a panel over the views for the least and the largest budget, and one over memory."""
    import matplotlib.pyplot as plt

    ranking = advice.standings
    views, budgets = advice.counted, list(advice.budgets)
    chosen = budgets if len(budgets) <= MOST_BUDGETS else [budgets[0], budgets[-1]]
    over_views = chosen if len(views) > 1 else []
    over_memory = len(budgets) > 1
    panels = max(1, len(over_views) + over_memory)
    rows = 0 if over_views or over_memory else len(advice.candidates)
    size = PANEL_INCHES * panels + LEGEND_INCHES, max(HEIGHT_INCHES, MARGIN_INCHES + ROW_INCHES * rows)
    figure, grid = plt.subplots(1, panels, figsize=size, squeeze=False, layout="constrained")
    axes = list(grid[0])
    styles = {one.label: series_style(i) for i, one in enumerate(advice.candidates)}
    chosen_lines = lines_of(advice, ranking)
    lines = {label: series_style(i) for i, label in enumerate(one for one in styles if one in chosen_lines)}
    for ax, memory in zip(axes, over_views, strict=False):
        of_views(ax, advice, memory, lines)
    if over_memory:
        of_memory(axes[-1], advice, ranking, lines)
    elif not over_views:
        of_candidates(axes[0], advice, ranking, styles)
    shared_scale(axes if over_views or over_memory else [], advice)
    if over_views or over_memory:
        legend(axes[-1], advice, ranking, lines)
    source = advice.source.name
    figure.suptitle(f"{source}: {advice.measure.title} at equal memory", fontsize="medium")
    return figure


def lines_of(advice: Advice, ranking: Sequence[Standing]) -> set[str]:
    """The candidates that have a line: all of a few, else uniform and those best in the budget where they are best."""
    if len(advice.candidates) <= MOST_LINES:
        return {one.label for one in advice.candidates}
    plain = next((one.candidate for one in ranking if one.ranked and one.technique == BASELINE), None)
    best = sorted((one for one in ranking if one.ranked), key=lambda one: (one.rank or 0, one.memory))
    order = dict.fromkeys([*([plain] if plain else []), *(one.candidate for one in best)])
    return set(list(order)[:MOST_LINES])


def axis_title(advice: Advice) -> str:
    """The measure with its unit; shares are drawn in per cent."""
    return f"{advice.measure.title} ({'%' if advice.measure.unit == 'share' else 'px'})"


def scaled(advice: Advice, values: Sequence[float | None]) -> np.ndarray:
    """Errors as they are drawn; NaN, which leaves a gap, where there is none."""
    factor = 100.0 if advice.measure.unit == "share" else 1.0
    return np.array([math.nan if v is None else factor * v for v in values], np.float64)


def of_views(ax: Axes, advice: Advice, memory: int, styles: Mapping[str, Mapping[str, Any]]) -> None:
    """The errors in each view, over the light angle where one camera has several, else view by view."""
    views = advice.counted
    axis = axis_of(views)
    angles = [getattr(view, axis) for view in views]
    one_camera = len({view.camera_label for view in views}) == 1
    by_angle = one_camera and None not in angles and len({round(a / SAME_ANGLE) for a in angles}) == len(angles)
    if by_angle:
        views = sorted(views, key=lambda view: place_of(view, axis))
    places = [math.degrees(getattr(view, axis)) if by_angle else i for i, view in enumerate(views)]
    found = {(o.candidate, o.view.label): o.error for o in advice.outcomes if o.memory == memory}
    lines = {}
    for label, style in styles.items():
        values = scaled(advice, [found.get((label, view.label)) for view in views])
        (lines[label],) = ax.plot(places, values, **style)
    thicken(lines, [s for s in advice.standings if s.memory == memory])
    curve_look(ax)
    ax.set_title(memory_text(memory), fontsize="medium")
    ax.set_ylabel(axis_title(advice))
    if by_angle:
        ax.set_xlabel(ANGLE_LABELS[axis])
    else:
        ax.set_xticks(places, [short_label(view.label) for view in views], rotation=30, ha="right", fontsize="small")


def of_memory(ax: Axes, advice: Advice, ranking: Sequence[Standing], styles: Mapping[str, Mapping[str, Any]]) -> None:
    """The error over all views, over the budget."""
    found = {(s.candidate, s.memory): s.error for s in ranking}
    lines = {}
    for label, style in styles.items():
        values = scaled(advice, [found.get((label, memory)) for memory in advice.budgets])
        (lines[label],) = ax.plot([memory / 2**20 for memory in advice.budgets], values, **style)
    thicken(lines, [s for s in ranking if s.memory == advice.budgets[-1]])
    curve_look(ax)
    many = len(advice.counted)
    ax.set_title(f"{advice.over} of {many} views" if many > 1 else "over memory", fontsize="medium")
    ax.set(xlabel="memory (MiB)", ylabel=axis_title(advice))
    ax.set_xscale("log")
    ax.set_xticks([m / 2**20 for m in advice.budgets], [f"{m / 2**20:.3g}" for m in advice.budgets])
    ax.minorticks_off()


def of_candidates(
    ax: Axes, advice: Advice, ranking: Sequence[Standing], styles: Mapping[str, Mapping[str, Any]]
) -> None:
    """The candidates one under the other, the best at the top, of one view and one budget."""
    shown = [one for one in ranking if one.error is not None][::-1]
    if not shown:
        say(ax, "nothing was measured")
        ax.set_axis_off()
        return
    values = scaled(advice, [one.error for one in shown])
    for i, (one, value) in enumerate(zip(shown, values, strict=True)):
        style = styles[one.candidate]
        ax.plot([value], [i], color=style["color"], marker=style["marker"], markersize=8)
        said = advice.measure.text(one.error or 0.0)
        ax.annotate(
            f" {said}", (value, i), xytext=(6, 0), textcoords="offset points", va="center",
            fontsize="small",
        )  # fmt: skip
    curve_look(ax)
    ax.set_yticks(range(len(shown)), [legend_name(one.candidate) for one in shown])
    ax.set_title(memory_text(advice.budgets[0]), fontsize="medium")
    ax.set_xlabel(axis_title(advice))
    ax.set_xlim(0, 1.25 * float(values.max()) or 1.0)


def legend_name(label: str) -> str:
    """A candidate for the legend, its middle left out where it is too long."""
    return label if len(label) <= WIDEST_NAME else short_label(label)


def thicken(lines: Mapping[str, Line2D], ranking: Sequence[Standing]) -> None:
    """Draw the best of a panel thick and in front."""
    if ranking and ranking[0].rank is not None and ranking[0].candidate in lines:
        line = lines[ranking[0].candidate]
        line.set(linewidth=3.0, markersize=7.5, zorder=3)


def shared_scale(axes: Sequence[Axes], advice: Advice) -> None:
    """One range of errors for all panels, logarithmic where all errors are above 0."""
    every = [
        float(v) for ax in axes for line in ax.get_lines() for v in np.asarray(line.get_ydata()) if math.isfinite(v)
    ]
    if not every:
        for ax in axes:
            say(ax, "nothing was measured")
        return
    positive = min(every) > 0
    for ax in axes:
        if positive:
            log_axis(ax, "y", padded(every))
        else:
            ax.set_ylim(0, 1.08 * max(every) or 1.0)


def legend(ax: Axes, advice: Advice, ranking: Sequence[Standing], styles: Mapping[str, Mapping[str, Any]]) -> None:
    """The candidates beside the last panel, in the order of the largest budget."""
    from matplotlib.lines import Line2D

    order = [s for s in ranking if s.memory == advice.budgets[-1] and s.candidate in styles]
    handles = [
        Line2D(
            [], [], **styles[s.candidate], label=legend_name(s.candidate) + ("" if s.error is not None else " (failed)")
        )
        for s in order
    ]
    few = len(styles) < len(advice.candidates)
    title = f"{len(styles)} of {len(advice.candidates)} candidates" if few else None
    legend_beside(ax, handles, fontsize="small", title=title, title_fontsize="small", alignment="left")
