"""A sweep in processes of its own: each is sent a scene once, keeps to a view, and may die without harm to the others.

```
    a free worker takes   the next run of its view; else the largest view that nobody has; else one of the view with
                          most runs left, which costs it that view's truth
    a worker that dies    costs its run another try, alone, when all others are done; dying again is its failure
    a run that is late    ends itself (Deadline); a worker that does not is killed, without another try
```
The processes run `worker.py`, never the main module, so scripts without a guard, notebooks and
standard input work.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import queue
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, BinaryIO, cast

from ... import _core
from ...errors import WorkerError
from .messages import receive, send
from .parcels import Parcels, SentGroup, frozen
from .work import Answer, Group, Task, failed

# Between two looks for runs that are late; a message ends the wait at once.
TICK_S = 0.1
# Beyond its timeout a run has this long to end itself.
GRACE_S = 1.0
# Until workers that are no longer needed have ended by themselves.
LEAVE_S = 2.0
# Modules are found where this program finds them.
START = "import json, sys; sys.path[:] = json.loads(sys.argv[1]); from {} import work; work()"
OF_WORKER = f"{__package__}.worker"
DIED = WorkerError.__name__
Events = queue.SimpleQueue[tuple["Worker", Any]]


class Worker:
    """A process and what it is at.

    Parameters
    ----------
    data : bytes
        The task.
    threads : int
    events : queue
        Gets (worker, message) for every message, and (worker, None) when the process has ended.

    Raises
    ------
    WorkerError
        Where it cannot be started.
    """

    def __init__(self, data: bytes, threads: int, events: Events):
        command = [sys.executable, "-c", START.format(OF_WORKER), json.dumps(module_path())]
        # Ctrl-C is for this process, which ends its workers.
        apart: dict[str, Any] = {"start_new_session": True}
        if sys.platform == "win32":
            apart = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
        try:
            self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, **apart)
        except OSError as error:
            raise WorkerError(f"workers: cannot start {sys.executable} ({error}); leave workers out") from None
        self.ready = False
        self.work: Left | None = None
        self.run: tuple[int, bytes] | None = None
        self.begun: float | None = None
        self.late = False
        threading.Thread(target=self._listen, args=(events,), daemon=True).start()
        self.tell("start", threads, data)

    def _listen(self, events: Events) -> None:
        with contextlib.suppress(EOFError, OSError, ValueError):
            while True:
                events.put((self, receive(cast("BinaryIO", self.process.stdout))))
        events.put((self, None))

    def tell(self, *message: object) -> None:
        """Sends a message; that the process has ended is an event of its own."""
        with contextlib.suppress(OSError, ValueError):
            send(cast("BinaryIO", self.process.stdin), message)

    def give(self, left: Left, run: tuple[int, bytes], parcels: Parcels) -> None:
        """Gives it a run."""
        if left is not self.work:
            self.tell("view", left.group.view, str(parcels.file(left.group.view.scene)))
            self.work = left
        self.run, self.begun, self.late = run, None, False
        self.tell("run", *run)

    def close(self, kill: bool = False) -> None:
        """Ends it: at once, or when it sees that there is nothing more."""
        if kill:
            self.process.kill()
        with contextlib.suppress(OSError, ValueError):
            cast("BinaryIO", self.process.stdin).close()
        try:
            self.process.wait(LEAVE_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()


class Left:
    """What is left of a group."""

    def __init__(self, group: SentGroup):
        self.group = group
        self.runs = deque(group.requests)


class Crew:
    """The workers of a sweep and what is left for them, as a context.

    Parameters
    ----------
    groups : sequence of SentGroup
        The largest first.
    parcels : Parcels
    count : int
        Workers.
    """

    def __init__(self, groups: Sequence[SentGroup], parcels: Parcels, count: int):
        # Groups that nobody has, the largest first, and those with runs left that somebody has: what is done is in
        # neither, so that a run costs no look at thousands of views.
        self.free = deque(map(Left, groups))
        self.taken: list[Left] = []
        self.parcels = parcels
        self.count = min(count, sum(len(group.requests) for group in groups))
        self.threads = max(1, _core.threads() // max(1, self.count))
        self.events: Events = queue.SimpleQueue()
        self.workers: list[Worker] = []
        self.died: list[tuple[SentGroup, tuple[int, bytes], int]] = []
        self._unready = 0

    def __enter__(self) -> Crew:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        for worker in self.workers:
            if kind is not None:
                worker.process.kill()
        for worker in self.workers:
            worker.close(kill=kind is not None)

    def work(self, add: Callable[[Answer], None]) -> None:
        """Has all runs answered, in parallel; then those whose workers died, one after the other."""
        self._until_done(self.count, self.threads, add)
        again, self.died = self.died, []
        for group, run, _ in again:
            # By a worker of its own: the one before may have grown.
            self.free.append(Left(replace(group, requests=(run,))))
            self._until_done(1, _core.threads(), add)
            for _, (place, _), status in self.died:
                add(
                    failed(
                        place, DIED, f"its process ended twice, alone, too: {reason_of_status(status)}", settled=False
                    )
                )
            self.died = []

    def _until_done(self, count: int, threads: int, add: Callable[[Answer], None]) -> None:
        """Has what is left answered by so many workers, which have ended then."""
        while True:
            self._fill(count, threads)
            if not self.workers:
                return
            try:
                worker, message = self.events.get(timeout=TICK_S)
            except queue.Empty:
                self._kill_late()
                continue
            if worker in self.workers:
                self._take(worker, message, add)
            self._kill_late()

    def _fill(self, count: int, threads: int) -> None:
        """Gives work to the workers that have none, and starts those that are missing."""
        for worker in self.workers:
            if worker.ready and worker.run is None:
                found = self._next(worker)
                if found is not None:
                    worker.give(*found, self.parcels)
        # No more than so many count.
        waiting = sum(len(left.runs) for left in (*self.taken, *itertools.islice(self.free, count)))
        starting = sum(not worker.ready for worker in self.workers)
        while len(self.workers) < count and starting < waiting:
            self.workers.append(Worker(self.parcels.task, threads, self.events))
            starting += 1
        if not waiting and all(worker.run is None for worker in self.workers):
            for worker in self.workers:
                worker.close(kill=not worker.ready)
            self.workers = []

    def _next(self, worker: Worker) -> tuple[Left, tuple[int, bytes]] | None:
        """The next run of a worker, and what it is part of."""
        left = worker.work
        if left is None or left not in self.taken:
            if self.free:
                self.taken.append(self.free.popleft())
                left = self.taken[-1]
            elif self.taken:
                left = max(self.taken, key=lambda one: len(one.runs))
            else:
                return None
        run = left.runs.popleft()
        if not left.runs:
            self.taken.remove(left)
        return left, run

    def _take(self, worker: Worker, message: Any, add: Callable[[Answer], None]) -> None:
        kind = "ended" if message is None else message[0]
        if kind == "ready":
            worker.ready, self._unready = True, 0
        elif kind == "broken":
            raise WorkerError(
                f"workers: they cannot read what they are sent ({message[1]}); define metrics in a module that they "
                "can import"
            )
        elif kind == "begun":
            worker.begun = time.monotonic()
        elif kind == "answer":
            worker.run = None
            add(message[1])
        else:
            self._bury(worker, add)

    def _bury(self, worker: Worker, add: Callable[[Answer], None]) -> None:
        """Takes up what a worker that has ended was at."""
        self.workers.remove(worker)
        worker.close()
        status = worker.process.returncode
        if not worker.ready:
            self._unready += 1
            if self._unready > self.count:
                raise WorkerError(
                    f"workers: they end before they work ({reason_of_status(status)}); see standard error, or leave "
                    "workers out"
                )
        if worker.run is None or worker.work is None:
            return
        if worker.late:
            text = f"took longer than the timeout of {self.parcels.timeout:g} s; its process was killed"
            add(failed(worker.run[0], TimeoutError.__name__, text, settled=False))
        else:
            self.died.append((worker.work.group, worker.run, status))

    def _kill_late(self) -> None:
        limit = self.parcels.timeout
        if limit is None:
            return
        now = time.monotonic()
        for worker in self.workers:
            if worker.begun is not None and worker.run is not None and now > worker.begun + limit + GRACE_S:
                worker.late = True
                worker.process.kill()


def run_in_workers(groups: Sequence[Group], task: Task, add: Callable[[Answer], None], count: int) -> None:
    """Adds the answer of every run, made by so many processes.

    Raises
    ------
    ArgumentError
        For what cannot be sent.
    WorkerError
        Where processes cannot be started.
    """
    if frozen():
        raise WorkerError(
            "workers: expected a Python interpreter to start, this program has none beside it; leave workers out, "
            "since one process uses all cores, or give an executor that the program can start"
        )
    with Parcels(groups, task) as parcels:
        run_sent(parcels.groups, parcels, count, add)


def run_sent(groups: Sequence[SentGroup], parcels: Parcels, count: int, add: Callable[[Answer], None]) -> None:
    """The same of groups that are bytes already."""
    with Crew(groups, parcels, count) as crew:
        crew.work(add)


def module_path() -> list[str]:
    """Where this program looks for modules, its own copy of the package among them."""
    own = str(Path(__file__).resolve().parents[3])
    path = [one for one in sys.path if isinstance(one, str)]
    return path if own in path or "" in path else [*path, own]


def reason_of_status(status: int) -> str:
    """Why a process ended, by its exit status."""
    if status >= 0:
        return f"exit status {status}"
    name = signal.Signals(-status).name if -status in {one.value for one in signal.Signals} else f"signal {-status}"
    memory = ", as where memory runs out" if name == "SIGKILL" and os.name == "posix" else ""
    return f"killed by {name}{memory}"
