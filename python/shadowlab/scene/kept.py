"""Results that are made once and kept while there is room: the least recently used go first."""

from __future__ import annotations

import os
import threading
from collections import OrderedDict, deque
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from typing import TypeVar, cast

T = TypeVar("T")
Key = tuple[Hashable, Hashable]


class Kept:
    """A store of results by owner and name, bounded by the bytes that they take.

    Threads that ask for the same result at once make it once. A process that was forked begins with an empty store,
    since another thread may have been changing it.

    Parameters
    ----------
    most_bytes : int
        Upper limit of all results together. A result that is larger alone is returned and not kept.
    """

    def __init__(self, most_bytes: int):
        self.most_bytes = most_bytes
        self._empty()
        if hasattr(os, "register_at_fork"):
            os.register_at_fork(after_in_child=self._empty)

    def _empty(self) -> None:
        self._lock = threading.Lock()
        self._values: OrderedDict[Key, tuple[object, int]] = OrderedDict()
        self._making: dict[Key, threading.Lock] = {}
        self._forgotten: deque[Hashable] = deque()
        self._bytes = 0

    @property
    def bytes(self) -> int:
        """What the results take now."""
        return self._bytes

    def get(self, owner: Hashable, name: Hashable, make: Callable[[], T], size: Callable[[T], int]) -> T:
        """The result; `make` is called where it is not there, and `size` gives its bytes."""
        key = (owner, name)
        with self._locked():
            if key in self._values:
                self._values.move_to_end(key)
                return cast("T", self._values[key][0])
            making = self._making.setdefault(key, threading.Lock())
        with making:
            with self._locked():
                if key in self._values:
                    return cast("T", self._values[key][0])
            try:
                value = make()
                self._put(key, value, size(value))
            finally:
                with self._locked():
                    self._making.pop(key, None)
            return value

    def holds(self, owner: Hashable, name: Hashable) -> bool:
        """Whether the result is there now."""
        with self._locked():
            return (owner, name) in self._values

    def forget(self, owner: Hashable, name: Hashable = None) -> None:
        """Drops a result, or all of an owner where no name is given."""
        with self._locked():
            self._drop(owner, name)

    def forget_soon(self, owner: Hashable) -> None:
        """Drops all results of an owner, from a finalizer: those run anywhere, even where the store is locked."""
        self._forgotten.append(owner)
        if self._lock.acquire(blocking=False):
            try:
                self._sweep()
            finally:
                self._lock.release()

    @contextmanager
    def _locked(self) -> Iterator[None]:
        with self._lock:
            yield
            self._sweep()

    def _sweep(self) -> None:
        while self._forgotten:
            self._drop(self._forgotten.popleft(), None)

    def _drop(self, owner: Hashable, name: Hashable) -> None:
        for key in [key for key in self._values if key[0] == owner and name in (None, key[1])]:
            self._bytes -= self._values.pop(key)[1]

    def _put(self, key: Key, value: object, taken: int) -> None:
        if taken > self.most_bytes:
            return
        with self._locked():
            self._values[key] = value, taken
            self._bytes += taken
            while self._bytes > self.most_bytes:
                _, (_, freed) = self._values.popitem(last=False)
                self._bytes -= freed
