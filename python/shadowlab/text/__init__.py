"""The ground of the package: texts that name things, numbers as people read them, and checks of arguments."""

from .biases import BIAS, bias_of, bias_text, format_bias, parse_bias
from .specs import (
    Parsed,
    bare,
    format_spec,
    format_value,
    parse_pair,
    parse_pixel,
    parse_resolutions,
    parse_size,
    parse_spec,
    parse_value,
    parse_vector,
    pieces,
    settings_text,
)
from .words import digits, is_missing, listed, one_line, plain, px_text, reason_of, share_text, shown

__all__ = [
    "BIAS",
    "Parsed",
    "bare",
    "bias_of",
    "bias_text",
    "digits",
    "format_bias",
    "format_spec",
    "format_value",
    "is_missing",
    "listed",
    "one_line",
    "parse_bias",
    "parse_pair",
    "parse_pixel",
    "parse_resolutions",
    "parse_size",
    "parse_spec",
    "parse_value",
    "parse_vector",
    "pieces",
    "plain",
    "px_text",
    "reason_of",
    "settings_text",
    "share_text",
    "shown",
]
