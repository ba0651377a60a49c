"""The command line."""

from .main import joined_negative_values, main, parser
from .view import load_view

__all__ = ["joined_negative_values", "load_view", "main", "parser"]
