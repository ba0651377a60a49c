"""What closed forms hold to for all views: symmetries, limits, sums, least errors, and an answer to every number."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from closed_form_support import EXACT, IDEAL, WARPS, close, fovs, lams, ratios, scales, shares, thetas, view_of
from hypothesis import given
from hypothesis import strategies as st

from shadowlab.aliasing import closed_form as cf
from shadowlab.errors import ArgumentError

# A warning of numpy is a failure.
pytestmark = pytest.mark.filterwarnings("error")

# An integral over the logarithm of depth by Gauss and Legendre, 64 nodes on each of 32 pieces.
INTEGRATED = 1e-10


def n_between(view, share):
    """A warp distance at this share between near and n_opt."""
    least = view["near"]
    return least + share * (cf.n_opt(**view) - least)


@given(scales, ratios, shares)
def test_the_product_of_the_largest_errors_is_one_for_all_warps_up_to_the_optimal(scale, ratio, share):
    view = view_of(scale, ratio)
    close(cf.worst(**view, technique="lispsm", n=n_between(view, share)).storage, view["far"] - view["near"])
    # A weaker warp than the optimal one costs more, at most what the uniform map does.
    weaker = cf.worst(**view, technique="lispsm", n=1.5 * cf.n_opt(**view)).storage
    assert view["far"] - view["near"] < weaker < cf.worst(**view, technique="uniform").storage


@given(scales, ratios, st.sampled_from(IDEAL), shares, st.floats(1e-3, 1e3))
def test_lengths_scale_and_shares_do_not(scale, ratio, technique, share, factor):
    view, other = view_of(scale, ratio), view_of(scale * factor, ratio)
    z = np.clip(view["near"] * (view["far"] / view["near"]) ** share, view["near"], view["far"])
    # near * ratio is rounded, and far - near of a ratio of 1.001 has three digits less.
    z_other = np.clip(z * factor, other["near"], other["far"])
    close(
        cf.dp_ds(z_other, **other, technique=technique), factor * cf.dp_ds(z, **view, technique=technique), 1e3 * EXACT
    )
    close(cf.dp_dt(z_other, **other, technique=technique), cf.dp_dt(z, **view, technique=technique), 1e3 * EXACT)


@given(scales, ratios, st.sampled_from([*IDEAL, "n"]), shares)
def test_a_map_is_filled_once(scale, ratio, technique, share):
    view = view_of(scale, ratio)
    warp = {"technique": "lispsm", "n": n_between(view, share)} if technique == "n" else {"technique": technique}
    nodes, weights = np.polynomial.legendre.leggauss(64)
    borders = np.linspace(0, np.log(view["far"] / view["near"]), 33)
    half = 0.5 * np.diff(borders)[:, None]
    log_z = borders[:-1, None] + half * (1 + nodes)
    z = np.clip(view["near"] * np.exp(log_z), view["near"], view["far"])
    # ds = near dz / (z dp/ds), and dz = z d ln z.
    integral = (half * weights * view["near"] / cf.dp_ds(z, **view, **warp)).sum()
    close(integral, 1.0, INTEGRATED)


@pytest.mark.parametrize("technique", IDEAL)
@pytest.mark.parametrize("ratio", [1.01, 3.0, 100.0, 1e5])
def test_worst_is_what_a_dense_scan_finds(technique, ratio):
    for n in [None] if technique != "lispsm" else [None, 0.5, 0.507, 0.8, 5.0, 40.0, np.inf]:
        w = cf.worst(near=0.5, far=0.5 * ratio, technique=technique, n=n)
        z = np.geomspace(0.5, 0.5 * ratio, 200_001)
        ds, dt = (f(z, near=0.5, far=0.5 * ratio, technique=technique, n=n) for f in (cf.dp_ds, cf.dp_dt))
        ds, dt = np.broadcast_to(ds, z.shape), np.broadcast_to(dt, z.shape)
        close([w.max_dp_ds, w.min_dp_ds, w.max_dp_dt], [ds.max(), ds.min(), dt.max()], 1e-8)
        at = [w.max_dp_ds_z, w.min_dp_ds_z, w.max_dp_dt_z]
        for place, found in zip(at, [ds.argmax(), ds.argmin(), dt.argmax()], strict=True):
            values = dt if place is at[2] else ds
            # Where one value is at several depths, the nearest.
            assert abs(place / z[found] - 1) < 1e-3 or (abs(values[0] / values[found] - 1) < 1e-12 and place == 0.5)
        close(cf.dp_ds([w.max_dp_ds_z, w.min_dp_ds_z], near=0.5, far=0.5 * ratio, technique=technique, n=n),
              [w.max_dp_ds, w.min_dp_ds] if technique != "log" else w.max_dp_ds)  # fmt: skip


@given(scales, ratios, shares)
def test_warps_between_perspective_and_uniform(scale, ratio, share):
    view = view_of(scale, ratio)
    z = np.clip(view["near"] + share * (view["far"] - view["near"]), view["near"], view["far"])
    for error in (cf.dp_ds, cf.dp_dt):
        close(error(z, **view, n=view["near"]), error(z, **view, technique="psm"))
        uniform = error(z, **view, technique="uniform")
        close(error(z, **view, n=np.inf), uniform)
        close(error(z, **view, n=1e13 * view["far"]), uniform)
    # No other distance has a smaller largest error.
    best = cf.worst(**view, technique="lispsm").max_dp_ds
    for factor in (0.99, 1.01):
        n = max(view["near"], factor * cf.n_opt(**view))
        assert cf.worst(**view, technique="lispsm", n=n).max_dp_ds >= best * (1 - EXACT)


@given(scales, ratios, fovs, st.sampled_from(IDEAL))
def test_storage_is_the_product_of_the_largest_errors_in_pixels(scale, ratio, fov_y, technique):
    view = view_of(scale, ratio)
    ratio = view["far"] / view["near"]
    near_plane = 2 * view["near"] * np.tan(fov_y / 2)
    w = cf.worst(**view, technique=technique)
    close(cf.storage_factor(ratio=ratio, fov_y=fov_y, technique=technique), w.storage / near_plane, 1e3 * EXACT)
    # All splits of one view: their largest errors, each with its width.
    ends = cf.splits(**view, count=3)
    total = 0.0
    for begin, end in itertools.pairwise(ends):
        z = np.geomspace(begin, end, 5)
        ds = cf.dp_ds_in_split(z, **view, split_near=begin, split_far=end, technique=technique)
        close(np.max(ds), cf.max_dp_ds_of_splits(**view, count=3, technique=technique), 1e3 * EXACT)
        total += np.max(ds) / near_plane * np.max(cf.dp_dt(z, near=begin, far=end, technique=technique))
    close(cf.storage_factor(ratio=ratio, fov_y=fov_y, technique=technique, splits=3), total, 1e3 * EXACT)


@given(scales, ratios, fovs, shares)
def test_gmnpr_has_equal_errors_at_both_ends(scale, ratio, fov_y, share):
    view = {**view_of(scale, ratio), "fov_y": fov_y}
    theta = fov_y / 2 + share * (np.pi / 2 - fov_y / 2)
    lam = cf.warp_lambda(theta, **view)
    ends = cf.F_ends(theta, lam=lam, **view)
    tolerance = 1e-9  # λ of a narrow range of depths is a difference of numbers 1e3 times as large
    close(ends.near, ends.far, tolerance)
    close(cf.phi_offset(theta, lam=lam, **view), np.sqrt(scale) * np.sqrt(view["far"]), tolerance)


@given(ratios, fovs, shares)
def test_equal_ends_are_the_least_largest_error_where_the_near_one_grows_with_lambda(ratio, fov_y, share):
    view = {**view_of(1.0, ratio), "fov_y": fov_y}
    theta = fov_y / 2 + share * (np.pi / 2 - fov_y / 2)
    t = np.tan(fov_y / 2) / np.tan(theta)
    lam, mu = cf.warp_lambda(theta, **view), t / (ratio - 1 + (ratio + 1) * t)
    # (λ + μ)² / (λ (λ + 1)) grows with λ beyond μ / (1 - 2μ).
    margin = lam * (1 - 2 * mu) / mu if mu > 0 else np.inf
    change = [max(cf.F_ends(theta, lam=lam * factor, **view)) / cf.F_ends(theta, lam=lam, **view).near
              for factor in (0.99, 1.01)]  # fmt: skip
    assert change[0] > 1
    if margin > 1.02:
        assert change[1] > 1
    if margin < 0.98:
        assert change[1] < 1


def test_in_a_view_narrow_in_depth_equal_ends_are_not_the_least_largest_error():
    view = {"near": 1.0, "far": 1.5, "fov_y": 1.0}
    ours = cf.F_ends(0.5, lam=cf.warp_lambda(0.5, **view), **view)
    weaker = cf.F_ends(0.5, lam=cf.warp_lambda(0.5, **view, technique="lispsm"), **view)
    assert max(weaker) < 0.98 * min(ours)
    # In the paper's own view they are, at every angle of equation 4.
    view = {"near": 1.0, "far": 100.0, "fov_y": np.pi / 3}
    theta = np.linspace(np.pi / 6, np.pi / 2, 61)[:, None]
    lam = cf.warp_lambda(theta, **view)
    largest = np.maximum(*cf.F_ends(theta, lam=lam * np.geomspace(0.5, 2, 801), **view))
    close(largest.min(axis=1), largest[:, 400])
    assert (largest.argmin(axis=1) == 400).all()


@given(scales, ratios, fovs, thetas, lams)
def test_the_printed_ends_and_the_minimum_are_those_of_f(scale, ratio, fov_y, theta, lam):
    view = {**view_of(scale, ratio), "fov_y": fov_y}
    at = {"lam": lam, **view}
    tolerance = 1e-8  # the printed μ and ν cancel where the view is narrow in depth
    ends = cf.F([view["near"], view["far"]], theta=theta, **at)
    close(cf.F_ends(theta, **at), ends, tolerance)
    least = cf.F_least(theta, **at)
    z = np.geomspace(view["near"], view["far"], 101)
    scan = cf.F(np.clip(z, view["near"], view["far"]), theta=theta, **at)
    assert (scan >= least.value * (1 - EXACT)).all()
    close(cf.F(least.z, theta=theta, **at), least.value)
    offset = cf.phi_offset(theta, **at)
    if view["near"] < offset < view["far"]:
        assert least.z == offset
        # 4 ψ ϕ of theory.md 6, ψ as written in (6.2).
        acute, phi = min(theta, np.pi - theta), fov_y / 2
        t = np.tan(phi) / np.tan(acute)
        n, f = view["near"], view["far"]
        a = f - n + (f + n) * t if acute >= phi else 2 * f * t
        close(least.value, 4 * offset / (np.tan(phi) * a * lam * (lam + 1)), 1e-6)


@given(scales, ratios, fovs, thetas, lams, shares, st.floats(1e-3, 1e3))
def test_errors_on_the_centre_ray_know_no_scale_and_no_side(scale, ratio, fov_y, theta, lam, share, factor):
    results = []
    for s, angle in ((scale, theta), (scale * factor, theta), (scale, np.pi - theta)):
        view = view_of(s, ratio)
        z = np.clip(s * ratio**share, view["near"], view["far"])
        at = {"theta": angle, "lam": lam, "fov_y": fov_y, **view}
        results.append([cf.F(z, **at), cf.G(z, **at), cf.F_log(z, **at)])
    # pi - theta of a theta of 1e-4 has four digits less.
    close(results[1], results[0], 1e-8)
    close(results[2], results[0], 1e-8)
    assert (np.array(results) > 0).all()


@given(scales, ratios, fovs, thetas, shares)
def test_weak_warps_and_no_warp_are_one(scale, ratio, fov_y, theta, share):
    view = {**view_of(scale, ratio), "fov_y": fov_y}
    z = np.clip(scale * ratio**share, view["near"], view["far"])
    for error in (cf.F, cf.G, cf.F_log):
        limit = error(z, theta=theta, lam=np.inf, **view)
        close(error(z, theta=theta, lam=1e14, **view), limit)
        assert abs(error(z, theta=theta, lam=1e6, **view) / limit - 1) < 3e-6
    close(cf.G(z, theta=theta, lam=np.inf, **view), 2 * view["far"] / z)


@given(scales, ratios, fovs, st.sampled_from(list(WARPS.values())))
def test_lambda_goes_to_the_uniform_map_and_has_no_jump_at_half_the_field_of_view(scale, ratio, fov_y, technique):
    view = {**view_of(scale, ratio), "fov_y": fov_y, "technique": technique}
    assert cf.warp_lambda(0, **view) == cf.warp_lambda(np.pi, **view) == cf.warp_lambda(1e-7, **view) == np.inf
    small = cf.warp_lambda([1e-5, 1e-4, 1e-3], **view)
    if fov_y > 0.1:
        assert (np.diff(small) < 0).all()
    step = 1e-9
    below, above = cf.warp_lambda([fov_y / 2 * (1 - step), fov_y / 2 * (1 + step)], **view)
    # GLPR's own λ rises from 0 with a slope of a quarter to one over the angle, its floor is near / far / 10.
    close(below, above, 1e-7 * (1 + ratio if technique == "glpr" else 1))
    close(cf.warp_lambda(fov_y / 2, **view), above, 1e-7 * (1 + ratio if technique == "glpr" else 1))


@given(scales, ratios, fovs, shares)
def test_glpr_is_linear_and_its_logarithm_constant(scale, ratio, fov_y, share):
    view = {**view_of(scale, ratio), "fov_y": fov_y}
    theta = fov_y / 2 + (0.1 + 0.9 * share) * (np.pi / 2 - fov_y / 2)
    lam = cf.warp_lambda(theta, **view, technique="glpr", lambda_floor=0)
    z = np.clip(scale * ratio ** np.linspace(0, 1, 9), view["near"], view["far"])
    at = {"theta": theta, "lam": lam, **view}
    error = cf.F(z, **at)
    tolerance = 1e-8
    close(error / z * z[0], np.full(9, error[0]), tolerance)
    t = np.tan(fov_y / 2) / np.tan(theta)
    n, f = view["near"], view["far"]
    close(cf.F_log(z, **at), np.full(9, np.log1p((f - n + (f + n) * t) / (n * (1 - t))) / np.tan(fov_y / 2)), tolerance)
    close(np.log1p((f - n + (f + n) * t) / (n * (1 - t))), np.log(f * (1 + t) / (n * (1 - t))), tolerance)


@given(
    st.floats(width=64, allow_nan=True, allow_infinity=True),
    st.floats(),
    st.floats(),
    st.floats(),
    st.floats(),
    st.floats(),
    st.sampled_from(IDEAL),
    st.sampled_from(list(WARPS.values())),
)
def test_every_number_has_a_finite_answer_or_a_typed_error(z, near, far, theta, lam, fov_y, ideal, warp):
    view = {"near": near, "far": far, "fov_y": fov_y}
    at = {"theta": theta, "lam": lam, **view}
    for call in (
        lambda: cf.n_opt(near, far),
        lambda: cf.dp_ds(z, near=near, far=far, technique=ideal),
        lambda: cf.dp_ds(z, near=near, far=far, n=lam),
        lambda: cf.dp_dt(z, near=near, far=far, n=lam),
        lambda: cf.worst(near=near, far=far, technique=ideal).storage,
        lambda: cf.storage_factor(ratio=far, fov_y=fov_y, technique=ideal, splits=lam),
        lambda: cf.splits(near=near, far=far, count=3, scheme="practical", blend=lam),
        lambda: cf.max_dp_ds_of_splits(near=near, far=far, count=lam, technique=ideal),
        lambda: cf.F(z, **at),
        lambda: cf.G(z, **at),
        lambda: cf.F_log(z, **at),
        lambda: cf.F_ends(theta, lam=lam, **view),
        lambda: cf.dp_ds_on_surface(z, theta, cos_alpha=near, cos_beta=far),
    ):
        try:
            assert np.isfinite(call()).all()
        except ArgumentError:
            continue
    for call in (
        lambda: cf.warp_lambda(theta, **view, technique=warp),
        lambda: cf.phi_offset(theta, lam=lam, **view),
        lambda: cf.worst(near=near, far=far, technique=ideal).n,
    ):
        try:
            assert not np.isnan(call())
        except ArgumentError:
            continue


@given(
    st.floats(1e-300, 1e290),
    st.floats(0, 52),
    shares,
    st.one_of(st.floats(1e-6, np.pi - 1e-6), st.just(np.pi / 2)),
    st.floats(-74, 300),
    st.floats(-70, np.log10(np.pi)),
    st.sampled_from(list(WARPS.values())),
)
def test_extreme_views_have_finite_answers(near, log2_ratio, share, theta, log_lam, log_fov, warp):
    far = min(near * 2.0**log2_ratio, 1.7e308)
    if not near < far <= near * 2.0**52:
        return
    fov_y = min(10.0**log_fov, np.nextafter(np.pi, 0))
    view, z = {"near": near, "far": far}, min(far, max(near, near * (far / near) ** share))
    for technique in IDEAL:
        assert np.isfinite(cf.dp_ds(z, **view, technique=technique))
        assert np.isfinite(cf.dp_dt(z, **view, technique=technique))
        assert np.isfinite(cf.storage_factor(ratio=far / near, fov_y=fov_y, technique=technique))
    for lam in (10.0**log_lam, cf.warp_lambda(theta, **view, fov_y=fov_y, technique=warp)):
        at = {"theta": theta, "lam": lam, "fov_y": fov_y, **view}
        for error in (cf.F, cf.G, cf.F_log):
            assert 0 < error(z, **at) < np.inf
        assert np.isfinite(cf.F_ends(theta, lam=lam, fov_y=fov_y, **view)).all()
        assert np.isfinite(cf.F_least(theta, lam=lam, fov_y=fov_y, **view)).all()
