"""What a study's table says of causes and of texels: why the best run is wrong, and what map would be fine enough."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from ..experiments.counts import WrongPixels, maps_of
from ..experiments.thresholds import FEW_FOR_SHARES, NOTABLE_CAUSE
from ..text import digits, is_missing, px_text, share_text
from .words import place

REMARKS = {
    "acne": "are acne, surfaces that shadow themselves: more bias takes them away, and brings leaks",
    "leak": "are leaks, dark without the bias: less bias takes them away, and brings acne",
    "missing": "have casters that the map does not hold: thinner than a texel, or cut off by its depths",
    "other": "are none of a shadow map's kinds: the map holds what the light does not meet. Is it made for this light?",
}


def error_sentences(best: Mapping[str, Any]) -> list[str]:
    """Sentences on the run with the fewest wrong pixels; none where its table has no such columns."""
    return [*_cause_sentences(best), *_texels(best)]


def _cause_sentences(row: Mapping[str, Any]) -> list[str]:
    """The cause other than edges that many of the wrong pixels have."""
    wrong = row.get("misclassified")
    if wrong is None or is_missing(wrong) or int(wrong) < FEW_FOR_SHARES:
        return []
    shares = {name: int(row[name]) / int(wrong) for name in REMARKS if not is_missing(row.get(name))}
    much = [name for name in shares if shares[name] >= NOTABLE_CAUSE]
    return [f"Of the wrong pixels of {place(row)}, {share_text(shares[name])} {REMARKS[name]}." for name in much]


def _texels(row: Mapping[str, Any]) -> list[str]:
    """How long its texels are in the picture, and the map whose texels are no longer than a pixel."""
    length = row.get("texel_p95")
    if length is None or is_missing(length):
        return []
    told = f"A texel of {place(row)} is up to {px_text(length)} long in 95 % of the picture"
    if length <= 1:
        return [f"{told}: fine enough."]
    needed = math.ceil(int(row["resolution"]) * float(length))
    a_map = " a map" if maps_of(row) > 1 else ""
    return [f"{told}; one pixel would take {digits(needed)}² texels{a_map}."]


def best_row(rows: Sequence[Mapping[str, Any]]) -> Mapping[str, Any]:
    """The row with the fewest wrong pixels."""
    return min(rows, key=lambda row: WrongPixels.of(row).count)
