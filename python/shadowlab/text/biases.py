"""Biases as texts: `slope=1,texels=0.5`, `none`, `default`."""

from __future__ import annotations

from .. import _core
from ..errors import ArgumentError, UnknownNameError
from .specs import format_value, parse_spec
from .words import shown

# The parts of a bias, in the order in which they are told.
BIAS = ("world", "texels", "ndc", "slope", "slope_limit", "plane", "normal", "factor", "units")
# Words for whole biases.
NO_BIAS, OWN_BIAS = "none", "default"


def parse_bias(text: str) -> dict[str, float]:
    """The values of `world=0.01,texels=0.1,slope=1`.

    Raises
    ------
    ArgumentError
        For nothing, a value that is no number, or one given twice.
    UnknownNameError
        For a name that a bias does not have.
    """
    _, values = parse_spec(f"bias:{text}", "bias")
    numbers: dict[str, float] = {}
    for name, value in values.items():
        if name not in BIAS:
            raise UnknownNameError(f"bias: unknown value {shown(name)}; expected some of {', '.join(BIAS)}")
        if isinstance(value, (bool, str, tuple)):
            raise ArgumentError(f"bias: expected a number for {name}, got {shown(value)}; try --bias world=0.01")
        numbers[name] = float(value)
    return numbers


def format_bias(bias: object) -> str:
    """The text that `parse_bias` reads back, every value spelled out."""
    return ",".join(f"{name}={format_value(float(getattr(bias, name)))}" for name in BIAS)


def bias_of(text: str) -> _core.Bias:
    """The bias of `slope=1,texels=0.5`, the other parts at their defaults; of `none` and `default`."""
    word = text.strip()
    if word == NO_BIAS:
        return _core.Bias.none()
    return _core.Bias() if word == OWN_BIAS else _core.Bias(**parse_bias(text))


def bias_text(bias: _core.Bias) -> str:
    """The text that `bias_of` reads back, with the parts that are not at their defaults."""
    if bias == _core.Bias.none():
        return NO_BIAS
    own = _core.Bias()
    texts = dict(part.split("=") for part in format_bias(bias).split(","))
    return ",".join(f"{name}={texts[name]}" for name in BIAS if getattr(bias, name) != getattr(own, name)) or OWN_BIAS
