"""The command `shadowlab sweep`: a space of views and techniques from a configuration, measured run by run."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import ArgumentError
from ..experiments.memory import memory_text
from ..text import counted, is_missing, plain, share_text
from .command import Argument, Command, Option, Options
from .config import read_config
from .options import writable_file
from .sweep_config import sweep_config

if TYPE_CHECKING:
    import pandas as pd

    from ..experiments.sweeps.plan import Plan

# Lines of the table that a terminal shows.
SHOWN_ROWS = 40
TIMED_RUNS = 3


def sweep_command(options: Options) -> int:
    """Measures every run of a space: scenes, cameras, lights, techniques and their settings, resolutions.

    CONFIG.toml says which; docs/sweep_config.md has its keys. Rows are written to the store as they are done, and a
    sweep that was stopped goes on where it was. Paths are relative to the folder that the command runs in.
    """
    from ..experiments.sweeps.plan import plan_of
    from ..experiments.sweeps.sweep import planned_table

    config = sweep_config(read_config(options.config))
    store = config.store if options.store is None else options.store
    workers = config.workers if options.workers is None else options.workers
    out = config.out if options.out is None else options.out
    write = None if out is None else writer(out)
    if store is not None and out is not None and os.path.realpath(store) == os.path.realpath(out):
        raise ArgumentError(f"out: expected another file than the store, got {out!r} for both; rename one")
    if store is not None:
        with config.table.naming("store") if options.store is None else nullcontext():
            check_store(store, options.resume)
    if write is not None and not options.dry_run:
        writable_file("out", str(out))
    with config.table.naming("space"):
        plan = plan_of(config.space, size=config.size, metrics=config.metrics, renderer=config.backend)
    if options.dry_run:
        print(dry_run_text(options.config, plan, store, workers))
        return 0
    table = planned_table(plan, store=store, workers=workers, timeout=config.timeout)
    failed = table[table["failure"] != ""]
    if len(failed) == len(table):
        which = f"all {len(table):,} runs failed, the first" if len(table) > 1 else "the only run failed"
        raise ArgumentError(f"{which}: {table['failure'].iloc[0]}")
    print(shown_table(table))
    print(f"\n{counted(len(table), 'run')}" + (f", {len(failed):,} of them failed" if len(failed) else ""))
    for failure, count in failed["failure"].value_counts().items():
        print(f"  {count:,}: {failure}")
    if store is not None:
        print(f"Store: {store}")
    if write is not None:
        write(table)
        print(f"Table: {out}")
    return 0


def check_store(store: str, resume: bool) -> None:
    """Raises for a store that cannot be written, and for one that is there where nothing is to be resumed.

    Raises
    ------
    ArgumentError
    """
    if Path(store).exists() and not resume:
        raise ArgumentError(f"no-resume: {store!r} is there; name another --store, remove it, or go on with --resume")
    if not Path(store).parent.is_dir():
        raise ArgumentError(f"store: expected a file in a folder that is there, got {store!r}; make the folder")


def dry_run_text(path: str, plan: Plan, store: str | None, workers: int | None) -> str:
    """What a sweep would do: runs, views, what varies, what was left out, and the estimate of time and memory."""
    from ..experiments.sweeps.estimate import estimate

    found = estimate(plan, TIMED_RUNS)
    missing = missing_runs(plan, store)
    whole, rest = (sum(group.cost for group in plan.groups(places)) for places in (None, missing))
    scenes = {id(view.view.scene) for view in plan.views}
    lines = [
        f"{path}: {counted(plan.runs, 'run')} in {counted(len(plan.views), 'view')} "
        f"of {counted(len(scenes), 'scene')}, on {plan.backend}",
        f"What varies: {', '.join(plan.swept) or 'nothing'}",
        *(f"Note: {note}" for note in plan.notes),
    ]
    if store is not None:
        # Runs without a request fail without being run.
        there = sum(row.request is not None for row in plan.rows) - len(missing)
        said = f"{there:,} of them are there" if Path(store).exists() else "a new file"
        lines.append(f"Store: {store}, {said}")
    each = f"{found.bytes / 2**20:,.0f} MiB of memory"
    if workers is not None:
        each += f" in each of {counted(workers, 'process', 'processes')}"
    if found.seconds is None:
        return "\n".join([*lines, f"Estimate: {each}; no run could be timed, so nothing is said of the time"])
    seconds = found.seconds * rest / whole if whole else 0.0
    timed = f"from {counted(found.timed, 'timed run')} and the sizes of all"
    lines.append(f"Estimate: {duration_text(seconds)} in one process, {each}; {timed}")
    if workers is not None and workers > 1:
        at_best = duration_text(seconds / workers)
        lines.append(f"Workers share the cores of the machine: at best {at_best} with {workers}")
    return "\n".join(lines)


def missing_runs(plan: Plan, store: str | None) -> list[int]:
    """The places of the runs that are not in the store yet."""
    from ..experiments.sweeps.collected import Collected, opened

    if store is None or not Path(store).exists():
        return [place for place, row in enumerate(plan.rows) if row.request is not None]
    with opened(store) as kept:
        return Collected(plan, kept).missing()


def duration_text(seconds: float) -> str:
    """A time as people say it."""
    if seconds < 90:
        return f"{seconds:.1f} s" if seconds < 9.95 else f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


def shown_table(table: pd.DataFrame) -> str:
    """The first rows with what varies and what was counted, aligned."""
    from ..reports.terminal import aligned

    names = [*table.attrs.get("swept", ["technique"])]
    counted_too = ("misclassified", "share", "texel_p95", "unused", "seconds")
    names += [name for name in counted_too if name in table and table[name].notna().any()]
    rows = [[cell_text(row[name], name) for name in names] for row in table.head(SHOWN_ROWS).to_dict("records")]
    left = [i for i, name in enumerate(names) if table[name].dtype == object]
    more = len(table) - SHOWN_ROWS
    return aligned(names, rows, left=left) + (f"\n… and {more:,} more" if more > 0 else "")


def cell_text(value: object, name: str) -> str:
    """A cell of a column as people read it; a dash where there is nothing."""
    known = known_cell(value)
    if known is None or known == "":
        return "–"
    if name == "share":
        return share_text(known)
    if name == "memory":
        return memory_text(known)
    if isinstance(known, float):
        return f"{known:.4g}"
    return f"{known:,}" if isinstance(known, int) and name != "resolution" else str(known)


def known_cell(value: object) -> Any:
    """A cell as JSON has it; None for what is missing."""
    return None if is_missing(value) else plain(value)


def writer(path: str) -> Callable[[pd.DataFrame], None]:
    """What writes a table to a file, by the file's ending.

    Raises
    ------
    ArgumentError
        For another ending, and for parquet where nothing is installed that writes it.
    """
    ending = Path(path).suffix.lower()
    if ending not in WRITERS:
        raise ArgumentError(f"out: expected a file that ends in one of {', '.join(WRITERS)}, got {path!r}; rename it")
    if ending == ".parquet":
        from importlib.util import find_spec

        if find_spec("pyarrow") is None and find_spec("fastparquet") is None:
            raise ArgumentError("out: expected pyarrow for parquet, got none; pip install pyarrow, or write .csv")

    def write(table: pd.DataFrame) -> None:
        try:
            WRITERS[ending](table, path)
        except OSError as error:
            raise ArgumentError(f"out: cannot write {path!r} ({error.strerror or error})") from error

    return write


def write_json(table: pd.DataFrame, path: str) -> None:
    """A list of rows, null where nothing is known."""
    import json

    rows = [{name: known_cell(value) for name, value in row.items()} for row in table.to_dict("records")]
    text = json.dumps(rows, indent=1, allow_nan=False, ensure_ascii=False)
    Path(path).write_text(f"{text}\n", encoding="utf-8")


WRITERS: Mapping[str, Callable[[pd.DataFrame, str], None]] = {
    ".csv": lambda table, path: table.to_csv(path, index=False),
    ".json": write_json,
    ".parquet": lambda table, path: table.to_parquet(path, index=False),
}
SWEEP = Command(
    "sweep",
    sweep_command,
    [
        Argument("config", metavar="CONFIG.toml", type=click.Path(), help="the space, and how it is carried out"),
        Option("--store", metavar="FILE", type=click.Path(), help="write rows there as they are done (SQLite)"),
        Option("--workers", metavar="N", type=click.IntRange(1, 1024), help="so many processes (default: this one)"),
        Option(
            "--dry-run", is_flag=True, help="run nothing but three runs that are timed: how many runs, time and memory"
        ),
        Option(
            "--resume/--no-resume", default=True, help="whether to go on with a store that is there (default: resume)"
        ),
        Option("--out", metavar="FILE", type=click.Path(), help="write the table there: .csv, .json or .parquet"),
    ],
)
