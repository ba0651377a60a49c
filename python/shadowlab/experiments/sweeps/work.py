"""One run of a sweep: what it is asked for, and what comes of it. The same code in every process.

```
    Group    a view and the runs in it        their G-buffer and truth are made once
    Task     what all runs share: metrics, renderer, limit of time
      |
      v      answer_to(view, request, task)
    Answer   the numbers of a run by columns, or the type and text of its failure
```
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, cast

from ...errors import ArgumentError, DeviceError, LoadError, ShadowlabError
from ...scene.view import View
from ...techniques.kinds import is_parameterization
from ...text import reason_of
from ...text.checks import renderer_of
from ...text.progress import Deadline, OutOfTimeError
from ..candidates import FIRST_TEXELS, attempt
from ..evaluate import evaluate, fitted, samples_for
from ..memory import side_of, too_small
from ..metrics import DRAWN, HELD_AGAINST_TRUTH, Metric
from ..store.row_text import Cell
from .functions import numbers_from

if TYPE_CHECKING:
    from ...techniques.variant import MapReading
    from ...types import Item, RendererLike
    from ..run import Run


# The errors that another try may not have: of a device, a file, the machine.
PASSING = (DeviceError, LoadError)


@dataclass(frozen=True, eq=False)
class Request:
    """What is asked for in a view.

    Attributes
    ----------
    place : int
        Of its row in the table.
    label : str
        The technique's.
    item : Technique, Preset or Parameterization
    resolution, memory : int or None
        Texels along each side of the maps, or the bytes that decide them.
    read : MapReading
    """

    place: int
    label: str
    item: Item
    resolution: int | None
    memory: int | None
    read: MapReading


@dataclass(frozen=True, eq=False)
class Group:
    """The runs in one view, and how long they are thought to take beside those of other views."""

    view: View
    requests: tuple[Request, ...]
    cost: float


@dataclass(frozen=True, eq=False)
class Task:
    """What all runs of a sweep share.

    Attributes
    ----------
    metrics : tuple of str
    functions : tuple of (str, callable)
        Metrics that are functions of a run, with their names.
    renderer : Renderer or str
        One of the package by its backend's name, so that each process makes its own.
    timeout : float or None
        Seconds of a run.
    """

    metrics: tuple[Metric, ...]
    functions: tuple[tuple[str, Callable[[Run], object]], ...]
    renderer: RendererLike | str
    timeout: float | None = None

    def here(self) -> Task:
        """The same with a renderer of this process."""
        return replace(self, renderer=renderer_of(self.renderer))


@dataclass(frozen=True, eq=False)
class Answer:
    """What came of a run.

    Attributes
    ----------
    place : int
        Of its row in the table.
    row : mapping of str to bool, int, float, str or None
        By columns, "seconds", "failure_type" and "failure" among them.
    settled : bool
        Whether another try would give the same: of numbers and refusals, not of what the machine did.
    """

    place: int
    row: Mapping[str, Cell]
    settled: bool = True


def prepare(view: View, task: Task, request: Request) -> None:
    """Makes what the run shares with others in its view, if it is not there, so that its time counts for none."""
    renderer = cast("RendererLike", task.renderer)
    # What goes wrong here goes wrong in each run, too, and is told there.
    with suppress(Exception):
        if DRAWN & set(task.metrics):
            view.gbuffer(renderer)
        if HELD_AGAINST_TRUTH & set(task.metrics):
            view.truth()
        samples_for(request.item, view, renderer)


def answer_to(view: View, request: Request, task: Task) -> Answer:
    """The answer of a run; whatever it raises, interruptions aside, is its failure."""
    start = time.perf_counter()
    try:
        with Deadline(task.timeout):
            row, settled = row_of(view, request, task)
    except OutOfTimeError as error:
        return failed(request.place, TimeoutError.__name__, str(error), time.perf_counter() - start, settled=False)
    except Exception as error:  # noqa: BLE001 - a failing run is a row, whatever fails
        settled = isinstance(error, ShadowlabError) and not isinstance(error, PASSING)
        return failed(request.place, type(error).__name__, reason_of(error), time.perf_counter() - start, settled)
    row["seconds"] = time.perf_counter() - start
    return Answer(request.place, row, settled)


def failed(place: int, kind: str, text: str, seconds: float | None = None, settled: bool = True) -> Answer:
    """The answer of a run without numbers."""
    return Answer(place, {"failure_type": kind, "failure": text, "seconds": seconds}, settled)


def row_of(view: View, request: Request, task: Task) -> tuple[dict[str, Any], bool]:
    """The row of a run, and whether another try would give the same."""
    resolution = request.resolution
    if resolution is None:
        resolution = side_for(view, request, task)
    run = evaluate(
        view, request.item, resolution, metrics=task.metrics, renderer=task.renderer, label=request.label,  # type: ignore[arg-type]
        **request.read._asdict(),
    )  # fmt: skip
    row = {**run.row(), "failure_type": run.failure_type}
    passing = {kind.__name__ for kind in PASSING}
    settled = not any(part.failure_type in passing for part in run.parts or (run,))
    numbers: dict[str, Cell] = {}
    for name, function in () if run.failure else task.functions:
        try:
            numbers |= numbers_from(name, function, run)
        except OutOfTimeError:
            raise
        except (Exception, SystemExit) as error:  # noqa: BLE001 - metrics of callers raise what they like
            blank = {key: value for key, value in row.items() if key not in run.numbers}
            text = f"metric {name}: {reason_of(error)}"
            return {**blank, "failure_type": type(error).__name__, "failure": text}, False
    return row | numbers, settled


def side_for(view: View, request: Request, task: Task) -> int:
    """The side of the largest maps that fit into the memory, of all lights together.

    Raises
    ------
    ArgumentError
        Where not even the smallest do.
    """
    memory = request.memory or 0
    renderer = renderer_of(task.renderer)

    def maps_at(side: int) -> int:
        if is_parameterization(request.item):
            return len(view.views) * len(request.item.matrices)
        made = [attempt(partial(fitted, request.item, one, side, renderer)) for one in view.views]
        return sum(0 if p is None else len(p.matrices) for p, _ in made)

    # Where nothing is made, the run says why.
    most = maps_at(FIRST_TEXELS) or 1
    while side := side_of(memory, most):
        needed = maps_at(side)
        if needed <= most:
            return side
        most = needed
    raise ArgumentError(too_small(memory, most))
