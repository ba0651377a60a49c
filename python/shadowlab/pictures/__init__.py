"""Pictures as numpy arrays, without matplotlib: `plot` puts them on axes and `reports` into pages.

All are (H, W, 3) uint8.
"""

from .eye import FALSE_LIGHT_RGB, FALSE_SHADOW_RGB, densest_window, difference, shade, truth_mask
from .frustum import FRUSTUM_RGB, frustum_edges, frustum_segments, with_frustum
from .maps import reduced, relief
from .png import png

__all__ = [
    "FALSE_LIGHT_RGB",
    "FALSE_SHADOW_RGB",
    "FRUSTUM_RGB",
    "densest_window",
    "difference",
    "frustum_edges",
    "frustum_segments",
    "png",
    "reduced",
    "relief",
    "shade",
    "truth_mask",
    "with_frustum",
]
