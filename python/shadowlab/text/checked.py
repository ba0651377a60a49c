"""Arguments of a function checked by name before it runs: `@checked(gbuffer=a_gbuffer, width=a_count(1, 64))`.

A check takes the name and the value, and returns what the function gets; its error names the argument, what was
expected, what came and what to do.
"""

from __future__ import annotations

import functools
import inspect
import math
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from .. import _core
from ..errors import ArgumentError, UnknownNameError
from .arrays import checked_array, checked_items, checked_number
from .words import shown

if TYPE_CHECKING:
    from ..types import Light

P = ParamSpec("P")
R = TypeVar("R")

Check: TypeAlias = Callable[[str, object], Any]


def checked(**checks: Check) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """The decorator of a function whose arguments of these names are checked."""

    def decorated(function: Callable[P, R]) -> Callable[P, R]:
        signature = inspect.signature(function)

        @functools.wraps(function)
        def call(*args: P.args, **keywords: P.kwargs) -> R:
            try:
                bound = signature.bind(*args, **keywords)
            except TypeError:
                return function(*args, **keywords)  # in Python's own words
            for name, check in checks.items():
                if name in bound.arguments:
                    bound.arguments[name] = check(name, bound.arguments[name])
            return function(*bound.args, **bound.kwargs)

        return call

    return decorated


def optional(check: Check) -> Check:
    """The same check where there is a value."""
    return lambda name, value: None if value is None else check(name, value)


def instance(kinds: type | tuple[type, ...], expected: str, fix: str) -> Check:
    """Objects of some classes."""

    def check(name: str, value: object) -> object:
        if not isinstance(value, kinds):
            raise ArgumentError(f"{name}: expected {expected}, got {type(value).__name__}; {fix}")
        return value

    return check


A_CAMERA = instance(_core.Camera, "a Camera", "sl.Camera.look_at makes one")
A_SCENE = instance(_core.Scene, "a Scene", "sl.load_scene, sl.Scene.from_trimesh and sl.Scene.from_arrays make one")
LIGHTS = (_core.DirectionalLight, _core.SpotLight, _core.PointLight)
KINDS_OF_LIGHTS = "a DirectionalLight, a SpotLight or a PointLight"
LIGHT_HINT = "sl.DirectionalLight((0.3, -1, 0.1)) travels along that vector"


def a_light(name: str, value: object, fix: str = "call it for each light") -> Light:
    """A light.

    Raises
    ------
    ArgumentError
        For several lights, with `fix` as what to do with them, and for anything else.
    """
    if isinstance(value, LIGHTS):
        return value
    # Numbers would be a direction.
    if isinstance(value, (list, tuple)) and any(isinstance(one, LIGHTS) for one in value):
        raise ArgumentError(f"{name}: expected one light, got several in a {type(value).__name__}; {fix}")
    raise ArgumentError(f"{name}: expected {KINDS_OF_LIGHTS}, got {type(value).__name__}; {LIGHT_HINT}")


def one_or_more_lights(name: str, value: object) -> Light | tuple[Light, ...]:
    """A light, or the tuple of several.

    Raises
    ------
    ArgumentError
        For none, or something else.
    """
    if isinstance(value, LIGHTS):
        return value
    several = tuple(a_light(name, one) for one in checked_items(name, value, "a light, or several", LIGHT_HINT))
    if not several:
        raise ArgumentError(f"{name}: expected at least one light, got none; {LIGHT_HINT}")
    return several


def a_gbuffer(name: str, value: object) -> object:
    """A G-buffer, or anything with its pictures: `triangle` (H, W), `normal` and `position` (H, W, 3).

    Raises
    ------
    ArgumentError
        For anything else.
    """
    if isinstance(value, _core.GBuffer):
        return value
    if not has_all(value, "triangle", "normal", "position"):
        fix = "sl.Renderer().gbuffer(scene, camera, size=(640, 360)) makes one"
        raise ArgumentError(f"{name}: expected a GBuffer, got {type(value).__name__}; {fix}")
    of: Any = value
    shape = checked_array(f"{name}.triangle", of.triangle, np.int64, (None, None)).shape
    for picture in ("normal", "position"):
        checked_array(f"{name}.{picture}", getattr(of, picture), np.float64, (*shape, 3))
    return value


A_PARTITION = instance(_core.Partition, "a Partition", "take one of Parameterization.partitions")
A_PARAMETERIZATION = instance(_core.Parameterization, "a Parameterization", "technique.parameterize(...) makes one")


def a_text(name: str, value: object) -> str:
    """Text that can be written to a file.

    Raises
    ------
    ArgumentError
        For anything else.
    """
    if not isinstance(value, str):
        raise ArgumentError(f"{name}: expected text, got {shown(value)}; give a str")
    try:
        value.encode()
    except UnicodeEncodeError:
        raise ArgumentError(
            f"{name}: expected text that UTF-8 encodes, got {shown(value)}; replace those letters"
        ) from None
    return value


