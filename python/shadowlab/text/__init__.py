"""The ground of the package: texts that name things, numbers as people read them, and checks of arguments."""

from .specs import (
    BIAS,
    Parsed,
    bare,
    format_bias,
    format_spec,
    format_value,
    parse_bias,
    parse_pair,
    parse_resolutions,
    parse_size,
    parse_spec,
    parse_value,
    parse_vector,
    pieces,
    settings_text,
)
from .words import digits, listed, plain, px_text, share_text, shown

__all__ = [
    "BIAS",
    "Parsed",
    "bare",
    "digits",
    "format_bias",
    "format_spec",
    "format_value",
    "listed",
    "parse_bias",
    "parse_pair",
    "parse_resolutions",
    "parse_size",
    "parse_spec",
    "parse_value",
    "parse_vector",
    "pieces",
    "plain",
    "px_text",
    "settings_text",
    "share_text",
    "shown",
]
