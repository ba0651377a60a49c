"""What can be measured of a run, and the columns that it fills."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Literal, get_args

from ..aliasing.causes import CAUSES
from ..errors import ArgumentError, UnknownNameError
from ..text import shown
from ..text.arrays import checked_items
from .columns import OF_NOISE, OF_WRONG

Metric = Literal["mask", "misclassified", "causes", "texels", "usage"]
#: What is measured where nobody says. "mask" draws and looks up without holding the result against the truth.
METRICS: tuple[Metric, ...] = tuple(name for name in get_args(Metric) if name != "mask")
KNOWN_METRICS: tuple[Metric, ...] = get_args(Metric)
# Those that need maps.
DRAWN = frozenset({"mask", "misclassified", "causes"})
# Those that need the traced truth.
HELD_AGAINST_TRUTH = frozenset({"misclassified", "causes"})
#: The columns that each metric fills; those of wrong pixels come with causes, too.
FILLED: Mapping[Metric, tuple[str, ...]] = MappingProxyType({
    "mask": ("map_ms", "lookup_ms"),
    "misclassified": (*OF_WRONG, *OF_NOISE),
    "causes": (*CAUSES.values(), "edge_px"),
    "texels": (
        "measured", "outside", "undersampled", "texel_mean", "texel_p50", "texel_p95", "texel_p99", "texel_max",
        "perspective_max", "storage_factor",
    ),
    "usage": ("unused",),
})  # fmt: skip
# The columns that metrics and times fill.
MEASURED = (
    *(name for metric in METRICS for name in FILLED[metric]),
    "outside_shadow", "samples_ms", "fit_us", *FILLED["mask"],
)  # fmt: skip


def checked_metrics(metrics: object) -> tuple[Metric, ...]:
    """The metrics, each once, in their order.

    Raises
    ------
    ArgumentError
        For something that is no list of names.
    UnknownNameError
        For a metric that does not exist.
    """
    listed = ", ".join(KNOWN_METRICS)
    given = checked_items("metrics", metrics, f"several of {listed}", "try ['misclassified']")
    for name in given:
        if not isinstance(name, str):
            raise ArgumentError(f"metrics: expected names, got {shown(name)}; try ['misclassified']")
        if name not in KNOWN_METRICS:
            raise UnknownNameError(f"metrics: unknown metric {shown(name)}; expected some of {listed}")
    return tuple(name for name in KNOWN_METRICS if name in given)
