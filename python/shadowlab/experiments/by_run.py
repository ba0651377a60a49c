"""What the runs of a study have, by their labels and resolutions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, TypeVar, cast

if TYPE_CHECKING:
    from .run import Run

T = TypeVar("T")


class ByRun(Mapping["str | tuple[str, int]", T]):
    """What the runs that succeeded have, by (label, resolution), or by label alone in a study of one resolution.

    An entry is made when it is asked for.
    """

    def __init__(self, runs: Sequence[Run], what: str):
        self._runs = {(run.label, run.resolution): run for run in runs}
        self._what = what

    def __getitem__(self, key: str | tuple[str, int]) -> T:
        found = [k for k in self._runs if k == key] or [k for k in self._runs if k[0] == key]
        if len(found) != 1:
            keys = ", ".join(map(repr, self._runs)) or "none"
            raise KeyError(f"{key!r}: expected one of {keys}")
        run = self._runs[found[0]]
        return cast("T", run if self._what == "run" else getattr(run, self._what))

    def __iter__(self) -> Iterator[tuple[str, int]]:
        return iter(self._runs)

    def __len__(self) -> int:
        return len(self._runs)

    def __repr__(self) -> str:
        return f"{{{', '.join(f'{key!r}: {self._what}' for key in self._runs)}}}"
