"""Texts that name things: `lispsm:near=basic`, `@forest:trees=500`, `1,2,3`, `1280x720`; and back again.

What stands in parentheses is one value, whatever separators are in it, as in src/techniques/text.rs:
`z_partition:count=4,inner=(lispsm:near=optimal)/uniform`, `plane_optimal:plane=(0,1,0,0)`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TypeAlias

from ..errors import ArgumentError
from .words import shown

# Parentheses within parentheses, as in src/techniques/text.rs: more than any text has that means something.
MOST_PARENTHESES = 64
# Pixels along a side of a picture, as of the renderers.
LONGEST_PICTURE = 16384
# Of a column or row that a text says.
MOST_PIXEL_DIGITS = 10

#: What a text can say: a flag, a number, a word, or a tuple of numbers or of such tuples.
Parsed: TypeAlias = "bool | int | float | str | tuple[Parsed, ...]"


def pieces(text: str, separator: str) -> list[str] | None:
    """The pieces between separators outside of parentheses; None where the parentheses do not pair up."""
    depth, found = 0, [""]
    for letter in text:
        depth += (letter == "(") - (letter == ")")
        if not 0 <= depth <= MOST_PARENTHESES:
            return None
        if letter == separator and depth == 0:
            found.append("")
        else:
            found[-1] += letter
    return [piece.strip() for piece in found] if depth == 0 else None


def bare(text: str) -> str:
    """The text without the parentheses around all of it."""
    text = text.strip()
    # "(a)/(b)" begins and ends with one, too.
    while text.startswith("(") and text.endswith(")") and pieces(text[1:-1], ",") is not None:
        text = text[1:-1].strip()
    return text


def parse_value(text: str) -> Parsed:
    """A flag, a whole number, a number, a word, or a tuple of numbers that stand in parentheses."""
    text = text.strip()
    inner = bare(text)
    parts = (pieces(inner, ",") or []) if inner != text else []
    if len(parts) > 1:
        values = tuple(parse_value(part) for part in parts)
        return inner if any(isinstance(value, (bool, str)) for value in values) else values
    lowered = inner.lower()
    if lowered in ("true", "false"):
        return lowered == "true"
    for kind in (int, float):
        try:
            return kind(lowered)
        except ValueError:  # of whole numbers with thousands of digits, too
            continue
    return inner


def parse_spec(text: str, what: str) -> tuple[str, dict[str, Parsed]]:
    """Name and parameters of `name:key=value,key=value`.

    Raises
    ------
    ArgumentError
        For text that cannot be encoded, an empty name, a parameter without a value, or one that is given twice.
    """
    try:
        text.encode()
    except UnicodeEncodeError:
        raise ArgumentError(f"{what} {shown(text)}: expected text that UTF-8 encodes; replace those letters") from None
    name, colon, rest = text.strip().partition(":")
    values: dict[str, Parsed] = {}
    parts = pieces(rest, ",") if colon else []
    if parts is None:
        raise ArgumentError(
            f"{what} {shown(text)}: a parenthesis has no partner; expected {what}:name=value,name=(value,value)"
        )
    for part in parts:
        key, equals, value = (piece.strip() for piece in part.partition("="))
        if not (key and equals and value):
            raise ArgumentError(
                f"{what} {shown(text)}: expected {what}:name=value,name=value, got {shown(part)} after the colon"
            )
        if key in values:
            raise ArgumentError(f"{what} {shown(text)}: {key} is given twice; give it once")
        values[key.replace("-", "_")] = parse_value(value)
    if not name.strip():
        raise ArgumentError(f"{what} {shown(text)}: the name is missing; expected {what}:name=value,name=value")
    return name.strip(), values


def format_value(value: object) -> str:
    """The text that `parse_value` reads back as this value, to the last digit; a tuple of one number as the number."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (tuple, list)):
        return f"({','.join(map(format_value, value))})"
    if isinstance(value, str) and (len(pieces(value, ",") or ()) > 1 or bare(value) != value):
        return f"({value})"
    return repr(value) if isinstance(value, float) else str(value)


def format_spec(name: str, settings: Mapping[str, object]) -> str:
    """The text that `parse_spec` reads back."""
    parts = ",".join(f"{key}={format_value(value)}" for key, value in settings.items())
    return f"{name}:{parts}" if parts else name


def parse_vector(text: str, name: str) -> tuple[float, float, float]:
    """Three finite numbers, separated by commas or spaces.

    Raises
    ------
    ArgumentError
        For anything else.
    """
    x, y, z = _finite_numbers(text, name, 3, "three", "1,2.5,-3")
    return x, y, z


def parse_pair(text: str, name: str) -> tuple[float, float]:
    """Two finite numbers, separated by a comma or spaces.

    Raises
    ------
    ArgumentError
        For anything else.
    """
    x, y = _finite_numbers(text, name, 2, "two", "0,0.5")
    return x, y


def parse_pixel(text: str) -> tuple[int, int]:
    """Column and row of `412,233`.

    Raises
    ------
    ArgumentError
        For anything but two whole numbers of 0 or more.
    """
    parts = text.replace(",", " ").split()
    if len(parts) == 2 and all(part.isascii() and part.isdigit() and len(part) < MOST_PIXEL_DIGITS for part in parts):
        return int(parts[0]), int(parts[1])
    raise ArgumentError(f"pixel: expected column and row such as 412,233, counted from 0, got {shown(text)}")


def _finite_numbers(text: str, name: str, count: int, word: str, example: str) -> list[float]:
    try:
        numbers = [float(part) for part in text.replace(",", " ").split()]
    except ValueError:
        numbers = []
    if len(numbers) != count:
        raise ArgumentError(f"{name}: expected {word} numbers such as {example}, got {shown(text)}")
    if not all(map(math.isfinite, numbers)):
        raise ArgumentError(f"{name}: expected {word} finite numbers, got {shown(text)}")
    return numbers


def parse_size(text: str) -> tuple[int, int]:
    """Width and height in pixels of `1280x720`.

    Raises
    ------
    ArgumentError
        For anything but two whole numbers from 1 to `LONGEST_PICTURE`.
    """
    parts = text.lower().replace("×", "x").replace(",", "x").split("x")
    if len(parts) == 2 and all(part.strip().isascii() and part.strip().isdigit() for part in parts):
        width, height = (int(part) for part in parts)
        if min(width, height) > 0 and max(width, height) <= LONGEST_PICTURE:
            return width, height
    raise ArgumentError(
        f"size: expected width x height in pixels, such as 1280x720, 1 to {LONGEST_PICTURE} each, got {shown(text)}"
    )


def parse_resolutions(text: str) -> list[int]:
    """Texels along each side of `1024` or `512,1024,2048`.

    Raises
    ------
    ArgumentError
        For anything but whole numbers above 0.
    """
    parts = [part.strip() for part in text.split(",")]
    if all(part.isascii() and part.isdigit() and int(part) > 0 for part in parts):
        return [int(part) for part in parts]
    raise ArgumentError(
        f"resolution: expected whole numbers of texels above 0, such as 1024 or 512,1024, got {shown(text)}"
    )


def settings_text(settings: Mapping[str, object]) -> str:
    """Settings on one line."""
    return ", ".join(f"{key}={format_value(value)}" for key, value in settings.items())
