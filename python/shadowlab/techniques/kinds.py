"""What is a technique, and what is the result of one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from .. import _core
from ..text.checked import has_all

if TYPE_CHECKING:
    from typing_extensions import TypeIs

    from .._core import Parameterization


def is_parameterization(item: object) -> TypeIs[Parameterization]:
    """Whether it is the result of a technique rather than a technique."""
    return isinstance(item, _core.Parameterization)


def makes_maps(item: object) -> bool:
    """Whether it is a technique: one of ours, or what has its attributes."""
    if isinstance(item, (_core.Technique, type)):
        return not isinstance(item, type)
    known = has_all(item, "name", "settings", "parameterize")
    return known and isinstance(item.name, str) and isinstance(item.settings, Mapping)  # type: ignore[attr-defined]