def a_flag(name: str, value: object) -> bool:
    """True or False.

    Raises
    ------
    ArgumentError
        For anything else.
    """
    if not isinstance(value, (bool, np.bool_)):
        raise ArgumentError(f"{name}: expected True or False, got {shown(value)}; give one of both")
    return bool(value)


def a_word(words: Sequence[object], fix: str) -> Check:
    """One of some words; None where it is among them."""
    listed = ", ".join(str(word) if word is None else repr(word) for word in words)

    def check(name: str, value: object) -> object:
        if value is None and None in words:
            return None
        if not isinstance(value, str):
            raise ArgumentError(f"{name}: expected one of {listed}, got {shown(value)}; {fix}")
        if value not in words:
            raise UnknownNameError(f"{name}: unknown {name} {shown(value)}; expected one of {listed}")
        return value

    return check


def a_number(name: str, value: object) -> float:
    """A finite number.

    Raises
    ------
    ArgumentError
        For anything else.
    """
    found = checked_number(name, value, "try 1.0", "a finite number")
    if not math.isfinite(found):
        raise ArgumentError(f"{name}: expected a finite number, got {found}; try 1.0")
    return found


def a_length(name: str, value: object) -> float:
    """A finite number above 0.

    Raises
    ------
    ArgumentError
        For anything else.
    """
    found = checked_number(name, value, "try 1.0", "a finite number above 0")
    if not 0 < found < math.inf:
        raise ArgumentError(f"{name}: expected a finite number above 0, got {found}; try 1.0")
    return found


def a_count(least: int, most: int) -> Check:
    """Whole numbers of a range."""

    def check(name: str, value: object) -> int:
        if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)):
            raise ArgumentError(f"{name}: expected a whole number from {least} to {most:,}, got {shown(value)}")
        if not least <= value <= most:
            raise ArgumentError(f"{name}: expected a whole number from {least} to {most:,}, got {shown(value)}")
        return int(value)

    return check


def numbers_in(dtype: npt.DTypeLike, *shape: int | None) -> Check:
    """Arrays of numbers of a type and shape; None for any length of at least 1."""

    def check(name: str, value: object) -> npt.NDArray[Any]:
        found = checked_array(name, value, dtype, shape)
        if not found.size:
            raise ArgumentError(f"{name}: expected at least one number, got shape {found.shape}; give a larger one")
        return found

    return check


def any_numbers(*shape: int | None) -> Check:
    """Arrays of float64 of a shape; there may be no number in them."""
    return lambda name, value: checked_array(name, value, np.float64, shape)


def finite_numbers(*shape: int | None) -> Check:
    """The same of float64, all finite."""
    of_shape = numbers_in(np.float64, *shape)

    def check(name: str, value: object) -> npt.NDArray[np.float64]:
        found: npt.NDArray[np.float64] = of_shape(name, value)
        if not np.isfinite(found).all():
            raise ArgumentError(f"{name}: expected finite numbers, got a NaN or an infinity; leave those out")
        return found

    return check


def a_picture(name: str, value: object) -> npt.NDArray[np.uint8]:
    """A picture (H, W, 3) of bytes.

    Raises
    ------
    ArgumentError
        For anything else.
    """
    if not isinstance(value, np.ndarray) or value.dtype != np.uint8 or value.ndim != 3 or value.shape[2] != 3:
        got = f"shape {value.shape} of {value.dtype}" if isinstance(value, np.ndarray) else shown(value)
        raise ArgumentError(f"{name}: expected a picture (H, W, 3) of uint8, got {got}; sl.plot.shade makes one")
    if 0 in value.shape:
        raise ArgumentError(f"{name}: expected at least one pixel, got shape {value.shape}; sl.plot.shade makes one")
    found: npt.NDArray[np.uint8] = np.ascontiguousarray(np.asarray(value))
    return found


def items_of(check: Check, expected: str, fix: str, least: int = 0) -> Check:
    """Lists of what another check takes."""

    def check_all(name: str, value: object) -> list[Any]:
        found = [check(name, item) for item in checked_items(name, value, expected, fix)]
        if len(found) < least:
            raise ArgumentError(f"{name}: expected {expected}, at least {least}, got {len(found)}; {fix}")
        return found

    return check_all


def a_path(name: str, value: object, example: str = "report") -> Path:
    """A path that the system may have; an error shows the example.

    Raises
    ------
    ArgumentError
        For anything else.
    """
    try:
        found = Path(value) if isinstance(value, (str, os.PathLike)) else None
        if found is not None and value != "":
            os.fsencode(found)
            if "\0" not in str(found):
                return found
    except Exception:  # noqa: BLE001 - paths of callers may raise whatever they like
        found = None
    raise ArgumentError(f'{name}: expected a path, got {shown(value)}; try "{example}"')


def has_all(value: object, *names: str) -> bool:
    """Whether a value has all of these attributes; one that raises where it is asked has none."""
    try:
        return all(hasattr(value, name) for name in names)
    except Exception:  # noqa: BLE001 - as in `a_path`
        return False
