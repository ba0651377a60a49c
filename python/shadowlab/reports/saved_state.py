"""Results as plain data, exactly, and back: what `Study.load` and `Advice.load` read.

Values are objects in a list, which name one another by their places, so that views and scenes that runs share stay
shared. Of the extension's values there are the bytes that they are pickled as, with a checksum of their own; nothing in
a file names a class that is not listed here, and nothing of it is run. A scene is its origin.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any, cast

import numpy as np

from .. import _core
from ..aliasing.summary import Summary
from ..errors import StateError
from ..experiments.advice import Advice
from ..experiments.candidates import Candidate, Outcome
from ..experiments.measures import Measure, measure_of
from ..experiments.run import Run
from ..experiments.study import Study
from ..experiments.tried import Untried
from ..experiments.views import LabelledView
from ..scene.origin import SceneOrigin
from ..scene.source import Source
from ..scene.view import View, view_of_origin
from ..techniques.absent import AbsentTechnique
from ..techniques.labels import full_name_of
from ..techniques.presets import PRESETS, Preset, preset
from ..techniques.variant import Variant
from ..travel import Value, checksum, restored

#: What a file may name, beside what the extension restores.
CLASSES: Mapping[str, type[Any]] = {
    one.__name__: one
    for one in (
        AbsentTechnique, Advice, Candidate, LabelledView, Outcome, Run, SceneOrigin, Source, Study, Summary, Untried,
        Variant,
    )
}  # fmt: skip
_LEAF = (bool, int, str, type(None))


def state_of_result(result: Study | Advice) -> dict[str, Any]:
    """A result as data that JSON writes."""
    return _Writing().whole(result)


def result_of_state(state: object) -> tuple[Any, list[SceneOrigin]]:
    """The result of such data, and the origins of its scenes.

    Raises
    ------
    StateError
        For anything else.
    """
    try:
        reading = _Reading(cast("Mapping[str, Any]", state))
        return reading.result, [one for one in reading.made if isinstance(one, SceneOrigin)]
    except StateError:
        raise
    except Exception as error:  # noqa: BLE001 - a file may hold anything
        raise StateError(
            f"state: expected what `save` wrote, got another ({type(error).__name__}); save it again"
        ) from None


class _Writing:
    def __init__(self) -> None:
        self._objects: list[Any] = []
        # Values are kept beside their places, so that an identity stays that of one value.
        self._places: dict[int, tuple[int, object]] = {}
        self._origins: dict[str, SceneOrigin] = {}

    def whole(self, result: object) -> dict[str, Any]:
        root = self.of(result)
        return {"objects": self._objects, "root": root}

    def of(self, value: object) -> Any:
        """A value, or the place of its object."""
        if isinstance(value, np.generic):
            value = value.item()
        if isinstance(value, _LEAF):
            return value
        if isinstance(value, float):
            return value if math.isfinite(value) else {"float": repr(value)}
        if isinstance(value, (tuple, list)):
            found = [self.of(one) for one in value]
            return found if isinstance(value, list) else {"tuple": found}
        if isinstance(value, Mapping):
            return {"map": [[self.of(name), self.of(one)] for name, one in value.items()]}
        if id(value) not in self._places:
            made = self._object(value)
            self._places[id(value)] = (len(self._objects), value)
            self._objects.append(made)
        return {"at": self._places[id(value)][0]}

    def _object(self, value: Any) -> dict[str, Any]:
        if isinstance(value, np.ndarray):
            little = np.ascontiguousarray(value, value.dtype.newbyteorder("<"))
            return {"array": [little.dtype.str, list(little.shape), _text_of(little.tobytes())]}
        if isinstance(value, View):
            names = ("camera", "light", "size", "label")
            return {"view": [self.of(self._origin(value)), *(self.of(getattr(value, name)) for name in names)]}
        if isinstance(value, Measure):
            return {"measure": value.name}
        if isinstance(value, Preset) and value in PRESETS:
            return {"preset": value.name}
        if type(value) in CLASSES.values():
            version = value.STATE_VERSION if isinstance(value, Value) else 1
            state = {name: self.of(getattr(value, name)) for name in _field_names(type(value))}
            return {"class": [type(value).__name__, version, state]}
        reduced = value.__reduce__() if type(value).__module__.startswith("shadowlab") else ()
        if reduced and reduced[0] is _core.restore:
            kind, version, data = reduced[1]
            return {"core": [kind, version, _text_of(data)]}
        # A technique of a class that is not known where the file is read.
        return self._object(AbsentTechnique(full_name_of(value), dict(value.settings)))

    def _origin(self, view: View) -> SceneOrigin:
        """The origin of a view's scene: the same for all views of it."""
        origin = view.origin
        return self._origins.setdefault(origin.content_hash, origin)


class _Reading:
    def __init__(self, state: Mapping[str, Any]):
        # An object names those before it alone, so that none is a part of itself.
        self.made: list[Any] = []
        for data in state["objects"]:
            ((kind, held),) = data.items()
            self.made.append(_OBJECTS[kind](self, held))
        self.result = self.of(state["root"])

    def of(self, data: Any) -> Any:
        """The value of some data."""
        if isinstance(data, (*_LEAF, float)):
            return data
        if isinstance(data, list):
            return [self.of(one) for one in data]
        ((kind, held),) = data.items()
        if kind != "at":
            return _PLAIN[kind](self, held)
        if held < 0:
            raise StateError("state: expected objects that name those before them; save it again")
        return self.made[held]

    def view(self, held: Any) -> View:
        origin, camera, light, size, label = map(self.of, held)
        return view_of_origin(origin, camera, light, size, label)

    def value(self, held: Any) -> Any:
        name, version, data = held
        cls, state = CLASSES[name], {key: self.of(one) for key, one in data.items()}
        if issubclass(cls, Value):
            return restored(cls, version, state, checksum(state))
        return cls(**state)


def _array(_: object, held: Any) -> np.ndarray:
    kind, shape, data = held
    made: np.ndarray = np.frombuffer(_bytes_of_text(data), np.dtype(kind)).reshape(shape).copy()
    return made


_PLAIN: Mapping[str, Callable[[_Reading, Any], Any]] = {
    "float": lambda _, held: float(held),
    "tuple": lambda reading, held: tuple(reading.of(one) for one in held),
    "map": lambda reading, held: {reading.of(name): reading.of(one) for name, one in held},
}
_OBJECTS: Mapping[str, Callable[[_Reading, Any], Any]] = {
    "array": _array,
    "view": _Reading.view,
    "measure": lambda _, held: measure_of(held),
    "preset": lambda _, held: preset(held),
    "class": _Reading.value,
    "core": lambda _, held: _core.restore(held[0], held[1], _bytes_of_text(held[2])),
}


def _field_names(cls: type[Any]) -> list[str]:
    return [one.name for one in fields(cls) if one.compare and one.init]


def _text_of(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")


def _bytes_of_text(text: str) -> bytes:
    return base64.b64decode(text, validate=True)
