"""Plots of errors: axes come back, say units, and show what the numbers are."""

from __future__ import annotations

import doctest
import importlib

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
    footprint,
    heights,
    image,
    legend,
    lone_axes,
    texts,
    view,
)

import shadowlab as sl
from shadowlab import plot
from shadowlab.pictures.errors import error_colours

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


CALLS = {
    "error_along_view": lambda ax: plot.error_along_view(CURVES, ax, measured={"psm": CURVES["psm"]}, **VIEW),
    "error_map": lambda ax: plot.error_map(image(), ax, gbuffer=view(20, 30), light=SUN, title="t"),
    "warped_view": lambda ax: plot.warped_view(LISPSM, ROBOTS.camera, ax),
    "light_view": lambda ax: plot.light_view(LISPSM, ROBOTS.camera, ROBOTS, ax),
    "lattice": lambda ax: plot.lattice(SEEN, ROBOTS.camera, ROBOTS.light, LISPSM, ax),
    "error_histogram": lambda ax: plot.error_histogram({"a": image(), "b": image(seed=1)}, ax),
    "error_histogram by depth": lambda ax: plot.error_histogram({"a": image()}, ax, by_depth=2),
    "error_histogram of summaries": lambda ax: plot.error_histogram({"a": image().summary(), "b": image()}, ax),
    "error_by_depth": lambda ax: plot.error_by_depth({"a": image(), "b": image(seed=1).summary()}, ax),
    "error_over_angle": lambda ax: plot.error_over_angle(angle_table(), ax),
    "error_over_angle ratio": lambda ax: plot.error_over_angle(angle_table(), ax, baseline="t3"),
    "causes": lambda ax: plot.causes(CAUSES, ax),
    "cause_map": lambda ax: plot.cause_map(view(), SUN, RIGHT, np.arange(48).reshape(6, 8) % 6 - 1, ax),
    "drift": lambda ax: plot.drift(DRIFT, ax),
    "flips": lambda ax: plot.flips(sl.aliasing.Temporal(DRIFT, FRAMES), ax),
}
PICTURES = ("error_map", "lattice", "cause_map")


@pytest.mark.parametrize("name", CALLS)
def test_axes_come_back_drawn_and_labelled(name, ax):
    import matplotlib.pyplot as plt

    assert CALLS[name](ax) is ax
    assert not plt.get_fignums()  # nothing of ours is left with pyplot
    ax.figure.canvas.draw()
    if name in PICTURES:
        assert len(ax.images) == 1
        return
    units = ("pixel", "world units", "degrees", "texels per frame", "number", "NDC", "%", "count", "over that of")
    for label in (ax.get_xlabel(), ax.get_ylabel()):
        assert any(unit in label.replace("\n", " ") for unit in units) or label == "", label
    if name != "causes":  # rows have names
        assert ax.get_ylabel()
    assert ax.get_xlabel()


@pytest.mark.parametrize("name", CALLS)
def test_no_label_lies_over_another(name, ax):
    CALLS[name](ax)
    ax.figure.canvas.draw()
    boxes = [ax.xaxis.label, ax.yaxis.label, ax.title]
    for axis in (ax.xaxis, ax.yaxis):
        low, high = sorted(axis.get_view_interval())
        ticks = zip(axis.get_ticklocs(), axis.get_ticklabels(), strict=True)
        boxes += [text for place, text in ticks if low <= place <= high]
    boxes = [t.get_window_extent() for t in boxes if t.get_text() and t.get_visible()]
    if ax.get_legend():
        boxes.append(ax.get_legend().get_window_extent())
    whole = ax.figure.bbox
    for i, a in enumerate(boxes):
        assert whole.x0 - 2 <= a.x0 <= a.x1 <= whole.x1 + 2
        assert whole.y0 - 2 <= a.y0 <= a.y1 <= whole.y1 + 2
        for b in boxes[:i]:
            across = min(a.x1, b.x1) - max(a.x0, b.x0)
            assert across < 1 or min(a.y1, b.y1) - max(a.y0, b.y0) < 1


@pytest.mark.parametrize("name", CALLS)
def test_axes_are_made_where_none_are_given(name):
    assert isinstance(CALLS[name](None), mpl.axes.Axes)


