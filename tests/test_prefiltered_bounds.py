"""Bounds of the light through filtered maps: closed forms, brute force over distributions, and what rounding costs."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from shadowlab.aliasing.box_kernel import blurred, compared, read_between, texels_before, weight_of
from shadowlab.aliasing.light_bounds import chebyshev_light, exponential_light, moment_light, without_bleeding
from shadowlab.aliasing.prefiltered_formats import (
    MOMENT_BIAS,
    MOMENT_INVERSE,
    MOMENT_OFFSET,
    MOMENT_TRANSFORM,
    PREFILTERED_FORMATS,
    UNORM16_STEPS,
    PrefilteredFormat,
)

COUNT = 20_000
# Moments resolve 2^-53, and the least variance here is 1e-9: of such a distribution seven digits are left.
ROOTS = 1e-6
# A variance is a difference of squares: below it depths count as one.
SQUARES = 2.0**-50
FORMATS = list(PREFILTERED_FORMATS.values())


def distributions(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Depths and weights (N, 36) from one depth to many, and receivers, a third of them at one of the depths."""
    rng = np.random.default_rng(seed)
    spread = rng.random((COUNT, 36))
    few = np.take_along_axis(spread, rng.integers(0, rng.integers(1, 5, (COUNT, 1)), (COUNT, 36)), axis=1)
    near = 0.5 + 1e-3 * spread  # a plane across the light
    depths = np.choose(rng.integers(0, 3, (COUNT, 1)), [spread, few, near])
    weights = rng.random((COUNT, 36))
    weights /= weights.sum(axis=1, keepdims=True)
    at = np.where(rng.random(COUNT) < 1 / 3, depths[:, 0], rng.uniform(-0.1, 1.1, COUNT))
    return depths, weights, at


def moments_of(depths: np.ndarray, weights: np.ndarray) -> np.ndarray:
    return np.stack([(weights * depths**k).sum(axis=1) for k in (1, 2, 3, 4)], axis=1)


def no_variance(of: np.ndarray) -> np.ndarray:
    return np.full(len(of), SQUARES)


@pytest.mark.parametrize("seed", range(3))
def test_no_bound_is_below_the_light_of_comparisons(seed):
    depths, weights, at = distributions(seed)
    light = (weights * (depths >= at[:, None])).sum(axis=1)
    moments = moments_of(depths, weights)
    assert (chebyshev_light(*moments[:, :2].T, at, no_variance(at), 0.0) >= light - ROOTS).all()
    for c in (1.0, 20.0, 80.0):
        assert (exponential_light(np.log((weights * np.exp(c * depths)).sum(axis=1)), at, c) >= light - ROOTS).all()
    # A bias moves the light by at most its half, that of the distribution which it adds.
    for bias in (0.0, *MOMENT_BIAS.values()):
        assert (moment_light(moments, at, bias) >= light - bias / 2 - ROOTS).all()


@pytest.mark.parametrize("seed", range(3))
def test_four_moments_bound_closer_than_two(seed):
    depths, weights, at = distributions(seed)
    moments = moments_of(depths, weights)
    two, four = chebyshev_light(*moments[:, :2].T, at, no_variance(at), 0.0), moment_light(moments, at, 0.0)
    assert (four <= two + ROOTS).all()
    light = (weights * (depths >= at[:, None])).sum(axis=1)
    assert (four - light).mean() < 0.6 * (two - light).mean()


def test_the_check_of_bounds_fails_on_a_smaller_light():
    depths, weights, at = distributions(0)
    light = (weights * (depths >= at[:, None])).sum(axis=1)
    moments = moments_of(depths, weights)
    # Three moments' worth: a receiver that is nearer the light by a hundredth is lit more.
    assert not (moment_light(moments, at + 0.01, 0.0) >= light - ROOTS).all()
    assert not (chebyshev_light(*moments[:, :2].T, at + 0.01, no_variance(at), 0.0) >= light - ROOTS).all()


@pytest.mark.parametrize("share", [0.01, 0.3, 0.5, 0.96])
def test_one_occluder_before_the_receiver_is_exact(share):
    """The penumbra of one plane on another: two depths, of which the farther is the receiver's own."""
    near, far = np.array([0.2]), np.array([0.7])
    depths, weights = np.stack([near, far], axis=1), np.array([[share, 1 - share]])
    moments = moments_of(depths, weights)
    assert chebyshev_light(*moments[:, :2].T, far, np.zeros(1), 0.0) == pytest.approx(1 - share, abs=1e-12)
    assert moment_light(moments, far, 0.0) == pytest.approx(1 - share, abs=ROOTS)


