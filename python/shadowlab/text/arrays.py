"""Numbers, lists and arrays of numbers as callers give them: the one place that reads them, for the extension as well.

What comes may be anything: an object whose methods raise, a list that holds itself, a sequence that says it has a
million million items. Reading it ends, soon, in an array or in an error that names the argument; nothing is allocated
because of what a sequence says of its own length.
"""

from __future__ import annotations

import itertools
import sys
from collections.abc import Iterable
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from ..errors import ArgumentError
from .words import reason_of, shown

# Items that are read of what is no list or tuple, such as a generator: more than anybody has cameras, lights or
# techniques; and numbers that are read of a sequence that is no array either. Both in a second at most.
MOST_ITEMS, MOST_NUMBERS = 1 << 16, 1 << 21
# Numbers that are converted at once: about 0.01 s.
_LARGE = 1 << 20
# Items of a list that numpy reads in some milliseconds.
AT_ONCE = 1 << 15
# The bits of 1 in single precision: those of negative numbers, larger ones and NaN are more.
_BITS_OF_ONE = 0x3F80_0000
# Axes of an array: more than any argument has.
MOST_AXES = 4
# What numpy reads at once, without a look at the items.
_PLAIN = (bool, int, float, complex, str, bytes)
_LISTS = frozenset({list, tuple})


def checked_array(
    name: str, value: object, dtype: npt.DTypeLike = np.float64, shape: tuple[int | None, ...] | None = None
) -> npt.NDArray[Any]:
    """The value as an array of numbers: contiguous, of this type and shape (None for any length, and for any shape).

    Truth values are no numbers; complex numbers, text and dates neither. What does not fit into the type is refused
    rather than wrapped around.

    Raises
    ------
    ArgumentError
        For anything else.
    """
    wanted = np.dtype(dtype)
    try:
        found = _converted(value, wanted)
    except Exception as error:  # noqa: BLE001 - what callers give may raise whatever it likes
        why = "" if isinstance(value, str) else f" ({reason_of(error)})"
        raise ArgumentError(
            f"{name}: expected {_expected(wanted, shape)}, got {shown(value)}{why}; convert it first"
        ) from None
    if shape is not None and not _fits(found.shape, shape):
        raise ArgumentError(
            f"{name}: expected {_expected(wanted, shape)}, got shape {list(found.shape)}; reshape it"
        ) from None
    return found


def check_map_depths(name: str, maps: object) -> None:
    """Raises where an array holds what is no depth of a shadow map; other types are left to those who take them.

    Raises
    ------
    ArgumentError
        For numbers below 0 or above 1, NaN and infinities.
    """
    if not isinstance(maps, np.ndarray) or maps.dtype.kind != "f" or not maps.size:
        return
    maps = np.asarray(maps)  # Of a class of somebody's own, what numpy makes of it.
    if maps.dtype == np.float32 and maps.view(np.uint32).max() <= _BITS_OF_ONE:
        return  # One look, where two would be needed.
    low, high = float(maps.min()), float(maps.max())
    if not (low >= 0.0 and high <= 1.0):
        got = "NaN among them" if np.isnan(low) else f"{low:g} to {high:g}"
        raise ArgumentError(
            f"{name}: expected depths between 0 and 1, got {got}; Renderer.shadow_map makes them; of other programs "
            "their range is to be scaled to [0, 1]"
        )


def checked_number(name: str, value: object, fix: str = "give a number", expected: str = "a number") -> float:
    """The value as a float; truth values and text are none. NaN and infinities are left to whoever knows the range.

    Raises
    ------
    ArgumentError
        For anything else.
    """
    if isinstance(value, (float, int)) and not isinstance(value, bool):
        try:
            return float(value)
        except OverflowError:
            raise ArgumentError(f"{name}: expected {expected}, got {shown(value)}; {fix}") from None
    try:
        found = _scalar(value)
    except Exception:  # noqa: BLE001 - as in `checked_array`
        found = None
    if found is None:
        raise ArgumentError(f"{name}: expected {expected}, got {shown(value)}; {fix}") from None
    return found


def checked_items(name: str, value: object, expected: str = "a list", fix: str = "give a list") -> list[Any]:
    """The items of anything that can be gone through, as a list; text is no list.

    Raises
    ------
    ArgumentError
        For what cannot be gone through, raises on the way, or has more than `MOST_ITEMS` items.
    """
    if type(value) in _LISTS:
        return list(cast("Iterable[Any]", value))
    try:
        iterator = None if isinstance(value, (str, bytes, bytearray)) else iter(cast("Iterable[Any]", value))
    except Exception:  # noqa: BLE001 - as in `checked_array`
        iterator = None
    if iterator is None:
        raise ArgumentError(f"{name}: expected {expected}, got {shown(value)}; {fix}")
    try:
        found = list(itertools.islice(iterator, MOST_ITEMS + 1))
        if len(found) > MOST_ITEMS:
            raise ValueError(f"more than {MOST_ITEMS:,} items")
    except Exception as error:  # noqa: BLE001 - as in `checked_array`
        raise ArgumentError(f"{name}: expected {expected}, got {shown(value)} ({reason_of(error)}); {fix}") from None
    return found


