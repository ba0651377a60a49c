"""What came of a call: a result, an error that helps, or something that it should not be."""

from __future__ import annotations

import re
import signal
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from shadowlab.errors import InternalError, ShadowlabError

from .calls import arguments, invoke
from .found import Callee
from .values import VALUES

#: Seconds that a call may take.
LIMIT = 20.0

#: Arguments that messages call by another name, and which.
SYNONYMS = {
    # Keywords without names of their own: the message has that of the keyword.
    "changes": ".*",
    "params": ".*",
    "parts": ".*",
    # Of meshes: what faces name.
    "positions": "positions?|vertices",
    # Of footprints: the array that is of another shape then.
    "map": "map|major",
    # What is looked up by name, and what is read.
    "value": "value|convention",
    "name": "name|scene|technique|preset|kind",
    "path": "path|file",
    "source": "source|file|bytes",
}


#: Calls that are left out, and why.
LEFT_OUT = {
    ("sl.scene_optimal_experiment", "views", "None"): "28 views: some minutes",
    ("_core.trace_shadow_mask", "progress", "class"): "the caller's own error",
    ("_core.trace_shadow_mask", "progress", "__call__ raises"): "as above",
}


class Late(BaseException):
    """A call took too long."""


@dataclass(frozen=True)
class Outcome:
    """What came of one call."""

    callee: str
    argument: str
    value: str
    #: "result", "error" for one that helps, else what is wrong with it.
    kind: str
    text: str = ""

    @property
    def good(self) -> bool:
        return self.kind in ("result", "error")


@contextmanager
def limited(seconds: float) -> Iterator[None]:
    """Raises `Late` where the block takes longer; work of the core stops at its next look at signals."""

    def late(*_: Any) -> None:
        raise Late

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def cases(callee: Callee) -> Iterator[tuple[str, str]]:
    """The arguments of a callable, each with every value, by name."""
    for parameter in callee.parameters:
        for value in VALUES:
            if (callee.name, parameter.name, value) in LEFT_OUT:
                continue
            yield parameter.name, value


def changed(callee: Callee, argument: str, hostile: Any) -> Mapping[str, Any]:
    """The arguments of a good call, one of them replaced; of keywords without names the first, of parts the last."""
    given = dict(arguments(callee))
    kinds = {parameter.name: parameter.kind for parameter in callee.parameters}
    parameter = next(iter(callee.parameters))
    if kinds[argument] is parameter.VAR_KEYWORD:
        given[argument] = {next(iter(given[argument]), "nothing_of_that_name"): hostile}
    elif kinds[argument] is parameter.VAR_POSITIONAL:
        given[argument] = (*given[argument][:-1], hostile)
    else:
        given[argument] = hostile
    return given


def judged(callee: Callee, argument: str, value: str) -> Outcome:
    """The outcome of a call with one hostile argument."""
    hostile = VALUES[value]()
    given = changed(callee, argument, hostile)
    try:
        with limited(LIMIT), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            invoke(callee, given)
    except InternalError as error:
        return Outcome(callee.name, argument, value, "defect", text_of(error))
    except ShadowlabError as error:
        return Outcome(callee.name, argument, value, fault_of(error, argument), text_of(error))
    except Late:
        return Outcome(callee.name, argument, value, "late")
    except BaseException as error:  # noqa: BLE001 - panics of the core are no Exception
        return Outcome(callee.name, argument, value, f"untyped {type(error).__name__}", text_of(error))
    return Outcome(callee.name, argument, value, "result")


def text_of(error: BaseException) -> str:
    """The beginning of a message."""
    try:
        return str(error)[:300]
    except Exception:  # noqa: BLE001 - the error may hold the hostile value
        return "no text"


def fault_of(error: ShadowlabError, argument: str) -> str:
    """ "error" for a message that helps, else what it lacks."""
    text = str(error)
    if "\n" in text:
        return "several lines"
    if not re.search(SYNONYMS.get(argument, rf"\b{argument}\b|\b{argument.removesuffix('s')}\b"), text):
        return "no name"
    return "error"
