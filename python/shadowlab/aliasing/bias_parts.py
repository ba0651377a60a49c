"""The parts of a bias by themselves: which there are, one of them alone, and another value of one."""

from __future__ import annotations

from .. import _core
from ..text import BIAS

# What limits a part of a bias and moves nothing by itself.
BIAS_LIMITS = ("slope_limit",)
BIAS_PARTS = tuple(name for name in BIAS if name not in BIAS_LIMITS)
# The largest value of parts that have one.
MOST_OF_PART = {"plane": 1.0}


def only(bias: _core.Bias, part: str | None) -> _core.Bias:
    """One part of a bias with its limits, or no part."""
    values = {name: getattr(bias, name) if name in BIAS_LIMITS or name == part else 0.0 for name in BIAS}
    return _core.Bias(**values)


def with_part(bias: _core.Bias, part: str, value: float) -> _core.Bias:
    """The bias with another value of a part."""
    return _core.Bias(**{name: value if name == part else getattr(bias, name) for name in BIAS})
