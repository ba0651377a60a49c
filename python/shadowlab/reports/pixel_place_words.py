"""Triangles, points and depths of an explained pixel as texts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..text import digits

if TYPE_CHECKING:
    from ..aliasing.pixel_surface import Met

# Digits of depths: a step of single precision is 6e-8.
DEPTH_DIGITS = 8


def met_text(met: Met) -> str:
    """A triangle on a ray, with where it is."""
    return f"{triangle_text(met.instance, met.triangle)} at {point_text(met.point)}, {digits(met.distance)} away"


def triangle_text(instance: int, triangle: int) -> str:
    """A triangle by its numbers."""
    return f"triangle {triangle} of instance {instance}"


def point_text(values: np.ndarray) -> str:
    """Numbers in parentheses, six digits each."""
    return f"({', '.join(f'{value:.6g}' for value in np.asarray(values).tolist())})"


def depth(value: float) -> str:
    """A stored or compared depth."""
    return f"{value:.{DEPTH_DIGITS}g}"


def depth_text(value: float) -> str:
    """A difference of depths."""
    return f"{value:.3g}"
