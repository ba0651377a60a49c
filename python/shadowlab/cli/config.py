"""Configurations in TOML: an error names file, line and key, and the nearest valid key of one that does not exist."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import ArgumentError, LoadError, ShadowlabError
from ..text import reason_of, shown
from .config_lines import KeyPlace, key_lines
from .nearest import nearest_text

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

# Bytes of a configuration: more than any that a person or a script would write for this.
LARGEST_CONFIG = 1 << 22


class PlacedError(ArgumentError):
    """A mistake in a configuration, which says file, line and key."""


@dataclass(frozen=True)
class Table:
    """A table of a configuration, and where it stands.

    Attributes
    ----------
    file : str
        The path of the configuration, as it was given.
    values : Mapping[str, Any]
        The keys with their values; keys may be written with - or _, here they have _.
    place : KeyPlace
        The keys that lead here from the top.
    lines : Mapping[KeyPlace, int]
        The line of each key of the document.
    """

    file: str
    values: Mapping[str, Any]
    place: KeyPlace
    lines: Mapping[KeyPlace, int]

    def __contains__(self, key: str) -> bool:
        return self.spelt(key) is not None

    def spelt(self, key: str) -> str | None:
        """A key as it is written here, with - or _; None where it is not."""
        if key in self.values:
            return key
        return next((name for name in self.values if name.replace("-", "_") == key.replace("-", "_")), None)

    def get(self, key: str, default: Any = None) -> Any:
        """The value of a key."""
        name = self.spelt(key)
        return default if name is None else self.values[name]

    def wrong(self, key: str | None, message: str) -> ArgumentError:
        """The error of a key, or of the table: file, line, key and what is wrong with it."""
        place = self.place if key is None else (*self.place, self.spelt(key) or key)
        at = place
        while at and at not in self.lines:
            at = at[:-1]
        dotted = ".".join(str(part) for part in place if isinstance(part, str))
        head = f"{self.file}:{self.lines.get(at, 1)}"
        # Checks of arguments name them themselves, by the names of options.
        for name in () if key is None else (key, key.replace("_", "-"), key.replace("-", "_")):
            message = message.removeprefix(f"{name}: ")
        return PlacedError(f"{head}: {dotted}: {message}" if dotted else f"{head}: {message}")

    @contextlib.contextmanager
    def naming(self, key: str | None) -> Iterator[None]:
        """Errors of ours from within say where the key stands; those of a key within do already."""
        try:
            yield
        except PlacedError:
            raise
        except ShadowlabError as error:
            raise self.wrong(key, str(error)) from error

    def only(self, names: Iterable[str]) -> None:
        """Raises for a key that is none of these, or is written twice.

        Raises
        ------
        ArgumentError
            With the nearest of the names.
        """
        known = list(names)
        seen: list[str] = []
        for key in self.values:
            name = key.replace("-", "_")
            if name not in (one.replace("-", "_") for one in known):
                raise self.wrong(key, f"unknown key; {nearest_text(key, known)}")
            if name in seen:
                raise self.wrong(key, "given twice, with - and with _; give it once")
            seen.append(name)

    def text(self, key: str, expected: str, default: str | None = None) -> str | None:
        """A text."""
        value = self.get(key, default)
        if value is not None and not (isinstance(value, str) and value):
            raise self.wrong(key, f"expected {expected}, got {shown(value)}")
        return value

    def texts(self, key: str, expected: str) -> list[str] | None:
        """One text, or several."""
        value = self.get(key)
        if value is None:
            return None
        found = [value] if isinstance(value, str) else value
        if not (isinstance(found, list) and found and all(isinstance(one, str) and one for one in found)):
            raise self.wrong(key, f"expected {expected}, got {shown(value)}")
        return found

    def number(self, key: str, expected: str) -> float | None:
        """A number."""
        value = self.get(key)
        if value is not None and (isinstance(value, bool) or not isinstance(value, (int, float))):
            raise self.wrong(key, f"expected {expected}, got {shown(value)}")
        return value

    def whole(self, key: str, default: int, least: int = 1) -> int:
        """A whole number."""
        value = self.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int) or value < least:
            raise self.wrong(key, f"expected a whole number of {least} or more, got {shown(value)}")
        return value

    def vector(self, key: str, expected: str) -> tuple[float, float, float] | None:
        """Three numbers."""
        value = self.get(key)
        if value is None:
            return None
        right = isinstance(value, list) and len(value) == 3
        if not right or any(isinstance(one, bool) or not isinstance(one, (int, float)) for one in value):
            raise self.wrong(key, f"expected {expected}, got {shown(value)}")
        return float(value[0]), float(value[1]), float(value[2])

    def table(self, key: str, example: str) -> Table | None:
        """A table within; None where there is none."""
        name = self.spelt(key)
        if name is None:
            return None
        if not isinstance(self.values[name], dict):
            raise self.wrong(key, f"expected a table such as {example}, got {shown(self.values[name])}")
        return Table(self.file, self.values[name], (*self.place, name), self.lines)

    def tables(self, key: str) -> list[Table]:
        """The tables of an array `[[key]]`."""
        name = self.spelt(key)
        value = [] if name is None else self.values[name]
        if not isinstance(value, list) or not all(isinstance(one, dict) for one in value):
            raise self.wrong(key, f"expected tables [[{key}]], got {shown(value)}")
        return [Table(self.file, one, (*self.place, name or key, i), self.lines) for i, one in enumerate(value)]


def read_config(path: str) -> Table:
    """The top of a configuration.

    Raises
    ------
    LoadError
        For a file that cannot be read, is no text, or too large.
    ArgumentError
        For what is no TOML, with line and column.
    """
    try:
        with Path(path).open("rb") as file:
            content = file.read(LARGEST_CONFIG + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise LoadError(f"{path}: cannot read it ({reason}); check the path") from error
    if len(content) > LARGEST_CONFIG:
        raise LoadError(f"{path}: expected at most {LARGEST_CONFIG:,} bytes, got more; is it a configuration?")
    try:
        text = content.decode("utf-8-sig").replace("\r\n", "\n")
        values = tomllib.loads(text)
    except UnicodeDecodeError as error:
        raise LoadError(
            f"{path}: expected text in UTF-8, got other bytes at {error.start}; save it as UTF-8"
        ) from error
    except (ValueError, RecursionError) as error:
        # Of numbers with thousands of digits a bare ValueError.
        raise ArgumentError(f"{path}: no valid TOML: {reason_of(error)}") from error
    return Table(path, values, (), key_lines(text))
