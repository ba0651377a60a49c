"""One vocabulary: the columns of every table of every experiment."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

import shadowlab as sl
from shadowlab.experiments import columns
from shadowlab.experiments.views import LabelledView

SIZE = (96, 54)


@pytest.fixture(scope="module")
def tables() -> dict[str, pd.DataFrame]:
    scene = sl.library.scene("robots")
    how = {"size": SIZE, "renderer": "cpu", "progress": False}
    study = sl.compare(scene, scene.camera, scene.light, ["uniform", "lispsm"], resolution=64, **how)
    lights = [scene.light, sl.DirectionalLight((-1, -0.3, 0.1))]
    advice = sl.advise(scene, scene.camera, lights, memory="64 KiB", techniques=["uniform", "lispsm"], **how)
    angles = sl.aliasing.over_light_angle(scene, scene.camera, [90, 30], resolution=64, **how)
    frustum = sl.aliasing.frustum_over_light_angle(scene.camera, [90])
    eye = np.asarray(scene.camera.eye)
    ahead, aside = np.asarray(scene.camera.forward), np.array([0.1, 0.0, 0.0])
    path = [sl.Camera.look_at(eye + i * aside, eye + ahead) for i in range(2)]
    temporal = sl.aliasing.temporal(scene, path, scene.light, resolution=64, **how)
    view = LabelledView(sl.View(scene, scene.camera, scene.light, SIZE, "robots"), "its own", "its own")
    optimal = sl.scene_optimal_experiment(
        ["uniform"], sizes=[64], views=[view], reference=128, renderer="cpu", progress=False
    )
    return {
        "compare": study.table, "advise": advice.table, "advise.runs": advice.runs, "advise.switches": advice.switches,
        "over_light_angle": angles.table, "frustum_over_light_angle": frustum.table, "temporal": temporal.table,
        "scene_optimal": optimal.table, "scene_optimal.totals": optimal.totals, "scene_optimal.views": optimal.views,
        "temporal.frames": temporal.frames,
        "sweep": sl.sweep({"scene": "@robots", "technique": ["uniform", "lispsm"], "resolution": 64}, **how),
    }  # fmt: skip


def test_every_table_of_the_vocabulary_is_held_against_it(tables: dict[str, pd.DataFrame]) -> None:
    assert tables.keys() == columns.TABLES.keys()


@pytest.mark.parametrize("name", columns.TABLES)
def test_tables_have_their_columns_in_order_with_their_dtypes(tables: dict[str, pd.DataFrame], name: str) -> None:
    table = tables[name]
    assert tuple(table.columns) == columns.TABLES[name]
    expected = {c: "object" if columns.COLUMNS[c].dtype == "str" else columns.COLUMNS[c].dtype for c in table.columns}
    assert {c: str(table[c].dtype) for c in table.columns} == expected
    for column in table.columns:
        if columns.COLUMNS[column].dtype == "str":
            assert all(isinstance(value, str) for value in table[column]), column


def test_the_columns_that_scripts_rely_on_are_in_every_table_of_runs(tables: dict[str, pd.DataFrame]) -> None:
    for name in ("compare", "advise.runs", "over_light_angle"):
        assert {"scene", "view", "technique", "misclassified", "failure", "resolution"} <= set(tables[name])
        assert set(tables[name]["scene"]) == {"robots"}
        assert (tables[name]["failure"] == "").all()


def test_each_column_stands_once_and_is_used() -> None:
    names = [column.name for group in columns.GROUPS.values() for column in group]
    assert len(set(names)) == len(names)
    used = {name for table in columns.TABLES.values() for name in table}
    assert used - {"angle_deg"} <= set(names)
    from shadowlab.experiments.metrics import MEASURED

    assert set(names) <= used | set(MEASURED), "a column that no table and no run has is no column"
    assert set(MEASURED) <= set(names)


def test_each_column_says_what_it_holds_in_one_line() -> None:
    for column in columns.COLUMNS.values():
        assert column.doc.endswith("."), column.name
        assert "\n" not in column.doc
        assert column.over_lights in ("", "sum", "max", "share of sums")
        assert not (column.dtype == "str" and column.over_lights)


def test_a_missing_column_is_missing_in_every_dtype() -> None:
    made = columns.frame(["technique", "misclassified", "share", "about_best"], [{}])
    assert made["technique"][0] == ""
    assert made["misclassified"][0] is pd.NA
    assert np.isnan(made["share"][0])
    assert made["about_best"][0] is pd.NA


def test_names_from_before_are_taken_with_a_warning() -> None:
    for old, new in columns.RENAMED.items():
        assert new in columns.COLUMNS
        with pytest.warns(sl.errors.ShadowlabWarning, match=f"{new!r} now"):
            assert columns.current(old) == new
    scene = sl.library.scene("robots")
    angles = sl.aliasing.over_light_angle(
        scene, scene.camera, [90, 30], resolution=64, size=SIZE, renderer="cpu", progress=False
    )
    with pytest.warns(sl.errors.ShadowlabWarning, match="texel_p95"):
        old = angles.relative("p95")
    pd.testing.assert_frame_equal(old, angles.relative("texel_p95"))
