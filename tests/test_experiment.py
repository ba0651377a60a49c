"""The scene-optimal experiment: counts that are `evaluate`'s, sums beside the normal map, kept rows, bounds."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest

import shadowlab as sl
from shadowlab.errors import ArgumentError, StoreError, UnknownNameError
from shadowlab.experiments import scene_optimal, scene_optimal_views
from shadowlab.experiments.scene_optimal_table import FIGURES, NORMAL, OPTIMAL, PUBLISHED
from shadowlab.reports import scene_optimal as report
from shadowlab.trace import Truth

PIXELS, SIDE, REFERENCE = 128, 96, 512
PARTITION = "z_partition:count=4,inner=lispsm"
TECHNIQUES = (NORMAL, "lispsm", PUBLISHED, OPTIMAL, PARTITION)


@pytest.fixture(scope="module")
def views():
    scene = sl.library.scene("statues", facets=12, leaves=20)
    return scene_optimal_views.quick_configurations(PIXELS, scene)


def counted(views, techniques=TECHNIQUES, sizes=(SIDE,), **how):
    how = {"renderer": "cpu", "reference": REFERENCE, "progress": False, **how}
    return sl.scene_optimal_experiment(techniques, sizes=sizes, views=views, **how)


@pytest.fixture(scope="module")
def result(views):
    return counted(views, sizes=(SIDE, 2 * SIDE))


def test_there_are_28_configurations_with_eight_spots_and_shadows_in_every_picture():
    scene = sl.library.scene("statues", facets=12, leaves=20)
    found = scene_optimal_views.configurations(64, scene)
    assert len(found) == len({view.label for view in found}) == 28
    assert [view.light.kind for view in found].count("spot") == 8
    assert all(view.view.size == (64, 64) and view.camera.aspect == 1.0 for view in found)
    for view in found:
        truth = view.view.truth()
        assert min((truth == Truth.LIT).mean(), (truth == Truth.SHADOW).mean()) > 0.02, view.label
    for name, (_, elevation) in scene_optimal_views.SUNS.items():
        sun = scene_optimal_views.light_named(name)
        assert np.isclose(np.degrees(np.arcsin(-sun.direction[1])), elevation)


def test_counts_are_those_of_evaluate(views, result):
    view = views[1]
    for technique in (NORMAL, OPTIMAL):
        run = sl.evaluate(view.view, technique, SIDE, metrics=["misclassified"], renderer="cpu")
        rows = result.table
        row = rows[(rows["view"] == view.label) & (rows["technique"] == technique) & (rows["single_side"] == SIDE)]
        assert list(row["misclassified"]) == [run.numbers["misclassified"]]
        large = sl.evaluate(view.view, NORMAL, REFERENCE, metrics=["mask"], renderer="cpu").mask
        seen = ~np.isnan(large)
        assert list(row["misclassified_by_map"]) == [int(((run.mask >= 0.5) != (large >= 0.5))[seen].sum())]
        assert list(row["compared_by_map"]) == [int(seen.sum())]


def test_views_of_one_camera_are_traced_together_with_the_same_counts(monkeypatch):
    scene = sl.library.scene("statues", facets=12, leaves=20)
    walk = scene_optimal_views.configurations(64, scene)[:7]
    alone = pd.concat([counted([view], ["lispsm"]).table for view in walk], ignore_index=True)
    walk[0].view.clear()
    traced, shadow_masks = [], sl._core.trace_shadow_masks

    def counting(scene, camera, lights, **how):
        traced.append(len(lights))
        return shadow_masks(scene, camera, lights, **how)

    monkeypatch.setattr(sl._core, "trace_shadow_masks", counting)
    monkeypatch.setattr(sl._core, "trace_shadow_mask", None)
    together = counted(walk, ["lispsm"]).table
    assert traced == [7]
    columns = ["view", "technique", "misclassified", "compared", "misclassified_by_map"]
    pd.testing.assert_frame_equal(together[columns], alone[columns])
    # No more of them at once than there is room for.
    walk[0].view.clear()
    monkeypatch.setattr(scene_optimal, "TRACED_BYTES", 3 * 64 * 64)
    traced.clear()
    monkeypatch.setattr(sl._core, "trace_shadow_mask", lambda s, c, light, **how: counting(s, c, [light], **how)[0])
    pd.testing.assert_frame_equal(counted(walk, ["lispsm"]).table[columns], alone[columns])
    assert traced == [3, 3, 1]


def test_techniques_with_several_maps_take_no_more_memory(result):
    rows = result.table[result.table["failure"] == ""]
    assert (rows["bytes"] <= 4 * rows["single_side"] ** 2).all()
    several = rows[rows["technique"] == PARTITION]
    assert (several["maps"] > 1).any()
    assert (several["resolution"] == np.floor(several["single_side"] / np.sqrt(several["maps"].astype(float)))).all()
    assert (rows[rows["maps"] == 1]["resolution"] == rows[rows["maps"] == 1]["single_side"]).all()


def test_sums_are_over_views_that_both_serve(views, result):
    rows = result.table
    # lispsm serves spots; gmnpr does not.
    gmnpr = counted(views, ["gmnpr"])
    failed = gmnpr.table[gmnpr.table["failure"] != ""]
    assert set(failed["light"]) == {"mast"}
    total = gmnpr.totals.iloc[0]
    assert total["configurations"] == len(views) - 1
    of_suns = rows[(rows["light"] != "mast") & (rows["single_side"] == SIDE)]
    assert total["misclassified_normal"] == of_suns[of_suns["technique"] == NORMAL]["misclassified"].sum()
    assert "no map in 1 of 4 views" in repr(gmnpr)
    for row in result.totals.to_dict("records"):
        mine = rows[(rows["technique"] == row["technique"]) & (rows["single_side"] == row["single_side"])]
        assert row["misclassified"] == mine["misclassified"].sum()
        expected = 100 * (row["misclassified_normal"] / row["misclassified"] - 1)
        assert np.isclose(row["percent_more"], expected)


def test_sums_may_be_taken_over_the_views_that_all_serve(views):
    both = counted(views, ["gmnpr", OPTIMAL])
    common = both.served_by_all
    assert set(common.table["light"]) == {"morning", "noon", "evening"}
    assert list(common.totals["configurations"]) == [3, 3]
    assert list(both.totals["configurations"]) == [3, 4]
    assert len(set(common.totals["misclassified_normal"])) == 1


def test_the_normal_map_makes_more_mistakes_than_both_optimized_ones(result):
    in_sum = result.in_sum.set_index("technique")
    assert in_sum.loc[OPTIMAL, "percent_more"] > in_sum.loc[PUBLISHED, "percent_more"] > 0
    assert in_sum.loc[OPTIMAL, "wins"] == in_sum.loc[OPTIMAL, "configurations"] == 4
    best = result.views
    assert list(best["view"]) == list(dict.fromkeys(result.table["view"]))
    assert np.allclose(best["ratio_of_best"], best["misclassified_normal"] / best["misclassified"])


def test_bounds_are_checked(result):
    # Bounds are of each size.
    more = result.totals.groupby("technique")["percent_more"].min()
    assert result.failed_bounds({OPTIMAL: more[OPTIMAL] - 0.1, PUBLISHED: more[PUBLISHED] - 0.1}) == []
    (sentence,) = result.failed_bounds({OPTIMAL: more[OPTIMAL] + 0.1, PUBLISHED: more[PUBLISHED] - 0.1})
    assert sentence.startswith(f"{OPTIMAL}: expected that the normal map makes at least")
    (sentence,) = result.failed_bounds({"tsm": 1.0})
    assert "expected to be counted" in sentence


def test_rows_are_kept_as_they_are_counted_and_not_made_again(views, tmp_path, monkeypatch):
    made = []
    row = scene_optimal._Counting.row

    def counting(self, label, item, side):
        if len(made) == 3:
            raise KeyboardInterrupt
        made.append((self.view.label, label))
        return row(self, label, item, side)

    monkeypatch.setattr(scene_optimal._Counting, "row", counting)
    with pytest.raises(KeyboardInterrupt):
        counted(views, [NORMAL, OPTIMAL], out=tmp_path)
    file = tmp_path / scene_optimal.ROWS_FILE
    assert len(sl.read_store(file)) == 3
    monkeypatch.setattr(scene_optimal._Counting, "row", row)
    whole = counted(views, [NORMAL, OPTIMAL], out=tmp_path)
    assert len(sl.read_store(file)) == 2 * len(views)
    fresh = counted(views, [NORMAL, OPTIMAL])
    times = ["samples_ms", "fit_us", "map_ms", "lookup_ms"]
    pd.testing.assert_frame_equal(whole.table.drop(columns=times), fresh.table.drop(columns=times))
    monkeypatch.setattr(scene_optimal._Counting, "row", lambda *_: pytest.fail("made again"))
    assert counted(views, [NORMAL, OPTIMAL], out=tmp_path) == whole
    # Another setting is another row.
    monkeypatch.setattr(scene_optimal._Counting, "row", row)
    other = counted(views[:1], [NORMAL, OPTIMAL], out=tmp_path, bias=sl.Bias(world=0.01))
    assert len(sl.read_store(file)) == 2 * len(views) + 2
    assert not other.table.equals(whole.table)


def test_another_table_in_its_place_is_refused(views, tmp_path):
    file = tmp_path / scene_optimal.ROWS_FILE
    for text in ("a,b\n1,2\n", "\x00\x01"):
        file.write_text(text)
        with pytest.raises(StoreError, match="another path"):
            counted(views[:1], [NORMAL], out=tmp_path)


def test_wrong_arguments_say_what_is_right(views):
    for sizes in ((), (64, 64), "64", (0,), (1.5,), None):
        with pytest.raises(ArgumentError, match=r"^sizes: "):
            counted(views, sizes=sizes)
    for given in ((), (1,), [views[0], views[0]]):
        with pytest.raises(ArgumentError, match=r"^views: "):
            counted(given)
    with pytest.raises(UnknownNameError, match="lispsn"):
        counted(views, ["lispsn"])
    matrix = sl.technique("uniform").parameterize(views[0].view.scene, views[0].camera, views[0].light)
    with pytest.raises(ArgumentError, match="matrices of one view"):
        counted(views, {"mine": matrix})
    with pytest.raises(ArgumentError, match=r"^reference: "):
        counted(views, reference=0)
    with pytest.raises(UnknownNameError, match=r"expected a camera .walk"):
        scene_optimal.chosen_views(["moon"], views)
    assert [v.label for v in scene_optimal.chosen_views(["walk", "walk, morning", "mast"], views)] == [
        "walk, morning", "overview, mast",
    ]  # fmt: skip


def test_tables_as_text_and_files(result, tmp_path, monkeypatch):
    monkeypatch.setattr(report, "FIGURES", ("percent_more",))  # the others take long
    directory = result.save(tmp_path / "new", progress=False)
    assert set(FIGURES[1:]) == set(scene_optimal_views.paper_views(32))
    assert (directory / "percent_more.png").stat().st_size > 5000
    with pytest.raises(UnknownNameError, match="unknown 'robots'; expected one of percent_more, dueling"):
        result.figure("robots")
    data = json.loads((directory / "results.json").read_text(encoding="utf-8"))
    assert data["reference"] == REFERENCE
    assert len(data["runs"]) == len(result.table)
    assert pd.read_csv(directory / "totals.csv")["misclassified"].sum() == result.totals["misclassified"].sum()
    text = (directory / "table.md").read_text(encoding="utf-8")
    assert report.paper_markdown(result) in text
    first = report.paper_markdown(result).splitlines()
    assert first[0].startswith("| Resolution | Optimal | Normal | Percent More |")
    row = result.totals[result.totals["technique"] == OPTIMAL].iloc[0]
    more = f"{row['percent_more']:+.1f} %"
    assert first[2].startswith(
        f"| {SIDE}x{SIDE} | {row['misclassified']:,} | {row['misclassified_normal']:,} | {more} |"
    )
    ratios = report.ratios_markdown(result).splitlines()
    assert len(ratios) == 2 + 4
    assert all(line.count("**") >= 2 for line in ratios[2:])
    beside = report.as_good(result)
    assert (beside["ratio"] <= 1.05).all()
    assert not set(beside["technique"]) & {NORMAL, OPTIMAL}


def test_the_page_lists_the_configurations_as_they_are():
    from pathlib import Path

    page = (Path(__file__).resolve().parents[1] / "docs" / "scene_optimal.md").read_text(encoding="utf-8")
    assert report.configurations_markdown() in page
