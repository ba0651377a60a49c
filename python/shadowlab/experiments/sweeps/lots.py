"""Parts of a sweep as executors of others carry them out: several runs in one view, sent as plain data.

```
    Lot      the runs, their view, and where the scene is: a file of this machine, or bytes
      |  carry_out      in the other process, which keeps the last scenes, pictures and tasks that it was sent
      v
    Lacking, the first time on another machine: the lot is sent again, with the scene
    answers
```
"""

from __future__ import annotations

import os
import threading
import uuid
from collections import OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

from ... import _core
from ...scene.kept import Kept
from ...scene.view import View
from .parcels import Parcels, SentGroup, answer_to_sent, file_of, held_scene, loaded
from .work import Answer, Task

# The last tasks that this process was sent, by their bytes.
TASKS = Kept(2)
# Views that a process keeps beside those that it is at.
VIEWS_HELD = 1
# So many lots a worker where there are fewer views, so that the last ones end at about the same time; and so many runs
# in one, since they are stored when all of it is done.
LOTS_OF_WORKER, MOST_RUNS_OF_LOT = 4, 64
#: Of this process and those forked from it.
PROCESS = uuid.uuid4().hex


@dataclass(frozen=True, eq=False)
class Lot:
    """Runs in a view for one call of another process.

    Attributes
    ----------
    group : SentGroup
    folder : str
        Where the scene's file is, on the machine that sent it. The lot ends early where the folder has gone.
    scene : bytes or None
        The scene itself.
    workers : int or None
        Processes that share the cores of the machine; None leaves the threads as they are.
    process : (str, int)
        That which sent it.
    """

    group: SentGroup
    folder: str
    workers: int | None
    scene: bytes | None = None
    process: tuple[str, int] = ("", 0)

    @property
    def places(self) -> list[int]:
        """The rows of its runs."""
        return [place for place, _ in self.group.requests]

    def without(self, done: set[int]) -> Lot:
        """The same without the runs that are done."""
        left = tuple(one for one in self.group.requests if one[0] not in done)
        return replace(self, group=replace(self.group, requests=left))

    def with_scene(self, data: bytes) -> Lot:
        """The same with the scene itself."""
        return replace(self, scene=data)

    def singles(self) -> list[Lot]:
        """A lot per run."""
        return [replace(self, group=replace(self.group, requests=(one,))) for one in self.group.requests]


@dataclass(frozen=True)
class Lacking:
    """The answer to a lot whose scene is not here."""

    scene: str


def lots_of(parcels: Parcels, workers: int, share: bool = True) -> list[Lot]:
    """The lots of all groups, the largest first."""
    here, groups = (PROCESS, os.getpid()), parcels.groups
    found: list[Lot] = []
    for group in groups:
        runs = len(group.requests)
        wanted = -(-LOTS_OF_WORKER * workers // len(groups)) if len(groups) < LOTS_OF_WORKER * workers else 1
        count = min(runs, max(wanted, -(-runs // MOST_RUNS_OF_LOT)))
        for k in range(count):
            part = group.requests[k * runs // count : (k + 1) * runs // count]
            own = replace(group, requests=part, cost=group.cost * len(part) / runs)
            found.append(Lot(own, str(parcels.folder), workers if share else None, process=here))
    return sorted(found, key=lambda lot: -lot.group.cost)


def carry_out(
    lot: Lot, data: bytes, scene: _core.Scene | None = None, threads: int | None = None
) -> list[Answer] | Lacking:
    """The answers of a lot, in another process; those that were not asked for any more are left out.

    Parameters
    ----------
    lot : Lot
    data : bytes
        The task.
    scene : Scene, optional
        Where the executor brings it.
    threads : int, optional
        Of this process; its share of the cores where none are given.
    """
    found = scene if scene is not None else scene_of_lot(lot)
    if found is None:
        return Lacking(lot.group.view.scene)
    if lot.process != (PROCESS, os.getpid()):
        _share_cores(lot, threads)
    folder = Path(lot.folder)
    local = folder.exists()
    answers = []
    task, view = task_of(data), lot.group.view.view(found)
    with PICTURES.of(view):
        for place, sent in lot.group.requests:
            if local and not folder.exists():
                break
            answers.append(answer_to_sent(view, place, sent, task))
    return answers


def scene_of_lot(lot: Lot) -> _core.Scene | None:
    """The scene of a lot: as it is here, as it came, or from its file."""
    name, data = lot.group.view.scene, lot.scene
    file = file_of(Path(lot.folder), name)
    try:
        return held_scene(name, file.read_bytes if data is None else lambda: data)
    except OSError:
        return None


def task_of(data: bytes) -> Task:
    """The task of its bytes, read once by a process."""
    return TASKS.get("task", data, lambda: cast("Task", loaded(data).here()), lambda _: 1)


_shared: set[tuple[int, int | None, int | None]] = set()


def _share_cores(lot: Lot, threads: int | None) -> None:
    """Sets the threads of this process to its share, once for each number of workers."""
    # By the process, since a fork has what its parent had.
    key = os.getpid(), threads, lot.workers
    if key in _shared:
        return
    _shared.add(key)
    if threads is None and lot.workers is not None:
        _core.set_threads(None)
        threads = max(1, _core.threads() // lot.workers)
    if threads is not None:
        _core.set_threads(threads)


class Pictures:
    """The G-buffers and truths of the views that a process is at, and of the last one; others are cleared."""

    def __init__(self) -> None:
        self._views: OrderedDict[tuple[str, object, object], tuple[View, int]] = OrderedDict()
        self._lock = threading.Lock()

    @contextmanager
    def of(self, view: View) -> Iterator[None]:
        """Keeps the pictures of a view within."""
        key = (view.scene.content_hash, view.camera, view.size)
        self._count(key, view, 1)
        try:
            yield
        finally:
            self._count(key, view, -1)

    def _count(self, key: tuple[str, object, object], view: View, step: int) -> None:
        with self._lock:
            held, users = self._views.pop(key, (view, 0))
            self._views[key] = held, users + step
            idle = [one for one, (_, users) in self._views.items() if users == 0]
            gone = [self._views.pop(one)[0] for one in idle[: max(0, len(idle) - VIEWS_HELD)]]
        for one in gone:
            one.clear()


#: Of this process.
PICTURES = Pictures()
