"""Errors as numbers: the size of texels in the image, where mask and truth disagree, what closed forms say."""

from .._core import Misclassified, misclassified
from . import closed_form
from .footprints import Footprint, footprint, footprint_at, halfway_normals
from .summary import Summary

__all__ = [
    "Footprint",
    "Misclassified",
    "Summary",
    "closed_form",
    "footprint",
    "footprint_at",
    "halfway_normals",
    "misclassified",
]
