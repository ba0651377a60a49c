"""Values that no argument expects: each by a name and a function that makes it anew."""

from __future__ import annotations

import itertools
import mmap
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

# Levels of a nested list: far beyond what Python's own recursion allows.
DEEP = 10_000
# What a sequence says of its length where it lies: more items than any memory holds.
HUGE = 1 << 40


class Raises:
    """An object of which one special method raises; all others are as usual."""

    def __init__(self, method: str) -> None:
        def fail(*args: Any, **keywords: Any) -> Any:
            raise RuntimeError(f"{method} was called")

        self.__class__ = type(f"Raises{method.strip('_')}", (Raises,), {method: fail})  # type: ignore[assignment]


class Liar:
    """A sequence that says that it has more items than it has, or fewer."""

    def __init__(self, length: int, items: int) -> None:
        self.length, self.items = length, items

    def __len__(self) -> int:
        return self.length

    def __getitem__(self, index: int) -> float:
        if index >= self.items:
            raise IndexError(index)
        return 1.0


class LyingList(list[float]):
    """A list that says that it has more items than any memory holds."""

    def __len__(self) -> int:
        return HUGE


class Attributes:
    """An object that has every attribute, each of them itself."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return self

    def __call__(self, *args: Any, **keywords: Any) -> Any:
        return self


class Delicate(np.ndarray[Any, Any]):
    """An array of which no view can be made."""

    def __array_finalize__(self, other: Any) -> None:
        if other is not None and type(other) is Delicate:
            raise RuntimeError("__array_finalize__ was called")


def delicate() -> Any:
    return np.eye(4).view(Delicate)


def deep() -> list[Any]:
    made: list[Any] = []
    for _ in range(DEEP):
        made = [made]
    return made


def cyclic() -> list[Any]:
    made: list[Any] = []
    made.append(made)
    return made


def mapped() -> Any:
    """An array in mapped memory."""
    return np.frombuffer(mmap.mmap(-1, 16 * 8), np.float64).reshape(4, 4)


def read_only() -> Any:
    made = np.eye(4)
    made.flags.writeable = False
    return made


def axes() -> Any:
    from matplotlib.figure import Figure

    return Figure().subplots()


def lonely() -> str:
    """Text that no encoding takes."""
    return "a\udc80b"


_ARRAYS: dict[str, Callable[[], Any]] = {
    "array of shape (0,)": lambda: np.zeros(0),
    "array of shape (0, 3)": lambda: np.zeros((0, 3)),
    "array of shape (3, 1)": lambda: np.ones((3, 1)),
    "array of shape (2, 2)": lambda: np.ones((2, 2)),
    "array of 30 axes": lambda: np.ones((1,) * 30),
    "array of one": lambda: np.ones(1),
    "array of NaN": lambda: np.full((4, 4), np.nan),
    "array of infinities": lambda: np.full(3, np.inf),
    "array of huge numbers": lambda: np.full((3, 3), 1e308),
    "array of -1": lambda: np.full((3, 3), -1),
    "array without axes": lambda: np.array(2.5),
    "complex array": lambda: np.eye(4, dtype=complex),
    "bool array": lambda: np.eye(4, dtype=bool),
    "object array": lambda: np.array([None, "a", object()], object),
    "object array of numbers": lambda: np.array([[1, 2.5, 3]], object),
    "array of text": lambda: np.array(["a", "b", "c"]),
    "array of bytes": lambda: np.array([b"a", b"b"]),
    "array of dates": lambda: np.array(["2020-01-01", "NaT"], "datetime64[D]"),
    "structured array": lambda: np.zeros(3, [("x", "f8"), ("y", "i4")]),
    "read-only array": read_only,
    "strided array": lambda: np.arange(32.0).reshape(4, 8)[:, ::2],
    "reversed array": lambda: np.eye(4)[::-1, ::-1],
    "Fortran array": lambda: np.asfortranarray(np.arange(16.0).reshape(4, 4)),
    "big-endian array": lambda: np.eye(4).astype(">f8"),
    "masked array": lambda: np.ma.masked_greater(np.eye(4), 0.5),  # type: ignore[no-untyped-call]
    "mapped array": mapped,
    "float16 array": lambda: np.eye(4, dtype=np.float16),
    "long double array": lambda: np.eye(4, dtype=np.longdouble),
    "array of 2**64 - 1": lambda: np.full((3, 3), 2**64 - 1, np.uint64),
    "matrix": lambda: np.asmatrix(np.eye(4)),
    "array that allows no view": delicate,
}

_OBJECTS: dict[str, Callable[[], Any]] = {
    f"{method} raises": lambda method=method: Raises(method)  # type: ignore[misc]
    for method in (
        "__array__", "__float__", "__index__", "__int__", "__bool__", "__len__", "__iter__", "__getitem__", "__repr__",
        "__str__", "__eq__", "__hash__", "__getattr__", "__fspath__", "__lt__", "__format__", "__call__",
    )
}  # fmt: skip

#: All of them.
VALUES: dict[str, Callable[[], Any]] = {
    "None": lambda: None,
    "NaN": lambda: float("nan"),
    "infinity": lambda: float("inf"),
    "-infinity": lambda: float("-inf"),
    "-0.0": lambda: -0.0,
    "1e308": lambda: 1e308,
    "5e-324": lambda: 5e-324,
    "2**63": lambda: 2**63,
    "2**200": lambda: 2**200,
    "10**5000": lambda: 10**5000,
    "1e9": lambda: 1_000_000_000,
    "-1": lambda: -1,
    "0": lambda: 0,
    "1.5": lambda: 1.5,
    "True": lambda: True,
    "1j": lambda: 1j,
    "Decimal": lambda: Decimal("sNaN"),
    "Fraction": lambda: Fraction(1, 3),
    "numpy NaN": lambda: np.float32("nan"),
    "numpy bool": lambda: np.bool_(True),
    "numpy int8": lambda: np.int8(-128),
    "numpy date": lambda: np.datetime64("NaT"),
    "empty text": lambda: "",
    "long text": lambda: "x" * 10_000,
    "text of a zero": lambda: "\0",
    "text of lines": lambda: "a\nb\r\nc",
    "text of half a character": lonely,
    "text of braces": lambda: "{0} %s {",
    "bytes": lambda: b"abc",
    "no bytes": lambda: b"",
    "bytearray": lambda: bytearray(b"abc"),
    "empty list": list,
    "empty tuple": tuple,
    "empty dict": dict,
    "dict": lambda: {"a": 1, 2: None},
    "empty set": set,
    "set": lambda: {1, 2, 3},
    "list of None": lambda: [None, None, None],
    "list of text": lambda: ["a", "b"],
    "ragged list": lambda: [[1, 2], [3]],
    "deep list": deep,
    "list that holds itself": cyclic,
    "long list": lambda: [[0.5] * 1000] * 1000,
    "generator": lambda: (i for i in range(3)),
    "empty generator": lambda: iter(()),
    "generator that raises": lambda: (1 // i for i in (1, 0)),
    "endless generator": itertools.count,
    "range": lambda: range(3),
    "long range": lambda: range(10**15),
    "sequence that claims too much": lambda: Liar(HUGE, 3),
    "sequence without an end": lambda: Liar(3, HUGE),
    "sequence of negative length": lambda: Liar(-1, 3),
    "list that claims too much": lambda: LyingList([1.0, 2.0, 3.0]),
    "object": object,
    "object of all attributes": Attributes,
    "class": lambda: int,
    "lambda": lambda: lambda *a, **k: None,
    "module": lambda: np,
    "Ellipsis": lambda: ...,
    "exception": lambda: ValueError("an exception"),
    "axes": axes,
    "path": lambda: Path("nowhere/at/all"),
    "table": lambda: pd.DataFrame({"a": [1, 2]}),
    "column": lambda: pd.Series(["a", None]),
    "pandas NA": lambda: pd.NA,
    **_ARRAYS,
    **_OBJECTS,
}

#: Those that stand for all where calls are many: one or two of each kind.
FEW = (
    "None", "NaN", "2**200", "-1", "1.5", "True", "empty text", "text of half a character", "bytes", "empty list",
    "dict",
    "deep list", "endless generator", "sequence that claims too much", "list that claims too much", "object", "lambda",
    "table", "array of shape (2, 2)", "array of NaN", "object array", "array of text", "array that allows no view",
    "__array__ raises", "__repr__ raises", "__eq__ raises", "__getattr__ raises", "__iter__ raises",
)  # fmt: skip
