"""Thresholds of judgement: when two results are about equal, and when a view or a run says too little.

Rankings and verdicts ask these, so that a number and the sentence about it never disagree.
"""

from __future__ import annotations

import math

from ..trace import MUCH_UNDECIDED

# The technique that the others are held against.
BASELINE = "uniform"
# Counts within this ratio are told as equal: less than one pixel in twenty is not what anybody chooses by.
ABOUT_EQUAL = 1.05
# Below this ratio a technique is called slightly better or worse: errors along silhouettes fall with the texel's side,
# so a map with a quarter more texels along each side does as much.
SLIGHT = 1.25
# Two errors that differ by less than this many standard deviations of their difference are about equal. Of means over
# eight shifts of the texels that is one standard deviation of a difference of single counts (3 / sqrt(8) = 1.06).
NOISE_SIGMAS = 3.0
# Edges move by parts of a texel when a map's texels shift, all along the edge at once: the standard deviation of a
# count over shifts is 0.7 to 4 per cent of it, half of the time below 2; 5 to 11 in the coarsest maps of a forest and
# of long shadows. Measured over eight shifts in the six library scenes, with uniform, lispsm and z_partition at 256 and
# 1024 texels.
LATTICE_SCATTER = 0.02
# Counts within this ratio are close: their noise is measured before anything is said of their difference. Derived from
# the largest scatter of a count, 0.11 of it: three standard deviations of a difference are 3 * sqrt(2) * 0.11 = 0.47.
CLOSE = 1.5
# From this share on, visible pixels that are undecided or not compared are the first thing a verdict says: differences
# between techniques are of this size.
UNJUDGED = MUCH_UNDECIDED
# With fewer wrong pixels than both of these in every run, a view has nothing to tell the runs apart by.
FEW_PIXELS = 10
FEW_SHARE = 1e-4
# With fewer wrong pixels than this a share of them says little.
FEW_FOR_SHARES = 100
# A camera that sees less than this share of its pixels filled compares little of the picture.
LITTLE_SEEN = 0.05
# A cause of this share of the wrong pixels of a run is named.
NOTABLE_CAUSE = 0.3
# A cause of more than this share of the wrong pixels is what to look at first.
MAIN_CAUSE = 0.5


def about_equal(first: float, second: float, variance: float) -> bool:
    """Whether two errors are too close to choose by: in ratio, or within the noise of their counts.

    `variance` is that of their difference; of two counts their sum.
    """
    low, high = sorted((first, second))
    return high <= ABOUT_EQUAL * low or high - low < NOISE_SIGMAS * math.sqrt(variance)


def count_variance(count: float) -> float:
    """The variance of a count of wrong pixels whose noise was not measured: of a count, and of where texels lie."""
    return count + (LATTICE_SCATTER * count) ** 2


def close(first: float, second: float) -> bool:
    """Whether two counts of wrong pixels are so close that their noise has to be measured."""
    low, high = sorted((first, second))
    return high <= CLOSE * low or high - low < NOISE_SIGMAS * math.sqrt(low + high)


def hardly_wrong(count: float, share: float) -> bool:
    """Whether wrong pixels are almost none, in number and as a share."""
    return count < FEW_PIXELS and share < FEW_SHARE
