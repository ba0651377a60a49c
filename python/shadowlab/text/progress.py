"""The progress of long work on terminals and in notebooks: how much of it is done, and an estimate of the time left.

```
    Steps       work of several steps that Python counts      a call of the core within a step moves the bar on, too
    waiting     one call of the core outside of all steps     the extension asks for it (src/python/convert.rs)
    Deadline    a limit of time                               calls of the core within end where they report beyond it
```
Nothing shows of work that is over within a second, nor where standard error is neither a terminal nor a notebook's,
unless somebody asks for it. Bars are gone when the work ends, however it ends.
"""

from __future__ import annotations

import contextlib
import math
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

from .checked import a_flag

# Seconds of work before a bar shows: people do not take less for a wait, and a bar that flashes tells nothing.
SHOWN_AFTER_S = 1.0
# Seconds between two looks of a bar: faster ones cannot be read.
REFRESH_S = 0.1
# Of a terminal that does not say.
UNKNOWN_SIZE = (80, 24)
FORMAT = "{desc}: {percentage:3.0f}%|{bar}| {elapsed} so far, {remaining} left"
FORMAT_OF_UNKNOWN = "{desc}: {elapsed} so far"

# The steps and limits of time that each thread is within, the innermost last.
_within = threading.local()


class Bar:
    """A bar that shows itself once the work has taken a while.

    Parameters
    ----------
    shown : bool
        Whether it shows at all.
    anywhere : bool
        Whether it also shows where standard error is no terminal.
    """

    def __init__(self, shown: bool, anywhere: bool = False):
        self._shown = shown and (anywhere or on_terminal() or in_notebook())
        self._begun = time.monotonic()
        self._last = -math.inf
        self._bar: Any = None

    def show(self, what: str, share: float | None) -> None:
        """Shows what is being done, and the share of all work that is done; None where nobody knows it."""
        now = time.monotonic()
        if not self._shown or now - self._begun < SHOWN_AFTER_S or now - self._last < REFRESH_S:
            return
        self._last = now
        try:
            self._refresh(what, share, now - self._begun)
        except (OSError, ValueError):  # whoever showed it has left; the work goes on
            self._shown = False

    def _refresh(self, what: str, share: float | None, elapsed: float) -> None:
        if self._bar is None:
            from tqdm.auto import tqdm

            columns, rows = unknown_size()
            self._bar = tqdm(total=1.0, desc=what, leave=False, bar_format=FORMAT, ncols=columns, nrows=rows)
            self._bar.start_t = time.time() - elapsed
        self._bar.bar_format = FORMAT_OF_UNKNOWN if share is None else FORMAT
        self._bar.n = 0.0 if share is None else share
        self._bar.set_description_str(what, refresh=False)
        self._bar.refresh()

    def close(self) -> None:
        """Takes it away."""
        bar, self._bar, self._shown = self._bar, None, False
        if bar is not None:
            with contextlib.suppress(OSError, ValueError):
                bar.close()


class Steps:
    """The progress of work of several steps, as a context; the work calls what it gives with the name of each step.

    Parameters
    ----------
    steps : int
        How many there are.
    shown : bool
        Whether a bar shows, on terminals and in notebooks. Without it calls of the core within show none either.
    anywhere : bool
        Whether it also shows where standard error is no terminal.
    """

    def __init__(self, steps: int, shown: bool, anywhere: bool = False):
        self._steps, self._begun_steps, self._what = steps, 0, ""
        self._how = shown, anywhere
        self._bar: Bar | None = None

    def __enter__(self) -> Callable[[str], None]:
        self._bar = Bar(*self._how)
        _all_within().append(self)
        return self._step

    def _step(self, what: str) -> None:
        self._begun_steps += 1
        self._what = what
        self.tell(0, 0)

    def tell(self, done: int, total: int) -> None:
        """Shows how much is done of the step that has begun, in time."""
        for one in _all_within():
            if isinstance(one, Deadline):
                one.check()
        if self._bar is not None:
            inner = min(1.0, done / total) if total > 0 else 0.0
            share = (max(0, self._begun_steps - 1) + inner) / max(1, self._steps)
            self._bar.show(self._what, min(1.0, share))

    def __exit__(self, *_: object) -> None:
        if self in (within := _all_within()):
            within.remove(self)
        if self._bar is not None:
            self._bar.close()


def checked_progress(progress: object) -> bool | None:
    """What an argument `progress` says: None shows a bar on terminals and in notebooks, True anywhere, False nowhere.

    Raises
    ------
    ArgumentError
        For anything else.
    """
    return None if progress is None else a_flag("progress", progress)