def test_the_figure_of_the_paper(ax):
    plot.error_along_view(CURVES, ax, **VIEW)
    assert ax.get_xscale() == ax.get_yscale() == "log"
    assert ax.get_xlim() == (1, 100)
    for line, (z, values) in zip(ax.lines, CURVES.values(), strict=True):
        np.testing.assert_array_equal(line.get_xydata(), np.column_stack([z, values]))
    low, high = ax.get_ylim()
    assert low < 0.99 < 99 < high < 200
    assert legend(ax) == list(CURVES)
    kinds = [(line.get_color(), str(line._unscaled_dash_pattern)) for line in ax.lines]
    assert len({c for c, _ in kinds}) == len({d for _, d in kinds}) == 3


def test_measured_dots_take_the_colour_of_their_curve(ax):
    other = (np.array([3.0]), np.array([4.0]))
    plot.error_along_view(CURVES, ax, measured={"lispsm": CURVES["lispsm"], "other": other}, **VIEW)
    lines = {line.get_label(): line for line in ax.lines}
    assert lines["lispsm, measured"].get_color() == lines["lispsm"].get_color()
    assert lines["lispsm, measured"].get_linestyle() == "None"
    assert lines["other, measured"].get_color() not in [lines[label].get_color() for label in CURVES]


def test_gaps_and_single_depths_are_drawn(ax):
    gaps = (Z, np.where(Z > 10, np.inf, 2.0))
    plot.error_along_view({"gap": gaps, "one": (5.0, 3.0), "none": (Z, Z * np.nan)}, ax, **VIEW)
    assert np.isnan(ax.lines[0].get_ydata()[-1])
    ax.figure.canvas.draw()


@pytest.mark.parametrize("colorbar", [True, False])
def test_the_error_map_shows_the_picture_and_its_scale(ax, colorbar):
    e = image()
    plot.error_map(e, ax, colorbar=colorbar)
    np.testing.assert_array_equal(ax.images[0].get_array(), plot.error_picture(e))
    assert legend(ax) == ["in no map", "averted from the light or out of its reach", "nothing seen"]
    bars = [a for a in ax.figure.axes if a is not ax]
    assert len(bars) == colorbar
    for bar in bars:
        assert bar.get_ylabel() == "longest extent of a texel, pixels per texel"
        assert [t.get_text() for t in bar.get_yticklabels()] == ["0.1", "0.2", "0.5", "1", "2", "5", "10"]


def test_the_bar_has_the_colours_of_the_picture(ax):
    plot.error_map(image(), ax)
    (bar,) = (a for a in ax.figure.axes if a is not ax)
    mappable = bar._colorbar.mappable
    values = np.array([0.11, 0.5, 0.99, 1.01, 3.0, 9.9])
    drawn = np.rint(255 * mappable.to_rgba(values)[:, :3])
    wanted = error_colours(values).astype(float)
    # A step of the scale apart, since both round.
    assert np.abs(drawn - wanted).max() <= 4


def test_only_reasons_that_occur_are_explained(ax):
    plot.error_map(footprint([[1.0, 2.0]], [[0, -2]]), ax)
    assert legend(ax) == ["averted from the light or out of its reach"]
    plot.error_map(footprint([[1.0, 2.0]]), other := lone_axes())
    assert other.get_legend() is None


def test_the_warped_view_has_a_regular_lattice(ax):
    plot.warped_view(LISPSM, ROBOTS.camera, ax, every=32)
    assert ax.get_xlim() == ax.get_ylim() == (-1, 1)
    lattice = np.array(ax.collections[0].get_segments())
    np.testing.assert_allclose(np.unique(lattice), [-1, -0.5, 0, 0.5, 1])
    assert "32 of 128 texels" in ax.get_xlabel()
    depth = sl.Renderer("cpu").shadow_map(ROBOTS, LISPSM)
    plot.warped_view(LISPSM, ROBOTS.camera, ax, depth=depth)
    assert ax.images[0].get_extent() == [-1, 1, -1, 1]


def test_the_light_view_holds_the_whole_map(ax):
    plot.light_view(LISPSM, ROBOTS.camera, ROBOTS.bounds, ax, light=ROBOTS.light, every=32)
    lines = np.array(ax.collections[1].get_segments())
    assert len(lines) == 2 * 5  # three between, and the edges
    for axis, (low, high) in enumerate((ax.get_xlim(), ax.get_ylim())):
        assert low <= lines[..., axis].min() < lines[..., axis].max() <= high
    # A warp: cells near the eye are smaller.
    rungs = np.sort(lines[5:, 0, 1])
    assert (np.diff(rungs, n=2) > 0).all()
    assert "eye" in texts(ax)


