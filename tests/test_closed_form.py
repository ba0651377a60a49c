"""Closed forms against the tables and the printed numbers; their examples; the shapes and errors of their arguments."""

from __future__ import annotations

import doctest
import importlib
import json
from pathlib import Path

import numpy as np
import pytest
from closed_form_support import EXACT, WARPS, close

import shadowlab as sl
from shadowlab.aliasing import closed_form as cf
from shadowlab.errors import ArgumentError, UnknownNameError

# A warning of numpy is a failure.
pytestmark = pytest.mark.filterwarnings("error")

TABLES = json.loads((Path(__file__).parent / "data" / "tables.json").read_text("utf-8"))
# The tables' uniform F and G are those of a matrix with a reference point 1e9 away.
FAR_AWAY = 1e-8
# theta = phi is where GLPR's λ falls to 0: of size 1e-3 there, and with it all that cancels.
NEAR_PHI = 1e-9


def test_a_small_difference_is_seen():
    with pytest.raises(AssertionError):
        close([1.0, 2.0], [1.0, 2.0 + 3e-12])


@pytest.mark.parametrize("module", ["overhead", "splits", "warp_distance", "any_angle"])
def test_examples_are_true(module):
    module = importlib.import_module(f"shadowlab.aliasing.closed_form.{module}")
    result = doctest.testmod(module, extraglobs={"np": np, **{name: getattr(cf, name) for name in cf.__all__}})
    assert result.attempted > 0
    assert result.failed == 0
    for name in vars(module).keys() & set(cf.__all__):
        if callable(getattr(module, name)) and not isinstance(getattr(module, name), type):
            assert "Examples" in getattr(module, name).__doc__, name
            assert "Raises" in getattr(module, name).__doc__, name


# Tables.


def test_errors_of_the_ideal_case_are_the_tables():
    table = TABLES["ideal_dp_ds"]
    view = {"near": table["zn"], "far": table["zf"]}
    for key in ("uniform", "psm", "lispsm", "log"):
        close(cf.dp_ds(table["z"], **view, technique=key), table[key])
        worst = cf.worst(**view, technique=key)
        close(worst.max_dp_ds, table["maxima"][key])
        if key in table["minima"]:
            close(worst.min_dp_ds, table["minima"][key])
    close(cf.n_opt(**view), table["n_opt"])
    table = TABLES["ideal_dp_dt"]
    for key, name in [("uniform", "uniform"), ("psm", "psm"), ("lispsm", "lispsm"), ("logpsm", "log")]:
        close(cf.dp_dt(table["z"], **view, technique=name), table[key])
        close(cf.worst(**view, technique=name).storage, TABLES["storage_product"][key])


def test_lambda_is_the_tables():
    table = TABLES["lambda"]
    view = {"near": table["n"], "far": table["f"], "fov_y": 2 * table["phi"]}
    theta = np.radians(table["theta_deg"])
    for key, technique in WARPS.items():
        for side in (theta, np.pi - theta):
            close(cf.warp_lambda(side, **view, technique=technique), table[key], NEAR_PHI)
    close(cf.warp_lambda(table["phi"], **view), table["lambda1_at_phi"])
    raw = np.array(table["glpr_raw"])
    close(cf.warp_lambda(theta[raw > 1e-9], **view, technique="glpr", lambda_floor=0), raw[raw > 1e-9], NEAR_PHI)
    assert (raw < 0).sum() > 5
    with pytest.raises(ArgumentError, match=r"theta.*above half the field of view.*lambda_floor"):
        cf.warp_lambda(theta[raw < 0], **view, technique="glpr", lambda_floor=0)


