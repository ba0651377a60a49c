"""Columns of a table over one another as lines."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..text.checked import a_text, checked
from .arguments import column_words, numbers_of
from .axes import _axes, curve_look, legend_beside, say, series_style
from .table_parts import axis_label, failed_rows, groups_of, meant, places_of, room_at_foot, scale, with_failures

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

# More bands over one another hide more than they show.
MOST_BANDS_SHOWN = 3


@checked(title=a_text)
def lines(
    table: pd.DataFrame, x: str, y: str, hue: str | None = "technique", ax: Axes | None = None, *, title: str = ""
) -> Axes:
    """Axes with one column of a table over another, a line for each value of a third.

    Several rows at one place, such as several views, are a line through their mean; of up to three lines each has a
    band from the least to the largest. Rows that failed are crosses at the foot of the axes, and counted in the legend.

    Parameters
    ----------
    table : DataFrame
        Of `sl.sweep`, `sl.read_store`, `Study.table`, `Advice.runs`, or any with these columns.
    x, y : str
        Columns of numbers; that of `x` may be of texts, which stand in their order. "wrong" means the wrong pixels,
        "memory" what the maps take.
    hue : str, optional
        The column whose values get lines of their own; None for a single line.
    ax : matplotlib axes, optional
        Made where none are given.
    title : str

    Returns
    -------
    matplotlib axes
        Labels have the units of docs/columns.md. Numbers that span much have logarithmic axes.

    Raises
    ------
    ArgumentError
        For something that is no table, a column that it lacks, and texts in the place of numbers.

    Examples
    --------
    >>> import shadowlab as sl
    >>> df = sl.sweep({"scene": "@robots", "technique": ["uniform", "lispsm"], "resolution": [64, 96]}, size=(64, 36),
    ...     renderer="cpu", progress=False)
    >>> ax = sl.plot.lines(df, "resolution", "misclassified")
    >>> ax.get_ylabel()
    'wrong pixels, count'
    """
    wanted = {"x": x, "y": y} | ({} if hue is None else {"hue": hue})
    rows, names = meant(table, wanted)
    ax = _axes(ax)
    places, values = places_of(rows, names["x"]), numbers_of(rows, names["y"])
    # An infinite length has no place on the axes; it counts as what cannot be shown.
    failed = failed_rows(rows) | ~np.isfinite(values)
    groups = groups_of(rows, names.get("hue"))
    foot: list[tuple[np.ndarray, str]] = []
    shown: list[float] = []
    for i, (label, of) in enumerate(groups.items()):
        style = series_style(i)
        good = of & ~failed & np.isfinite(places.position)
        at = np.unique(places.position[good])
        spread = [values[good & (places.position == place)] for place in at]
        mean, least, most = ([float(how(one)) for one in spread] for how in (np.mean, np.min, np.max))
        text = with_failures(label, int((of & failed).sum()), int(of.sum()))
        ax.plot(at, mean, label=text or None, **style)
        shown += mean
        if any(len(one) > 1 for one in spread) and len(groups) <= MOST_BANDS_SHOWN:
            shown += least + most
            ax.fill_between(at, least, most, color=style["color"], alpha=0.15, linewidth=0)
        foot.append((np.unique(places.position[of & failed & np.isfinite(places.position)]), style["color"]))
    if not (~failed).any():
        say(ax, "no run has a number" if len(rows) else "no rows")
    scale(ax, "x", names["x"], places.position, places.names)
    scale(ax, "y", names["y"], np.array(shown, np.float64))
    crosses = [(at, color) for at, color in foot if len(at)]
    if crosses:
        # Above one another, so that those of each line are seen.
        high = min(len(crosses), 8)
        room_at_foot(ax, 0.04 * high + 0.02)
        for i, (at, color) in enumerate(crosses):
            height = np.full(len(at), 0.02 + 0.04 * (i % high))
            ax.plot(at, height, "x", color=color, transform=ax.get_xaxis_transform(), markersize=6)
    curve_look(ax)
    ax.set(xlabel=axis_label(names["x"]), ylabel=axis_label(names["y"]), title=title)
    if ax.get_legend_handles_labels()[0]:
        legend_beside(ax, title=None if hue is None else column_words(names["hue"]))
    return ax
