"""Parts that are made of other parts, as files describe them, placed one by one."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...errors import LoadError
from ..gathered import Gathered
from .given import Given
from .limits import check_limit

Matrix = NDArray[np.float64]


@dataclass(eq=False)
class Part:
    """Keys of meshes, and other parts with their places."""

    meshes: list[Hashable] = field(default_factory=list)
    parts: list[tuple[Hashable, Matrix]] = field(default_factory=list)


def place_parts(
    given: Given, found: Gathered, parts: dict[Hashable, Part], roots: Sequence[tuple[Hashable, Matrix]]
) -> None:
    """Places the meshes of parts, depth first; a part that is used often is placed as often.

    Raises
    ------
    LoadError
        For a part that contains itself, and for more placed meshes than the limit.
    """
    counts = _counts(given, parts, [key for key, _ in roots])
    total = sum(counts[key] for key, _ in roots)
    check_limit(given.limits, given.name, "instances", total, "placed meshes")
    stack = [root for root in reversed(roots) if counts[root[0]]]
    while stack:
        key, matrix = stack.pop()
        part = parts[key]
        for mesh in part.meshes:
            found.place(mesh, matrix)
        with np.errstate(all="ignore"):
            stack += [(other, matrix @ own) for other, own in reversed(part.parts) if counts[other]]


def _counts(given: Given, parts: dict[Hashable, Part], roots: Sequence[Hashable]) -> dict[Hashable, int]:
    """How many meshes each part places."""
    counts: dict[Hashable, int] = {}
    open_parts: set[Hashable] = set()
    stack = list(roots)
    while stack:
        key = stack[-1]
        if key in counts:
            stack.pop()
            continue
        others = [other for other, _ in parts[key].parts]
        missing = [other for other in others if other not in counts]
        if not missing:
            counts[key] = len(parts[key].meshes) + sum(counts[other] for other in others)
            open_parts.discard(key)
            stack.pop()
            continue
        if key in open_parts:
            raise LoadError(
                f"{given.name}: expected parts that do not contain themselves, got a circle; check the file"
            )
        open_parts.add(key)
        stack += missing
    return counts
