"""A sweep on a `joblib.Parallel`."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from typing import Any

from ...errors import WorkerError
from ...text.checked import has_all
from .executors import answers_in, cannot_carry_out, finish
from .lots import Lacking, Lot, carry_out, lots_of
from .parcels import Parcels
from .places import of_package
from .work import Answer, Group, Task


def is_parallel(value: object) -> bool:
    """Whether it is a `joblib.Parallel`."""
    return of_package(value, "joblib") and callable(value) and has_all(value, "n_jobs") and not isinstance(value, type)


def run_in_joblib(groups: Sequence[Group], task: Task, add: Callable[[Answer], None], parallel: Any) -> None:
    """Adds the answer of every run, made by joblib's workers.

    Raises
    ------
    ArgumentError
        For what cannot be sent.
    WorkerError
        Where the other processes cannot carry runs out.
    """
    from joblib import effective_n_jobs

    workers = max(1, effective_n_jobs(parallel.n_jobs))
    done: set[int] = set()

    def take(answer: Answer) -> None:
        done.add(answer.place)
        add(answer)

    with Parcels(groups, task) as parcels:
        for group in groups:
            parcels.file(group.view.scene.content_hash)
        lots = lots_of(parcels, workers)
        lacking: list[Lot] = []
        try:
            for i, found in calls(parallel, lots, parcels.task):
                if isinstance(found, Lacking):
                    lacking.append(lots[i].with_scene(parcels.data(found.scene)))
                else:
                    for answer in answers_in(found, lots[i]):
                        take(answer)
            for i, found in calls(parallel, lacking, parcels.task):
                for answer in answers_in(found, lacking[i]):
                    take(answer)
        except (KeyboardInterrupt, SystemExit, WorkerError):
            raise
        except Exception as error:  # noqa: BLE001 - backends raise what they like
            if not any("Broken" in kind.__name__ for kind in type(error).__mro__):
                raise cannot_carry_out(error) from None
        left = [one for lot in lots if (one := lot.without(done)).places]
        finish(left, parcels, workers, add)


def calls(parallel: Any, lots: Sequence[Lot], data: bytes) -> Any:
    """(number of the lot, what came of it), as they end where the backend can, else when all have."""
    from joblib import delayed

    if not lots:
        return []
    own = copy.copy(parallel)
    own.return_generator = bool(getattr(getattr(parallel, "_backend", None), "supports_return_generator", False))
    own.return_ordered = not own.return_generator
    return own(delayed(numbered)(i, lot, data) for i, lot in enumerate(lots))


def numbered(i: int, lot: Lot, data: bytes) -> tuple[int, list[Answer] | Lacking]:
    """`carry_out` with the number of the lot."""
    return i, carry_out(lot, data)
