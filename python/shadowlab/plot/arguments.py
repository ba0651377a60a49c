"""What plots ask of their arguments: dictionaries of labels, tables with columns, and what a column's unit is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from ..aliasing.footprint import Footprint
from ..aliasing.summary import Summary
from ..errors import ArgumentError
from ..experiments.columns import with_current
from ..text import shown
from ..text.arrays import checked_array, checked_items
from ..text.checked import a_length, optional

T = TypeVar("T")

#: Of a camera, for pictures whose pixels are not square.
an_aspect = optional(a_length)

if TYPE_CHECKING:
    import pandas as pd

# What columns of tables are, and their units, where that is more than their name.
COLUMN_LABELS = {
    "angle_deg": ("angle between light and view", "degrees"),
    "elevation_deg": ("elevation of the light", "degrees"),
    "azimuth_deg": ("azimuth of the light", "degrees"),
    "bytes": ("memory of the maps", "bytes"),
    "memory": ("budget of depth texels", "bytes"),
    "resolution": ("texels along each side of the map", ""),
    "texel_max": ("longest extent of a texel, worst", "pixels per texel"),
    "texel_mean": ("longest extent of a texel, mean", "pixels per texel"),
    "texel_rms": ("longest extent of a texel, root mean square", "pixels per texel"),
    "texel_p50": ("longest extent of a texel, median", "pixels per texel"),
    "texel_p95": ("longest extent of a texel, 95th percentile", "pixels per texel"),
    "texel_p99": ("longest extent of a texel, 99th percentile", "pixels per texel"),
    "perspective_max": ("extent of a texel by perspective alone, worst", "pixels"),
    "perspective_mean": ("extent of a texel by perspective alone, mean", "pixels"),
    "undersampled": ("undersampled pixels", "share of those measured"),
    "share": ("wrong pixels", "share of those compared"),
    "misclassified": ("wrong pixels", "count"),
    "storage_factor": ("storage factor", "texels per pixel"),
}
COLUMN_UNITS = {
    "_px": "pixels", "_texels": "texels", "_deg": "degrees", "_ms": "milliseconds", "_s": "seconds",
    "_world": "world units", "_ndc": "NDC", "_fraction": "share",
}  # fmt: skip


def current_columns(table: T, wanted: list[str]) -> T:
    """The table with the wanted columns under the names that they have now; something else as it is."""
    import pandas as pd

    return cast("T", with_current(table, wanted)) if isinstance(table, pd.DataFrame) else table


def title_and_unit(column: object) -> tuple[str, str]:
    """What a column is, and its unit where the name gives one."""
    name = str(column)
    if name in COLUMN_LABELS:
        return COLUMN_LABELS[name]
    for suffix, unit in COLUMN_UNITS.items():
        if name.endswith(suffix) and len(name) > len(suffix):
            return column_words(name[: -len(suffix)]), unit
    return column_words(name), ""


def column_words(name: str) -> str:
    """The name of a column as words; that of a technique's setting, lispsm.near_factor, as people write it."""
    return name if "." in name else name.replace("_", " ")


def column_label(column: object) -> str:
    """What an axis says of a column, with its unit where the name gives one."""
    return ", ".join(text for text in title_and_unit(column) if text)


def dictionary_of(given: object, name: str, what: str) -> dict[str, Any]:
    """The dictionary, checked to be one that has an entry."""
    if not isinstance(given, Mapping) or not given:
        came = "an empty one" if isinstance(given, Mapping) else shown(given)
        raise ArgumentError(f'{name}: expected a dictionary of labels and {what}, got {came}; give {{"label": ...}}')
    return dict(given)


def footprints_of(given: object) -> dict[str, Footprint | Summary]:
    """The dictionary of footprints, or one without a label, checked; a summary may stand for one."""
    found = {"": given} if isinstance(given, (Footprint, Summary)) else dictionary_of(given, "footprints", "footprints")
    for label, value in found.items():
        if not isinstance(value, (Footprint, Summary)):
            raise ArgumentError(
                f"footprints: expected a Footprint of {label!r}, got {shown(value)}; "
                "sl.aliasing.footprint(...) makes one"
            )
    return found


def pair_of(given: object, name: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Depths and values (N,) of a curve, checked: positive where they are numbers; values may have gaps."""
    both = checked_items(name, given, "depths and values, two arrays (N,)", "give (z, values)")
    if len(both) != 2:
        raise ArgumentError(f"{name}: expected depths and values, two arrays (N,), got {shown(given)}")
    z, values = (np.atleast_1d(checked_array(name, numbers)) for numbers in both)
    if z.ndim != 1 or z.shape != values.shape:
        raise ArgumentError(
            f"{name}: expected as many depths as values, both (N,), got shapes {z.shape} and {values.shape}; "
            "evaluate the curve at its depths"
        )
    if not (np.isfinite(z) & (z > 0)).all() or (values <= 0).any():
        raise ArgumentError(
            f"{name}: expected positive numbers, for logarithmic axes, got others; leave those points out, "
            "or make values NaN where the line shall have a gap"
        )
    return z, np.where(np.isfinite(values), values, np.nan)


def column_name(name: str, column: object) -> None:
    """Raises for what is no name of a column; `name` is that of the argument."""
    if not isinstance(column, str) or not column:
        raise ArgumentError(f"{name}: expected names of columns, got {shown(column)}; name one of the table")


def columns_of(table: object, needed: Iterable[str], name: str = "table") -> pd.DataFrame:
    """The table, checked to be a pandas one with these columns."""
    import pandas as pd

    needed = list(needed)
    for one in needed:
        column_name(name, one)
    if not isinstance(table, pd.DataFrame):
        columns = ", ".join(map(str, needed)) or "of runs"
        raise ArgumentError(f"{name}: expected a pandas table with columns {columns}, got {shown(table)}")
    absent = [column for column in needed if column not in table.columns]
    if absent:
        there = ", ".join(map(_word, table.columns)) or "none"
        raise ArgumentError(
            f"{name}: expected columns {', '.join(map(_word, needed))}; there is no {', '.join(map(_word, absent))} "
            f"among {there}; rename or name another"
        )
    return table


def _word(column: object) -> str:
    """The name of a column for messages: as it is where it is a plain word."""
    return column if isinstance(column, str) and column.isidentifier() and len(column) < 40 else shown(column)


def numbers_of(table: pd.DataFrame, column: object) -> NDArray[np.float64]:
    """A column as numbers; NaN where there is none."""
    try:
        return np.asarray(table[column].to_numpy(dtype=np.float64, na_value=np.nan))
    except (TypeError, ValueError):
        raise ArgumentError(
            f"{column}: expected a column of numbers, got {shown(list(table[column])[:4])}; convert it, e.g. with "
            "pandas.to_numeric"
        ) from None


def image_of(given: object, shape: tuple[int, ...], name: str) -> NDArray[Any]:
    """The image, checked to have this shape."""
    image = checked_array(name, given)
    if image.shape != shape:
        raise ArgumentError(
            f"{name}: expected shape {shape}, the G-buffer's, got {image.shape}; render both at one size"
        )
    return image


def count_of(value: object, name: str, *, least: int = 1, most: int | None = None) -> int:
    """A whole number that is neither less nor more."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < least:
        raise ArgumentError(f"{name}: expected a whole number of at least {least}, got {shown(value)}")
    if most is not None and value > most:
        raise ArgumentError(f"{name}: expected at most {most:,}, got {shown(value)}; a plot shows no more")
    return int(value)
