"""Rows of a sweep that are drawn by chance from a space, the same ones for equal seeds."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, cast

import numpy as np

from ...errors import ArgumentError
from ...text import reason_of, shown
from ...text.arrays import checked_number
from ...text.checked import a_count, a_flag
from .space import MOST_RUNS, WITH_LABELS, Named, alternatives, checked_row

# The bounds of an interval, and whether it is drawn from evenly in the logarithm.
ENDS = {"min", "max"}
INTERVAL = {*ENDS, "log"}
MOST_SEED = 2**63 - 1
# Whole numbers up to here are floats without rounding.
MOST_NUMBER = 2.0**53


def random(space: Mapping[str, object], n: int, seed: int) -> list[dict[str, object]]:
    """Rows drawn from a space: what `sl.sweep` takes where the full product is too much.

    Every key is drawn from by its own stream of chance, so a key more leaves the values of the others, and a larger
    `n` begins with the rows of a smaller one.

    Parameters
    ----------
    space : dict
        As of `sl.sweep`; beside lists of values, each drawn as often as the others, a key may have an interval
        ``{"min": 0.5, "max": 4.0}`` of numbers, of whole ones where both ends are (drawn, too), drawn from evenly, or
        with ``"log": True`` evenly in the logarithm; or a callable ``f(rng)`` that makes a value with a
        `numpy.random.Generator`.
    n : int
        How many rows.
    seed : int
        0 or more.

    Returns
    -------
    list of dict
        One value per key. Rows that are the same after settings dropped out become one in the sweep.

    Raises
    ------
    ArgumentError
        For a space that is no dict, intervals without numbers, callables that raise, and numbers out of range.
    UnknownNameError
        For a key that does not exist.

    Examples
    --------
    >>> import shadowlab as sl
    >>> space = {
    ...     "scene": "@robots",
    ...     "light": lambda rng: sl.DirectionalLight((rng.normal(), -1, rng.normal())),
    ...     "technique": ["uniform", "lispsm"],
    ...     "lispsm.near": {"min": 0.5, "max": 4.0, "log": True},
    ...     "resolution": {"min": 256, "max": 1024},
    ... }
    >>> rows = sl.random(space, 5, seed=1)
    >>> len(rows), rows == sl.random(space, 8, seed=1)[:5]
    (5, True)
    >>> all(256 <= row["resolution"] <= 1024 for row in rows)
    True
    """
    given = checked_row("space", space)
    count = a_count(1, MOST_RUNS)("n", n)
    chance = a_count(0, MOST_SEED)("seed", seed)
    columns: dict[str, list[object]] = {}
    for key, value in given.items():
        draw = drawing_of(key, value)
        # By the key's letters, so that it has the same stream wherever it stands.
        rng = np.random.default_rng([chance, *key.encode()])
        columns[key] = [draw(rng) for _ in range(count)]
    return [{key: values[i] for key, values in columns.items()} for i in range(count)]


def drawing_of(key: str, value: object) -> Callable[[np.random.Generator], object]:
    """What draws one value of a key; errors as of `random`."""
    if isinstance(value, Mapping) and set(value) >= ENDS and key not in WITH_LABELS:
        return interval_of(key, value)
    if is_function(value):
        made = cast("Callable[[np.random.Generator], object]", value)
        return lambda rng: drawn_by(key, made, rng)
    choices = alternatives(key, value)
    if not choices:
        raise ArgumentError(f"space: expected at least one value for {key!r}, got none; leave the key out")
    return lambda rng: as_given(choices[int(rng.integers(len(choices)))])


def is_function(value: object) -> bool:
    """Whether a value is there to be called: techniques and presets may be callable, too, and are values."""
    return callable(value) and not isinstance(value, type) and not hasattr(value, "parameterize")


def as_given(one: Named) -> object:
    """A value as a row of a sweep has it."""
    return one.value if one.label is None else {one.label: one.value}


def drawn_by(key: str, make: Callable[[np.random.Generator], object], rng: np.random.Generator) -> object:
    """What a callable draws."""
    try:
        return make(rng)
    except Exception as error:
        raise ArgumentError(
            f"space: expected a function of a numpy Generator for {key!r}, got one that raised "
            f"{type(error).__name__} ({reason_of(error)}); try lambda rng: rng.uniform(0, 1)"
        ) from error


def interval_of(key: str, value: Mapping[Any, object]) -> Callable[[np.random.Generator], object]:
    """What draws a number of an interval."""
    if odd := [name for name in value if name not in INTERVAL]:
        raise ArgumentError(f"space: expected min, max and log for {key!r}, got {shown(odd[0])} beside; remove it")
    low, high = value["min"], value["max"]
    log = a_flag("log", value.get("log", False))
    least, most = (checked_number(f"space: {end} of {key!r}", value[end], "try 1.0") for end in ("min", "max"))
    if not max(abs(least), abs(most)) <= MOST_NUMBER:
        raise ArgumentError(
            f"space: expected numbers up to {MOST_NUMBER:g} as min and max of {key!r}, got {shown(value)}"
        )
    if least > most or (log and least <= 0):
        what = "above 0 and rising" if log else "rising"
        raise ArgumentError(f"space: expected numbers {what} as min and max of {key!r}, got {low} and {high}")
    if isinstance(low, (int, np.integer)) and isinstance(high, (int, np.integer)):
        return (lambda rng: log_whole(rng, int(low), int(high))) if log else (
            lambda rng: int(rng.integers(int(low), int(high), endpoint=True))
        )  # fmt: skip
    if log:
        return lambda rng: float(math.exp(rng.uniform(math.log(least), math.log(most))))
    return lambda rng: float(rng.uniform(least, most))


def log_whole(rng: np.random.Generator, low: int, high: int) -> int:
    """A whole number, evenly in the logarithm: each has the room from half below to half above it."""
    drawn = math.exp(rng.uniform(math.log(low - 0.5), math.log(high + 0.5)))
    return min(max(round(drawn), low), high)
