"""A table of runs as arrays with named axes: one axis per key that was swept, units as attributes."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Hashable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...errors import ArgumentError, UnsupportedError
from ...text import plain, shown
from ..columns import COLUMNS
from .space import OF_SCENES, keys_with, one_for_each, settings_keys

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

#: What tells runs apart beside their keys, and varies with some of them only: coordinates.
DESCRIBING = ("scene", "view", "camera", "light", "light_angle", "light_elevation", "technique", "spec")
# A grid of fewer filled cells than this is none, beyond so many cells.
LEAST_FILLED, MOST_EMPTY_PLACES = 1e-3, 1_000_000
MOST_PLACES = 100_000_000


def to_xarray(table: pd.DataFrame) -> xr.Dataset:
    """A table of `sl.sweep` as an xarray Dataset: an axis per key that was swept.

    Parameters
    ----------
    table : DataFrame
        Of `sl.sweep`, whole or some of its rows, or of `sl.read_store`.

    Returns
    -------
    xarray.Dataset
        A variable per column that has values, with the attributes `units` and `long_name`; NaN and empty texts where
        there is no run. Axes are the columns that vary by what was asked for: scene, camera, light, technique, settings
        such as "lispsm.near", resolution, memory, bias, filter, stored, blend. A technique without a setting has the
        same numbers all along its axis. Labels of views, texts of techniques and angles of lights are coordinates.
        `attrs` are those of the table.

    Raises
    ------
    ArgumentError
        For something else than a table of runs, two rows at one place of all axes, and rows that are no grid, such as
        those drawn by chance.
    UnsupportedError
        Where xarray is not installed; the message says how to get it.

    Examples
    --------
    >>> import shadowlab as sl
    >>> space = {"scene": "@robots", "technique": ["uniform", "lispsm"], "lispsm.near": [1, 2], "resolution": [64, 128]}
    >>> ds = sl.to_xarray(sl.sweep(space, size=(64, 36), renderer="cpu"))
    >>> dict(ds.sizes), ds["misclassified"].attrs["units"]
    ({'technique': 2, 'lispsm.near': 2, 'resolution': 2}, 'px')
    >>> best = ds["misclassified"].sel(technique="lispsm").min("lispsm.near")  # over resolution
    """
    try:
        import xarray as xr
    except ImportError:
        raise UnsupportedError(
            "to_xarray: expected the package xarray, which is not installed; pip install 'shadowlab[tables]'"
        ) from None
    check_table(table)
    axes = swept_axes(table)
    grid = Grid(table, axes)
    variables: dict[Hashable, Any] = {}
    coordinates: dict[Hashable, Any] = {
        name: (name, values_along(grid.along[name]), about(name)) for name in axes
    }  # fmt: skip
    for name in table.columns:
        if name in axes or is_empty_column(table[name]):
            continue
        filled = grid.filled(table[name])
        if name in DESCRIBING:
            names, array = grid.reduced(filled)
            coordinates[name] = names, array, about(name)
        else:
            variables[name] = tuple(axes), filled, about(name)
    return xr.Dataset(variables, coordinates, {name: attribute(value) for name, value in table.attrs.items()})


def check_table(table: object) -> None:
    """Raises unless it is a table of runs.

    Raises
    ------
    ArgumentError
    """
    import pandas as pd

    if not isinstance(table, pd.DataFrame):
        raise ArgumentError(f"table: expected a DataFrame of sl.sweep, got {shown(table)}; sl.sweep(...) makes one")
    missing = {"scene", "technique", "failure"} - set(table.columns)
    if missing or table.columns.has_duplicates:
        what = f"one without {', '.join(sorted(missing))}" if missing else "one with a column twice"
        raise ArgumentError(f"table: expected a DataFrame of sl.sweep, got {what}; sl.sweep(...) makes one")
    if table.empty:
        raise ArgumentError("table: expected at least one row, got none; sl.sweep(...) makes some")


def swept_axes(table: pd.DataFrame) -> list[str]:
    """The columns that are axes: those that were swept, in the order of the keys, and vary in these rows."""
    known = table.attrs.get("swept")
    if isinstance(known, (list, tuple)):
        wanted = [name for name in known if name in table.columns]
    else:
        order = keys_with(sorted(settings_keys() & set(table.columns)))
        # A budget decides the resolution.
        budgets = "memory" in table.columns and table["memory"].notna().any()
        wanted = [name for name in order if name in table.columns and not (budgets and name == "resolution")]
    follow = [
        name for name in OF_SCENES if name in wanted and one_for_each(table["scene"].tolist(), table[name].tolist())
    ]
    return [name for name in wanted if len(set(there(table[name]))) > 1 and name not in follow]


class Grid:
    """The places of rows on axes.

    Parameters
    ----------
    table : DataFrame
    axes : sequence of str

    Raises
    ------
    ArgumentError
        For two rows at one place, and rows that are no grid.
    """

    def __init__(self, table: pd.DataFrame, axes: Sequence[str]):
        self.axes = tuple(axes)
        self.along = {name: values_in_order(there(table[name])) for name in axes}
        self.shape = tuple(len(self.along[name]) for name in axes)
        cells = math.prod(self.shape)
        if cells > MOST_PLACES or (cells > MOST_EMPTY_PLACES and len(table) < LEAST_FILLED * cells):
            raise ArgumentError(
                f"table: expected rows that are a grid, got {len(table):,} rows for {cells:,} places of "
                f"{', '.join(axes)}; select fewer values, or work with the table"
            )
        self.places: dict[tuple[int, ...], int] = {}
        columns = [self._places(table, name) for name in axes]
        for row, along in enumerate(zip(*columns, strict=True) if columns else [() for _ in range(len(table))]):
            for place in itertools.product(*along):
                if place in self.places:
                    at = ", ".join(f"{name}={self.along[name][i]}" for name, i in zip(axes, place, strict=True))
                    raise ArgumentError(
                        f"table: expected one row at each place, got rows {self.places[place]} and {row} at "
                        f"{at or 'the same one'}; select by what sets them apart"
                    )
                self.places[place] = row

    def _places(self, table: pd.DataFrame, name: str) -> list[Sequence[int]]:
        """Where each row is along an axis: everywhere, where a technique does not have the setting."""
        numbers = {value: i for i, value in enumerate(self.along[name])}
        found: list[Sequence[int]] = []
        for value in plain_values(table[name]):
            if value is not None:
                found.append((numbers[value],))
            elif "." in name:
                found.append(range(len(numbers)))
            else:
                raise ArgumentError(f"table: expected rows with a {name}, got one without; select those that have one")
        return found

    def filled(self, column: pd.Series[Any]) -> NDArray[Any]:
        """The values of a column at their places: numbers with NaN, or texts, where there are no others."""
        values = plain_values(column)
        held = [values[row] for row in self.places.values()]
        texts = any(isinstance(value, str) for value in held)
        if texts:
            made: NDArray[Any] = np.full(self.shape, "", dtype=object)
        else:
            whole = len(self.places) == math.prod(self.shape) and None not in held
            kinds = {type(value) for value in held}
            dtype = bool if kinds == {bool} else np.int64 if kinds == {int} else np.float64
            made = np.zeros(self.shape, dtype) if whole else np.full(self.shape, np.nan)
        for place, value in zip(self.places, held, strict=True):
            try:
                made[place] = value if value is not None else "" if texts else np.nan
            except (TypeError, ValueError, OverflowError):
                raise ArgumentError(
                    f"table: expected numbers or texts in the column {shown(column.name)}, got {shown(value)}; drop it"
                ) from None
        return made

    def reduced(self, array: NDArray[Any]) -> tuple[tuple[str, ...], NDArray[Any]]:
        """An array without the axes along which it does not change, and those that it keeps."""
        there: NDArray[np.bool_] = np.zeros(self.shape, np.bool_)
        for place in self.places:
            there[place] = True
        kept: list[str] = []
        for name in self.axes:
            axis = len(kept)
            first = there.argmax(axis=axis, keepdims=True)
            one = np.take_along_axis(array, first, axis=axis)
            same = (array == one) | ~there | ((array != array) & (one != one))
            if bool(np.all(same)):
                array, there = one.squeeze(axis), np.logical_or.reduce(there, axis=axis)
            else:
                kept.append(name)
        return tuple(kept), array


def there(column: pd.Series[Any]) -> list[Any]:
    """The values that are not missing."""
    return [value for value in plain_values(column) if value is not None]


def plain_values(column: pd.Series[Any]) -> list[Any]:
    """The values of a column as Python has them; None for missing numbers and, of settings, for empty texts."""
    empty = "." in str(column.name)
    missing = column.isna().tolist()
    found: list[Any] = []
    for value, gone in zip(column.tolist(), missing, strict=True):
        found.append(None if gone or (empty and value == "") else value)
    return found


def is_empty_column(column: pd.Series[Any]) -> bool:
    """Whether nothing is in a column."""
    return bool((column.isna() | (column == "").fillna(False)).all())


def values_in_order(values: Sequence[Any]) -> list[Any]:
    """Each value once: numbers rising, texts as they come."""
    distinct = list(dict.fromkeys(values))
    numbers = all(isinstance(value, (int, float)) for value in distinct)
    return sorted(distinct) if numbers else distinct


def values_along(values: Sequence[Any]) -> NDArray[Any]:
    """The values of an axis as an array."""
    texts = any(isinstance(value, str) for value in values)
    return np.array(values, dtype=object if texts else None)


def about(name: str) -> dict[str, str]:
    """Unit and meaning of a column."""
    if name not in COLUMNS:
        return {}
    return {"units": COLUMNS[name].unit, "long_name": COLUMNS[name].doc}


def attribute(value: object) -> str | int | float:
    """An attribute as files of arrays take it: a number, or a text."""
    found = plain(value)
    return found if isinstance(found, (str, int, float)) else json.dumps(found)
