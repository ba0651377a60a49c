"""The rows of a store as a table."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ...text.checked import a_flag, a_path
from ..columns import COLUMNS, frame
from .database import EXAMPLE_FILE, opened_to_read
from .keys import ALGORITHMS
from .row_filter import row_filter
from .row_text import Cell
from .whole import all_rows

if TYPE_CHECKING:
    import pandas as pd

#: What says which run a row is of, and so how a table is ordered.
ORDER = ("scene", "view", "technique", "resolution", "key")


def read_store(path: str | os.PathLike[str], where: str | None = None, *, old: bool = False) -> pd.DataFrame:
    """The rows of a store as a table, in the vocabulary of columns of all tables.

    Other processes may write to it meanwhile: the table is that of one moment.

    Parameters
    ----------
    path : path
        What `sl.Store` or `sl.sweep(..., store=path)` wrote.
    where : str, optional
        Which rows: comparisons of columns, numbers and texts with ``and``, ``or``, ``not``, ``in``, ``is None`` and
        arithmetic, as in ``'misclassified > 0 and technique in ["lispsm", "tsm"]'``; SQL's ``=``, ``<>`` and ``AND``
        mean the same. Names with other letters stand in backticks. A comparison with a missing value is not true, and
        neither is its ``not``.
    old : bool
        Whether rows that other versions of the algorithms made are among them.

    Returns
    -------
    DataFrame
        A row per run, those that failed among them, by scene, view, technique and resolution. Columns of
        docs/columns.md come first, in their order there and with their dtypes, then others by name, then `key`.

    Raises
    ------
    ArgumentError
        For something that is no path, and a `where` that does not read or compares texts with numbers.
    UnknownNameError
        For a column that is not there; the message lists those that are.
    StoreError
        For a file that is missing, foreign, newer, damaged or locked.

    Examples
    --------
    >>> import tempfile, shadowlab as sl
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = f"{folder.name}/runs.sqlite"
    >>> with sl.Store(path) as store:
    ...     for i, technique in enumerate(["uniform", "lispsm"]):
    ...         store.put(str(i), {"technique": technique, "misclassified": 12 - 12 * i})
    >>> list(sl.read_store(path, where="misclassified > 0")["technique"])
    ['uniform']
    """
    file, every = a_path("path", path, EXAMPLE_FILE), a_flag("old", old)
    connection = opened_to_read(file)
    try:
        kept = list(all_rows(file, connection))
    finally:
        connection.close()
    rows: list[dict[str, Cell]] = [
        {**one.cells(file), "key": one.key} for one in kept if every or one.version == ALGORITHMS
    ]
    names = ordered_names(rows)
    if where is not None:
        wanted = row_filter(where, names)
        rows = [row for row in rows if wanted(row)]
    return frame(names, sorted(rows, key=_place))


def ordered_names(rows: Sequence[Mapping[str, Cell]]) -> list[str]:
    """The columns of rows: known ones in their order, then others by name, then the key."""
    there = {name for row in rows for name in row} - {"key"}
    return [*(name for name in COLUMNS if name in there), *sorted(there - set(COLUMNS)), "key"]


def _place(row: Mapping[str, Cell]) -> tuple[tuple[bool, Any], ...]:
    """Where a row stands; what a column holds of another type than usual comes last."""
    values = [(name, row.get(name)) for name in ORDER]
    fits = [isinstance(value, int if name == "resolution" else str) for name, value in values]
    return tuple((not fit, value if fit else 0) for fit, (_, value) in zip(fits, values, strict=True))