def test_all_maps_of_a_division_are_drawn(ax):
    p = sl.technique("z_partition").parameterize(ROBOTS, ROBOTS.camera, ROBOTS.light, resolution=64)
    plot.light_view(p, ROBOTS.camera, ROBOTS, ax, map=None)
    assert legend(ax) == [f"map {i}" for i in range(4)]


def test_shares_of_a_histogram_sum_to_the_whole(ax):
    e = image()
    major = np.where(e.map >= 0, e.major, np.nan)
    major[0, 0] = 1e9 if e.map[0, 0] >= 0 else np.nan
    plot.error_histogram({"a": e, "far": footprint(major, e.map, e.depth)}, ax)
    for patch in ax.patches:
        np.testing.assert_allclose(heights(patch).sum(), 100.0)
        assert 1.0 in patch.get_data().edges
    assert ("beyond" in ax.get_xlabel()) == bool(e.map[0, 0] >= 0)
    assert "one texel a pixel" in texts(ax)


@pytest.mark.parametrize("quantity", plot.distributions.QUANTITIES)
def test_all_quantities_have_a_histogram(ax, quantity):
    plot.error_histogram({"a": image()}, ax, quantity=quantity)
    np.testing.assert_allclose(heights(ax.patches[0]).sum(), 100.0)
    assert ax.get_xlabel().startswith(plot.distributions.QUANTITIES[quantity])


def test_a_change_of_one_pixel_changes_the_histogram(ax):
    major = np.full((10, 10), 2.1)
    plot.error_histogram({"a": footprint(major)}, ax)
    before = heights(ax.patches[0]).copy()
    major[4, 4] = 1.1
    other = plot.error_histogram({"a": footprint(major)})
    after = heights(other.patches[0])
    assert before.max() == 100.0
    assert sorted(after[after > 0]) == pytest.approx([1.0, 99.0])


def test_bands_by_depth_are_those_of_the_summary(ax):
    e = image()
    plot.error_by_depth({"a": e}, ax, bands=5)
    rows = e.summary(bands=5).bands
    np.testing.assert_allclose(ax.lines[0].get_ydata(), rows["mean"])
    np.testing.assert_allclose(ax.lines[1].get_ydata(), rows["p95"])
    np.testing.assert_allclose(ax.lines[0].get_xdata(), np.sqrt(rows["near"] * rows["far"]))
    plot.error_histogram({"a": e}, other := lone_axes(), by_depth=True)
    assert len(other.patches) == 3


def test_one_depth_is_one_band(ax):
    plot.error_by_depth({"a": footprint(np.full((3, 4), 2.0))}, ax)
    assert ax.lines[0].get_ydata().tolist() == [2.0]
    plot.error_histogram({"a": footprint([[2.0]])}, other := lone_axes(), by_depth=3)
    for axes in (ax, other):
        axes.figure.canvas.draw()


def test_twelve_techniques_differ_in_colour_marker_and_line(ax):
    plot.error_over_angle(angle_table(), ax)
    lines = ax.lines
    assert len({line.get_marker() for line in lines}) == 12
    assert len({(line.get_color(), str(line._unscaled_dash_pattern)) for line in lines}) == 12
    assert legend(ax) == [f"t{i}" for i in reversed(range(12))]  # as the lines end
    assert ax.get_xlabel() == "angle between light and view, degrees"


def test_ratios_have_the_baseline_at_one(ax):
    table = angle_table(3).replace({"technique": {"t1": "uniform"}})
    plot.error_over_angle(table, ax, baseline="uniform")
    np.testing.assert_allclose(ax.lines[0].get_ydata(), 0.5)
    np.testing.assert_allclose(ax.lines[1].get_ydata(), 1.5)
    assert "no warp" in texts(ax)
    assert "over that of uniform" in ax.get_ylabel().replace("\n", " ")
    other = plot.error_over_angle(table, baseline="t0")
    assert "as t0" in texts(other)


def test_failed_runs_are_gaps_and_columns_have_units(ax):
    table = angle_table(2).rename(columns={"texel_p95": "extent_px"}).astype({"extent_px": float})
    table.loc[1, "extent_px"], table.loc[5, "extent_px"] = np.nan, np.inf
    plot.error_over_angle(table, ax, y="extent_px")
    assert np.isnan(ax.lines[0].get_ydata()).tolist() == [False, True, False, False]
    assert np.isnan(ax.lines[1].get_ydata()).tolist() == [False, True, False, False]
    assert ax.get_ylabel() == "extent, pixels"


