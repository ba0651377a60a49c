"""Numbers and lists as people read them, and values as JSON knows them."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Sequence
from typing import Any

import numpy as np

# Letters of a value that a message shows.
LONGEST_SHOWN = 80


# Writes out no more of a value than may be shown, however much there is of it and however deep it is nested.
_BRIEF = reprlib.Repr()
_BRIEF.maxlevel = 6
_BRIEF.maxlist = _BRIEF.maxtuple = _BRIEF.maxdict = _BRIEF.maxset = _BRIEF.maxfrozenset = _BRIEF.maxdeque = 40
_BRIEF.maxstring = _BRIEF.maxother = _BRIEF.maxlong = 4 * LONGEST_SHOWN


def shown(value: object) -> str:
    """A value for messages: on one line, and no longer than one can read; its type where it cannot be written out."""
    try:
        # Its own representation would write out all of a long text first, or of a number with thousands of digits.
        text = _BRIEF.repr(value[: 4 * LONGEST_SHOWN] if type(value) in (str, bytes) else value)  # type: ignore[index]
    except Exception:  # noqa: BLE001 - what callers give may raise whatever it likes
        text = f"<{type(value).__name__}>"
    return one_line(text, LONGEST_SHOWN)


def reason_of(error: BaseException) -> str:
    """The message of somebody else's error, on one line and short enough to read; its type where it has none."""
    try:
        text = str(error)
    except Exception:  # noqa: BLE001 - as in `shown`
        text = ""
    return one_line(text, 2 * LONGEST_SHOWN) or type(error).__name__


def one_line(text: str, most: int) -> str:
    """The text on one line of at most so many letters, each of which can be written to a file."""
    line = " ".join(text[: 8 * most].split()).encode("utf-8", "backslashreplace").decode("utf-8").replace("\0", "\\0")
    return line if len(line) <= most else f"{line[:most]}..."


def is_missing(value: object) -> bool:
    """Whether a cell of a table holds nothing: None, NaN, or the NA of pandas, which is not loaded for it."""
    try:
        return value is None or bool(value != value)
    except TypeError:  # NA is neither true nor false, compared with itself
        return True


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


def counted(count: int, name: str, plural: str = "") -> str:
    """A number of things, with their name as English has it for one and for several."""
    return f"{count:,} {name if count == 1 else plural or f'{name}s'}"


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
