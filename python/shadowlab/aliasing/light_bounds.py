"""Light that arrives through a filtered shadow map, from averages of functions of the depths under the filter.

Sources: variance [donnelly2006], its reduction of light bleeding [lauritzen2008], exponential [annen2008], four moments
[peters2015], algorithm 3. The formulas are those of theory.md 19.

The depths z under the filter's kernel are a distribution, and a receiver at depth t gets the share P(z >= t) of the
light: percentage-closer filtering at one depth. What is stored averages without comparisons, and bounds that share from
above. So a bound never darkens what comparisons leave lit, and what it errs by is light that leaks.

Depths are linear along the light, 0 at the near end of the map's range and 1 at its far end.
"""

from __future__ import annotations

import numpy as np

from ..types import Vector

# The moments that a biased vector is moved towards: those of half the samples at 0 and half at 1, [peters2015] 3.2.
NEUTRAL_MOMENT = 0.5
# Below it a pivot of the moment matrix counts as 0: squares of depths in double precision resolve 2^-52.
LEAST_PIVOT = 2.0**-52


def chebyshev_light(mean: Vector, square: Vector, depth: Vector, least_variance: Vector, reduction: float) -> Vector:
    """The most light that depths of a mean and a mean square let through, (19.1); by Chebyshev's one-sided inequality.

    Parameters
    ----------
    mean, square : (N,) float64
        Averages of z and of z^2.
    depth : (N,) float64
        Of the receivers.
    least_variance : (N,) float64
        Smaller variances count as this one, so that rounding does not darken receivers.
    reduction : float
        Light below this share becomes 0, and the rest is stretched to 0 to 1; 0 keeps the bound. From 0 to below 1.

    Returns
    -------
    (N,) float64
        0 to 1.
    """
    variance = np.maximum(square - mean * mean, least_variance)
    behind = np.maximum(depth - mean, 0.0)
    whole = variance + behind * behind
    # Without variance the depths are one, and the test is exact.
    light = np.divide(variance, whole, out=np.where(behind > 0.0, 0.0, 1.0), where=whole > 0.0)
    return without_bleeding(light, reduction)


def without_bleeding(light: Vector, reduction: float) -> Vector:
    """The light with its lowest part cut off and the rest stretched to 0 to 1, (19.2)."""
    cut: Vector = np.clip((light - reduction) / (1.0 - reduction), 0.0, 1.0)
    return cut


def exponential_light(log_mean: Vector, depth: Vector, exponent: float) -> Vector:
    """The most light that depths let through whose mean exponential is known, (19.3); by Markov's inequality.

    Parameters
    ----------
    log_mean : (N,) float64
        Logarithm of the average of exp(c z).
    depth : (N,) float64
        Of the receivers.
    exponent : float
        c.

    Returns
    -------
    (N,) float64
        0 to 1.
    """
    light: Vector = np.exp(np.minimum(log_mean - exponent * depth, 0.0))
    return light


def moment_light(moments: Vector, depth: Vector, moment_bias: float) -> Vector:
    """The most light that depths of four moments let through, (19.4): Hamburger's moment problem.

    Among all distributions with these moments the one with a sample at the receiver has the least shadow. It has two
    more depths, the roots of a quadratic.

    Parameters
    ----------
    moments : (N, 4) float64
        Averages of z, z^2, z^3 and z^4.
    depth : (N,) float64
        Of the receivers.
    moment_bias : float
        Share by which the moments are moved to those of a distribution of 0 and 1, so that rounding leaves them
        moments of a distribution.

    Returns
    -------
    (N,) float64
        0 to 1, for any numbers that are finite.
    """
    b1, b2, b3, b4 = ((1.0 - moment_bias) * moments + moment_bias * NEUTRAL_MOMENT).T
    z1 = depth
    # B = L D L^T for the Hankel matrix B = ((1, b1, b2), (b1, b2, b3), (b2, b3, b4)), and B c = (1, z1, z1^2).
    d22 = np.maximum(b2 - b1 * b1, LEAST_PIVOT)
    l32_d22 = b3 - b1 * b2
    l32 = l32_d22 / d22
    d33 = np.maximum(b4 - b2 * b2 - l32_d22 * l32, LEAST_PIVOT)
    y2 = z1 - b1
    y3 = z1 * z1 - b2 - l32 * y2
    c3 = y3 / d33
    c2 = y2 / d22 - l32 * c3
    c1 = 1.0 - b1 * c2 - b2 * c3
    # z2 <= z3, the roots of c1 + c2 z + c3 z^2, without cancellation. A root at infinity has no weight.
    half = -0.5 * (c2 + np.copysign(np.sqrt(np.maximum(c2 * c2 - 4.0 * c1 * c3, 0.0)), c2))
    far = 1.0 / np.finfo(np.float64).eps
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        roots = np.stack(
            [np.where(half != 0.0, c1 / half, 0.0), np.where(c3 != 0.0, half / c3, np.copysign(far, half))]
        )
    z2, z3 = np.sort(np.clip(roots, -far, far), axis=0)

    def weight(a: Vector, b: Vector, c: Vector) -> Vector:
        """The weight at c where the other two depths are a and b."""
        below = (c - a) * (c - b)
        share: Vector = np.divide(a * b - b1 * (a + b) + b2, below, out=np.zeros_like(below), where=below != 0.0)
        return share

    # What lies before the receiver is in its way.
    shadow = np.where(z2 < z1, weight(z1, z3, z2), 0.0) + np.where(z3 < z1, weight(z1, z2, z3), 0.0)
    light: Vector = 1.0 - np.clip(shadow, 0.0, 1.0)
    return light
