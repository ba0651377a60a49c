"""Thresholds of judgement: when two results are about equal, and when a view or a run says too little.

Rankings and verdicts ask these, so that a number and the sentence about it never disagree.
"""

from __future__ import annotations

import math

# The technique that the others are held against.
BASELINE = "uniform"
# Counts within this ratio are told as equal: less than one pixel in twenty is not what anybody chooses by.
ABOUT_EQUAL = 1.05
# Below this ratio a technique is called slightly better or worse: errors along silhouettes fall with the texel's side,
# so a map with a quarter more texels along each side does as much.
SLIGHT = 1.25
# Counts of wrong pixels scatter as counts do when a map's texels shift against the scene: below this many standard
# deviations of their difference, sqrt(a + b), two runs are told as equal.
NOISE_SIGMAS = 3.0
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


def hardly_wrong(count: float, share: float) -> bool:
    """Whether wrong pixels are almost none, in number and as a share."""
    return count < FEW_PIXELS and share < FEW_SHARE
