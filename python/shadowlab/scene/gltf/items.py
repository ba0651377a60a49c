"""Objects of a glTF file's JSON with their place in it: every value is checked where it is read, and errors name it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import LoadError

# Of a name or value in an error.
MOST_LETTERS = 60
FIX = "export the file again"
# JSON's numbers; true and false are of another type.
NUMBERS = {int, float}


@dataclass(frozen=True, eq=False)
class JsonObject:
    """A JSON object and where it stands.

    Attributes
    ----------
    file : str
        The file, for errors.
    where : str
        Its place, such as "meshes[3].primitives[0]"; empty for the whole document.
    value : dict
    """

    file: str
    where: str
    value: dict[str, Any]

    @property
    def name(self) -> str:
        """Its name; empty where it has none, or where that is no text."""
        name = self.value.get("name")
        return name if isinstance(name, str) else ""

    @property
    def place(self) -> str:
        """Its place with its name."""
        return f"{self.where} ({self.name!r})" if self.name else self.where or "the document"

    def broken(self, what: str, fix: str = FIX) -> LoadError:
        """An error about this object, and what to do."""
        return LoadError(f"{self.file}: {self.place}: {what}; {fix}")

    def wrong(self, key: str, expected: str, fix: str = FIX) -> LoadError:
        """An error about a value of this object, and what to do."""
        got = brief(self.value[key]) if key in self.value else "nothing"
        return self.broken(f"{key}: expected {expected}, got {got}", fix)

    def whole(self, key: str, default: int | None = None, *, least: int = 0) -> int:
        """A whole number, which may be written as 3.0.

        Raises
        ------
        LoadError
            For another value, one below `least`, or none where there is no default.
        """
        value = self.value.get(key)
        if value is None and default is not None and key not in self.value:
            return default
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int) or value < least:
            raise self.wrong(key, f"a whole number of at least {least}")
        return value

    def index(self, key: str, count: int, what: str) -> int:
        """The index of one of `count` things.

        Raises
        ------
        LoadError
            For another value.
        """
        value = self.whole(key)
        if value >= count:
            raise self.wrong(key, f"one of the file's {count} {what}, counted from 0")
        return value

    def number(self, key: str, default: float | None = None) -> float:
        """A finite number.

        Raises
        ------
        LoadError
            For another value, or none where there is no default.
        """
        if key not in self.value and default is not None:
            return default
        value = self.value.get(key)
        if value is None or not is_number(value):
            raise self.wrong(key, "a finite number")
        return float(value)

    def numbers(self, key: str, count: int | None = None) -> NDArray[np.float64] | None:
        """A list of finite numbers, of a given length; None where there is none.

        Raises
        ------
        LoadError
            For another value.
        """
        value = self.value.get(key)
        if value is None and key not in self.value:
            return None
        fits = isinstance(value, list) and (count is None or len(value) == count) and set(map(type, value)) <= NUMBERS
        try:
            made = np.array(value if fits else np.nan, np.float64)
        except OverflowError:  # a whole number of hundreds of digits
            made = np.array(np.nan)
        if not np.isfinite(made).all():
            raise self.wrong(key, f"a list of {'' if count is None else f'{count} '}finite numbers")
        return made

    def indices(self, key: str, count: int, what: str) -> list[int]:
        """A list of indices of `count` things; empty where there is none.

        Raises
        ------
        LoadError
            For another value.
        """
        values = self.value.get(key, [])
        if not isinstance(values, list):
            raise self.wrong(key, f"a list of indices of {what}")
        found = []
        for i, value in enumerate(values):
            whole = type(value) in NUMBERS and value == value // 1
            if not whole or not 0 <= value < count:
                of = JsonObject(self.file, f"{self.where}.{key}[{i}]" if self.where else f"{key}[{i}]", {})
                raise of.broken(f"expected one of the file's {count} {what}, counted from 0, got {brief(value)}")
            found.append(int(value))
        return found

    def text(self, key: str, default: str | None = None) -> str:
        """A text.

        Raises
        ------
        LoadError
            For another value, or none where there is no default.
        """
        if key not in self.value and default is not None:
            return default
        value = self.value.get(key)
        if not isinstance(value, str):
            raise self.wrong(key, "a text")
        return value

    def flag(self, key: str, default: bool) -> bool:
        """True or false.

        Raises
        ------
        LoadError
            For another value.
        """
        value = self.value.get(key, default)
        if not isinstance(value, bool):
            raise self.wrong(key, "true or false")
        return value

    def items(self, key: str) -> list[JsonObject]:
        """The objects of a list; none where there is no list.

        Raises
        ------
        LoadError
            For something else than a list of objects.
        """
        values = self.value.get(key, [])
        if not isinstance(values, list) or not all(isinstance(value, dict) for value in values):
            raise self.wrong(key, "a list of objects")
        prefix = f"{self.where}.{key}" if self.where else key
        return [JsonObject(self.file, f"{prefix}[{i}]", value) for i, value in enumerate(values)]

    def item(self, key: str) -> JsonObject | None:
        """An object; None where there is none.

        Raises
        ------
        LoadError
            For something else than an object.
        """
        if key not in self.value:
            return None
        value = self.value[key]
        if not isinstance(value, dict):
            raise self.wrong(key, "an object")
        return JsonObject(self.file, f"{self.where}.{key}" if self.where else key, value)

    def needed(self, key: str) -> JsonObject:
        """An object that must be there.

        Raises
        ------
        LoadError
            Where it is missing, or something else.
        """
        found = self.item(key)
        if found is None:
            raise self.wrong(key, "an object")
        return found

    def extension(self, *names: str) -> JsonObject | None:
        """What the first extension of these names, if any is there, says of this object.

        Raises
        ------
        LoadError
            For something else than an object.
        """
        if "extensions" not in self.value:
            return None
        extensions = self.needed("extensions")
        return next((extensions.needed(name) for name in names if name in extensions.value), None)


def is_number(value: object) -> bool:
    """Whether a JSON value is a finite number that a float holds."""
    try:
        return type(value) in NUMBERS and math.isfinite(value)  # type: ignore[arg-type]
    except OverflowError:
        return False


def brief(value: object) -> str:
    """A JSON value for an error, shortened."""
    if isinstance(value, dict):
        return "an object"
    if isinstance(value, list):
        return (
            f"a list of {len(value)}"
            if len(value) > 4 or any(isinstance(v, (list, dict)) for v in value)
            else str(value)
        )
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) >= 10**20:
        return "a number of more than 20 digits"
    text = {"None": "null", "True": "true", "False": "false"}.get(repr(value), repr(value))
    return text if len(text) <= MOST_LETTERS else f"{text[:MOST_LETTERS]}..."