@pytest.mark.parametrize("share", [0.05, 0.5, 0.8])
def test_two_occluders_bleed_through_two_moments_and_not_through_four(share):
    """Depths a and b, the receiver at t behind both: Chebyshev leaves p (1-p) (b-a)² / (p (1-p) (b-a)² + (t-mean)²)."""
    a, b, t = 0.1, 0.6, np.array([0.65])
    depths, weights = np.array([[a, b]]), np.array([[share, 1 - share]])
    moments = moments_of(depths, weights)
    variance, mean = share * (1 - share) * (b - a) ** 2, share * a + (1 - share) * b
    bleeding = variance / (variance + (0.65 - mean) ** 2)
    assert chebyshev_light(*moments[:, :2].T, t, np.zeros(1), 0.0) == pytest.approx(bleeding)
    assert moment_light(moments, t, 0.0) == pytest.approx(0.0, abs=ROOTS)
    assert without_bleeding(np.array([bleeding]), 0.5) == pytest.approx(max(0.0, (bleeding - 0.5) / 0.5))
    # Exponentials forget how far apart the occluders are, and fall with the gap behind the nearer of the receiver.
    light = exponential_light(np.log((weights * np.exp(80 * depths)).sum(axis=1)), t, 80.0)
    assert light == pytest.approx((1 - share) * np.exp(-80 * 0.05) + share * np.exp(-80 * 0.55))


@pytest.mark.parametrize("shares", [(0.2, 0.3, 0.5), (0.6, 0.3, 0.1), (1 / 3, 1 / 3, 1 / 3)])
def test_two_occluders_before_a_receiver_are_exact_with_four_moments(shares):
    depths, weights = np.array([[0.1, 0.5, 0.8]]), np.array([shares])
    moments = moments_of(depths, weights)
    assert moment_light(moments, np.array([0.8]), 0.0) == pytest.approx(shares[2], abs=ROOTS)
    assert chebyshev_light(*moments[:, :2].T, np.array([0.8]), np.zeros(1), 0.0) > shares[2] + 0.02


def test_an_exponential_becomes_the_hard_test():
    """Of one depth exp(c (z - t)); of several, with a large c, whether any of them is not before the receiver."""
    rng = np.random.default_rng(5)
    z, t = rng.random(COUNT), rng.random(COUNT)
    for c in (1.0, 10.0, 80.0):
        assert exponential_light(c * z, t, c) == pytest.approx(np.exp(-c * np.maximum(t - z, 0.0)))
    wrong = [np.abs(exponential_light(c * z, t, c) - (z >= t)).mean() for c in (10.0, 1e2, 1e3, 1e4)]
    assert all(b < 0.2 * a for a, b in pairwise(wrong))
    # The mean of exp(-c x) over receivers behind, x to 1 with the density 1 - x, is 1/c - (1 - exp(-c)) / c².
    assert wrong[0] == pytest.approx(1 / 10 - (1 - np.exp(-10)) / 100, rel=0.05)


def test_any_moments_give_a_share_of_the_light():
    rng = np.random.default_rng(9)
    wild = rng.normal(size=(COUNT, 4)) * 10.0 ** rng.integers(-20, 3, (COUNT, 4))
    wild[:100] = 0.0
    for bias in (0.0, 3e-5):
        light = moment_light(wild, rng.uniform(-1, 2, COUNT), bias)
        assert ((light >= 0) & (light <= 1)).all()


def test_the_quantisation_of_moments_keeps_to_its_range_and_turns_back():
    z = np.linspace(0, 1, 4097)
    stored = np.stack([z**k for k in (1, 2, 3, 4)], axis=1) @ MOMENT_TRANSFORM + MOMENT_OFFSET
    assert stored.min() > -1e-6
    assert stored.max() < 1 + 1e-6
    # It fills the range: each channel uses nearly all of it, where z, z², z³, z⁴ leave a thin body.
    assert (stored.max(axis=0) - stored.min(axis=0) > 0.95).all()
    # Published beside it, to the digits of single precision.
    assert MOMENT_INVERSE[0] == pytest.approx([0.2227744146, 0.1549679261, 0.1451988946, 0.163127443], rel=1e-5)
    assert abs(np.linalg.det(MOMENT_TRANSFORM)) > 1000


@pytest.mark.parametrize("format", FORMATS, ids=[one.name for one in FORMATS])
def test_what_rounding_costs(format: PrefilteredFormat):
    """Once stored, a depth is as far off as a half step of its numbers."""
    z = np.random.default_rng(1).random(COUNT)
    texels = format.stored(z)
    assert texels.nbytes == format.bytes * COUNT
    read = format.read(texels)
    if format.quantity == "exponential":
        found = np.log(read[:, 0]) - format._shift
        assert np.abs(found - format.exponent * z).max() <= {"f16": 2.0**-11, "f32": 2.0**-23}[format.number] * 1.01
        return
    own = 2 * z - 1 if format.is_centred else z
    exact = np.stack([own ** (k + 1) for k in range(read.shape[1])], axis=1)
    if format.number == "unorm16":
        by_channel = np.full(read.shape[1], 0.5 / UNORM16_STEPS)
        most = by_channel @ np.abs(MOMENT_INVERSE) if format.quantity == "moment" else by_channel
        # The published matrix leaves [0, 1] by less than a step.
        assert (np.abs(read - exact).max(axis=0) <= 1.05 * most).all()
    else:
        share = {"f16": 2.0**-11, "f32": 2.0**-24}[format.number]
        assert (np.abs(read - exact) <= share * np.abs(exact) + 2.0**-25).all()


