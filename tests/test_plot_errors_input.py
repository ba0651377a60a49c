"""Plots of errors of nothing, and of what they cannot draw: words on the axes, or an error that says what to do."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import pytest
from plot_support import (
    CAUSES,
    CURVES,
    DRIFT,
    FRAMES,
    LISPSM,
    RIGHT,
    ROBOTS,
    SEEN,
    SUN,
    VIEW,
    Z,
    angle_table,
    image,
    legend,
    lone_axes,
    texts,
    view,
)

import shadowlab as sl
from shadowlab import plot
from shadowlab.errors import ArgumentError

mpl.use("Agg")
# A warning of numpy or matplotlib is a failure: nothing that is not a number reaches an artist.
pytestmark = pytest.mark.filterwarnings("error")


@pytest.fixture(autouse=True)
def no_figure_stays():
    import matplotlib.pyplot as plt

    plt.close("all")
    yield
    plt.close("all")


@pytest.fixture
def ax():
    return lone_axes()


NOTHING = {
    "error_map": lambda ax: plot.error_map(image(measured=False), ax),
    "error_histogram": lambda ax: plot.error_histogram({"a": image(measured=False)}, ax),
    "error_histogram by depth": lambda ax: plot.error_histogram({"a": image(measured=False)}, ax, by_depth=True),
    "error_histogram of summaries": lambda ax: plot.error_histogram({"a": image(measured=False).summary()}, ax),
    "error_by_depth": lambda ax: plot.error_by_depth({"a": image(measured=False)}, ax),
    "error_along_view": lambda ax: plot.error_along_view({"a": (Z, Z * np.nan)}, ax, **VIEW),
    "error_over_angle": lambda ax: plot.error_over_angle(angle_table().iloc[:0], ax),
    "error_over_angle failed": lambda ax: plot.error_over_angle(
        angle_table(2).assign(texel_p95=np.nan), ax, baseline="t0"
    ),
    "causes": lambda ax: plot.causes(CAUSES.iloc[:0], ax),
    "cause_map": lambda ax: plot.cause_map(view(), SUN, RIGHT, np.full((6, 8), -1), ax),
    "drift": lambda ax: plot.drift(DRIFT.iloc[:0], ax),
    "flips": lambda ax: plot.flips(sl.aliasing.Temporal(DRIFT.iloc[:0], FRAMES.iloc[:0]), ax),
    "flips failed": lambda ax: plot.flips(
        sl.aliasing.Temporal(DRIFT.assign(flips=np.nan), FRAMES.assign(misclassified=np.nan, refit=None)), ax
    ),
    "drift failed": lambda ax: plot.drift(DRIFT.assign(drift_rms=np.nan, drift_max=np.nan, flips=np.nan), ax),
}


@pytest.mark.parametrize("name", NOTHING)
def test_axes_say_that_nothing_was_measured(name, ax):
    NOTHING[name](ax)
    ax.figure.canvas.draw()
    said = " ".join([*texts(ax), *(legend(ax) if ax.get_legend() else [])])
    assert any(word in said for word in ("no ", "averted")), said


@pytest.mark.parametrize("name", ["error_histogram", "error_by_depth"])
def test_one_that_is_not_measured_says_so_beside_others(name, ax):
    getattr(plot, name)({"a": image(), "b": image(measured=False)}, ax)
    assert "b: no pixel looks up a texel" in legend(ax)


WRONG = [
    (lambda: plot.error_along_view({}, **VIEW), "curves: expected a dictionary .* got an empty one"),
    (lambda: plot.error_along_view([1], **VIEW), "curves: expected a dictionary"),
    (lambda: plot.error_along_view({"a": (Z, Z[:-1])}, **VIEW), r"curves\['a'\]: expected as many depths as values"),
    (lambda: plot.error_along_view({"a": 3}, **VIEW), r"curves\['a'\]: expected depths and values"),
    (lambda: plot.error_along_view({"a": (Z, -Z)}, **VIEW), "expected positive numbers"),
    (lambda: plot.error_along_view({"a": (Z * np.nan, Z)}, **VIEW), "expected positive numbers"),
    (lambda: plot.error_along_view(CURVES, near=None, far=1), "near: expected a finite number above 0"),
    (lambda: plot.error_along_view(CURVES, near=[], far=1), "near: expected a finite number above 0"),
    (
        lambda: plot.error_by_depth({"a": image()}, bands=(5, -1)),
        "bands: expected a whole number from 1 to 10000 or at least two rising depths",
    ),
    (lambda: plot.error_along_view(CURVES, near=5, far=1), "expected 0 < near < far"),
    (lambda: plot.error_along_view(CURVES, measured={}, **VIEW), "measured: expected a dictionary"),
    (lambda: plot.error_map(image(), values=np.ones(3)), "values: expected numbers of shape"),
    (lambda: plot.error_histogram({}), "footprints: expected a dictionary"),
    (lambda: plot.error_histogram({"a": 3}), "footprints: expected a Footprint of 'a'"),
    (lambda: plot.error_histogram({"a": image()}, quantity="size"), "quantity: expected one of major, minor"),
    (lambda: plot.error_histogram({"a": image().summary()}, quantity="minor"), "expected footprints for minor"),
    (lambda: plot.error_histogram({"a": image().summary()}, by_depth=True), "expected footprints for bands"),
    (lambda: plot.error_histogram({"a": image(), "b": image()}, by_depth=True), "by_depth: expected one footprint"),
    (lambda: plot.error_histogram({"a": image()}, by_depth=-1), "by_depth: expected a whole number"),
    (lambda: plot.error_by_depth({"a": None}), "footprints: expected a Footprint of 'a'"),
    (
        lambda: plot.error_by_depth({"a": image()}, bands=10**9),
        "bands: expected a whole number from 1 to 10000 or at least two rising depths",
    ),
    (lambda: plot.error_histogram({"a": image()}, by_depth=10**9), "by_depth: expected at most 100"),
    (lambda: plot.light_view(LISPSM, ROBOTS.camera, ROBOTS, lone_axes(), renderer=3), "renderer: expected a Renderer"),
    (
        lambda: plot.error_by_depth({"a": image()}, bands=0),
        "bands: expected a whole number from 1 to 10000 or at least two rising depths",
    ),
    (lambda: plot.error_over_angle([1, 2]), "table: expected a pandas table"),
    (
        lambda: plot.error_over_angle(angle_table(), y="worst"),
        "there is no worst among technique, angle_deg, texel_p95",
    ),
    (lambda: plot.error_over_angle(angle_table(), baseline="lispsm"), "baseline: expected one of t0, t1"),
    (lambda: plot.error_over_angle(angle_table().assign(angle_deg=1)), "several of 't0' at 1"),
    (lambda: plot.error_over_angle(angle_table().assign(texel_p95="x")), "texel_p95: expected a column of numbers"),
    (lambda: plot.causes(CAUSES[["technique"]]), "there is no acne, edge, leak, missing"),
    (lambda: plot.causes(CAUSES.assign(edge=-1)), "got a negative one"),
    (lambda: plot.cause_map(view(), SUN, RIGHT, np.zeros((2, 2), np.int8)), "cause_image: expected shape"),
    (lambda: plot.flips(DRIFT), "temporal: expected a Temporal"),
    (lambda: plot.drift(DRIFT, "Drift"), "ax: expected matplotlib axes, got 'Drift'; give title="),
    (lambda: plot.error_map(image(), "Error"), "ax: expected matplotlib axes"),
    (lambda: plot.drift(DRIFT.drop(columns="flips")), "there is no flips"),
    (lambda: plot.drift(DRIFT.assign(drift_max=-1.0)), "got a negative one"),
    (lambda: plot.warped_view(LISPSM, ROBOTS.camera, map=1), "map: expected one from 0 to 0, got 1"),
    (lambda: plot.warped_view(LISPSM, ROBOTS.camera, depth=np.ones(3)), "depth: expected a shadow map"),
    (lambda: plot.warped_view(LISPSM, ROBOTS.camera, every=0), "every: expected a whole number"),
    (lambda: plot.light_view(LISPSM, ROBOTS.camera, ROBOTS.bounds), "light: expected the light"),
    (
        lambda: plot.light_view(LISPSM, ROBOTS.camera, 3, light=ROBOTS.light),
        "scene: expected a Scene, or finite bounds",
    ),
    (
        lambda: plot.light_view(LISPSM, ROBOTS.camera, ROBOTS, light=sl.PointLight((0, 1, 0), range=3), map=None),
        "choose",
    ),
    (lambda: plot.lattice(SEEN, ROBOTS.camera, ROBOTS.light, LISPSM, every=0), "every: expected a whole number"),
]


@pytest.mark.parametrize(("call", "says"), WRONG, ids=lambda v: v if isinstance(v, str) else "")
def test_wrong_arguments_say_what_was_expected(call, says):
    import matplotlib.pyplot as plt

    with pytest.raises(ArgumentError, match=says):
        call()
    assert not plt.get_fignums()  # refused before a figure is made


def test_results_are_taken_as_they_are(ax):
    temporal, angles = sl.aliasing.Temporal(DRIFT, FRAMES), sl.aliasing.LightAngles(angle_table())
    assert plot.drift(temporal, ax) is ax
    assert len(plot.error_over_angle(angles, lone_axes()).lines) == 12
    assert plot.error_histogram(image(), lone_axes()).patches
    assert plot.error_by_depth(image(), lone_axes()).lines
    codes = np.zeros((6, 8), np.int8)
    codes[2, 3] = 1
    found = sl.aliasing.Causes(codes, np.zeros((6, 8), np.float32), np.ones((6, 8)), 0)
    assert "acne: 1 px" in legend(plot.cause_map(view(), SUN, RIGHT, found, lone_axes()))
