"""Plots. Every function takes matplotlib axes, or makes them, and returns them."""

from __future__ import annotations

from .. import pictures
from ..pictures import difference, shade, truth_mask
from .axes import MARKERS, SERIES
from .study import chosen_view, difference_view, error_curve, eye_view, frustum, shadow_map, study_figure

__all__ = [
    "MARKERS",
    "SERIES",
    "chosen_view",
    "difference",
    "difference_view",
    "error_curve",
    "eye_view",
    "frustum",
    "pictures",
    "shade",
    "shadow_map",
    "study_figure",
    "truth_mask",
]