def steps_of_call(steps: int, progress: object) -> Steps:
    """The steps of a call with an argument `progress`; errors as of `checked_progress`."""
    asked = checked_progress(progress)
    return Steps(steps, asked is not False, anywhere=asked is True)


def steps_of_wait(steps: int) -> contextlib.AbstractContextManager[Callable[[str], None]]:
    """The steps of a call without such an argument; a part of the step that it is within, if it is within one."""
    return contextlib.nullcontext(lambda _: None) if _all_within() else Steps(steps, is_main_thread())


def tell(done: int, total: int) -> None:
    """Shows how much is done of the step that this thread is within, if it is within one."""
    if within := _all_within():
        within[-1].tell(done, total)


class OutOfTimeError(Exception):
    """Work that took longer than it may. No error of the package, so that nothing takes it for a refusal."""


class Deadline:
    """A limit of time for the work of this thread within, as a context.

    Calls of the core end where they report that they go on beyond it, within a tenth of a second. What else there is
    ends on the main thread of systems with timers, where the program has no alarm of its own; elsewhere the work is
    found late when it is over.

    Parameters
    ----------
    seconds : float or None
        None for no limit.

    Raises
    ------
    OutOfTimeError
        From within, or at the end.
    """

    def __init__(self, seconds: float | None):
        self._seconds = seconds
        self._end = math.inf
        self._outer: Steps | Deadline | None = None
        self._alarm = False

    def __enter__(self) -> None:
        if self._seconds is None:
            return
        self._end = time.monotonic() + self._seconds
        within = _all_within()
        self._outer = within[-1] if within else None
        within.append(self)
        if threading.current_thread() is threading.main_thread() and hasattr(signal, "setitimer"):
            self._alarm = signal.getsignal(signal.SIGALRM) is signal.SIG_DFL
        if self._alarm:
            try:
                signal.signal(signal.SIGALRM, self._raise)
                signal.setitimer(signal.ITIMER_REAL, self._seconds)
            except OutOfTimeError:  # a limit so short that nothing has begun
                self._leave()
                raise

    def tell(self, done: int, total: int) -> None:
        """Passes on how much is done, in time."""
        self.check()
        if self._outer is not None:
            self._outer.tell(done, total)

    def check(self) -> None:
        """Raises beyond the limit.

        Raises
        ------
        OutOfTimeError
        """
        if time.monotonic() >= self._end:
            self._raise()

    def _raise(self, *_: object) -> None:
        raise OutOfTimeError(f"took longer than the timeout of {self._seconds:g} s")

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self._leave()
        if kind is None:
            self.check()

    def _leave(self) -> None:
        if self._alarm:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
        if self in (within := _all_within()):
            within.remove(self)


class Waiting:
    """The progress of one call of the core, which reports to it while it works and closes it afterwards."""

    def __init__(self) -> None:
        within = _all_within()
        self._steps = within[-1] if within else None
        self._bar = Bar(self._steps is None and is_main_thread())

    def __call__(self, done: int, total: int) -> None:
        """Shows how many steps are done, of how many; 0 where the call does not know."""
        if self._steps is not None:
            self._steps.tell(done, total)
        else:
            self._bar.show("shadowlab", min(1.0, done / total) if total > 0 else None)

    def close(self) -> None:
        """Takes the bar away, if it is the call's own."""
        self._bar.close()


def waiting() -> Waiting:
    """What shows the progress of a call that the core has begun on this thread."""
    return Waiting()


def _all_within() -> list[Steps | Deadline]:
    found: list[Steps | Deadline] | None = getattr(_within, "steps", None)
    if found is None:
        found = _within.steps = []
    return found


def on_terminal() -> bool:
    """Whether standard error is a terminal."""
    try:
        return sys.stderr.isatty()
    except (AttributeError, OSError, ValueError):  # none, or a closed one
        return False


def in_notebook() -> bool:
    """Whether a notebook shows what this process prints."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None and hasattr(ipython, "get_ipython") else None
    return type(shell).__name__ == "ZMQInteractiveShell"


def is_main_thread() -> bool:
    """Whether this is the main thread of a process that no other one works with."""
    parent = getattr(sys.modules.get("multiprocessing.process"), "parent_process", None)
    return threading.current_thread() is threading.main_thread() and (parent is None or parent() is None)


def unknown_size() -> tuple[int, int] | tuple[None, None]:
    """Columns and rows of a terminal that does not say its own, on which tqdm would draw nothing; None of others."""
    try:
        size = os.get_terminal_size(sys.__stderr__.fileno())  # type: ignore[union-attr]
    except (AttributeError, OSError, ValueError):  # no terminal
        return None, None
    return (None, None) if min(size) > 0 else UNKNOWN_SIZE
