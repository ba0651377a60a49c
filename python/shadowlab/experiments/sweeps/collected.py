"""The answers of a sweep as they come in: kept, written to the store, and put together as the table."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ... import _core
from ..columns import COLUMNS, frame
from .functions import text_of_metrics
from .plan import Plan, Planned, columns_with
from .work import Answer, Plain, failed

if TYPE_CHECKING:
    import pandas as pd

    from .work import Group


class StoreLike(Protocol):
    """What keeps rows by their keys: a `Store`, or anything that does the same."""

    def rows(self, keys: Iterable[str]) -> Mapping[str, Mapping[str, Plain]]:
        """The rows that are there."""

    def put(self, key: str, row: Mapping[str, Plain]) -> None:
        """Keeps a row at once."""


class Collected:
    """The rows of a plan that are done.

    Parameters
    ----------
    plan : Plan
    keys : sequence of str
        The digest of each row; empty of a row without a request, and of all without a store.
    store : Store, optional
        Has the rows that are done already, and gets those that will be.
    """

    def __init__(self, plan: Plan, keys: Sequence[str] = (), store: StoreLike | None = None):
        self.plan = plan
        self._keys, self._store = keys, store
        self._rows: dict[int, Mapping[str, Plain]] = {}
        for place, planned in enumerate(plan.rows):
            if planned.request is None:
                self._rows[place] = failed(place, *planned.failure).row
        if store is not None:
            there = store.rows([key for key in keys if key])
            self._rows |= {place: there[key] for place, key in enumerate(keys) if key in there}

    def missing(self) -> list[int]:
        """The places of the rows that are not done."""
        return [place for place in range(self.plan.runs) if place not in self._rows]

    def lacks(self, group: Group) -> list[int]:
        """The places of the rows of a group that are not done."""
        return [request.place for request in group.requests if request.place not in self._rows]

    def add(self, answer: Answer) -> None:
        """Keeps an answer; the first of a row counts."""
        if answer.place in self._rows:
            return
        self._rows[answer.place] = answer.row
        if self._store is not None and answer.settled:
            row = whole_row(self.plan.rows[answer.place], answer.row)
            self._store.put(self._keys[answer.place], row)

    def table(self) -> pd.DataFrame:
        """The table of the rows that are done, in the order of the plan."""
        plan = self.plan
        rows = [whole_row(plan.rows[place], self._rows[place]) for place in sorted(self._rows)]
        known = {*columns_with(plan.settings, ()), "dropped"}
        functions = list(
            dict.fromkeys(name for row in rows for name in row if name not in known and name not in COLUMNS)
        )
        names = columns_with(plan.settings, functions)
        made = frame([name for name in names if name in COLUMNS], rows)
        for i, name in enumerate(names):
            if name not in COLUMNS:
                made.insert(i, name, typed([row.get(name) for row in rows]))
        made.attrs.update(attributes(plan))
        return made


def whole_row(planned: Planned, row: Mapping[str, Plain]) -> dict[str, Plain]:
    """The row of an answer with what the plan knows of it, which goes before."""
    found = {**row, **planned.cells}
    dropped = found.pop("dropped", None)
    if dropped:
        found["notes"] = "; ".join(str(text) for text in (row.get("notes"), dropped) if text)
    return found


def typed(values: Sequence[Any]) -> pd.Series[Any]:
    """A column of the type that all its values have: whole numbers, numbers, truth values, else texts."""
    import pandas as pd

    kinds = {type(value) for value in values if value is not None}
    if kinds == {bool}:
        return pd.Series(values, dtype="boolean")
    if kinds and kinds <= {int}:
        return pd.Series(values, dtype="Int64")
    if not kinds or kinds <= {int, float}:
        return pd.Series([np.nan if value is None else float(value) for value in values], dtype="float64")
    texts = ["" if value is None else value if isinstance(value, str) else text_of(value) for value in values]
    return pd.Series(texts, dtype="object")


def text_of(value: bool | int | float) -> str:
    """A number among texts, as a technique's text has it."""
    from ...text import format_value

    return format_value(value)


def attributes(plan: Plan) -> dict[str, Any]:
    """What a table says of itself: versions, machine, renderer, and what was asked for."""
    import pandas as pd

    sizes = {view.size for view in plan.views}
    return {
        "shadowlab": _core.__version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "pandas": pd.__version__,
        "machine": f"{platform.system()} {platform.release()}, {platform.machine()}, {os.cpu_count() or 1} cores",
        "backend": plan.renderer.backend,
        "adapter": plan.renderer.adapter,
        "size": [list(size) for size in sorted(sizes)],
        "metrics": list(text_of_metrics(plan.metrics, plan.functions)),
        "swept": list(plan.swept),
        "notes": list(plan.notes),
    }