def test_bars_of_causes_are_stacked(ax):
    plot.causes(CAUSES, ax)
    assert len(ax.patches) == 8
    assert len({p.get_hatch() for p in ax.patches}) == 4
    ends = [p.get_x() + p.get_width() for p in ax.patches]
    assert max(ends) == 315
    assert texts(ax) == ["315", "50"]
    assert [t.get_text() for t in ax.get_yticklabels()] == ["uniform", "lispsm"]
    assert ax.get_ylim()[0] > ax.get_ylim()[1]  # the first on top


def test_a_cause_that_is_absent_counts_as_none(ax):
    table = CAUSES[["technique", "edge"]].astype({"edge": float})
    table.loc[0, "edge"] = np.nan
    plot.causes(table, ax)
    assert texts(ax) == ["not measured", "40"]
    assert legend(ax) == ["edge: a silhouette displaced"]


def test_the_cause_map_counts(ax):
    codes = np.zeros((6, 8), int)
    codes[0, :3], codes[1], codes[2, 0] = 2, -1, 4
    plot.cause_map(view(), SUN, RIGHT, codes, ax)
    np.testing.assert_array_equal(ax.images[0].get_array(), plot.cause_picture(view(), SUN, RIGHT, codes))
    assert legend(ax) == ["acne: 0 px", "edge: 3 px", "leak: 0 px", "missing: 1 px", "other: 0 px", "not compared"]


def test_flips_stand_beside_wrong_pixels_and_new_maps_are_ringed(ax):
    plot.flips(sl.aliasing.Temporal(DRIFT, FRAMES), ax)
    lines = [np.column_stack(line.get_data()) for line in ax.lines]
    # Flips since the frame before, each with its wrong pixels; rings where the one that keeps its maps made new ones.
    np.testing.assert_array_equal(lines[0], [(1, 10), (2, 20), (3, 30)])
    np.testing.assert_array_equal(lines[1], [(0, 30), (1, 31), (2, 32), (3, 33)])
    np.testing.assert_array_equal(lines[2], [(1, 0), (2, 0), (3, 0)])
    np.testing.assert_array_equal(lines[4], [(2, 0)])
    words = [text.get_text() for text in ax.get_legend().get_texts()]
    assert words[:2] == ["a\n20 flips, 32 wrong", "b\n0 flips, 42 wrong"]
    assert words[2:] == ["flips since the frame before", "wrong pixels", "new maps"]


def test_drift_has_rms_and_largest_of_each_label(ax):
    plot.drift(DRIFT, ax)
    assert ax.lines[0].get_ydata().tolist() == [0.1, 0.2, 0.3]
    assert ax.lines[1].get_ydata().tolist() == [0.2, 0.3, 0.5]
    assert legend(ax)[:2] == ["a\n20 flips a frame", "b\n0 flips a frame"]
    assert ax.get_yscale() == "linear"
    wide = DRIFT.assign(drift_rms=[0.1, 0.2, 0.3, 0.002, 0.0, np.nan])
    assert plot.drift(wide).get_yscale() == "symlog"


@pytest.mark.parametrize("module", ["causes", "curves", "distributions", "eye_views", "light_views", "temporal"])
def test_examples_run(module):
    result = doctest.testmod(importlib.import_module(f"shadowlab.plot.{module}"))
    assert result.attempted
    assert not result.failed


def test_every_name_of_the_package_is_there():
    assert all(hasattr(plot, name) for name in plot.__all__)
    assert sorted(plot.__all__) == plot.__all__


def test_causes_of_a_study_and_of_causes_by_label(ax):
    import shadowlab as sl

    scene = sl.library.scene("robots")
    study = sl.compare(
        scene, scene.camera, scene.light, ["uniform"], resolution=[64, 128], size=(64, 36), progress=False
    )
    plot.causes(study, ax)
    assert [t.get_text() for t in ax.get_yticklabels()] == ["uniform, 64²", "uniform, 128²"]
    other = plot.causes({"coarse": study.causes["uniform", 64]}, ax.figure.add_subplot())
    assert [t.get_text() for t in other.get_yticklabels()] == ["coarse"]
    with pytest.raises(sl.errors.ArgumentError, match="table"):
        plot.causes({}, ax)
