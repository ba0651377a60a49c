"""What `prefiltered_maps` was given, checked before any work, and the maps that a budget holds."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from .. import _core
from ..aliasing.prefiltered_formats import DEPTH_BYTES, DEPTH_FORMATS, PREFILTERED_FORMATS
from ..errors import ArgumentError
from ..text.arrays import checked_items
from ..text.checked import a_number, a_word
from ..text.checks import whole
from .evaluate import fitted
from .memory import DEFAULT_MEMORY, LEAST_TEXELS, bytes_of, memory_text

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..scene.view import View
    from ..types import Item, RendererLike

ALL_FORMATS: tuple[str, ...] = (*DEPTH_FORMATS, *PREFILTERED_FORMATS)
# The study holds a map as drawn, as distances in double precision, as stored and as filtered: some 3 GiB at the most.
MOST_MEMORY, MOST_SIDE = 1 << 28, 8192
# A wider box has more comparisons than any renderer makes.
WIDEST_KERNEL = 31
# The side at which maps are counted, before a budget gives the side.
COUNTED_AT = 1024


def checked_formats(value: object) -> tuple[str, ...]:
    """The formats in order; all of them for None.

    Raises
    ------
    ArgumentError
        For none, one that is given twice, or something that is no text.
    UnknownNameError
        For a format that does not exist.
    """
    if value is None:
        return ALL_FORMATS
    fix = 'try ("depth:pcf", "variance:f32")'
    single = isinstance(value, str)
    given = [value] if single else checked_items("formats", value, "a format, or several", fix)
    check = a_word(ALL_FORMATS, fix)
    found: tuple[str, ...] = tuple(check("formats", one) for one in given)
    if not found:
        raise ArgumentError(f"formats: expected at least one format, got none; {fix}")
    for one in found:
        if found.count(one) > 1:
            raise ArgumentError(f"formats: {one!r} is given more than once; give each once")
    return found


def checked_kernel(value: object) -> int:
    """The side of the box in texels.

    Raises
    ------
    ArgumentError
        For anything but an odd whole number from 1 to 31.
    """
    side = whole("kernel", value)
    if side % 2 == 0 or side > WIDEST_KERNEL:
        raise ArgumentError(f"kernel: expected an odd number of texels from 1 to {WIDEST_KERNEL}, got {side}; try 5")
    return side


def checked_reduction(value: object) -> float:
    """The share of the light that is cut off.

    Raises
    ------
    ArgumentError
        For anything but a number from 0 to below 1.
    """
    share = a_number("reduction", value)
    if not 0.0 <= share < 1.0:
        raise ArgumentError(f"reduction: expected a share of the light from 0 to below 1, got {share:g}; try 0.2")
    return share


def budget_of(memory: object, resolution: object) -> tuple[int | None, int | None]:
    """Bytes for the maps together, or the side of each; one of both is None.

    Raises
    ------
    ArgumentError
        For both, or one out of range.
    UnknownNameError
        For a unit of memory that does not exist.
    """
    if resolution is None:
        size = bytes_of(DEFAULT_MEMORY if memory is None else memory)
        if size > MOST_MEMORY:
            raise ArgumentError(
                f'memory: expected at most {memory_text(MOST_MEMORY)}, got {memory_text(size)}; try "4 MiB"'
            )
        return size, None
    if memory is not None:
        raise ArgumentError("memory, resolution: expected one of both, got both; leave one out")
    side = whole("resolution", resolution)
    if side > MOST_SIDE:
        raise ArgumentError(f"resolution: expected at most {MOST_SIDE} texels, got {side}; try 1024")
    return None, side


def texel_bytes(format: str) -> int:
    """Bytes of a texel in a format."""
    return DEPTH_BYTES if format in DEPTH_FORMATS else PREFILTERED_FORMATS[format].bytes


def largest_maps(
    item: Item, view: View, renderer: RendererLike, memory: int, of_texel: int
) -> tuple[int, _core.Parameterization]:
    """The largest side of square maps that fit into the memory together, and the maps fitted to it.

    Raises
    ------
    ArgumentError
        Where maps of 8 x 8 texels do not fit.
    """
    maps = fitted(item, view, COUNTED_AT, renderer)
    while True:
        count = len(maps.partitions)
        side = min(math.isqrt(memory // (of_texel * max(1, count))), MOST_SIDE)
        if side < LEAST_TEXELS:
            raise ArgumentError(
                f"memory: {count} maps of {LEAST_TEXELS} x {LEAST_TEXELS} texels of {of_texel} bytes, the smallest "
                f'drawn, take {of_texel * count * LEAST_TEXELS**2:,} bytes, got {memory:,}; try "4 MiB"'
            )
        maps = fitted(item, view, side, renderer)
        # The border is in texels, so that a face may need a map at one side and none at another.
        if len(maps.partitions) <= count:
            return side, maps


def grouped(formats: Sequence[str]) -> dict[int, list[str]]:
    """The formats by the bytes of their texels: those of one group look up the same maps."""
    groups: dict[int, list[str]] = {}
    for one in formats:
        groups.setdefault(texel_bytes(one), []).append(one)
    return groups
