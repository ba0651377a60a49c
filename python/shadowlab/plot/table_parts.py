"""What plots of tables share: what a name means in a table, its failures, positions and scales of axes, series."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..experiments.columns import COLUMNS, with_current
from ..experiments.memory import memory_text
from .arguments import COLUMN_LABELS, column_name, columns_of, numbers_of, title_and_unit
from .axes import log_axis, padded, short_label, wrapped

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

#: What people call columns: the first of these that has a number in every row, else in any. A budget goes before what
#: maps take of it, since it is the same for all.
SYNONYMS: Mapping[str, tuple[str, ...]] = MappingProxyType({
    "memory": ("memory", "bytes"),
    "wrong": ("misclassified", "error", "error_mean"),
})  # fmt: skip
#: Positive numbers that span more than this factor get a logarithmic axis.
WIDE_SPAN = 8.0
# Digits by which numbers have to differ to stand in places of their own.
DIGITS_APART = 12
# Places on an axis that each get a tick of their own, and letters of these.
MOST_TICKS, WIDEST_TICK = 14, 22


class Places(NamedTuple):
    """A column as places on an axis.

    Attributes
    ----------
    position : (N,) float64
        The number of each row, or of a text its rank among the texts; NaN where there is none.
    names : tuple of str
        The texts in order; empty of a column of numbers.
    """

    position: NDArray[np.float64]
    names: tuple[str, ...]


def meant(table: object, names: Mapping[str, str]) -> tuple[pd.DataFrame, dict[str, str]]:
    """The table and the columns that arguments mean in it.

    Raises
    ------
    ArgumentError
        For something that is no table, and a column that it lacks.
    """
    rows = columns_of(table, ())
    found = dict(names)
    for argument, name in names.items():
        column_name(argument, name)
        there = [one for one in SYNONYMS.get(name, ()) if one in rows.columns]
        in_all = [one for one in there if rows[one].notna().all()]
        in_any = [one for one in reversed(there) if rows[one].notna().any()]
        found[argument] = next(iter([*in_all, *in_any, *there]), name)
    rows = with_current(rows, found.values())
    for argument, name in found.items():
        columns_of(rows, [name], f"table, {argument}")
    return rows, found


def axis_label(column: str) -> str:
    """What an axis says of a column, with the unit that it has in every table."""
    title, unit = title_and_unit(column)
    if not unit and column in COLUMNS and column not in COLUMN_LABELS:
        unit = COLUMNS[column].unit
    return wrapped(f"{title}, {unit}" if unit else title)


def failed_rows(table: pd.DataFrame) -> NDArray[np.bool_]:
    """Which rows (N,) have failed, as they say themselves."""
    if "failure" not in table.columns:
        return np.zeros(len(table), bool)
    return np.asarray([isinstance(text, str) and text != "" for text in table["failure"]], bool)


def places_of(table: pd.DataFrame, column: str) -> Places:
    """A column as places: numbers as they are, texts and truth values by their first row."""
    import pandas as pd

    values = table[column]
    if pd.api.types.is_numeric_dtype(values) and not pd.api.types.is_bool_dtype(values):
        # Angles that are computed differ in their last bits.
        at = [float(f"{value:.{DIGITS_APART}g}") for value in numbers_of(table, column)]
        return Places(np.where(np.isfinite(at), at, np.nan), ())
    texts = [str(value) for value in values]
    names = tuple(dict.fromkeys(texts))
    rank = {name: i for i, name in enumerate(names)}
    return Places(np.array([rank[text] for text in texts], np.float64), names)


def groups_of(table: pd.DataFrame, hue: str | None) -> dict[str, NDArray[np.bool_]]:
    """The rows of each series, by its name; one without a name where nothing tells them apart."""
    if hue is None:
        return {"": np.ones(len(table), bool)}
    texts = np.array([str(value) for value in table[hue]], object)
    return {name: np.asarray(texts == name, bool) for name in dict.fromkeys(texts)}


def scale(ax: Axes, which: str, column: str, values: NDArray[np.float64], names: tuple[str, ...] = ()) -> None:
    """Scale and ticks of an axis: of texts the texts, of numbers that span much a logarithm, of few the numbers."""
    from matplotlib.ticker import FuncFormatter, LogLocator

    axis = getattr(ax, f"{which}axis")
    known = values[np.isfinite(values)]
    if names:
        ticks: dict[str, Any] = {"rotation": 35, "ha": "right"} if which == "x" and len("".join(names)) > 60 else {}
        if len(names) <= 4 * MOST_TICKS:
            axis.set_ticks(range(len(names)), [short_label(name) for name in names], **ticks)
        getattr(ax, f"set_{which}lim")(-0.5, len(names) - 0.5)
        return
    if known.size and (known > 0).all() and known.max() > WIDE_SPAN * known.min():
        log_axis(ax, which, padded(known))
        if is_bytes(column):
            axis.set_major_locator(LogLocator(base=2, numticks=7))
            axis.set_major_formatter(FuncFormatter(lambda v, _: memory_text(round(v))))
        return
    if known.size and (known >= 0).all() and known.max() > 100 * WIDE_SPAN:
        axis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:,.0f}"))
    places = np.unique(known)
    if which == "x" and 0 < len(places) <= MOST_TICKS:
        axis.set_ticks(places, [number_text(v, column) for v in places])


def is_bytes(column: str) -> bool:
    """Whether a column counts bytes."""
    return column in COLUMNS and COLUMNS[column].unit == "bytes"


def number_text(value: float, column: str) -> str:
    """A number of a column at its place: bytes as people write them, whole numbers whole, others with three digits."""
    if is_bytes(column):
        return memory_text(round(value))
    return f"{value:,.0f}" if value == round(value) and abs(value) < 1e15 else f"{value:.3g}"


def room_at_foot(ax: Axes, share: float) -> None:
    """Makes room below all that the axes show, as a share of their height."""
    low, high = ax.get_ylim()
    if ax.get_yscale() == "log":
        ax.set_ylim(low * (low / high) ** (share / (1 - share)), high)
    else:
        ax.set_ylim(low - (high - low) * share / (1 - share), high)


def with_failures(label: str, failed: int, of: int, what: str = "runs") -> str:
    """The label of a series with how many of its rows failed."""
    name = short_label(label)
    if not failed:
        return name
    told = f"{failed:,} of {of:,} {what} failed"
    return f"{name} ({told})" if name else told
