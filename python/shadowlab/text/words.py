"""Numbers and lists as people read them, and values as JSON knows them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

# Letters of a value that a message shows.
LONGEST_SHOWN = 80


def shown(value: object) -> str:
    """A value for messages: on one line, and no longer than one can read."""
    text = " ".join(repr(value).split())
    return text if len(text) <= LONGEST_SHOWN else f"{text[:LONGEST_SHOWN]}..."


def share_text(share: float) -> str:
    """A share in per cent with three significant digits, never rounded to nothing."""
    value = 100.0 * share
    return "0 %" if value == 0 else f"{value:#.3g} %" if value < 99.95 else "100 %"


def digits(value: float) -> str:
    """A number with three digits, or whole from a thousand on."""
    return f"{value:,.0f}" if abs(value) >= 999.5 else f"{value:.3g}"


def px_text(value: float) -> str:
    """A length in the picture."""
    return f"{digits(value)} px"


def listed(names: Sequence[str]) -> str:
    """Names as English lists them."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def plain(value: object) -> Any:
    """The value as JSON knows it: arrays become lists, NaN and missing become null, infinity the word "inf"."""
    if isinstance(value, dict):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        number = float(value)
        return None if math.isnan(number) else number if math.isfinite(number) else "inf" if number > 0 else "-inf"
    return value if value is None or isinstance(value, str) else str(value)
