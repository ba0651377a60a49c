"""Budgets of depth texels: how they are written, and the largest maps that they hold."""

from __future__ import annotations

import math
import re

import numpy as np

from ..errors import ArgumentError, UnknownNameError
from ..text import shown
from ..text.arrays import checked_items, checked_number

# A depth texel of 32 bits, as every renderer here has.
BYTES_PER_TEXEL = 4
# A budget of which more than this share is left unused is told: sides are whole texels, and a map of 256 texels on a
# side leaves at most 0.8 % unused, one of 1024 0.2 %.
UNUSED_FROM = 0.01
# The smallest and the largest side: fewer texels are no map, and the renderers draw no larger one.
LEAST_TEXELS, MOST_TEXELS = 8, 16384
# The budget where nobody says: one map of 1024 x 1024 texels, the default resolution of everything else here.
DEFAULT_MEMORY = "4 MiB"
LEAST_BYTES = BYTES_PER_TEXEL * LEAST_TEXELS**2

# More than any device has.
MOST_BYTES = 1 << 50

UNITS = {
    "B": 1, "kB": 10**3, "MB": 10**6, "GB": 10**9, "KiB": 2**10, "MiB": 2**20, "GiB": 2**30,
}  # fmt: skip
_UNIT_OF = {**{name.lower(): size for name, size in UNITS.items()}, "bytes": 1, "byte": 1}
_TEXT = re.compile(r"(\d+(?:\.\d*)?|\.\d+)\s*([A-Za-z]*)")


def bytes_of(value: object) -> int:
    """The bytes of one budget: a number of them, or text such as "4 MiB" (2^20 each) or "16MB" (10^6 each).

    Raises
    ------
    ArgumentError
        For anything else, and for less than one map of 8 x 8 texels.
    UnknownNameError
        For a unit that does not exist.
    """
    if isinstance(value, str):
        found = _TEXT.fullmatch(value.strip())
        if found is None:
            raise ArgumentError(f'memory: expected bytes such as 4194304 or "4 MiB", got {shown(value)}')
        number, unit = found.groups()
        if unit and unit.lower() not in _UNIT_OF:
            raise UnknownNameError(
                f"memory: unknown unit {unit!r} in {shown(value)}; expected one of {', '.join(UNITS)}"
            )
        exact = float(number) * (_UNIT_OF[unit.lower()] if unit else 1)
    elif isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise ArgumentError(f'memory: expected bytes such as 4194304 or "4 MiB", got {shown(value)}')
    else:
        exact = checked_number("memory", value, 'try "4 MiB"', "bytes")
    if exact > MOST_BYTES:
        raise ArgumentError(f'memory: expected at most {memory_text(MOST_BYTES)}, got {shown(value)}; try "4 MiB"')
    if not math.isfinite(exact) or exact < LEAST_BYTES:
        raise ArgumentError(
            f"memory: expected at least {LEAST_BYTES} bytes, one map of {LEAST_TEXELS} x {LEAST_TEXELS} texels of "
            f'{BYTES_PER_TEXEL} bytes, got {shown(value)}; try "4 MiB"'
        )
    return int(exact)


def budgets_of(value: object) -> list[int]:
    """The budgets of an advice in bytes, rising, none twice.

    Raises
    ------
    ArgumentError, UnknownNameError
        As `bytes_of`, and for none or the same one twice.
    """
    single = isinstance(value, (str, int, float, np.generic))
    given = [value] if single else checked_items("memory", value, "bytes, or several", 'try "4 MiB"')
    found = sorted(bytes_of(one) for one in given)
    if not found:
        raise ArgumentError('memory: expected at least one budget, got none; try "4 MiB"')
    for one in found:
        if found.count(one) > 1:
            raise ArgumentError(f"memory: {memory_text(one)} comes twice; give each once")
    return found


def memory_text(size: int) -> str:
    """A number of bytes as people write it, exactly: 4 MiB, 16 MB, 1,234 bytes; `bytes_of` reads the first two back."""
    for name in ("GiB", "MiB", "KiB", "GB", "MB", "kB"):
        # In halves and quarters of a unit as well, 1.5 MiB; :g has six digits.
        if UNITS[name] <= size < 10_000 * UNITS[name] and (4 * size) % UNITS[name] == 0:
            return f"{size / UNITS[name]:g} {name}"
    return f"{size:,} bytes"


def side_of(memory: int, maps: int) -> int:
    """The largest side in texels of so many square maps that fit into the memory together; 0 where none fits."""
    side = math.isqrt(memory // (BYTES_PER_TEXEL * maps))
    return min(side, MOST_TEXELS) if side >= LEAST_TEXELS else 0


def taken(maps: int, side: int) -> int:
    """The bytes that maps take."""
    return BYTES_PER_TEXEL * maps * side * side


def unused(memory: int, maps: int, side: int) -> float:
    """The share of the memory that maps do not take, from 0 to 1."""
    return 1.0 - taken(maps, side) / memory


def too_small(memory: int, maps: int) -> str:
    """Why so many maps are not drawn in this memory."""
    return (
        f"memory: {maps} map{'' if maps == 1 else 's'} of {LEAST_TEXELS} x {LEAST_TEXELS} texels, the smallest drawn, "
        f"take {taken(maps, LEAST_TEXELS):,} bytes, more than the {memory:,} there are"
    )
