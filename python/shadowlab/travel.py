"""Values that travel: dataclasses that are equal by content, have a hash, and come out of a pickle as they went in.

The classes of the extension do the same with bytes of their own (`_core.restore`). A pickle holds a version, the
fields, and a checksum of them, so that what was damaged on the way is refused instead of read.

Two values are equal where their fields are: numbers as numbers (0.0 and -0.0 are one), NaN and NaN (it marks pixels and
points without a value), arrays by type, shape and elements. Bits travel: -0.0 and the payload of a NaN come back.
"""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any, ClassVar, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from .errors import StateError

T = TypeVar("T")

DIGEST_BYTES = 16


class Value:
    """Base of frozen dataclasses with ``eq=False``: `==`, `hash`, `copy`, `deepcopy` and `pickle` by their fields.

    Everything but the fields, such as what a cached property holds, stays behind. So do fields with ``compare=False``,
    which belong to a process: they do not count, and come back as their defaults. Whoever writes into an array of a
    value that is a key of a dict loses it there, as with any mutable key.
    """

    #: Of the fields as they are pickled; a class that changes them raises it.
    STATE_VERSION: ClassVar[int] = 1

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return self is other or all(same(a, b) for a, b in zip(_values(self), _values(other), strict=True))

    def __hash__(self) -> int:
        return hash((type(self).__qualname__, *map(key_of, _values(self))))

    def __reduce__(self) -> tuple[Any, ...]:
        state = dict(zip(_names(type(self)), _values(self), strict=True))
        return restored, (type(self), self.STATE_VERSION, state, checksum(state))


def restored(*parts: Any) -> Any:
    """The value of a class, a version, the fields by name, and their checksum.

    Raises
    ------
    StateError
        For a state that is damaged, or that a newer version wrote.
    """
    cls = parts[0] if parts else None
    if not (isinstance(cls, type) and issubclass(cls, Value) and len(parts) == 4):
        raise damaged("value", "its class is missing")
    version, state, digest = parts[1:]
    check_version(cls.__name__, version, cls.STATE_VERSION)
    if not isinstance(state, dict) or list(state) != _names(cls):
        raise damaged(cls.__name__, f"its fields are not {', '.join(_names(cls))}")
    if checksum(state) != digest:
        raise damaged(cls.__name__, "its checksum is another")
    made = object.__new__(cls)
    for name, value in {**_defaults(cls), **state}.items():
        object.__setattr__(made, name, value)
    return made


def check_version(name: str, version: Any, newest: int) -> None:
    """Raises unless the version is one that is known.

    Raises
    ------
    StateError
        For a newer one, or something else.
    """
    if isinstance(version, bool) or not isinstance(version, int) or version < 1:
        raise damaged(name, "its version is missing")
    if version > newest:
        raise StateError(
            f"{name}: expected a state of version {newest} or older, got version {version}, which a newer shadowlab "
            "wrote; update shadowlab here, or write it again with this version"
        )


def damaged(name: str, what: str) -> StateError:
    """The error for a state that is none."""
    return StateError(f"{name}: expected the state that pickle wrote, but {what}; copy it again, or make a new {name}")


def same(a: Any, b: Any) -> bool:
    """Whether two fields are equal: arrays and tables by their elements, NaN to NaN."""
    if a is b:
        return True
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return _same_arrays(a, b)
    if isinstance(a, float) and isinstance(b, float):
        return a == b or (a != a and b != b)
    if isinstance(a, (tuple, list)):
        return type(a) is type(b) and len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return a.keys() == b.keys() and all(same(value, b[name]) for name, value in a.items())
    if _is_table(a):
        return type(a) is type(b) and _same_tables(a, b)
    return bool(a == b)


def key_of(value: Any) -> Any:
    """Something hashable that is equal for equal fields."""
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, _settled_digest(value)
    if isinstance(value, float) and value != value:
        return "nan"
    if isinstance(value, (tuple, list)):
        return tuple(map(key_of, value))
    if isinstance(value, Mapping):
        return frozenset((name, key_of(one)) for name, one in value.items())
    if _is_table(value):
        return tuple(map(str, value.columns)), len(value)
    return hash(value)


