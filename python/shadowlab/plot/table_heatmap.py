"""A column of a table over two others as coloured cells."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..text import digits
from ..text.checked import a_text, checked
from .arguments import numbers_of
from .axes import SOFT, _axes, drawable, log_axis, say
from .table_parts import WIDE_SPAN, Places, axis_label, failed_rows, meant, number_text, places_of

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

# Cells that have room for a number each.
MOST_NUMBERS_SHOWN = 200
# Names along an axis that have room.
MOST_CELLS_NAMED = 60
# Between the axes and their title.
ROOM_FOR_LEGEND_PT = 20.0
CELL_COLOURS = "cividis"  # as light as it is large, and the same to all kinds of eyes


@checked(title=a_text)
def heatmap(table: pd.DataFrame, x: str, y: str, value: str, ax: Axes | None = None, *, title: str = "") -> Axes:
    """Axes with a cell for each pair of values of two columns, coloured by the mean of a third.

    A cell whose rows all failed is hatched, one of which some failed has a cross in its corner, and the legend counts
    both; one without rows is empty.

    Parameters
    ----------
    table : DataFrame
        As of `lines`.
    x, y : str
        Columns of texts, in their order, or of numbers, rising.
    value : str
        A column of numbers; where there are not too many cells, each has its number.
    ax : matplotlib axes, optional
        Made where none are given.
    title : str

    Returns
    -------
    matplotlib axes
        With a bar of colours that has the unit; logarithmic where the numbers span much.

    Raises
    ------
    ArgumentError
        As of `lines`.

    Examples
    --------
    >>> import shadowlab as sl
    >>> df = sl.sweep({"scene": "@robots", "technique": ["uniform", "lispsm"], "resolution": [64, 96]}, size=(64, 36),
    ...     renderer="cpu", progress=False)
    >>> sl.plot.heatmap(df, "resolution", "technique", "misclassified").get_ylabel()
    'technique'
    """
    from matplotlib.colors import LogNorm, Normalize
    from matplotlib.patches import Patch, Rectangle

    rows, names = meant(table, {"x": x, "y": y, "value": value})
    ax = _axes(ax)
    values = numbers_of(rows, names["value"])
    failed = failed_rows(rows) | ~np.isfinite(values)
    (column, across), (row, down) = (_cells(names[one], places_of(rows, names[one])) for one in ("x", "y"))
    total, count, lost = (np.zeros((len(down), len(across))) for _ in range(3))
    placed = (column >= 0) & (row >= 0)
    good, bad = placed & ~failed, placed & failed
    np.add.at(total, (row[good], column[good]), values[good])
    np.add.at(count, (row[good], column[good]), 1)
    np.add.at(lost, (row[bad], column[bad]), 1)
    mean = np.where(count > 0, total / np.maximum(count, 1), np.nan)
    known = mean[np.isfinite(mean)]
    if known.size:
        low, high = float(known.min()), float(known.max())
        norm = LogNorm(low, high) if low > 0 and high > WIDE_SPAN * low else Normalize(low, high)
        picture = ax.imshow(
            np.ma.masked_invalid(mean), cmap=CELL_COLOURS, norm=norm, aspect="auto", interpolation="nearest"
        )
        bar = ax.figure.colorbar(picture, ax=ax, label=axis_label(names["value"]))
        if isinstance(norm, LogNorm):
            log_axis(bar.ax, "y", (low, high))
        _write_numbers(ax, mean, norm, picture.cmap)
    else:
        say(ax, "no run has a number" if len(rows) else "no rows")
        ax.set(xlim=(-0.5, max(len(across), 1) - 0.5), ylim=(max(len(down), 1) - 0.5, -0.5))
    handles: list[Artist] = []
    for i, k in zip(*np.nonzero(lost), strict=True):
        if count[i, k]:
            ax.plot(k + 0.38, i - 0.36, "x", color="#D00000", markersize=5, markeredgewidth=1.4)
        else:
            box = {"facecolor": "#E4E4E4", "edgecolor": "#909090", "hatch": "///", "linewidth": 0.0}
            ax.add_patch(Rectangle((k - 0.5, i - 0.5), 1, 1, **box))  # type: ignore[arg-type]
    if lost.any():
        told = f"{int(lost.sum()):,} of {len(rows):,} runs failed"
        partly, all_of = (lost * count).any(), ((lost > 0) & (count == 0)).any()
        if all_of:
            handles.append(Patch(facecolor="#E4E4E4", edgecolor="#909090", hatch="///", label=told))
        if partly:
            words = "some of the cell" if all_of else f"{told}, some of the cell"
            handles += ax.plot([], [], "x", color="#D00000", label=words)
        place: dict[str, Any] = {
            "loc": "lower right",
            "bbox_to_anchor": (1.0, 1.0),
            "frameon": False,
            "borderaxespad": 0.2,
        }
        ax.legend(handles=handles, fontsize="small", ncols=2, **place)
    ax.set(xlabel=axis_label(names["x"]), ylabel=axis_label(names["y"]))
    ax.set_title(title, pad=ROOM_FOR_LEGEND_PT if handles else None)
    turned = len("".join(across)) > 60
    for axis, texts in ((ax.xaxis, across), (ax.yaxis, down)):
        if len(texts) <= MOST_CELLS_NAMED:
            axis.set_ticks(range(len(texts)), texts)
    ax.tick_params(length=0, labelcolor=SOFT)
    if turned:
        for text in ax.get_xticklabels():
            text.set(rotation=35, ha="right", rotation_mode="anchor")
    return ax


def _cells(name: str, places: Places) -> tuple[NDArray[np.int64], list[str]]:
    """The cell of each row along an axis, -1 for none, and what the cells are called."""
    if places.names:
        return places.position.astype(np.int64), [drawable(name) for name in places.names]
    known = np.unique(places.position[np.isfinite(places.position)])
    cell = np.searchsorted(known, np.where(np.isfinite(places.position), places.position, np.inf))
    return np.where(np.isfinite(places.position), cell, -1).astype(np.int64), [number_text(v, name) for v in known]


def _write_numbers(ax: Axes, mean: NDArray[np.float64], norm: object, colours: object) -> None:
    """The number of each cell, dark on light and light on dark."""
    if mean.size > MOST_NUMBERS_SHOWN:
        return
    for (i, k), number in np.ndenumerate(mean):
        if np.isfinite(number):
            red, green, blue, _ = colours(norm(number))  # type: ignore[operator]
            dark = 0.299 * red + 0.587 * green + 0.114 * blue > 0.5
            words = digits(float(number))
            ax.text(k, i, words, ha="center", va="center", fontsize="small", color="black" if dark else "white")
