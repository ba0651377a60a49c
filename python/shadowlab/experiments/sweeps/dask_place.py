"""Lots on a Dask cluster."""

from __future__ import annotations

import asyncio
import contextlib
import sys
import time
import warnings
from collections.abc import Sequence
from concurrent.futures import CancelledError
from typing import Any, cast

from ... import _core
from .lots import Lacking, Lot, carry_out
from .parcels import Parcels, loaded
from .places import Future
from .work import Answer

# Without any worker a cluster is given up after this long: a nanny takes seconds to start one.
ALONE_S = 60.0


class DaskPlace:
    """A Dask client: a scene is a result that goes to each worker once, and is made again where it is lost."""

    share = False

    def __init__(self, client: Any):
        self.client = client
        self.workers = max(1, sum(client.nthreads().values()))
        # The cluster knows best, and moves what has not begun from worker to worker.
        self.window = sys.maxsize
        self._scenes: dict[str, Any] = {}
        self._seen = time.monotonic()

    def submit(self, lot: Lot, parcels: Parcels) -> Future:
        """As of `LotPlace`."""
        name = lot.group.view.scene
        with warnings.catch_warnings():
            # Of large graphs: the scene has to get there.
            warnings.simplefilter("ignore", UserWarning)
            if name not in self._scenes:
                key = f"shadowlab-scene-{name}"
                self._scenes[name] = self.client.submit(loaded, parcels.data(name), key=key)
            return cast(
                "Future", self.client.submit(carry_out_in_dask, lot, parcels.task, self._scenes[name], pure=False)
            )

    def cancel(self, futures: Sequence[Future]) -> None:
        """As of `LotPlace`."""
        with contextlib.suppress(Exception):
            self.client.cancel(list(futures), force=True)

    def died(self, error: BaseException) -> bool:
        """As of `LotPlace`."""
        from distributed import KilledWorker

        return isinstance(error, KilledWorker)

    def lost(self, error: BaseException) -> bool:
        """As of `LotPlace`."""
        from distributed.comm.core import CommClosedError

        return isinstance(error, (CancelledError, asyncio.CancelledError, CommClosedError))

    def alone(self) -> bool:
        """As of `LotPlace`."""
        try:
            there = bool(self.client.nthreads())
        except Exception:  # noqa: BLE001 - of a scheduler that has gone, whatever that raises
            there = False
        now = time.monotonic()
        self._seen = now if there else self._seen
        return now > self._seen + ALONE_S


def carry_out_in_dask(lot: Lot, data: bytes, scene: _core.Scene) -> list[Answer] | Lacking:
    """`carry_out` with as many threads as the worker has of Dask's."""
    from distributed import get_worker

    return carry_out(lot, data, scene, threads=max(1, get_worker().state.nthreads))
