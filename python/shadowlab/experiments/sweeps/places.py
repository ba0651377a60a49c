"""Where lots are carried out: an executor of `concurrent.futures`, or of the same kind (ray's, mpi4py's)."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from concurrent.futures import BrokenExecutor, CancelledError
from typing import Any, Protocol, cast

from .lots import Lot, carry_out
from .parcels import Parcels

# Of executors that do not say how many they are.
UNKNOWN_WORKERS = 16


class Future(Protocol):
    """What an executor gives for a call."""

    def result(self) -> Any:
        """What the call gave."""

    def cancel(self) -> object:
        """Gives it up."""

    def add_done_callback(self, fn: Callable[[Any], object], /) -> object:
        """Calls when it is done."""


class LotPlace(Protocol):
    """Where lots are carried out."""

    workers: int
    window: int
    share: bool

    def submit(self, lot: Lot, parcels: Parcels) -> Future:
        """Begins with a lot."""

    def cancel(self, futures: Sequence[Future]) -> None:
        """Gives lots up."""

    def died(self, error: BaseException) -> bool:
        """Whether an error says that a process died with this lot alone, and others go on."""

    def lost(self, error: BaseException) -> bool:
        """Whether an error says that nothing can be carried out any more."""

    def alone(self) -> bool:
        """Whether nobody is left to work."""


class FuturesPlace:
    """An executor of `concurrent.futures`, or of the same kind."""

    share = True

    def __init__(self, executor: Any):
        self.executor = executor
        self.workers = workers_of(executor)
        # One is carried out, one waits for it.
        self.window = 2 * self.workers

    def submit(self, lot: Lot, parcels: Parcels) -> Future:
        """As of `LotPlace`."""
        parcels.file(lot.group.view.scene)
        return cast("Future", self.executor.submit(carry_out, lot, parcels.task))

    def cancel(self, futures: Sequence[Future]) -> None:
        """As of `LotPlace`."""
        for future in futures:
            with contextlib.suppress(Exception):
                future.cancel()

    def died(self, error: BaseException) -> bool:
        """As of `LotPlace`."""
        return False

    def lost(self, error: BaseException) -> bool:
        """As of `LotPlace`."""
        return isinstance(error, (BrokenExecutor, CancelledError))

    def alone(self) -> bool:
        """As of `LotPlace`."""
        return False


def workers_of(executor: object) -> int:
    """How many calls an executor carries out at a time, as far as it says."""
    for name in ("_max_workers", "num_workers", "max_workers"):
        with contextlib.suppress(Exception):
            count = getattr(executor, name, None)
            if isinstance(count, int) and count > 0:
                return count
    return UNKNOWN_WORKERS


def of_package(value: object, package: str) -> bool:
    """Whether a value's class, or one that it is derived from, is of a package."""
    return any(str(cls.__module__).partition(".")[0] == package for cls in type(value).__mro__)
