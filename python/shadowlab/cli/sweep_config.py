"""What `shadowlab sweep` is asked to run, from a configuration: a space of `sl.sweep`, and how it is carried out.

`[space]` has the keys of `sl.sweep`. A setting of a technique is a dotted key in it, `lispsm.near = [1, 2]`, or one in
quotes, `"lispsm.near" = [1, 2]`; `[[space]]` is rows as they are, one table each. `[random]` draws rows from the space.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from ..experiments.metrics import KNOWN_METRICS
from ..experiments.sweeps.drawn_rows import random
from ..experiments.sweeps.plan import SWEPT_METRICS, read_in, size_in
from ..experiments.sweeps.space import EVERY, KEYS, WITH_LABELS, alternatives, settings_after, settings_of_techniques
from ..experiments.sweeps.sweep import MOST_WORKERS, checked_timeout
from ..experiments.sweeps.technique_values import owner_of
from ..scene import library
from ..text import parse_size, parse_spec, shown
from ..text.checks import BACKENDS
from .config import Table
from .nearest import nearest_text

if TYPE_CHECKING:
    from ..types import Backend

TOP_KEYS = ("space", "random", "size", "metrics", "store", "workers", "timeout", "backend", "out")
EXAMPLE_SPACE_TABLE = '[space] with scene = "@robots" and technique = ["uniform", "lispsm"]'
ENDS_OF_INTERVAL = {"min", "max"}

#: The values of a space by its keys, and the table and the key where each stands.
Values: TypeAlias = "dict[str, Any]"
Spots: TypeAlias = "dict[str, tuple[Table, str]]"


@dataclass(frozen=True)
class SweepConfig:
    """What a configuration says, checked as far as single values go.

    Attributes
    ----------
    space : dict or list of dict
        As `sl.sweep` takes it; of `[random]` the rows that were drawn.
    size : (int, int) or None
    metrics : tuple of str
    store, out : str or None
    workers : int or None
    timeout : float or None
    backend : str
    table : Table
        The top of the document.
    """

    space: Values | list[Values]
    size: tuple[int, int] | None
    metrics: tuple[str, ...]
    store: str | None
    out: str | None
    workers: int | None
    timeout: float | None
    backend: Backend
    table: Table


def sweep_config(top: Table) -> SweepConfig:
    """What the configuration says.

    Raises
    ------
    ArgumentError
        For a key that does not exist or a value that does not fit, with file, line and key.
    """
    top.only(TOP_KEYS)
    metrics = top.texts("metrics", f"some of {', '.join(KNOWN_METRICS)}") or list(SWEPT_METRICS)
    for name in metrics:
        if name not in KNOWN_METRICS:
            raise top.wrong("metrics", f"unknown metric {shown(name)}; {nearest_text(name, KNOWN_METRICS)}")
    backend = top.text("backend", f"one of {', '.join(BACKENDS)}", "auto") or "auto"
    if backend not in BACKENDS:
        raise top.wrong("backend", f"unknown renderer {shown(backend)}; {nearest_text(backend, BACKENDS)}")
    timeout = top.number("timeout", "seconds above 0")
    with top.naming("timeout"):
        checked_timeout(timeout)
    return SweepConfig(
        space_of(top),
        size_of_config(top),
        tuple(metrics),
        top.text("store", "the name of a file such as runs.sqlite"),
        top.text("out", "the name of a file such as table.csv"),
        workers_of_config(top),
        timeout,
        backend,
        top,
    )


def workers_of_config(top: Table) -> int | None:
    """The number of processes, if there is one."""
    if "workers" not in top:
        return None
    found = top.whole("workers", 1)
    if found > MOST_WORKERS:
        raise top.wrong("workers", f"expected at most {MOST_WORKERS:,} processes, got {found:,}; try 2")
    return found


def size_of_config(top: Table) -> tuple[int, int] | None:
    """The size of all pictures, a text or two numbers."""
    value = top.get("size")
    if value is None:
        return None
    with top.naming("size"):
        return parse_size("x".join(map(str, value)) if isinstance(value, list) else str(value))


def space_of(top: Table) -> Values | list[Values]:
    """The space, or the rows that are drawn from it."""
    if isinstance(top.get("space"), list):
        rows = top.tables("space")
        if not rows:
            raise top.wrong("space", f"expected at least one row, got none; try {EXAMPLE_SPACE_TABLE}")
        if "random" in top:
            raise top.wrong("random", "expected one table [space] to draw from, got rows; remove [random]")
        return [values_in(row)[0] for row in rows]
    table = top.table("space", EXAMPLE_SPACE_TABLE)
    if table is None:
        raise top.wrong("space", f"expected a table, got none; try {EXAMPLE_SPACE_TABLE}")
    values, _ = values_in(table)
    drawn = top.table("random", "{ n = 100, seed = 1 }")
    if drawn is None:
        for key, value in values.items():
            if is_interval(key, value):
                message = "expected a list of values, got an interval; [random] with n and seed draws from intervals"
                raise table.wrong(key, message)
        return values
    drawn.only(("n", "seed"))
    if "n" not in drawn:
        raise drawn.wrong("n", "expected how many rows are drawn, got none; add n = 100")
    with drawn.naming(None):
        return random(values, drawn.whole("n", 1), drawn.whole("seed", 0, 0))


def values_in(table: Table) -> tuple[Values, Spots]:
    """The values of a space, each checked where it can be checked alone, and where they stand."""
    values: Values = {}
    spots: Spots = {}
    for spelt, value in table.values.items():
        key = spelt.strip()
        of_technique = isinstance(value, dict) and key not in KEYS
        parts = value.items() if of_technique else [("", value)]
        place = table.table(spelt, "") if of_technique else table
        assert place is not None
        for name, one in parts:
            full = f"{key}.{name.replace('-', '_')}" if name else key
            at = place, (name or spelt)
            check_space_key(*at, full)
            if full in values:
                raise at[0].wrong(at[1], f"{full} is given twice; give it once")
            values[full], spots[full] = one, at
            check_values(*at, full, one)
    for needed in ("scene", "technique"):
        if needed not in values:
            raise table.wrong(needed, f"expected one or several, got none; try {EXAMPLE_SPACE_TABLE}")
    if "resolution" in values and "memory" in values:
        raise table.wrong("memory", "expected resolution or memory, got both; the memory decides the resolution")
    return values, spots


def check_space_key(table: Table, key: str, full: str) -> None:
    """Raises for a key that `sl.sweep` does not have, with the nearest one."""
    if full in KEYS:
        return
    owner, dot, setting = full.rpartition(".")
    if not dot:
        raise table.wrong(key, f"unknown key; {nearest_text(full, KEYS)}, or a technique's setting such as lispsm.near")
    settings = settings_after(owner)
    if settings is None:
        known = (*settings_of_techniques(), EVERY)
        raise table.wrong(key, f"unknown technique {owner!r}; {nearest_text(owner, known)}")
    if setting not in settings:
        raise table.wrong(key, f"unknown setting {setting!r} of {owner}; {nearest_text(setting, settings)}")


def is_interval(key: str, value: object) -> bool:
    """Whether rows are drawn from between two numbers."""
    return isinstance(value, Mapping) and set(value) >= ENDS_OF_INTERVAL and key not in WITH_LABELS


def check_values(table: Table, key: str, full: str, value: object) -> None:
    """Checks the values of a key, as far as one can without loading scenes."""
    if is_interval(full, value):
        return
    with table.naming(key):
        for one in alternatives(full, value):
            if full == "scene":
                check_scene_text(one.value, table, key)
            elif full == "technique":
                check_technique_name(owner_of(one), table, key)
            elif full in ("resolution", "memory"):
                size_in({full: one})
            elif full in ("bias", "filter", "stored", "blend"):
                read_in({full: one})


def check_technique_name(name: str, table: Table, key: str) -> None:
    """Raises for a technique that does not exist; presets and matrices are found by the plan."""
    known = (*settings_of_techniques(), "matrix")
    if not name.startswith("preset:") and name not in known:
        raise table.wrong(key, f"unknown technique {name!r}; {nearest_text(name, known)}")


def check_scene_text(value: object, table: Table, key: str) -> None:
    """Raises for a scene that is not there; it is not loaded yet."""
    if not isinstance(value, str) or not value:
        raise table.wrong(key, f'expected a scene such as "@robots", or a mesh file, got {shown(value)}')
    if value.startswith("@"):
        name = parse_spec(value[1:], "scene")[0]
        if name not in library.names():
            raise table.wrong(key, f"unknown scene {shown(value)}; {nearest_text(name, library.names())}")
    elif not Path(value).exists():
        raise table.wrong(key, f"cannot find the file {shown(value)}; paths are relative to where the command runs")
