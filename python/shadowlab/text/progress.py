"""The progress of long work on terminals and in notebooks."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable

# Of a terminal that does not say.
UNKNOWN_SIZE = (80, 24)


class Steps:
    """A progress bar on terminals and in notebooks that is gone when the work ends, however it ends."""

    def __init__(self, steps: int, shown: bool):
        from tqdm.auto import tqdm

        columns, rows = unknown_size()
        self._bar = tqdm(
            total=steps, leave=False, disable=None if shown else True, unit="step", ncols=columns, nrows=rows
        )
        self._started = False

    def __enter__(self) -> Callable[[str], None]:
        return self._step

    def _step(self, what: str) -> None:
        if self._started:
            self._bar.update()
        self._started = True
        self._bar.set_description(what)

    def __exit__(self, *_: object) -> None:
        self._bar.close()


def unknown_size() -> tuple[int, int] | tuple[None, None]:
    """Columns and rows of a terminal that does not say its own, on which tqdm would draw nothing; None of others."""
    try:
        size = os.get_terminal_size(sys.__stderr__.fileno())  # type: ignore[union-attr]
    except (AttributeError, OSError, ValueError):  # no terminal
        return None, None
    return (None, None) if min(size) > 0 else UNKNOWN_SIZE