def test_errors_on_the_centre_ray_are_the_tables():
    table = TABLES["F"]
    view = {"near": table["n"], "far": table["f"], "fov_y": 2 * table["phi"]}
    theta, z = np.radians(table["theta_deg"])[:, None], np.array(table["z"])
    for key, technique in {**WARPS, "uniform": "uniform"}.items():
        lam = cf.warp_lambda(theta, **view, technique=technique)
        tolerance = FAR_AWAY if key == "uniform" else NEAR_PHI
        close(cf.F(z, theta=theta, lam=lam, **view), table[key], tolerance)
        for row in TABLES["centre_ray_maxima"][key]:
            at = {"theta": np.radians(row["theta_deg"]), **view}
            at["lam"] = cf.warp_lambda(**at, technique=technique)
            close(cf.F(z, **at).max(), row["max_F"], tolerance)
            close(cf.G(z, **at).max(), row["max_G"], tolerance)
    # Of GLPR's own λ, without the floor.
    above = [i for i, row in enumerate(table["log_glpr"]) if row[0] is not None]
    assert (theta[above] > table["phi"]).all()
    assert len(above) > 4
    lam = cf.warp_lambda(theta[above], **view, technique="glpr", lambda_floor=0)
    close(cf.F_log(z, theta=theta[above], lam=lam, **view), np.array([table["log_glpr"][i] for i in above]), NEAR_PHI)


def test_splits_are_the_tables():
    table = TABLES["splits"]
    view = {"near": table["n"], "far": table["f"], "count": table["m"]}
    close(cf.splits(**view, scheme="uniform"), table["uniform"])
    close(cf.splits(**view), table["log"])
    close(cf.splits(**view, scheme="practical"), table["practical_0_5"])
    for split in TABLES["zpartition_lispsm_overhead"]["splits"]:
        close(cf.n_opt(split["near"], split["far"]), split["Pn"])


# Printed numbers.


def printed(text):
    """The number, and half a unit of its last digit."""
    mantissa, _, exponent = text.partition("e")
    decimals = len(mantissa.partition(".")[2])
    return float(text), 0.5 * 10.0 ** (int(exponent or 0) - decimals)


def assert_printed(ours, text):
    value, half = printed(text)
    assert abs(ours - value) <= half * (1 + 1e-9), f"{ours} is not {text}"


def test_one_digit_more_or_less_is_not_the_printed_one():
    assert_printed(8.6540e5, "8.65e5")
    for ours, text in [(8.6551e5, "8.65e5"), (1.984, "1.99"), (8575.0, "8574"), (np.nan, "1")]:
        with pytest.raises(AssertionError):
            assert_printed(ours, text)


OVERHEAD = {
    "uniform": ("77.9", "8574", "8.65e5", "8.66e7"),
    "psm": ("7.79", "85.7", "865", "8659"),
    "lispsm": ("7.79", "85.7", "865", "8659"),
    "log": ("1.99", "3.99", "5.98", "7.98"),
}
SPLIT = {  # ratio: splits: uniform, warped
    10: {2: ("11.8", "3.75"), 3: ("6.46", "3.00"), 4: ("4.79", "2.70"), 8: ("3.08", "2.31")},
    100: {2: ("156", "15.6"), 3: ("43.9", "9.46"), 4: ("23.7", "7.49"), 8: ("9.59", "5.39")},
    1000: {2: ("1677", "53.0"), 3: ("234", "23.4"), 4: ("90.1", "16.0"), 8: ("22.5", "9.50")},
    10**4: {2: ("17150", "171"), 3: ("1150", "53.4"), 4: ("312", "31.2"), 8: ("47.4", "15.0")},
}


def test_storage_factors_are_the_printed_ones():
    for technique, row in OVERHEAD.items():
        for ratio, text in zip((10, 100, 1000, 10**4), row, strict=True):
            assert_printed(cf.storage_factor(ratio=ratio, fov_y=np.radians(60), technique=technique), text)
    for ratio, row in SPLIT.items():
        for splits, texts in row.items():
            for technique, text in zip(("uniform", "lispsm"), texts, strict=True):
                ours = cf.storage_factor(ratio=ratio, fov_y=np.radians(60), technique=technique, splits=splits)
                # 17150.4 is printed to four digits.
                assert_printed(ours, "1.715e4" if text == "17150" else text)


