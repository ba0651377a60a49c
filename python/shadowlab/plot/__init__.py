"""Plots. Every function takes matplotlib axes, or makes them, and returns them.

- Of a run and a study: `eye_view`, `difference_view`, `chosen_view`, `shadow_map`, `frustum`, `error_curve`,
  `study_figure`.
- Of one pixel: `pixel_figure`. Of prefiltered maps: `prefiltered_figure`.
- Of the error of pixels: `error_map`, `error_histogram`, `error_by_depth`, `causes`, `cause_map`.
- Of tables, those of sweeps among them: `lines`, `heatmap`, `pareto`.
- Of techniques: `error_along_view`, `error_over_angle`, `drift`, `flips`, `bias_curve`.
- Of a map's texels: `warped_view`, `light_view`, `lattice`. Of its casters: `culled`.
- Of scene-optimized maps: `samples_view`, `search_history`, `samples_and_maps`, `percent_more`.
"""

from __future__ import annotations

from .. import pictures
from ..pictures.causes import cause_picture
from ..pictures.errors import error_picture
from ..pictures.eye import difference, shade, truth_mask
from ..pictures.lattice import lattice_picture
from .axes import MARKERS, SERIES
from .bias import bias_curve
from .causes import cause_map, causes
from .culled import culled
from .curves import error_along_view, error_over_angle
from .distributions import error_by_depth, error_histogram
from .eye_views import error_map, lattice
from .light_views import light_view, warped_view
from .pixel import pixel_figure
from .prefiltered import prefiltered_figure
from .scene_optimal import percent_more, samples_and_maps, samples_view, search_history
from .study import chosen_view, difference_view, error_curve, eye_view, frustum, shadow_map, study_figure
from .table_heatmap import heatmap
from .table_lines import lines
from .table_pareto import pareto
from .temporal import drift, flips

__all__ = [
    "MARKERS",
    "SERIES",
    "bias_curve",
    "cause_map",
    "cause_picture",
    "causes",
    "chosen_view",
    "culled",
    "difference",
    "difference_view",
    "drift",
    "error_along_view",
    "error_by_depth",
    "error_curve",
    "error_histogram",
    "error_map",
    "error_over_angle",
    "error_picture",
    "eye_view",
    "flips",
    "frustum",
    "heatmap",
    "lattice",
    "lattice_picture",
    "light_view",
    "lines",
    "pareto",
    "percent_more",
    "pictures",
    "pixel_figure",
    "prefiltered_figure",
    "samples_and_maps",
    "samples_view",
    "search_history",
    "shade",
    "shadow_map",
    "study_figure",
    "truth_mask",
    "warped_view",
]
