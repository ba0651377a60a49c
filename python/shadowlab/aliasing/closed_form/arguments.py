"""What the closed forms were given, checked and broadcast: each error names the argument, what came, and what to do."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ...errors import ArgumentError, UnknownNameError
from ...text import shown
from ...text.arrays import checked_array, checked_number

Array: TypeAlias = npt.NDArray[np.float64]
#: What a closed form returns: a float where all arguments are single numbers, else an array.
Numbers: TypeAlias = float | Array

# Derived from float64: of a larger far / near, the difference far - near is far itself.
LARGEST_RATIO = 2.0**52
# An end of a range that went through a logarithm and back, or a rotation, may miss itself by some units of the last
# digit.
END_SLACK = 8 * float(np.finfo(np.float64).eps)
# Chosen because products of three such numbers and of LARGEST_RATIO stay within float64.
SMALLEST = 1e-75


def together(**values: npt.ArrayLike) -> list[Array]:
    """The values as float64 arrays of one shape, in order.

    Raises
    ------
    ArgumentError
        For what is no real number, and for shapes that do not broadcast.
    """
    arrays = [real(name, value) for name, value in values.items()]
    try:
        return list(np.broadcast_arrays(*arrays))
    except ValueError:
        shapes = ", ".join(f"{name} {a.shape}" for name, a in zip(values, arrays, strict=True) if a.ndim)
        raise ArgumentError(
            f"{', '.join(values)}: expected shapes that broadcast, got {shapes}; z[:, None] makes a table of two"
        ) from None


def real(name: str, value: object) -> Array:
    """The value as an array of float64; infinities and NaN are left to the check of its range."""
    if isinstance(value, int) and not isinstance(value, bool):
        return np.asarray(checked_number(name, value, "try a float", "a real number or an array of them"))
    return checked_array(name, value)


def returned(values: npt.NDArray[Any]) -> Numbers:
    """The values as the caller gets them: a float for one number."""
    return float(values) if np.ndim(values) == 0 else np.array(values, dtype=np.float64)


def refuse(name: str, value: Array, wrong: npt.NDArray[np.bool_], expected: str, advice: str, **others: Array) -> None:
    """Raises for the first value that is wrong; `{name}` in `expected` is the number of `others` beside it.

    Raises
    ------
    ArgumentError
        Where any is wrong.
    """
    if np.any(wrong):
        first = int(np.flatnonzero(wrong)[0])
        beside = {key: repr(float(other.flat[first])) for key, other in others.items()}
        got = float(value.flat[first])
        raise ArgumentError(f"{name}: expected {expected.format(**beside)}, got {got!r}; {advice}")


def check_depths(near: Array, far: Array, names: tuple[str, str] = ("near", "far")) -> None:
    """Raises unless 0 < near < far, both finite, and the ratio is one that float64 can tell from infinity.

    Raises
    ------
    ArgumentError
        For other depths.
    """
    advice = "depths are distances along the view direction, as Camera.near and Camera.far"
    refuse(names[0], near, ~((near > 0) & (near < math.inf)), "a finite depth above 0", advice)
    refuse(
        names[1],
        far,
        ~((far > near) & (far < math.inf)),
        f"a finite depth beyond {names[0]} = {{near}}",
        advice,
        near=near,
    )
    with np.errstate(over="ignore"):
        ratio = far / near
    refuse(
        names[1],
        far,
        ~(ratio <= LARGEST_RATIO),
        f"at most {LARGEST_RATIO:.1e} times {names[0]} = {{near}}",
        "beyond that, far - near is far itself in float64; move near out",
        near=near,
    )


def check_within(name: str, z: Array, low: Array, high: Array) -> None:
    """Raises unless low <= z <= high, up to rounding.

    Raises
    ------
    ArgumentError
        For a depth outside, or NaN.
    """
    inside = (z >= low * (1 - END_SLACK)) & (z * (1 - END_SLACK) <= high)
    advice = "receivers have depths within the range of the map, such as np.geomspace(near, far)"
    refuse(name, z, ~inside, "a depth in [{low}, {high}]", advice, low=low, high=high)


def check_fov(fov_y: Array) -> None:
    """Raises unless the full vertical field of view is an angle of a camera.

    Raises
    ------
    ArgumentError
        For an angle outside (0, pi).
    """
    wrong = ~((fov_y >= SMALLEST) & (fov_y < math.pi))
    advice = "it is the full vertical angle, as Camera.fov_y; np.radians(60) is a common one"
    refuse("fov_y", fov_y, wrong, "an angle in (0, pi) radians", advice)


def check_whole(name: str, value: Array) -> None:
    """Raises unless all are whole numbers of 1 or more.

    Raises
    ------
    ArgumentError
        For others.
    """
    wrong = ~((value >= 1) & (value < math.inf) & (np.floor(value) == value))
    refuse(name, value, wrong, "a whole number of 1 or more", "4 is a common number of splits")


def check_name(name: str, value: object, known: Sequence[str]) -> str:
    """The value, one of the known names.

    Raises
    ------
    ArgumentError
        For what is no name.
    UnknownNameError
        For a name that is not known.
    """
    names = ", ".join(known)
    if not isinstance(value, str):
        raise ArgumentError(f"{name}: expected one of {names}, got {shown(value)}; closed forms go by name")
    if value not in known:
        raise UnknownNameError(f"{name}: unknown {name} {shown(value)}; expected one of {names}")
    return value