def test_numbers_of_the_lispsm_paper():
    # Figure 6: near 1, far 100.
    for technique, numbers in {
        "uniform": (99, 1, 0.99, 100, 100, 9900),
        "perspective": (99, 100, 0.99, 1, 1, 99),
        "lispsm": (9.9, 1, 36 / 11, 10, 10, 99),
        "log": (np.log(100), 1, np.log(100), 1, 1, np.log(100)),
    }.items():
        w = cf.worst(near=1, far=100, technique=technique)
        close((w.max_dp_ds, w.max_dp_ds_z, w.min_dp_ds, w.min_dp_ds_z, w.max_dp_dt, w.storage), numbers)
        assert w.max_dp_dt_z == 1
    close(cf.dp_ds(100, near=1, far=100, technique="lispsm"), 9.9)


# Shapes and errors.


def test_one_number_is_a_float_and_arrays_broadcast():
    assert type(cf.dp_ds(1, near=1, far=100)) is float
    assert type(cf.dp_ds(np.float32(1), near=np.array(1), far=100, technique="log")) is float
    table = cf.dp_ds(np.array([1.0, 2.0])[:, None], near=1, far=[10, 100, 1000], n=[1, 11, np.inf])
    assert table.shape == (2, 3)
    assert table[1, 1] == cf.dp_ds(2, near=1, far=100, n=11)
    assert cf.dp_ds([], near=1, far=100).shape == (0,)
    assert cf.dp_ds([1, 2], near=1, far=100, technique="log").shape == (2,)
    assert cf.splits(near=[1, 2], far=100, count=3).shape == (2, 4)
    w = cf.worst(near=[1, 2], far=100, technique="lispsm")
    close(w.max_dp_ds, [cf.worst(near=n, far=100, technique="lispsm").max_dp_ds for n in (1, 2)])
    assert type(cf.worst(near=1, far=100, technique="psm").n) is float
    view = {"near": 1, "far": 100, "fov_y": 1.0}
    assert cf.F([1, 2, 3], theta=[[0.5], [1.0]], lam=0.2, **view).shape == (2, 3)
    assert cf.warp_lambda([0.0, 1.0, 3.0], **view).shape == (3,)
    ends = cf.F_ends([0.5, 1.0], lam=0.2, **view)
    assert ends.near.shape == ends.far.shape == (2,)
    # The caller's arrays are not written, and the result is no view of them.
    z = np.array([1.0, 2.0])
    result = cf.worst(near=z, far=100, technique="log").min_dp_ds_z
    result[0] = 7
    assert z[0] == 1


VIEW = {"near": 1, "far": 100, "fov_y": 1.0}


