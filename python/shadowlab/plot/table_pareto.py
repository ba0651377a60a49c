"""The error of runs over what they cost, and which of them no other beats in both."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..text.checked import a_text, checked
from .arguments import numbers_of
from .axes import SOFT, _axes, curve_look, legend_beside, say, series_style, short_label
from .table_parts import axis_label, failed_rows, meant, scale, with_failures

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

#: What tells one way to draw shadows from another, where a table has it; rows that share all of it are its views.
OF_A_WAY = ("technique", "spec", "settings", "resolution", "memory", "bias", "filter", "blend", "stored", "single_side")
# Points of the front that have room for their names.
MOST_POINTS_NAMED = 12


class Way(NamedTuple):
    """A technique with its settings and size, over all its views."""

    series: str
    name: str
    cost: float
    error: float
    failed: int
    rows: int


@checked(title=a_text)
def pareto(
    table: pd.DataFrame,
    cost: str = "memory",
    error: str = "wrong",
    hue: str = "technique",
    ax: Axes | None = None,
    *,
    title: str = "",
) -> Axes:
    """Axes with the error of every way to draw shadows over its cost, and the front of those that none beats in both.

    A way is a technique with its settings and size. Of its views error and cost are means. One that fails in a view is
    no part of the front, since its mean is over fewer views: it is a cross, and the legend counts it.

    Parameters
    ----------
    table : DataFrame
        As of `lines`; `Advice.table`, too.
    cost, error : str
        Columns of numbers, less is better. "memory" is what the maps take (`bytes`, or the budget), "wrong" the wrong
        pixels (`misclassified`, or the error that an advice ranks by).
    hue : str
        The column whose values have colours of their own.
    ax : matplotlib axes, optional
        Made where none are given.
    title : str

    Returns
    -------
    matplotlib axes

    Raises
    ------
    ArgumentError
        As of `lines`.

    Examples
    --------
    >>> import shadowlab as sl
    >>> df = sl.sweep({"scene": "@robots", "technique": ["uniform", "lispsm"], "resolution": [64, 96]}, size=(64, 36),
    ...     renderer="cpu", progress=False)
    >>> sl.plot.pareto(df).get_xlabel()
    'memory of the maps, bytes'
    """
    rows, names = meant(table, {"cost": cost, "error": error, "hue": hue})
    ax = _axes(ax)
    ways = ways_in(rows, names["cost"], names["error"], names["hue"])
    shown = [way for way in ways if np.isfinite(way.error) and np.isfinite(way.cost)]
    front = front_of([way for way in shown if not way.failed])
    for i, series in enumerate(dict.fromkeys(way.series for way in ways)):
        style = series_style(i) | {"linestyle": "none"}
        of = [way for way in ways if way.series == series]
        text = with_failures(series, sum(way.failed for way in of), sum(way.rows for way in of))
        whole = [way for way in of if way in shown and not way.failed]
        ax.plot([way.cost for way in whole], [way.error for way in whole], label=text, **style)
        partly = [way for way in of if way in shown and way.failed]
        ax.plot([way.cost for way in partly], [way.error for way in partly], "x", color=style["color"], markersize=6)
    if front:
        x = np.repeat([way.cost for way in front], 2)[1:]
        y = np.repeat([way.error for way in front], 2)[:-1]
        ax.plot(x, y, color=SOFT, linewidth=1.2, zorder=1, label="no other is better in both")
    else:
        say(ax, "no run has a number in every view" if len(rows) else "no rows")
    scale(ax, "x", names["cost"], np.array([way.cost for way in shown], np.float64))
    scale(ax, "y", names["error"], np.array([way.error for way in shown], np.float64))
    for way in front if len(front) <= MOST_POINTS_NAMED else ():
        # Into the axes, from points of their right half.
        right = ax.transData.transform((way.cost, way.error))[0] > ax.transAxes.transform((0.5, 0.5))[0]
        place = {"xytext": (-5 if right else 5, 5), "ha": "right" if right else "left", "textcoords": "offset points"}
        words = {"fontsize": "x-small", "color": SOFT}
        ax.annotate(short_label(way.name), (way.cost, way.error), **place, **words)  # type: ignore[arg-type]
    curve_look(ax)
    several = bool(ways) and max(way.rows for way in ways) > 1
    ax.set(xlabel=axis_label(names["cost"]), title=title)
    ax.set_ylabel(axis_label(names["error"]) + (", mean of the views" if several else ""))
    if ax.get_legend_handles_labels()[0]:
        legend_beside(ax)
    return ax


def ways_in(rows: pd.DataFrame, cost: str, error: str, hue: str) -> list[Way]:
    """The ways of a table, in the order of their first rows."""
    costs, errors = numbers_of(rows, cost), numbers_of(rows, error)
    failed = failed_rows(rows) | ~np.isfinite(errors) | ~np.isfinite(costs)
    keys = [name for name in OF_A_WAY if name in rows.columns and name != error]
    keys += [hue] * (hue not in keys)
    budgets = rows["memory"].notna() if "memory" in rows.columns else [False] * len(rows)
    found: dict[tuple[str, ...], list[int]] = {}
    for i, (budget, *values) in enumerate(zip(budgets, *(rows[name] for name in keys), strict=True)):
        # With a budget the side of the maps is that of a view.
        texts = (
            "" if budget and name == "resolution" else str(value) for name, value in zip(keys, values, strict=True)
        )
        found.setdefault(tuple(texts), []).append(i)
    ways = []
    for at in found.values():
        good = [i for i in at if not failed[i]]
        series = str(rows[hue].iloc[at[0]])
        sides = {str(rows["resolution"].iloc[i]) for i in good} if "resolution" in rows.columns else set()
        name = f"{series} {sides.pop()}²" if len(sides) == 1 else series
        ways.append(Way(series, name, _mean(costs, good), _mean(errors, good), len(at) - len(good), len(at)))
    return ways


def front_of(ways: list[Way]) -> list[Way]:
    """Those that no other equals or beats in both, costs rising and errors falling."""
    front: list[Way] = []
    for way in sorted(ways, key=lambda way: (way.cost, way.error)):
        if not front or way.error < front[-1].error:
            front.append(way)
    return front


def _mean(values: NDArray[np.float64], at: list[int]) -> float:
    return float(np.mean(values[at])) if at else np.nan