def _expected(dtype: np.dtype[Any], shape: tuple[int | None, ...] | None) -> str:
    if shape is None:
        return f"an array of {dtype}"
    sides = ", ".join("N" if side is None else str(side) for side in shape)
    return f"an array of shape ({sides}{',' * (len(shape) == 1)}) of {dtype}"


def _fits(actual: tuple[int, ...], shape: tuple[int | None, ...]) -> bool:
    return len(actual) == len(shape) and all(side is None or side == n for n, side in zip(actual, shape, strict=True))


def _scalar(value: object) -> float | None:
    """The number that an object stands for; None for what is none."""
    if isinstance(value, (bool, np.bool_, str, bytes, bytearray, complex, np.complexfloating, list, tuple)):
        return None
    if isinstance(value, np.ndarray):
        return float(value) if value.ndim == 0 and value.dtype.kind in "iuf" else None
    if isinstance(value, (np.datetime64, np.timedelta64)):
        return None
    return float(cast("Any", value))


def _converted(value: object, dtype: np.dtype[Any]) -> npt.NDArray[Any]:
    raw = _read_at_once(value) if type(value) not in _LISTS else _read_in_parts(cast("list[object]", value))
    masked = sys.modules.get("numpy.ma")  # only there where somebody made such an array: loading it takes a while
    if masked is not None and isinstance(value, masked.MaskedArray) and masked.is_masked(value):
        raise TypeError("values are masked; value.filled(...) says what stands there")
    if raw.size == 0:
        # An empty list has the type float64, whatever it is meant to hold.
        return np.ascontiguousarray(raw, dtype).reshape(raw.shape)
    if raw.dtype.kind == "b":
        raise TypeError("truth values are no numbers")
    if raw.dtype.kind not in "iuf":
        raise TypeError(f"no real numbers, but {raw.dtype}")
    with np.errstate(all="ignore"):
        # Unsigned indices are fine; real numbers as indices are not.
        casting: Any = "unsafe" if raw.dtype.kind == "u" and dtype.kind == "i" else "same_kind"
        if raw.dtype == dtype or raw.ndim == 0 or raw.size < _LARGE or not np.can_cast(raw.dtype, dtype, casting):
            found = np.require(raw.astype(dtype, casting=casting, order="C", copy=False), requirements=["C", "A"])
        else:
            # Row by row, so that an interruption need not wait for all of them.
            found = np.empty(raw.shape, dtype)
            step = max(1, _LARGE * len(raw) // raw.size)
            for row in range(0, len(raw), step):
                found[row : row + step] = raw[row : row + step]
    if raw.dtype.kind in "iu" and dtype.kind in "iu" and raw.dtype != found.dtype and not bool((raw == found).all()):
        raise ValueError(f"numbers that {dtype} does not hold")
    return found


def _read_at_once(value: object) -> npt.NDArray[Any]:
    return np.asarray(bounded(value))


def _read_in_parts(value: list[object]) -> npt.NDArray[Any]:
    """A list as an array; of a long one part by part, so that Ctrl-C is seen between two of them."""
    if len(value) <= AT_ONCE:
        return _read_at_once(value)
    parts = [_read_at_once(value[i : i + AT_ONCE]) for i in range(0, len(value), AT_ONCE)]
    odd = next((part for part in parts if part.dtype.kind not in "iuf"), None)
    # An array of the kind that is refused, or one of all numbers.
    return odd if odd is not None else np.concatenate(parts)


def bounded(value: object) -> object:
    """The value, or lists with its items, in which numpy finds nothing that makes it wait or ask for memory."""
    if isinstance(value, (np.ndarray, np.generic, *_PLAIN)):
        return value
    level: Iterable[Any] = [value]
    for _ in range(MOST_AXES + 1):
        kinds = set(map(type, level))
        if all(issubclass(kind, (np.ndarray, np.generic, *_PLAIN)) for kind in kinds):
            return value
        if not kinds <= _LISTS:
            return _read(value, 0)
        level = list(itertools.chain.from_iterable(level))
    raise ValueError(f"lists within lists, more than {MOST_AXES} deep")


def _read(value: object, depth: int) -> object:
    """The value with each item looked at by itself."""
    if depth > MOST_AXES:
        raise ValueError(f"lists within lists, more than {MOST_AXES} deep")
    if isinstance(value, (np.ndarray, np.generic, *_PLAIN)):
        return value
    if type(value) in _LISTS:
        return [_read(item, depth + 1) for item in cast("Iterable[Any]", value)]
    if hasattr(value, "__array__") or hasattr(value, "__array_interface__") or isinstance(value, memoryview):
        return np.asarray(value)
    if hasattr(type(value), "__len__") and hasattr(type(value), "__getitem__") and not hasattr(value, "keys"):
        length = len(cast("Any", value))
        if length > MOST_NUMBERS:
            raise ValueError(f"it says that it has {length:,} items; give an array")
        items = list(itertools.islice(iter(cast("Iterable[Any]", value)), length + 1))
        if len(items) != length:
            raise ValueError(
                f"it says that it has {length:,} items, and has {'more' if len(items) > length else len(items)}"
            )
        return [_read(item, depth + 1) for item in items]
    return value