@pytest.mark.parametrize(
    ("call", "error", "match"),
    [
        (lambda: cf.dp_ds(1, near=2, far=1), ArgumentError, r"far: expected.*beyond near = 2\.0, got 1\.0"),
        (lambda: cf.dp_ds(1, near=1, far=1), ArgumentError, "far"),
        (lambda: cf.dp_ds(1, near=0, far=1), ArgumentError, "near: expected a finite depth above 0, got 0"),
        (lambda: cf.dp_ds(1, near=-1, far=1), ArgumentError, "near"),
        (lambda: cf.dp_ds(1, near=np.nan, far=1), ArgumentError, "near.*nan"),
        (lambda: cf.dp_ds(1, near=1, far=np.nan), ArgumentError, "far.*nan"),
        (lambda: cf.dp_ds(1, near=1, far=np.inf), ArgumentError, "far: expected a finite.*inf"),
        (lambda: cf.dp_ds(1, near=1, far=1e300), ArgumentError, "far.*times near"),
        (lambda: cf.dp_ds(np.nan, near=1, far=9), ArgumentError, r"z: expected a depth in \[1\.0, 9\.0\], got nan"),
        (lambda: cf.dp_ds(0.99, near=1, far=9), ArgumentError, r"\[1\.0, 9\.0\], got 0\.99"),
        (lambda: cf.dp_ds([2, 9.1], near=1, far=9), ArgumentError, r"\[1\.0, 9\.0\], got 9\.1"),
        (lambda: cf.dp_dt(10, near=1, far=9), ArgumentError, r"\[1\.0, 9\.0\]"),
        (lambda: cf.dp_ds(2, near=1, far=9, n=0.5), ArgumentError, r"n: expected 1\.0, the near depth, or more"),
        (lambda: cf.dp_ds(2, near=1, far=9, n=np.nan), ArgumentError, "n: .*nan"),
        (lambda: cf.dp_ds(2, near=1, far=9, technique="psm", n=3), ArgumentError, "n: expected none.*lispsm"),
        (lambda: cf.dp_ds(2, near=1, far=9, technique="nonsense"), UnknownNameError, "uniform, psm.*lispsm, log"),
        (lambda: cf.dp_ds(2, near=1, far=9, technique=sl.technique("psm")), ArgumentError, "technique: expected one"),
        (lambda: cf.dp_ds("2", near=1, far=9), ArgumentError, "z: expected an array of float64"),
        (lambda: cf.dp_ds(None, near=1, far=9), ArgumentError, "z: expected an array of float64"),
        (lambda: cf.dp_ds(True, near=1, far=9), ArgumentError, "z: expected an array of float64"),
        (lambda: cf.dp_ds(2 + 1j, near=1, far=9), ArgumentError, "z: expected an array of float64"),
        (lambda: cf.dp_ds([[1], [2, 3]], near=1, far=9), ArgumentError, "z: expected an array of float64"),
        (lambda: cf.dp_ds([2, 3], near=[1, 1, 1], far=9), ArgumentError, r"broadcast.*z \(2,\), near \(3,\)"),
        (lambda: cf.n_opt(2, 1), ArgumentError, "far"),
        (lambda: cf.worst(near=1, far=100, technique="glpr"), UnknownNameError, "lispsm"),
        (lambda: cf.storage_factor(ratio=1, fov_y=1, technique="psm"), ArgumentError, "ratio: expected above 1"),
        (lambda: cf.storage_factor(ratio=9, fov_y=0, technique="psm"), ArgumentError, "fov_y.*radians"),
        (lambda: cf.storage_factor(ratio=9, fov_y=60, technique="psm"), ArgumentError, "np.radians"),
        (lambda: cf.storage_factor(ratio=9, fov_y=1, technique="psm", splits=0), ArgumentError, "splits.*whole"),
        (lambda: cf.storage_factor(ratio=9, fov_y=1, technique="psm", splits=1.5), ArgumentError, "splits.*1.5"),
        (lambda: cf.splits(near=1, far=9, count=0), ArgumentError, "count: expected a whole number of 1 or more"),
        (lambda: cf.splits(near=1, far=9, count=2.5), ArgumentError, "count"),
        (lambda: cf.splits(near=1, far=9, count=[2, 3]), ArgumentError, "count: expected one number"),
        (lambda: cf.splits(near=1, far=9, count=True), ArgumentError, "count"),
        (lambda: cf.splits(near=9, far=1, count=2), ArgumentError, "far"),
        (lambda: cf.splits(near=1, far=9, count=2, scheme="nonsense"), UnknownNameError, "uniform, logarithmic, pract"),
        (lambda: cf.splits(near=1, far=9, count=2, scheme="practical", blend=2), ArgumentError, "blend.*in .0, 1"),
        (
            lambda: cf.dp_ds_in_split(2, near=1, far=9, split_near=0.5, split_far=3, technique="psm"),
            ArgumentError,
            "split_near: expected a depth from near = 1.0, got 0.5",
        ),
        (
            lambda: cf.dp_ds_in_split(2, near=1, far=9, split_near=3, split_far=2, technique="psm"),
            ArgumentError,
            "split_far: .*beyond split_near = 3",
        ),
        (
            lambda: cf.dp_ds_in_split(2, near=1, far=9, split_near=1, split_far=10, technique="psm"),
            ArgumentError,
            "split_far: expected a depth up to far = 9.0",
        ),
        (
            lambda: cf.dp_ds_in_split(5, near=1, far=9, split_near=1, split_far=3, technique="psm"),
            ArgumentError,
            r"z: .*\[1\.0, 3\.0\]",
        ),
        (lambda: cf.max_dp_ds_of_splits(near=1, far=9, count=0, technique="psm"), ArgumentError, "count"),
        (lambda: cf.warp_lambda(-0.1, **VIEW), ArgumentError, r"theta: expected an angle in \[0, pi\]"),
        (lambda: cf.warp_lambda(45, **VIEW), ArgumentError, "np.radians"),
        (lambda: cf.warp_lambda(np.nan, **VIEW), ArgumentError, "theta.*nan"),
        (lambda: cf.warp_lambda(1.0, **{**VIEW, "fov_y": np.pi}), ArgumentError, r"fov_y.*\(0, pi\)"),
        (lambda: cf.warp_lambda(1.0, **VIEW, technique="psm"), UnknownNameError, "gmnpr, lispsm, lispsm-delta-z, glpr"),
        (lambda: cf.warp_lambda(1.0, **VIEW, lambda_floor=0.2), ArgumentError, "lambda_floor: expected none.*glpr"),
        (lambda: cf.warp_lambda(1.0, **VIEW, technique="glpr", lambda_floor=-1), ArgumentError, "lambda_floor.*-1"),
        (lambda: cf.F(1, theta=0, lam=1, **VIEW), ArgumentError, "theta.*no warp axis"),
        (lambda: cf.F(1, theta=np.pi, lam=1, **VIEW), ArgumentError, "theta.*no warp axis"),
        (lambda: cf.F(1, theta=1, lam=0, **VIEW), ArgumentError, "lam: expected a number above 0.*warp_lambda"),
        (lambda: cf.F(1, theta=1, lam=-2, **VIEW), ArgumentError, "lam"),
        (lambda: cf.G(1, theta=1, lam=np.nan, **VIEW), ArgumentError, "lam.*nan"),
        (lambda: cf.F_log(0.5, theta=1, lam=1, **VIEW), ArgumentError, r"z.*\[1\.0, 100\.0\]"),
        (lambda: cf.F_ends(1, lam=1, near=1, far=100, fov_y=-1), ArgumentError, "fov_y"),
        (lambda: cf.F_least(4, lam=1, **VIEW), ArgumentError, "theta"),
        (lambda: cf.phi_offset(1, lam=1, near=5, far=1, fov_y=1), ArgumentError, "far"),
        (lambda: cf.dp_ds_on_surface(np.inf, 1, cos_alpha=1, cos_beta=1), ArgumentError, "F: expected"),
        (lambda: cf.dp_ds_on_surface(1, 0, cos_alpha=1, cos_beta=1), ArgumentError, "theta"),
        (lambda: cf.dp_ds_on_surface(1, 1, cos_alpha=-0.1, cos_beta=1), ArgumentError, "cos_alpha"),
        (lambda: cf.dp_ds_on_surface(1, 1, cos_alpha=1, cos_beta=0), ArgumentError, "cos_beta"),
        (lambda: cf.dp_ds_on_surface(1e300, 1, cos_alpha=1, cos_beta=1e-300), ArgumentError, "cos_beta"),
    ],
)
def test_bad_input_is_a_typed_error_that_helps(call, error, match):
    with pytest.raises(error, match=match):
        call()


def test_an_end_that_went_through_a_logarithm_is_still_the_end():
    z = np.exp(np.linspace(np.log(0.3), np.log(70.1), 9))
    assert np.isfinite(cf.dp_ds(z, near=0.3, far=70.1)).all()
    rounded = [np.nextafter(0.3, 0), np.nextafter(70.1, 100)]
    close(cf.dp_ds(rounded, near=0.3, far=70.1), cf.dp_ds([0.3, 70.1], near=0.3, far=70.1))


def test_it_is_found_from_the_package():
    assert sl.aliasing.closed_form.dp_ds(1, near=1, far=100, technique="lispsm") == pytest.approx(9.9, rel=EXACT)
    assert set(cf.__all__) <= set(dir(cf))
