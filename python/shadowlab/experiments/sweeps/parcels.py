"""What travels to other processes: views without their scenes, tasks, runs; and scenes once per process, by content.

```
    Parcels     task and groups; and a folder with one file per scene, named by `Scene.content_hash`, gone at the end
    dumped      bytes of anything, or an error that says what cannot be sent before the work starts
```
Functions of `__main__`, of notebooks and lambdas travel by value where cloudpickle is installed (alone, or with Dask or
joblib): no worker runs the main module again.
"""

from __future__ import annotations

import pickle
import shutil
import sys
import tempfile
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, cast

from ... import _core
from ...errors import ArgumentError
from ...scene.kept import Kept
from ...scene.view import View
from ...text import reason_of
from .work import Answer, Group, Request, Task, answer_to, failed, prepare

if TYPE_CHECKING:
    from ...types import Light

# The scenes that this process was sent, by their hashes: work is grouped by view, so few are in use.
HELD = Kept(4)


@dataclass(frozen=True, eq=False)
class SentView:
    """A view without its scene, which is known by its content."""

    scene: str
    camera: _core.Camera
    light: Light | tuple[Light, ...]
    size: tuple[int, int]
    label: str

    @classmethod
    def of(cls, view: View) -> SentView:
        """A view to send."""
        return cls(view.scene.content_hash, view.camera, view.light, view.size, view.label)

    def view(self, scene: _core.Scene) -> View:
        """The view again."""
        return View(scene, self.camera, self.light, self.size, self.label)


@dataclass(frozen=True, eq=False)
class SentGroup:
    """The runs in a view as they travel: each run by itself, so that one that cannot be read fails alone."""

    view: SentView
    requests: tuple[tuple[int, bytes], ...]
    cost: float

    @classmethod
    def of(cls, group: Group) -> SentGroup:
        """A group to send.

        Raises
        ------
        ArgumentError
            For a technique that cannot be sent.
        """
        requests = tuple(
            (one.place, dumped(one, f"technique: {one.label!r}", "define its class in a module"))
            for one in group.requests
        )
        return cls(SentView.of(group.view), requests, group.cost)


def dumped_task(task: Task) -> bytes:
    """A task to send.

    Raises
    ------
    ArgumentError
        For a function or a renderer that cannot be sent.
    """
    for name, function in task.functions:
        dumped(function, f"metrics: {name!r}", "define it in a module, without open files or locks")
    dumped(task.renderer, "renderer: it", 'give "cpu" or "gpu"')
    return dumped(task, "metrics: they", "define them in a module")


def dumped(value: object, what: str, fix: str) -> bytes:
    """The bytes of a value.

    Raises
    ------
    ArgumentError
        Where there are none, or where they can only be read in this program; `what` begins the message.
    """
    by_value = dumps_by_value()
    try:
        found: bytes = pickle.dumps(value, 5) if by_value is None else by_value(value)
    except Exception as error:  # noqa: BLE001 - what callers give may refuse in any way
        raise ArgumentError(f"{what} cannot be sent to other processes ({reason_of(error)}); {fix}") from None
    # A name of the main module, which workers do not run.
    if by_value is None and b"__main__" in found:
        raise ArgumentError(
            f"{what} cannot be sent to other processes: it is defined in the main program; move it into a module, or "
            "install cloudpickle: pip install cloudpickle"
        )
    return found


def dumps_by_value() -> Callable[[object], bytes] | None:
    """What pickles functions of the main module by value; None where it is not installed."""
    try:
        from cloudpickle import dumps
    except ImportError:
        try:
            from joblib.externals.cloudpickle import dumps
        except ImportError:
            return None
    made: Callable[[object], bytes] = dumps
    return made


def loaded(data: bytes) -> Any:
    """The value of bytes that `dumped` made."""
    return pickle.loads(data)


def file_of(folder: Path, scene: str) -> Path:
    """Where the scene of a hash is in the folder of a sweep."""
    return folder / f"{scene}.pickle"


class Parcels:
    """What a sweep sends: its task and groups, and its scenes as files in a folder of their own, which goes at the end.

    Parameters
    ----------
    groups : sequence of Group
    task : Task

    Raises
    ------
    ArgumentError
        For what cannot be sent.
    """

    def __init__(self, groups: Sequence[Group], task: Task):
        self.task, self.timeout = dumped_task(task), task.timeout
        self.groups = [SentGroup.of(group) for group in groups]
        self._scenes = {group.view.scene.content_hash: group.view.scene for group in groups}
        self.folder = Path(tempfile.mkdtemp(prefix="shadowlab-sweep-"))

    def file(self, scene: str) -> Path:
        """The file of a scene, written at the first use."""
        path = file_of(self.folder, scene)
        if not path.exists():
            part = path.with_suffix(f".{threading.get_ident()}")
            part.write_bytes(self.data(scene))
            part.replace(path)
        return path

    def data(self, scene: str) -> bytes:
        """The bytes of a scene."""
        return pickle.dumps(self._scenes[scene], 5)

    def __enter__(self) -> Parcels:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        shutil.rmtree(self.folder, ignore_errors=True)


def held_scene(scene: str, read: Callable[[], bytes]) -> _core.Scene:
    """The scene of a hash as this process holds it, or of the bytes that `read` gives."""
    return HELD.get("scene", scene, lambda: cast("_core.Scene", loaded(read())), lambda _: 1)


def answer_to_sent(view: View, place: int, data: bytes, task: Task, begun: Callable[[], None] = lambda: None) -> Answer:
    """The answer of a run that was sent; `begun` is called when what it shares with others is there."""
    try:
        request: Request = loaded(data)
        prepare(view, task, request)
    except Exception as error:  # noqa: BLE001 - what callers sent may fail in any way
        return failed(place, type(error).__name__, f"cannot be read here: {reason_of(error)}", settled=False)
    begun()
    return answer_to(view, request, task)


def frozen() -> bool:
    """Whether this program has no Python interpreter that could be started beside it."""
    return bool(getattr(sys, "frozen", False)) or not sys.executable
