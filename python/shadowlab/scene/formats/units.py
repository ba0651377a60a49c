"""Units of length in metres."""

from __future__ import annotations

import sys

from ...errors import ArgumentError
from ...text import shown

#: Metres per unit, by the names of 3MF and the usual short ones.
METRES = {
    "micron": 1e-6, "millimeter": 1e-3, "centimeter": 1e-2, "meter": 1.0, "inch": 0.0254, "foot": 0.3048,
    "um": 1e-6, "mm": 1e-3, "cm": 1e-2, "m": 1.0, "km": 1e3, "in": 0.0254, "ft": 0.3048,
}  # fmt: skip


def metres_per_unit(unit: object) -> float | None:
    """What `unit` of `load_scene` says, in metres; None for what the file says.

    Raises
    ------
    ArgumentError
        For another word, and for a number that is not finite and above 0.
    """
    if unit is None:
        return None
    if isinstance(unit, str) and unit in METRES:
        return METRES[unit]
    if isinstance(unit, (int, float)) and not isinstance(unit, bool) and 0 < unit <= sys.float_info.max:
        return float(unit)
    listed = ", ".join(repr(name) for name in METRES)
    raise ArgumentError(
        f"unit: expected metres per unit above 0, or one of {listed}, got {shown(unit)}; unit=1 scales nothing"
    )
