"""How far the count of wrong pixels depends on where a map's lattice of texels happens to lie.

A map that is shifted by parts of a texel is as good as before, but its edges fall elsewhere and its count of wrong
pixels changes. The counts over several shifts give the mean, by which maps are compared, and its standard deviation.

The first shift is none, so that the map as fitted is one of them. The others are multiples of two irrational steps
modulo one texel, which fill the square of all shifts evenly however many there are [roberts2018]. They reach at most
half a texel: the fit leaves a border of one texel around the receivers, so none leaves the map.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .. import _core
from ..errors import ArgumentError
from ..text import shown
from ..types import PostWarp

# Shifts by which a count is averaged. Chosen because three standard errors of a difference of two means over eight are
# then one standard deviation of a difference of two counts (3 / sqrt(8) = 1.06).
PHASES = 8
# More tell nothing that these do not.
MOST_PHASES = 4096
# The root of x^3 = x + 1; the steps are its first two negative powers.
PLASTIC = 1.3247179572447460
SHIFT_STEPS = (1.0 / PLASTIC, 1.0 / PLASTIC**2)


@dataclass(frozen=True)
class Scatter:
    """Counts of wrong pixels over shifts of the texels.

    Attributes
    ----------
    counts : tuple of int
        One per shift, pixels; the first is that of the map as fitted.
    """

    counts: tuple[int, ...]

    @property
    def mean(self) -> float:
        """Mean of the counts, pixels."""
        return statistics.fmean(self.counts)

    @property
    def sd(self) -> float:
        """Standard deviation of a single count, pixels; 0 of one count alone."""
        return statistics.stdev(self.counts) if len(self.counts) > 1 else 0.0

    @property
    def columns(self) -> dict[str, float]:
        """The same by the names of columns."""
        return {"phases": len(self.counts), "misclassified_mean": self.mean, "misclassified_sd": self.sd}


def checked_phases(value: object, least: int = 1) -> int:
    """The number of shifts of the texels.

    Raises
    ------
    ArgumentError
        For anything but a whole number, and for less than `least`.
    """
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)) or value < least:
        raise ArgumentError(
            f"phases: expected a whole number of shifts from {least} on, got {shown(value)}; {PHASES} give a "
            "mean and a standard deviation, 1 counts the map as fitted alone"
        )
    if value > MOST_PHASES:
        raise ArgumentError(f"phases: expected at most {MOST_PHASES} shifts, got {shown(value)}; {PHASES} are enough")
    return int(value)


def shifts(count: int) -> list[tuple[float, float]]:
    """Shifts along x and y in texels, each from -0.5 to 0.5; the first is none, and fewer are the first of more."""
    return [tuple((i * step + 0.5) % 1.0 - 0.5 for step in SHIFT_STEPS) for i in range(count)]  # type: ignore[misc]


def shifted(p: _core.Parameterization, dx: float, dy: float, resolution: int) -> _core.Parameterization:
    """The same maps with the scene shifted in them.

    Parameters
    ----------
    p : Parameterization
    dx, dy : float
        Shift in texels, x to the right and y up.
    resolution : int
        Texels along each side of the maps.

    Returns
    -------
    Parameterization
        As of `Parameterization.from_matrix`: it has the matrices, depth ranges, regions and post-warps, and no factors
        or notes.
    """
    x_ndc, y_ndc = 2.0 * dx / resolution, 2.0 * dy / resolution
    moved = np.array(p.matrices)
    after: list[PostWarp | None] = []
    for part, matrix in zip(p.partitions, moved, strict=True):
        terms, knots = part.post_warp_terms, part.post_warp_knots
        if knots is not None:
            # Shifted is what the functions return.
            x, y = (k + np.array([0.0, shift]) for k, shift in zip(knots, (x_ndc, y_ndc), strict=True))
            after.append(("rectilinear", x, y))
            continue
        matrix[0] += x_ndc * matrix[3]
        # A logarithm replaces y, so the shift is its offset's.
        after.append(("log", terms["scale"], terms["offset"] + y_ndc) if terms else None)
        if not terms:
            matrix[1] += y_ndc * matrix[3]
    return _core.Parameterization.from_matrix(
        moved, resolution=p.resolution, eye_depth=[part.eye_depth for part in p.partitions], selection=p.selection,
        post_warp=after, regions=[part.region for part in p.partitions],
    )  # fmt: skip


def scatter_of(count_at: Callable[[float, float], int], phases: int) -> Scatter:
    """The counts over so many shifts; `count_at` gives the wrong pixels at a shift in texels."""
    return Scatter(tuple(count_at(dx, dy) for dx, dy in shifts(phases)))