@pytest.mark.parametrize("format", FORMATS, ids=[one.name for one in FORMATS])
def test_rounding_leaves_a_surface_lit(format: PrefilteredFormat):
    """Maps of one depth, blurred and so rounded twice: a receiver at that depth keeps its light, one before it too."""
    for z in np.random.default_rng(2).random(40):
        texels = blurred(format.stored(np.full((7, 7), z)), format, 3)
        read = read_between(texels, format, np.array([[3.2, 3.9]]))
        assert format.light(read, np.array([z]), 0.0) > 0.99
        assert format.light(read, np.array([z - 0.01]), 0.0) > 0.99


@pytest.mark.parametrize("format", [one for one in FORMATS if one.quantity == "variance"], ids=lambda one: one.name)
def test_a_rounded_variance_is_off_by_less_than_the_least(format: PrefilteredFormat):
    rng = np.random.default_rng(3)
    for _ in range(50):
        z = rng.random() + 0.02 * rng.standard_normal((9, 9))
        texels = blurred(format.stored(np.clip(z, 0, 1)), format, 5)
        mean, square = read_between(texels, format, np.array([[4.5, 4.5]])).T
        own = format._own(np.clip(z, 0, 1))[2:7, 2:7]
        assert abs(square - mean * mean - own.var()) <= format.least_variance(mean, square)


@pytest.mark.parametrize("kernel", [1, 3, 5, 11])
def test_both_ways_average_over_the_same_kernel(kernel):
    """A blurred map between texels, and comparisons: the weights are the same, found from maps of one texel."""
    rng = np.random.default_rng(kernel)
    places = rng.uniform(0.5, 15.5, (200, 2))  # the outermost half texel is the border's
    part = texels_before(places)[1]
    assert sum(weight_of(i, part[:, 0], kernel) for i in range(kernel + 1)) == pytest.approx(np.ones(200))
    # With z = 1 at marked texels and 0 elsewhere, the mean of z and the share of texels at 1 or behind are one number.
    marked = (rng.random((16, 16)) < 0.4).astype(float)
    stored = PREFILTERED_FORMATS["variance:f32"]
    mean = read_between(blurred(stored.stored(marked), stored, kernel), stored, places)[:, 0]
    light = compared(marked, places, np.full(200, 0.5), np.zeros((200, 2)), kernel)
    assert 0.5 * (mean + 1) == pytest.approx(light, abs=1e-6)
    # By hand at one place: the box of n texels about a texel's centre.
    reach = kernel // 2
    at = compared(marked, np.array([[8.5, 7.5]]), np.array([0.5]), np.zeros((1, 2)), kernel)
    assert at == pytest.approx(marked[7 - reach : 8 + reach, 8 - reach : 9 + reach].mean())


def test_a_plane_lights_itself_by_comparisons():
    """Depths of a plane over the map: with its own gradient no texel is before the receiver, without it half are."""
    rows, columns = np.mgrid[:16, :16] + 0.5
    plane = 0.5 + 0.01 * columns - 0.003 * rows
    places = np.random.default_rng(4).uniform(5, 11, (100, 2))
    depth = 0.5 + 0.01 * places[:, 0] - 0.003 * places[:, 1]
    gradients = np.tile([0.01, -0.003], (100, 1))
    assert compared(plane, places, depth - 1e-12, gradients, 5) == pytest.approx(1.0)
    assert compared(plane, places, depth, 0 * gradients, 5).mean() == pytest.approx(0.5, abs=0.05)


@pytest.mark.parametrize("format", FORMATS, ids=[one.name for one in FORMATS])
def test_a_format_lets_through_no_less_than_comparisons(format: PrefilteredFormat):
    """Whole maps, stored, blurred and read: the bound holds against the same kernel's comparisons, up to rounding."""
    rng = np.random.default_rng(6)
    depths = np.where(rng.random((32, 32)) < 0.5, 0.2 + 0.1 * rng.random((32, 32)), 0.8)
    places, at = rng.uniform(4, 28, (2000, 2)), rng.random(2000)
    light = format.light(read_between(blurred(format.stored(depths), format, 5), format, places), at, 0.0)
    comparisons = compared(depths, places, at, np.zeros((2000, 2)), 5)
    # Rounded moments are those of a distribution that is hardly another one.
    assert (light >= comparisons - 5e-3).all()
    assert (light - comparisons).mean() > 0.01
