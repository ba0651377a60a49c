"""The answers of a sweep as they come in: kept, written to the store, and put together as the table."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np

from ... import _core
from ...errors import ArgumentError
from ...text import format_value, shown
from ...text.checked import a_path, has_all
from ..columns import COLUMNS, frame
from ..store.database import EXAMPLE_FILE
from ..store.keys import key_of_parts, run_key
from ..store.row_text import Cell
from ..store.store import Store
from .functions import text_of_metrics
from .plan import Plan, Planned, columns_with
from .space import settings_keys
from .work import Answer, failed

if TYPE_CHECKING:
    import pandas as pd


class StoreLike(Protocol):
    """What keeps rows by their keys: a `Store`, or anything that does the same."""

    def missing(self, keys: Iterable[str], /) -> list[str]:
        """The keys of which no done row is there."""

    def rows(self, keys: Iterable[str], /) -> Mapping[str, Mapping[str, Any]]:
        """The rows that are there."""

    def put(self, key: str, row: Mapping[str, Any], /, *, done: bool = True) -> None:
        """Keeps a row at once."""


class Collected:
    """The rows of a plan that are done.

    Parameters
    ----------
    plan : Plan
    store : Store, optional
        Has the rows that are done already, and gets those that will be.

    Raises
    ------
    ArgumentError
        For a store, and techniques whose settings are no plain values.
    """

    def __init__(self, plan: Plan, store: StoreLike | None = None):
        self.plan = plan
        self._store = store
        self._keys: dict[int, str] = {}
        self._rows: dict[int, Mapping[str, Cell]] = {}
        for place, planned in enumerate(plan.rows):
            if planned.request is None:
                self._rows[place] = failed(place, *planned.failure).row
        if store is not None:
            self._keys = keys_of(plan)
            missing = set(store.missing(list(self._keys.values())))
            there = store.rows([key for key in self._keys.values() if key not in missing])
            others = {*settings_keys()} - set(plan.settings)
            for place, key in self._keys.items():
                if key in there:
                    self._rows[place] = {name: cell for name, cell in there[key].items() if name not in others}

    def missing(self) -> list[int]:
        """The places of the rows that are not done."""
        return [place for place in range(self.plan.runs) if place not in self._rows]

    def add(self, answer: Answer) -> None:
        """Keeps an answer; the first of a row counts."""
        if answer.place in self._rows:
            return
        self._rows[answer.place] = answer.row
        if self._store is not None:
            row = {**answer.row, **self.plan.rows[answer.place].cells}
            self._store.put(self._keys[answer.place], row, done=answer.settled)

    def table(self) -> pd.DataFrame:
        """The table of the rows that are done, in the order of the plan."""
        import pandas as pd

        plan = self.plan
        rows = [whole_row(plan.rows[place], self._rows[place]) for place in sorted(self._rows)]
        known = columns_with(plan.settings, ())
        functions = dict.fromkeys(name for row in rows for name in row if name not in known and name not in COLUMNS)
        names = columns_with(plan.settings, list(functions))
        known_ones = frame([name for name in names if name in COLUMNS], rows)
        # At once: pandas warns of tables that a hundred columns were inserted into.
        made = pd.DataFrame(
            {name: known_ones[name] if name in COLUMNS else typed([row.get(name) for row in rows]) for name in names}
        )
        made.attrs.update(attributes(plan))
        return made


def whole_row(planned: Planned, row: Mapping[str, Cell]) -> dict[str, Cell]:
    """The row of an answer with what the plan knows of it, which goes before."""
    notes = "; ".join(text for text in (row.get("notes"), planned.note) if isinstance(text, str) and text)
    return {**row, **planned.cells, "notes": notes}


def keys_of(plan: Plan) -> dict[int, str]:
    """The keys of the rows in a store, by their places."""
    backend, adapter = plan.renderer.backend, plan.renderer.adapter
    drawn_by = backend if backend == "cpu" else f"{backend} ({adapter})"
    functions = text_of_metrics((), plan.functions)
    found = {}
    for place, planned in enumerate(plan.rows):
        request = planned.request
        if request is None:
            continue
        key = run_key(
            plan.views[planned.view].view, request.item, resolution=request.resolution or 1, metrics=plan.metrics,
            **request.read._asdict(), backend=drawn_by,
        )  # fmt: skip
        more = (request.memory, *functions)
        found[place] = key_of_parts(key, *more) if any(one is not None for one in more) else key
    return found


@contextmanager
def opened(store: object) -> Iterator[StoreLike | None]:
    """The store that is given, or that of a path, which is closed again.

    Raises
    ------
    ArgumentError
        For anything else.
    StoreError
        For a file that is no store.
    """
    if store is None:
        yield None
    elif isinstance(store, (str, os.PathLike)):
        with Store(a_path("store", store, EXAMPLE_FILE)) as made:
            yield made
    elif not isinstance(store, type) and has_all(store, "missing", "rows", "put"):
        yield cast("StoreLike", store)
    else:
        raise ArgumentError(f'store: expected a path or a Store, got {shown(store)}; try "{EXAMPLE_FILE}"')


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
    # A number among texts is written as a technique's text has it.
    texts = ["" if value is None else value if isinstance(value, str) else format_value(value) for value in values]
    return pd.Series(texts, dtype="object")


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
