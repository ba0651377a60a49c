"""Plots of tables: values where they belong, units on the axes, failures marked and counted."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest
from plot_support import legend, lone_axes, texts

import shadowlab as sl
from shadowlab import plot
from shadowlab.errors import ArgumentError
from shadowlab.plot.table_pareto import Way, front_of, ways_in

mpl.use("Agg")


def table():
    """Two views, three techniques, three sizes; psm fails in one view, tsm in all."""
    rows = []
    for view, factor in (("noon", 1), ("lamp", 3)):
        for technique, wrong in (("uniform", 400), ("psm", 100), ("tsm", 0)):
            for side in (64, 128, 256):
                failed = technique == "tsm" or (technique == "psm" and view == "lamp")
                rows.append({
                    "view": view, "technique": technique, "resolution": side, "bytes": 4 * side * side,
                    "misclassified": None if failed else factor * wrong * 64 // side,
                    "failure": "refuses the light" if failed else "",
                })  # fmt: skip
    return pd.DataFrame(rows).astype({"misclassified": "Int64"})


def line(ax, label):
    (found,) = [one for one in ax.lines if str(one.get_label()).startswith(label)]
    return found


def crosses(ax):
    return [one for one in ax.lines if one.get_marker() == "x" and len(one.get_xdata())]


def test_lines_are_means_and_failures_are_crosses():
    ax = plot.lines(table(), "resolution", "wrong", ax=lone_axes())
    uniform = line(ax, "uniform")
    assert list(uniform.get_xdata()) == [64, 128, 256]
    assert list(uniform.get_ydata()) == [800, 400, 200]
    assert list(line(ax, "psm").get_ydata()) == [100, 50, 25], "of the views that have a number"
    assert legend(ax) == ["uniform", "psm (3 of 6 runs failed)", "tsm (6 of 6 runs failed)"]
    assert [list(one.get_xdata()) for one in crosses(ax)] == [[64, 128, 256]] * 2
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("texels along each side of the map", "wrong pixels, count")
    assert ax.get_yscale() == "log"
    low, high = ax.get_ylim()
    foot = (np.log(25) - np.log(low)) / (np.log(high) - np.log(low))
    assert foot > max(one.get_ydata()[0] for one in crosses(ax)), "no cross lies among the values"


def test_a_band_reaches_from_the_least_to_the_largest():
    ax = plot.lines(table()[lambda rows: rows["technique"] == "uniform"], "resolution", "wrong", ax=lone_axes())
    (band,) = ax.collections
    edges = band.get_paths()[0].vertices
    assert {tuple(map(float, v)) for v in edges} >= {(64, 400), (64, 1200), (256, 100), (256, 300)}


def test_texts_stand_in_their_order_and_one_line_needs_no_name():
    ax = plot.lines(table()[lambda rows: rows["technique"] == "uniform"], "view", "wrong", None, lone_axes())
    assert [text.get_text() for text in ax.get_xticklabels()] == ["noon", "lamp"]
    (only,) = [one for one in ax.lines if len(one.get_xdata()) == 2]
    assert np.allclose(only.get_ydata(), [400 * 1.75 / 3, 1200 * 1.75 / 3])
    assert ax.get_legend() is None
    ax = plot.lines(table(), "view", "wrong", None, lone_axes())
    assert legend(ax) == ["9 of 18 runs failed"]


def test_cells_are_means_and_failed_ones_are_hatched():
    ax = plot.heatmap(table(), "view", "technique", "wrong", lone_axes())
    cells = np.ma.filled(ax.images[0].get_array().astype(float), np.nan)
    assert np.allclose(cells, [[700 / 3, 700], [175 / 3, np.nan], [np.nan, np.nan]], equal_nan=True)
    assert len(ax.patches) == 3
    assert all(patch.get_hatch() for patch in ax.patches)
    assert legend(ax) == ["9 of 18 runs failed"]
    assert [text.get_text() for text in ax.get_yticklabels()] == ["uniform", "psm", "tsm"]
    assert texts(ax) == ["233", "700", "58.3"]
    assert ax.figure.axes[1].get_ylabel() == "wrong pixels, count"


def test_a_cell_of_which_some_failed_has_a_cross():
    ax = plot.heatmap(table(), "resolution", "technique", "wrong", lone_axes())
    assert len(crosses(ax)) == 3
    assert len(ax.patches) == 3
    assert [text.get_text() for text in ax.get_xticklabels()] == ["64", "128", "256"]
    assert len(legend(ax)) == 2
    few = table()[lambda rows: ~((rows["view"] == "lamp") & (rows["resolution"] == 64))]
    cells = plot.heatmap(few, "resolution", "view", "wrong", lone_axes()).images[0].get_array()
    assert np.ma.getmaskarray(cells).tolist() == [[False] * 3, [True, False, False]], "nothing was run there"


def test_the_front_is_of_ways_that_none_beats():
    ax = plot.pareto(table(), ax=lone_axes())
    front = line(ax, "no other")
    assert list(front.get_xdata()) == [16384, 65536, 65536, 262144, 262144]
    assert list(front.get_ydata()) == [800, 800, 400, 400, 200]
    assert texts(ax) == ["uniform 64²", "uniform 128²", "uniform 256²"]
    assert [len(one.get_xdata()) for one in crosses(ax)] == [3], "psm has no number in every view"
    assert legend(ax)[:3] == ["uniform", "psm (3 of 6 runs failed)", "tsm (6 of 6 runs failed)"]
    assert ax.get_xlabel() == "memory of the maps, bytes"
    assert ax.get_ylabel() == "wrong pixels, count, mean of the views"
    assert [text.get_text() for text in ax.get_xticklabels() if text.get_text()][:2] != []
    noon = plot.pareto(table()[lambda rows: rows["view"] == "noon"], ax=lone_axes())
    assert texts(noon) == ["psm 64²", "psm 128²", "psm 256²"]


@pytest.mark.parametrize("seed", range(20))
def test_a_front_is_that_of_all_pairs(seed):
    rng = np.random.default_rng(seed)
    ways = [Way("", str(i), *map(float, rng.integers(0, 12, 2)), 0, 1) for i in range(40)]
    wanted = {
        (a.cost, a.error)
        for a in ways
        if not any(b.cost <= a.cost and b.error <= a.error and (b.cost, b.error) != (a.cost, a.error) for b in ways)
    }
    found = [(way.cost, way.error) for way in front_of(ways)]
    assert set(found) == wanted
    assert found == sorted(found)


def test_a_budget_is_one_way_whatever_the_side_of_its_maps():
    rows = pd.DataFrame(
        {"view": ["a", "b"], "technique": ["z"] * 2, "memory": [1024] * 2, "resolution": [16, 11],
         "misclassified": [1, 3], "bytes": [1024, 968]}
    )  # fmt: skip
    (way,) = ways_in(rows, "bytes", "misclassified", "technique")
    assert (way.name, way.cost, way.error, way.failed, way.rows) == ("z", 996.0, 2.0, 0, 2)


def test_places_that_differ_by_rounding_are_one():
    rows = pd.DataFrame(
        {"technique": ["a"] * 4, "angle": [0.1 + 0.2, 0.3, 0.6, 0.1 * 6], "misclassified": [1, 3, 5, 7]}
    )
    ax = plot.lines(rows, "angle", "wrong", ax=lone_axes())
    assert list(line(ax, "a").get_ydata()) == [2.0, 6.0]
    assert [text.get_text() for text in ax.get_xticklabels()] == ["0.3", "0.6"]


def test_memory_is_the_budget_where_every_row_has_one():
    rows = table().assign(memory=1 << 14)
    assert plot.pareto(rows, ax=lone_axes()).get_xlabel() == "budget of depth texels, bytes"
    two = pd.concat([rows, rows.assign(memory=1 << 16, misclassified=lambda t: t["misclassified"] // 2)])
    assert list(line(plot.pareto(two, ax=lone_axes()), "no other").get_xdata()) == [1 << 14, 1 << 16, 1 << 16]
    heat = plot.heatmap(two, "memory", "technique", "wrong", lone_axes())
    assert [text.get_text() for text in heat.get_xticklabels()] == ["16 KiB", "64 KiB"]
    some = rows.assign(memory=[None, *[1 << 14] * (len(rows) - 1)])
    assert plot.pareto(some, ax=lone_axes()).get_xlabel() == "memory of the maps, bytes"


def test_tables_of_sweeps_studies_and_advices_are_drawn():
    scene = sl.library.scene("robots")
    how = {"size": (48, 27), "renderer": "cpu", "progress": False}
    space = {
        "scene": "@robots",
        "technique": ["uniform", "lispsm"],
        "lispsm.near_factor": [1.0, 2.0],
        "resolution": [32, 48],
    }
    sweep = sl.sweep(space, **how)
    study = sl.compare(scene, scene.camera, scene.light, ["uniform", "lispsm"], resolution=[32, 48], **how)
    advice = sl.advise(
        scene, scene.camera, scene.light, memory=["4 KiB", "16 KiB"], techniques=["uniform", "lispsm"], **how
    )
    assert len(legend(plot.lines(sweep, "resolution", "wrong", "spec", lone_axes()))) == 3
    cells = plot.heatmap(sweep, "lispsm.near_factor", "technique", "texel_p95", lone_axes())
    assert cells.get_xlabel() == "lispsm.near_factor"
    for rows in (sweep, study.table, advice.table, advice.runs):
        assert "no other is better in both" in legend(plot.pareto(rows, ax=lone_axes()))
        assert plot.lines(rows, "resolution", "wrong", ax=lone_axes()).lines
        assert plot.heatmap(rows, "resolution", "technique", "wrong", lone_axes()).images


@pytest.mark.parametrize("draw", [
    lambda rows, ax: plot.lines(rows, "resolution", "wrong", ax=ax),
    lambda rows, ax: plot.heatmap(rows, "resolution", "technique", "wrong", ax),
    lambda rows, ax: plot.pareto(rows, ax=ax),
])  # fmt: skip
def test_tables_without_a_number_say_so(draw):
    failed = table()[lambda rows: rows["technique"] == "tsm"]
    assert "no run has a number" in texts(draw(failed, lone_axes()))[0]
    assert texts(draw(table()[:0], lone_axes())) == ["no rows"]
    infinite = table().assign(misclassified=np.inf)
    draw(infinite, lone_axes()).figure.canvas.draw()
    zero = table().assign(misclassified=0, failure="")
    draw(zero, lone_axes()).figure.canvas.draw()


def test_what_cannot_be_drawn_names_the_argument():
    for call, said in (
        (lambda: plot.lines(1, "a", "b"), "table: expected a pandas table"),
        (lambda: plot.lines(table(), "sizes", "wrong"), "table, x: expected columns sizes; there is no sizes among"),
        (lambda: plot.lines(table(), "view", 5), "y: expected names of columns"),
        (lambda: plot.lines(table(), "view", "technique"), "technique: expected a column of numbers"),
        (lambda: plot.heatmap(table(), "view", "technique", "view"), "view: expected a column of numbers"),
        (lambda: plot.pareto(table(), cost="price"), "table, cost: expected columns price"),
        (lambda: plot.pareto(table(), hue=None), "hue: expected names"),
        (lambda: plot.pareto(table(), title=3), "title: expected text"),
    ):
        with pytest.raises(ArgumentError, match=said):
            call()


# Texts that axes take for something else, or cannot draw, by what they show of them.
ODD_NAMES = {
    "_left out by legends": " _left out by legends", r"a $\frac$ b": r"a \$\frac\$ b", "5$ of 6": "5$ of 6",
    "bell\x07": "bell\N{REPLACEMENT CHARACTER}", "half \ud800": "half \N{REPLACEMENT CHARACTER}",
    r"$\alpha$": r"$\alpha$",
}  # fmt: skip


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("draw", ["lines", "heatmap", "pareto"])
def test_texts_of_tables_are_drawn_as_they_are_written(draw):
    names = list(ODD_NAMES)
    rows = pd.DataFrame({
        "scene": "a", "technique": names * 2, "memory": [1000.0] * len(names) + [2000.0] * len(names),
        "misclassified": np.arange(1.0, 2 * len(names) + 1), "failure": "",
    })  # fmt: skip
    ax = lone_axes()
    if draw == "lines":
        plot.lines(rows, "memory", "misclassified", "technique", ax)
        assert legend(ax) == list(ODD_NAMES.values())
    elif draw == "heatmap":
        plot.heatmap(rows, "memory", "technique", "misclassified", ax)
        assert [label.get_text() for label in ax.get_yticklabels()] == list(ODD_NAMES.values())
    else:
        plot.pareto(rows, "memory", "misclassified", ax=ax)
    ax.figure.canvas.draw()
