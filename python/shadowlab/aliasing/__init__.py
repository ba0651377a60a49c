"""Errors as numbers: where a shadow mask and the truth disagree."""

from .._core import Misclassified, misclassified

__all__ = ["Misclassified", "misclassified"]
