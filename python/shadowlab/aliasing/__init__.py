"""Errors as numbers: where a shadow mask and the truth disagree, and what closed forms say of maps."""

from .._core import Misclassified, misclassified
from . import closed_form

__all__ = ["Misclassified", "closed_form", "misclassified"]
