"""The public callables of the package, found by looking at it: functions, constructors, methods and operators."""

from __future__ import annotations

import enum
import inspect
import types
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import travel_support

import shadowlab as sl
from shadowlab import _core

#: Operators that take a value.
OPERATORS = ("__eq__", "__ne__", "__lt__", "__add__", "__getitem__", "__contains__", "__call__")
#: What dataclasses, enumerations and `object` bring along.
INHERITED = {"__class__", "__init_subclass__", "__subclasshook__"}


@dataclass(frozen=True)
class Callee:
    """A callable by its public name; a method also by the name of its class."""

    name: str
    of: Any
    #: Class of the object that it is called on, for methods of instances.
    owner: type | None = None

    @property
    def parameters(self) -> list[inspect.Parameter]:
        """Its parameters, without the object that it is called on."""
        found = list(inspect.signature(self.of).parameters.values())
        return found[1:] if self.owner is not None else found


def modules() -> dict[str, types.ModuleType]:
    """The package, the modules that its `__all__` names, at any depth, and the extension."""
    found = {"sl": sl}
    waiting = [("sl", sl)]
    while waiting:
        prefix, module = waiting.pop()
        for name in getattr(module, "__all__", None) or vars(module):
            value = getattr(module, name)
            if (
                isinstance(value, types.ModuleType)
                and value.__name__.startswith("shadowlab")
                and value not in found.values()
            ):
                found[f"{prefix}.{name}"] = value
                waiting.append((f"{prefix}.{name}", value))
    return {**found, "_core": _core}


def callees() -> list[Callee]:
    """All of them, each once."""
    found: dict[int, Callee] = {}
    for prefix, module in modules().items():
        for name in getattr(module, "__all__", None) or vars(module):
            value = getattr(module, name)
            if callable(value) and not isinstance(value, type) and not name.startswith("_"):
                found.setdefault(id(value), Callee(f"{prefix}.{name}", value))
    for cls in travel_support.public_classes():
        if issubclass(cls, enum.Enum):
            continue
        for callee in members(cls):
            found.setdefault(id(callee.of), callee)
    return sorted(found.values(), key=lambda callee: callee.name)


def members(cls: type) -> Iterator[Callee]:
    """The constructor, methods and operators that a class defines itself."""
    name = travel_support.name_of(cls)
    if not issubclass(cls, Exception) and takes_arguments(cls):
        yield Callee(name, cls)
    for key, member in vars(cls).items():
        if key in INHERITED or (key.startswith("_") and key not in OPERATORS):
            continue
        if isinstance(member, (staticmethod, classmethod)):
            yield Callee(f"{name}.{key}", getattr(cls, key))
        elif callable(member) and not isinstance(member, type):
            yield Callee(f"{name}.{key}", member, cls)


def takes_arguments(cls: type) -> bool:
    """Whether a class of the package can be called to make an object."""
    try:
        return bool(inspect.signature(cls).parameters)
    except ValueError:
        return False


def properties() -> list[tuple[str, type, str]]:
    """Properties that can be written to: class and name."""
    return [
        (f"{travel_support.name_of(cls)}.{key}", cls, key)
        for cls in travel_support.public_classes()
        for key, member in vars(cls).items()
        if isinstance(member, property) and member.fset is not None
    ]
