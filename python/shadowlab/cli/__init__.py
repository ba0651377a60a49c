"""The command line."""

from .main import given_options, main
from .view import load_view

__all__ = ["given_options", "load_view", "main"]
