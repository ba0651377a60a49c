"""A process that works for a sweep: reads runs from its standard input and writes answers to its standard output.

```
    <- ("start", threads, task)     -> ("ready",) or ("broken", why)
    <- ("view", view, file)         the view of the runs that follow, and the file of its scene
    <- ("run", place, run)          -> ("begun", place), ("answer", Answer)
```
It never runs the main module of the program that started it, and ends with it, in the middle of a run if need be.
"""

from __future__ import annotations

import contextlib
import os
import queue
import sys
import threading
from pathlib import Path
from typing import Any, BinaryIO

from ... import _core
from ...scene.view import View
from ...text import reason_of
from .messages import receive, send
from .parcels import SentView, answer_to_sent, held_scene, loaded
from .work import Answer, Task


def work() -> None:
    """Works until its input ends."""
    source, sink = own_pipes()
    messages: queue.SimpleQueue[Any] = queue.SimpleQueue()
    threading.Thread(target=listen, args=(source, messages), daemon=True).start()
    _, threads, data = messages.get()
    try:
        _core.set_threads(threads)
        task: Task = loaded(data).here()
    except Exception as error:  # noqa: BLE001 - what callers sent may fail in any way
        send(sink, ("broken", f"{type(error).__name__}: {reason_of(error)}"))
        return
    send(sink, ("ready",))
    desk = Desk(task, sink)
    # Nobody reads any more where the program that started it was killed.
    with contextlib.suppress(BrokenPipeError):
        while True:
            kind, *parts = messages.get()
            getattr(desk, kind)(*parts)
    os._exit(0)


class Desk:
    """What a worker has before it: the task, and the view of its runs."""

    def __init__(self, task: Task, sink: BinaryIO):
        self.task, self.sink, self.process = task, sink, os.getpid()
        self._view: View | None = None

    def view(self, sent: SentView, file: str) -> None:
        """Turns to a view; pictures of the one before would only take room."""
        scene = held_scene(sent.scene, Path(file).read_bytes)
        if self._view is not None:
            self._view.clear()
        self._view = sent.view(scene)

    def run(self, place: int, data: bytes) -> None:
        """Answers a run."""
        answer = self._answer(place, data)
        if os.getpid() != self.process:
            # A metric forked and came back twice: the copy hears nothing, and would wait for ever.
            os._exit(0)
        send(self.sink, ("answer", answer))

    def _answer(self, place: int, data: bytes) -> Answer:
        if self._view is None:
            raise RuntimeError("a run came before its view")
        return answer_to_sent(self._view, place, data, self.task, lambda: send(self.sink, ("begun", place)))


def listen(source: BinaryIO, messages: queue.SimpleQueue[Any]) -> None:
    """Passes messages on; where there will be no more, nobody waits for an answer."""
    with contextlib.suppress(EOFError, OSError):
        while True:
            messages.put(receive(source))
    os._exit(0)


def own_pipes() -> tuple[BinaryIO, BinaryIO]:
    """The input and output for messages alone; what metrics print goes to standard error."""
    source, sink = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    os.dup2(2, 1)
    if sys.platform == "win32":
        import msvcrt

        for descriptor in (source, sink):
            msvcrt.setmode(descriptor, os.O_BINARY)
    return os.fdopen(source, "rb"), os.fdopen(sink, "wb")
