"""The fields of a `Convention` and the matrices it takes, checked: each error says what came and what to do."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import cast

import numpy as np

from ..errors import ArgumentError
from ..text.arrays import checked_array, checked_items, checked_number
from ..text.words import shown

Tile = tuple[float, float, float, float]
#: One tile for all maps, or one for each.
Tiles = Tile | tuple[Tile, ...]

AXES = ("x", "y", "z")
LEFT_HANDED_AXES = ("x", "y", "-z")


def check_word(name: str, value: object, words: Sequence[str]) -> None:
    """Raises unless the value is one of the words."""
    if not isinstance(value, str) or value not in words:
        raise ArgumentError(f"{name}: expected {' or '.join(map(repr, words))}, got {shown(value)}; try {words[0]!r}")


def finite_tuple(name: str, value: object, count: int, example: str) -> tuple[float, ...]:
    """So many finite numbers."""
    expected = f"{count} finite numbers"
    items = checked_items(name, value, expected, f"try {example}")
    found = tuple(checked_number(name, item, f"try {example}", expected) for item in items[: count + 1])
    if len(found) != count or not np.all(np.isfinite(found)):
        raise ArgumentError(f"{name}: expected {expected}, got {shown(value)}; try {example}")
    return found


def range_of(name: str, value: object) -> tuple[float, float]:
    """Two numbers, the lower first."""
    low, high = finite_tuple(name, value, 2, "(-1, 1)")
    if not low < high:
        fix = "reversed_z=True" if name == "z_range" else "x='left' or y='down'"
        raise ArgumentError(f"{name}: expected the lower number first, got {shown(value)}; {fix} turns the direction")
    return low, high


def axes_of(value: object) -> tuple[str, str, str]:
    """Three of our axes with their signs, each axis once."""
    fix = "a right-handed world with z up is ('x', '-z', 'y')"
    expected = "our x, y and z once each, with signs"
    parts = value.strip("() ").split(",") if isinstance(value, str) else checked_items("axes", value, expected, fix)
    found = tuple(str(part).strip().lower().removeprefix("+") for part in parts[:4] if isinstance(part, str))
    if len(found) != 3 or sorted(name.removeprefix("-") for name in found) != list(AXES):
        raise ArgumentError(f"axes: expected {expected}, got {shown(value)}; {fix}")
    return found


def tiles_of(value: object) -> Tiles:
    """One tile, or several, each with a positive size and a place inside the atlas."""
    example = "(0, 0.5, 0.5, 0.5)"
    items = checked_items("tile", value, "(u, v, width, height), or several", f"try {example}")
    several = bool(items) and (
        isinstance(items[0], (tuple, list)) or (isinstance(items[0], np.ndarray) and items[0].ndim)
    )
    made = [finite_tuple("tile", tile, 4, example) for tile in (items if several else [items])]
    # Thirds and the like do not add up exactly.
    most = 1.0 + 4.0 * np.finfo(np.float64).eps
    for tile in made:
        u, v, width, height = tile
        if not (width > 0 and height > 0 and u >= 0 and v >= 0 and u + width <= most and v + height <= most):
            raise ArgumentError(
                "tile: expected (u, v, width, height) inside the atlas, which spans 0 to 1, "
                f"got {tile!r}; try {example}"
            )
    return cast("Tiles", tuple(made) if several else made[0])


def matrices_of(name: str, value: object) -> np.ndarray:
    """A (4, 4) or (K, 4, 4) array of finite float64, K at least 1."""
    found: np.ndarray = checked_array(name, value)
    if found.ndim not in (2, 3) or found.shape[-2:] != (4, 4) or not found.size:
        raise ArgumentError(
            f"{name}: expected an array of shape (4, 4) or (K, 4, 4), got shape {found.shape}; reshape it"
        )
    if not np.isfinite(found).all():
        raise ArgumentError(f"{name}: expected finite numbers, got NaN or infinity; check where it comes from")
    return found


def all_axes() -> list[tuple[str, str, str]]:
    """All 48 sets of axes, ours first."""
    signs = list(itertools.product(("", "-"), repeat=3))
    made = [
        tuple(s + a for s, a in zip(sign, order, strict=True))
        for order in itertools.permutations(AXES)
        for sign in signs
    ]
    return cast("list[tuple[str, str, str]]", made)
