"""Errors as numbers: the size of texels in the image, where mask and truth disagree, what closed forms say."""

from .._core import Misclassified, misclassified
from . import closed_form
from .footprints import Footprint, footprint, footprint_at, halfway_normals
from .paths import Temporal, temporal
from .summary import Summary
from .texels import Usage, look_up, texel_coordinates, usage
from .wrong_pixels import Causes, causes

__all__ = [
    "Causes",
    "Footprint",
    "Misclassified",
    "Summary",
    "Temporal",
    "Usage",
    "causes",
    "closed_form",
    "footprint",
    "footprint_at",
    "halfway_normals",
    "look_up",
    "misclassified",
    "temporal",
    "texel_coordinates",
    "usage",
]
