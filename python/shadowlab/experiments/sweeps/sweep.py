"""`sl.sweep`: techniques in views, measured, as one table; a loop over `evaluate`, wherever that runs.

```
    space --plan--> rows --store--> those that are missing --groups by view, largest first--> run --> table
                                                            in_process | workers | executors
```
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import TYPE_CHECKING

from ... import _core
from ...errors import ArgumentError, WorkerError
from ...text import shown
from ...text.arrays import checked_number
from ...text.checked import a_count
from ...text.progress import checked_progress, steps_of_call
from .collected import Collected, opened
from .executors import KINDS, place_for, run_in_place, run_in_threads, takes_calls
from .in_process import run_here
from .joblib_calls import is_parallel, run_in_joblib
from .plan import SWEPT_METRICS, Plan, plan_of
from .work import Answer, Group, Task, failed
from .workers import run_in_workers

if TYPE_CHECKING:
    import pandas as pd

    from ...types import RendererArgument, RendererLike, Size
    from ..metrics import Metric
    from .collected import StoreLike
    from .functions import Function

# More than machines have cores.
MOST_WORKERS = 1024
# A year.
LONGEST_RUN_S = 3.2e7


def sweep(
    space: Mapping[str, object] | Iterable[Mapping[str, object]],
    *,
    size: Size | None = None,
    store: str | os.PathLike[str] | StoreLike | None = None,
    executor: object = None,
    workers: int | None = None,
    metrics: Metric | Function | Sequence[Metric | Function] = SWEPT_METRICS,
    progress: bool | None = None,
    timeout: float | None = None,
    renderer: RendererArgument = None,
) -> pd.DataFrame:
    """Techniques in views, measured: one row per run, whatever fails.

    Parameters
    ----------
    space : dict, or sequence of dict
        A dict of key to value or list of values is their full product; a list of dicts is rows as they are;
        `sl.random` draws some from a space. Keys: "scene" (a Scene, "@robots" of the library, a file), "camera" (a
        Camera, the name of one of the scene's, "own" for that of a library scene, or one of the views "along", "above"
        and "against"), "light" (a light, several together as a tuple, a name as for cameras, or a direction
        "0.3,-1,0.1"), "technique" (as `sl.technique` takes it; "all" for each with its defaults), "technique.setting"
        such as "lispsm.near" (or literally "technique.near" for all that have it), "resolution" (texels along each
        side, 1024) or "memory" (bytes, "4 MiB"), "bias", "filter", "stored" and "blend" as of `sl.evaluate`. A dict of
        label to value names scenes, cameras, lights and techniques. Views that are left out are the scene's own or
        "along". A setting that a technique does not have drops out for it, and is said in `notes`.
    size : int, (int, int), optional
        Width and height of all pictures, pixels. About 1024 * 1024 of the camera's aspect where none is given.
    store : path or Store, optional
        Rows are written to it as they are done, and not computed again where they are there.
    executor : optional
        Where the runs are carried out: any `concurrent.futures.Executor`, a Dask `Client`, or a `joblib.Parallel`.
    workers : int, optional
        So many processes of their own, which share the cores. Without either, runs are in this process.
    metrics : str, callable, or sequence of them
        Names as of `sl.evaluate`, and functions ``f(run)`` that give a number or a dict of numbers. What they raise is
        the failure of the row.
    progress : bool, optional
        Whether to show a progress bar; on terminals and in notebooks where nothing is given, True anywhere.
    timeout : float, optional
        Seconds after which a run is a failure. Calls of the core end then; Python of a metric ends on the main thread
        and in worker processes, and is waited for in threads of an executor.
    renderer : Renderer or str, optional
        As of `sl.evaluate`.

    Returns
    -------
    DataFrame
        Columns as of docs/columns.md, with one per setting and per number of a function. `failure` and `failure_type`
        are empty where there are numbers. `attrs` has versions, the machine, the adapter, and what was swept. Equal
        for any executor, number of workers and order, times aside.

    Raises
    ------
    ArgumentError
        For a space, a value or an argument of another kind, and what cannot be sent to other processes.
    UnknownNameError
        For a key, scene, camera, light, technique, setting, metric, filter or renderer that does not exist.
    LoadError
        For a scene's file that cannot be read.
    StoreError
        For a store that is no store, or that cannot be written.
    WorkerError
        Where workers cannot be started.

    Examples
    --------
    >>> import shadowlab as sl
    >>> space = {"scene": "@robots", "technique": ["uniform", "lispsm"], "lispsm.near": [1, 2], "resolution": 128}
    >>> df = sl.sweep(space, size=(160, 90), renderer="cpu")
    >>> df[["technique", "lispsm.near", "misclassified"]].shape, set(df["failure"])
    ((3, 3), {''})
    """
    checked_progress(progress)
    limit = checked_timeout(timeout)
    count = None if workers is None else a_count(1, MOST_WORKERS)("workers", workers)
    if executor is not None and not is_parallel(executor) and not takes_calls(executor):
        raise ArgumentError(f"executor: expected {KINDS}, got {shown(executor)}; workers=2 starts two processes")
    if count is not None and executor is not None:
        raise ArgumentError("workers: expected none beside an executor, got both; the executor has its own")
    plan = plan_of(space, size=size, metrics=metrics, renderer=renderer)
    return planned_table(plan, store=store, executor=executor, workers=count, progress=progress, timeout=limit)


def planned_table(
    plan: Plan,
    *,
    store: str | os.PathLike[str] | StoreLike | None = None,
    executor: object = None,
    workers: int | None = None,
    progress: bool | None = None,
    timeout: float | None = None,
) -> pd.DataFrame:
    """The table of a plan, with the arguments of `sweep`, which have been checked.

    Raises
    ------
    ArgumentError
        For what cannot be sent to other processes.
    StoreError, WorkerError
        As of `sweep`.
    """
    task = Task(plan.metrics, plan.functions, plan.renderer, timeout)
    with opened(store) as kept:
        collected = Collected(plan, kept)
        groups = plan.groups(collected.missing())
        with steps_of_call(sum(len(group.requests) for group in groups), progress) as step:
            if groups:
                carry_on(groups, task, collected, step, executor, workers)
        return collected.table()


def carry_on(
    groups: Sequence[Group],
    task: Task,
    collected: Collected,
    step: Callable[[str], None],
    executor: object,
    workers: int | None,
) -> None:
    """Adds the answer of every run, made where it is asked for."""
    add = told(collected, step)
    sent = replace(task, renderer=sendable(task.renderer))
    if workers is not None:
        run_in_workers(groups, sent, add, workers)
    elif executor is None:
        run_here(groups, task, collected.add, step)
    elif isinstance(executor, ThreadPoolExecutor):
        run_in_threads(groups, task, add, executor)
    elif is_parallel(executor):
        run_in_joblib(groups, sent, add, executor)
    else:
        run_in_place(groups, sent, add, place_for(executor))
    for place in collected.missing():
        # As where an executor gives a part of what its calls gave.
        add(failed(place, WorkerError.__name__, "executor: it gave no answer", settled=False))


def told(collected: Collected, step: Callable[[str], None]) -> Callable[[Answer], None]:
    """What takes up an answer from elsewhere and moves the bar on."""

    def add(answer: Answer) -> None:
        cells = collected.plan.rows[answer.place].cells
        collected.add(answer)
        step(f"{cells['view']}, {cells['technique']}")

    return add


def sendable(renderer: RendererLike | str) -> RendererLike | str:
    """The renderer as every process makes its own: the package's by the name of its backend."""
    return renderer.backend if isinstance(renderer, _core.Renderer) else renderer


def checked_timeout(timeout: object) -> float | None:
    """The limit of a run, seconds.

    Raises
    ------
    ArgumentError
        For anything but a number above 0.
    """
    if timeout is None:
        return None
    found = checked_number("timeout", timeout, "try 60", "seconds above 0")
    if not 0 < found <= LONGEST_RUN_S:
        raise ArgumentError(f"timeout: expected seconds above 0, got {shown(timeout)}; try 60")
    return found
