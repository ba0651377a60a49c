"""Metrics that are functions of a run: their names, the numbers that they give, and what tells one from another."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import math
import pickle
import types
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ...errors import ArgumentError
from ...text import shown
from ...text.arrays import checked_items
from ...text.checked import a_text
from ..columns import COLUMNS
from ..metrics import KNOWN_METRICS, Metric, checked_metrics
from ..store.row_text import LONGEST_NAME, MOST_CELLS, of_64_bits
from .space import settings_keys

if TYPE_CHECKING:
    from ..run import Run

Function = Callable[["Run"], object]
DIGEST_BYTES_OF_CODE = 8
# Of one function: half of what a store keeps of a row.
NUMBERS_OF_FUNCTION = MOST_CELLS // 2


def apart_from_names(metrics: object) -> tuple[tuple[Metric, ...], tuple[tuple[str, Function], ...]]:
    """The metrics that `evaluate` has, and the functions with their names.

    Raises
    ------
    ArgumentError
        For neither a name nor a function, two functions of one name, and a name that a column has.
    UnknownNameError
        For a metric that does not exist.
    """
    listed = f"several of {', '.join(KNOWN_METRICS)}, or functions of a run"
    single = isinstance(metrics, str) or callable(metrics)
    given = [metrics] if single else checked_items("metrics", metrics, listed, 'try ("misclassified",)')
    names = [one for one in given if not callable(one)]
    functions = [(name_of_function(one), cast("Function", one)) for one in given if callable(one)]
    for name, _ in functions:
        if [other for other, _ in functions].count(name) > 1:
            raise ArgumentError(f"metrics: two functions are called {name!r}; define them under names of their own")
        check_column(name)
    for one in names:
        if not isinstance(one, str):
            raise ArgumentError(f'metrics: expected {listed}, got {shown(one)}; try ("misclassified",)')
    return checked_metrics(names), tuple(functions)


def name_of_function(function: object) -> str:
    """What a function is called: that of the function within a partial one, the class of an object."""
    while isinstance(function, functools.partial):
        function = function.func
    name = None
    with contextlib.suppress(Exception):
        # Objects of callers may raise where they are asked.
        name = getattr(function, "__name__", None)
    return a_text("metrics", name if isinstance(name, str) else type(function).__name__)


def check_column(name: str) -> None:
    """Raises for a name that a column of every table has.

    Raises
    ------
    ArgumentError
    """
    if name in COLUMNS or name in settings_keys():
        raise ArgumentError(f"metrics: expected a name that no column has, got {name!r}; call it otherwise")
    if not name.strip() or len(name) > LONGEST_NAME:
        raise ArgumentError(
            f"metrics: expected names of 1 to {LONGEST_NAME} letters, got {shown(name)}; call it otherwise"
        )


def numbers_from(name: str, function: Function, run: Run) -> dict[str, bool | int | float | None]:
    """What a function gives for a run, by columns.

    Raises
    ------
    ArgumentError
        For something that is neither a number nor a dict of numbers.
    Exception
        Whatever the function raises.
    """
    found = function(run)
    if not isinstance(found, Mapping):
        return {name: plain_number(name, found)}
    if len(found) > NUMBERS_OF_FUNCTION:
        raise ArgumentError(f"expected at most {NUMBERS_OF_FUNCTION:,} numbers, got {len(found):,}; give fewer")
    numbers = {}
    for key, value in found.items():
        if not isinstance(key, str):
            raise ArgumentError(f"expected texts as names of its numbers, got {shown(key)}")
        check_column(a_text("metrics", key))
        numbers[key] = plain_number(key, value)
    return numbers


def plain_number(name: str, value: object) -> bool | int | float | None:
    """A number of Python; None for none and for NaN.

    Raises
    ------
    ArgumentError
        For anything else.
    """
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return None
    if isinstance(value, (bool, float)):
        return value
    if isinstance(value, int):
        return of_64_bits(value)
    raise ArgumentError(f"expected a number or a dict of numbers for {name}, got {shown(value)}")


def text_of_metrics(metrics: tuple[Metric, ...], functions: tuple[tuple[str, Function], ...]) -> tuple[str, ...]:
    """What rows in a store depend on: the names, and of functions their modules, names and code."""
    return (*metrics, *(f"{name}#{digest_of(function)}" for name, function in functions))


def digest_of(function: object) -> str:
    """A digest of what a function does: its code and what it holds, not the functions that it calls."""
    digest = hashlib.blake2b(digest_size=DIGEST_BYTES_OF_CODE)
    for part in parts_of(function):
        digest.update(part.encode("utf-8", "backslashreplace"))
        digest.update(b"\0")
    return digest.hexdigest()


def parts_of(function: object) -> list[str]:
    """What tells a function from others, as texts that are the same in every process."""
    if isinstance(function, functools.partial):
        held = [repr(digest_of(value)) for value in (*function.args, *function.keywords.values())]
        return [*parts_of(function.func), *held, *function.keywords]
    if isinstance(function, types.MethodType):
        return [*parts_of(function.__func__), digest_of(function.__self__)]
    code = getattr(function, "__code__", None) if isinstance(function, types.FunctionType) else None
    if isinstance(code, types.CodeType):
        made = cast("Any", function)
        cells = [digest_of(cell.cell_contents) for cell in made.__closure__ or () if not is_empty(cell)]
        defaults = [digest_of(value) for value in made.__defaults__ or ()]
        return [made.__module__ or "", made.__qualname__, *parts_of_code(code), *cells, *defaults]
    try:
        return [type(function).__qualname__, hashlib.blake2b(pickle.dumps(function, 4)).hexdigest()]
    except Exception:  # noqa: BLE001 - what callers hold may refuse in any way
        return [type(function).__qualname__]


def is_empty(cell: types.CellType) -> bool:
    """Whether a cell of a closure holds nothing yet."""
    try:
        _ = cell.cell_contents
    except ValueError:
        return True
    return False


def parts_of_code(code: types.CodeType) -> list[str]:
    """Instructions, names and constants, those of functions within among them."""
    constants = []
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            constants += parts_of_code(constant)
        elif isinstance(constant, frozenset):
            constants.append(repr(sorted(map(repr, constant))))
        else:
            constants.append(repr(constant))
    return [code.co_code.hex(), *code.co_names, *code.co_varnames, *constants]