def checksum(value: Any) -> bytes:
    """A digest of the bits of plain data, arrays and tables; the same in every process.

    Values of this package inside of it have a checksum of their own, so that they count by their class alone.
    """
    digest = hashlib.blake2b(digest_size=DIGEST_BYTES)
    _feed(digest, value)
    return digest.digest()


def _feed(digest: Any, value: Any) -> None:
    kind = type(value).__name__.encode()
    digest.update(struct.pack("<Q", len(kind)) + kind)
    if isinstance(value, float):
        digest.update(struct.pack("<d", value))
    elif isinstance(value, (bool, int)) or value is None:
        text = repr(value).encode()
        digest.update(struct.pack("<Q", len(text)) + text)
    elif isinstance(value, (str, bytes)):
        data = value.encode("utf-8", "surrogatepass") if isinstance(value, str) else value
        digest.update(struct.pack("<Q", len(data)) + data)
    elif isinstance(value, (tuple, list)):
        digest.update(struct.pack("<Q", len(value)))
        for item in value:
            _feed(digest, item)
    elif isinstance(value, Mapping):
        digest.update(struct.pack("<Q", len(value)))
        for name, item in value.items():
            _feed(digest, name)
            _feed(digest, item)
    elif isinstance(value, (np.ndarray, np.generic)):
        _feed_array(digest, np.asarray(value))
    elif is_dataclass(value) and not isinstance(value, (type, Value)):
        _feed(digest, [(field.name, getattr(value, field.name)) for field in fields(value) if field.compare])
    elif _is_table(value):
        _feed(digest, list(map(str, value.columns)))
        for i in range(len(value.columns)):
            _feed(digest, value.iloc[:, i].to_numpy())


def _feed_array(digest: Any, array: NDArray[Any]) -> None:
    _feed(digest, (array.dtype.newbyteorder("<").str, *array.shape))
    if array.dtype == object:
        _feed(digest, array.ravel().tolist())
    else:
        little = array.astype(array.dtype.newbyteorder("<"), copy=False)
        digest.update(_bytes_of(little))


def _bytes_of(array: NDArray[Any]) -> memoryview:
    return np.ascontiguousarray(array).reshape(-1).view(np.uint8).data


def _settled_digest(array: NDArray[Any]) -> Any:
    """A digest of the elements as they compare: -0.0 as 0.0, and one NaN for all."""
    if array.dtype == object:
        return tuple(map(key_of, array.ravel().tolist()))
    if array.dtype.kind in "fc":
        array = array + 0.0
        array[np.isnan(array)] = np.nan
    return hashlib.blake2b(_bytes_of(array), digest_size=DIGEST_BYTES).digest()


def _same_arrays(a: Any, b: Any) -> bool:
    if type(a) is not type(b) or a.dtype != b.dtype or a.shape != b.shape:
        return False
    if a.dtype == object:
        return all(map(same, a.ravel().tolist(), b.ravel().tolist()))
    return bool(np.array_equal(a, b, equal_nan=a.dtype.kind in "fc"))


def _is_table(value: Any) -> bool:
    # Without pandas there is none, and asking for it would load it.
    return hasattr(value, "columns") and hasattr(value, "iloc")


def _same_tables(a: Any, b: Any) -> bool:
    if list(a.columns) != list(b.columns) or len(a) != len(b) or not a.index.equals(b.index):
        return False
    columns = range(len(a.columns))
    return all(_same_arrays(a.iloc[:, i].to_numpy(), b.iloc[:, i].to_numpy()) for i in columns)


def _names(cls: type[Value]) -> list[str]:
    return [field.name for field in fields(cast("Any", cls)) if field.compare]


def _defaults(cls: type[Value]) -> dict[str, Any]:
    return {field.name: field.default for field in fields(cast("Any", cls)) if not field.compare}


def _values(value: Value) -> list[Any]:
    return [getattr(value, name) for name in _names(type(value))]
