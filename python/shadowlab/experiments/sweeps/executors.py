"""A sweep on an executor of somebody else's: one of `concurrent.futures`, of the same kind (ray's, mpi4py's), or Dask.

```
    lots, the largest first --submit--> futures --as they end--> answers
                                           |  the process died     Dask: each of its runs again at the end, with no
                                           |                       other beside it; dying again is its failure
                                           |                       others: what is left is done in processes of our own
```
"""

from __future__ import annotations

import queue
import threading
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, ThreadPoolExecutor
from typing import Any

from ...errors import ArgumentError, WorkerError
from ...text import reason_of, shown
from ...text.checked import has_all
from .dask_place import DaskPlace
from .in_process import run_here
from .lots import PICTURES, Lacking, Lot, lots_of
from .parcels import Parcels, frozen
from .places import Future, FuturesPlace, LotPlace, of_package
from .work import Answer, Group, Task, failed
from .workers import DIED, run_sent

# Between two looks whether there is anybody left to work.
LOOK_S = 0.5
KINDS = "a concurrent.futures.Executor, a Dask Client or a joblib.Parallel"


def takes_calls(executor: object) -> bool:
    """Whether it is an executor: one of `concurrent.futures`, of the same kind, or a Dask client."""
    return not isinstance(executor, type) and has_all(executor, "submit")


def place_for(executor: object) -> LotPlace:
    """Where an executor carries lots out.

    Raises
    ------
    ArgumentError
        For a Dask client that is closed.
    """
    if not (of_package(executor, "distributed") and has_all(executor, "nthreads", "cancel")):
        return FuturesPlace(executor)
    try:
        return DaskPlace(executor)
    except Exception as error:  # noqa: BLE001 - of a client that is closed, whatever it raises
        raise ArgumentError(
            f"executor: expected a client of a running cluster, got one that fails ({reason_of(error)})"
        ) from None


def run_in_thread(group: Group, task: Task, add: Callable[[Answer], None]) -> None:
    """`run_here` on one of several threads, which keep no pictures but those that they are at."""
    with PICTURES.of(group.view):
        run_here([group], task, add)


def run_in_threads(
    groups: Sequence[Group], task: Task, add: Callable[[Answer], None], executor: ThreadPoolExecutor
) -> None:
    """Adds the answer of every run, made by threads of this process: nothing is sent."""
    caller = threading.current_thread()

    def is_own() -> bool:
        # A call of the executor's own: where all of its threads wait as this one, none would work. A thread that has
        # just been started is not among them yet.
        return caller in getattr(executor, "_threads", ())

    if is_own():
        for group in groups:
            run_here([group], task, add)
        return
    done: queue.SimpleQueue[Any] = queue.SimpleQueue()
    stopped = threading.Event()

    def put(answer: Answer) -> None:
        if stopped.is_set():
            raise CancelledError
        done.put(answer)

    futures: list[Any] = []
    left: list[Group] = []
    try:
        for group in groups:
            try:
                futures.append(executor.submit(run_in_thread, group, task, put))
            except RuntimeError as error:
                raise ArgumentError(f"executor: expected one that is open ({reason_of(error)})") from None
            futures[-1].add_done_callback(done.put)
        ended = 0
        while ended < len(futures):
            found = take(done, is_own)
            if found is None:
                for future in futures:
                    future.cancel()
            elif isinstance(found, Answer):
                add(found)
            else:
                ended += 1
                if found.cancelled():
                    left.append(groups[futures.index(found)])
                else:
                    found.result()
    finally:
        stopped.set()
        for future in futures:
            future.cancel()
    for group in left:
        # They were cancelled before they had begun: above, or since somebody shut the executor down.
        run_here([group], task, add)


def take(done: queue.SimpleQueue[Any], alone: Callable[[], bool]) -> Any:
    """What comes next; None where nothing comes any more."""
    while True:
        try:
            return done.get(timeout=LOOK_S)
        except queue.Empty:
            if alone():
                return None


def run_in_place(groups: Sequence[Group], task: Task, add: Callable[[Answer], None], place: LotPlace) -> None:
    """Adds the answer of every run, made where an executor says.

    Raises
    ------
    ArgumentError
        For what cannot be sent, and an executor that is closed.
    WorkerError
        Where the other processes cannot carry runs out.
    """
    with Parcels(groups, task) as parcels:
        left = Submitted(place, parcels, add).all(lots_of(parcels, place.workers, place.share))
        finish(left, parcels, place.workers, add)


def finish(lots: Sequence[Lot], parcels: Parcels, workers: int, add: Callable[[Answer], None]) -> None:
    """Answers what an executor left undone when it broke: in processes of our own, where one may die for itself."""
    if lots and frozen():
        for lot in lots:
            for place in lot.places:
                add(failed(place, DIED, "the executor broke before it was done", settled=False))
    elif lots:
        run_sent([lot.group for lot in lots], parcels, workers, add)


def cannot_carry_out(error: BaseException) -> WorkerError:
    """The error for what an executor raises itself."""
    return WorkerError(f"executor: its processes cannot carry runs out ({type(error).__name__}: {reason_of(error)})")


def answers_in(found: object, lot: Lot) -> list[Answer]:
    """The answers to a lot, which may be fewer than its runs.

    Raises
    ------
    WorkerError
        For what `carry_out` does not give.
    """
    if not isinstance(found, list) or any(not isinstance(one, Answer) or one.place not in lot.places for one in found):
        raise WorkerError(
            f"executor: expected what its calls give, got {shown(found)} from it; give another, or workers=2"
        )
    return found


class Submitted:
    """The lots that an executor has.

    Parameters
    ----------
    place : LotPlace
    parcels : Parcels
    add : callable
        Gets the answers.
    """

    def __init__(self, place: LotPlace, parcels: Parcels, add: Callable[[Answer], None]):
        self.place, self.parcels, self.add = place, parcels, add
        self.lots: dict[int, tuple[Future, Lot]] = {}
        self.done: queue.SimpleQueue[Any] = queue.SimpleQueue()
        # Runs whose process died, which any of them may have caused: each waits until nothing else is carried out.
        self.alone: deque[Lot] = deque()
        self.alone_before: set[int] = set()
        self.answered = self.lacking = False
        self.unsent: list[Lot] = []

    def all(self, lots: Sequence[Lot]) -> list[Lot]:
        """Has all lots answered; what is given back has not been, for the executor is broken."""
        waiting = deque(lots)
        try:
            while waiting or self.lots or self.alone:
                if not waiting and not self.lots:
                    waiting.append(self.alone.popleft())
                while waiting and len(self.lots) < self._window():
                    if not self._begun(waiting.popleft()):
                        return [*self._left(), *waiting]
                future = take(self.done, self.place.alone)
                if future is None or not self._take(future):
                    return [*self._left(), *waiting]
        except BaseException:
            self.place.cancel([future for future, _ in self.lots.values()])
            raise
        return []

    def _window(self) -> int:
        """Lots that the executor has at a time: where they lack scenes, one a process, so that each is sent one."""
        return self.place.window if self.answered and not self.lacking else min(self.place.workers, self.place.window)

    def _begun(self, lot: Lot) -> bool:
        """Begins with a lot; False where the executor is broken."""
        try:
            self._submit(lot)
        except BrokenExecutor:
            self.unsent.append(lot)
            return False
        except ArgumentError:
            raise
        except Exception as error:  # noqa: BLE001 - of a closed executor, whatever it raises
            raise ArgumentError(
                f"executor: expected one that takes calls, got one that fails ({reason_of(error)})"
            ) from None
        return True

    def _submit(self, lot: Lot) -> None:
        future = self.place.submit(lot, self.parcels)
        if id(future) in self.lots:
            raise ArgumentError("executor: expected a future of its own for each call, got one for two; give another")
        self.lots[id(future)] = future, lot
        # Whatever it calls back with.
        future.add_done_callback(lambda _: self.done.put(future))

    def _left(self) -> list[Lot]:
        self.place.cancel([future for future, _ in self.lots.values()])
        return [*(lot for _, lot in self.lots.values()), *self.unsent, *self.alone]

    def _take(self, future: Future) -> bool:
        """Takes up what became of a lot; False where the executor is broken."""
        if id(future) not in self.lots:
            # It called back twice.
            return True
        _, lot = self.lots[id(future)]
        try:
            found = future.result()
        except (KeyboardInterrupt, SystemExit):
            raise
        except BaseException as error:  # noqa: BLE001 - what executors raise is of any kind
            if self.place.lost(error):
                return False
            del self.lots[id(future)]
            if not self.place.died(error):
                raise cannot_carry_out(error) from None
            self._again(lot)
            return True
        del self.lots[id(future)]
        if isinstance(found, Lacking):
            self.lacking = True
            return self._begun(lot.with_scene(self.parcels.data(found.scene)))
        answers = answers_in(found, lot)
        self.answered = True
        for answer in answers:
            self.add(answer)
        return True

    def _again(self, lot: Lot) -> None:
        """Has each run of a lot that took its process along wait for its turn alone; one that had it has failed."""
        for single in lot.singles():
            place = single.places[0]
            if place in self.alone_before:
                self.add(
                    failed(place, DIED, "its processes ended, alone, too, as where memory runs out", settled=False)
                )
            else:
                self.alone_before.add(place)
                self.alone.append(single)
