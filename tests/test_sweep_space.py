"""The space of a sweep: which rows it has, in which order, under which labels; rows drawn by chance; the plan."""

from __future__ import annotations

import itertools
import os

import numpy as np
import pytest
from sweep_support import ROBOTS, SIZE

import shadowlab as sl
from shadowlab.errors import ArgumentError, LoadError, UnknownNameError
from shadowlab.experiments.sweeps.estimate import estimate
from shadowlab.experiments.sweeps.plan import plan_of


def cells(space, *names):
    """These cells of all rows of a plan."""
    return [tuple(row.cells.get(name) for name in names) for row in plan_of(space, size=SIZE, renderer="cpu").rows]


def test_a_dict_is_the_full_product_in_the_order_of_the_keys():
    space = {"resolution": [64, 128], "technique": ["uniform", "tsm"], "scene": ["@robots", "@dueling"]}
    expected = list(itertools.product(("robots", "dueling"), ("uniform", "tsm"), (64, 128)))
    assert cells(space, "scene", "technique", "resolution") == expected


def test_a_list_of_rows_is_taken_as_it_is():
    rows = [{**ROBOTS, "resolution": 64}, {"scene": "@dueling", "technique": "lispsm", "lispsm.near": 2}]
    assert cells(rows, "scene", "technique", "lispsm.near", "resolution") == [
        ("robots", "uniform", None, 64), ("dueling", "lispsm", 2, 1024),
    ]  # fmt: skip


def test_a_setting_that_a_technique_does_not_have_drops_out_once():
    space = {
        **ROBOTS,
        "technique": ["uniform", "lispsm", "tsm"],
        "lispsm.near": [1, 2],
        "lispsm.norm": ["linf", "mean"],
    }
    plan = plan_of(space, size=SIZE)
    assert [row.cells["technique"] for row in plan.rows] == ["uniform", *["lispsm"] * 4, "tsm"]
    assert "lispsm.near does not apply to uniform: left out there" in plan.notes
    assert "lispsm.norm does not apply to tsm: left out there" in plan.notes
    assert plan.swept == ("technique", "lispsm.near", "lispsm.norm")
    same = [{**ROBOTS, "technique": name, "lispsm.near": near} for name in ("uniform", "lispsm") for near in (1, 2)]
    assert plan_of(same, size=SIZE).runs == 3


def test_a_setting_of_all_techniques_is_given_to_those_that_have_it():
    space = {
        **ROBOTS,
        "technique": ["uniform", "lispsm", "z_partition:count=2"],
        "technique.near": ["basic", "optimal"],
    }
    plan = plan_of(space, size=SIZE)
    assert [row.cells["technique"] for row in plan.rows] == ["uniform", "lispsm", "lispsm", "z_partition:count=2"]
    assert [row.request.item.settings["near"] for row in plan.rows[1:3]] == ["basic", "optimal"]


def test_settings_reach_texts_objects_and_variants():
    forms = ["lispsm:fit=seen", sl.technique("lispsm", fit="seen"), sl.technique("lispsm:fit=seen,bias=(slope=1)")]
    for form in forms:
        (row,) = plan_of({**ROBOTS, "technique": [form], "lispsm.near": 2}, size=SIZE).rows
        assert (row.request.item.settings["fit"], row.request.item.settings["near"]) == ("seen", 2)
    assert row.cells["bias"] == "slope=1.0"
    (row,) = plan_of({**ROBOTS, "uniform.filter": "bilinear", "filter": "pcf:size=3"}, size=SIZE).rows
    assert row.cells["filter"] == row.cells["uniform.filter"] == "bilinear"


def test_all_is_every_technique():
    names = [row[0] for row in cells({**ROBOTS, "technique": "all"}, "technique")]
    assert names == list(dict.fromkeys(sl.techniques()["name"]))


def test_a_value_out_of_range_is_a_row_and_a_name_that_is_none_an_error():
    plan = plan_of({**ROBOTS, "technique": "lispsm", "lispsm.near": [1, -5]}, size=SIZE)
    assert plan.rows[0].request is not None
    assert plan.rows[1].request is None
    assert plan.rows[1].failure[0] == "ArgumentError"
    assert plan.rows[1].cells["lispsm.near"] == -5


@pytest.mark.parametrize(
    ("space", "error", "says"),
    [
        ({}, ArgumentError, "scene"),
        ([], ArgumentError, "at least one row"),
        ([ROBOTS, 3], ArgumentError, "row 1"),
        ({"scene": "@robots"}, ArgumentError, "techniques"),
        ({**ROBOTS, "resolutions": 64}, UnknownNameError, "resolutions"),
        ({**ROBOTS, 3: 64}, ArgumentError, "keys"),
        ({**ROBOTS, "lispm.near": 1}, UnknownNameError, "lispm"),
        ({**ROBOTS, "lispsm.neer": 1}, UnknownNameError, "neer"),
        ({**ROBOTS, "technique.neer": 1}, UnknownNameError, "neer"),
        ({**ROBOTS, "technique": "unifrom"}, UnknownNameError, "unifrom"),
        ({**ROBOTS, "technique": 3}, ArgumentError, "technique"),
        ({**ROBOTS, "scene": "@robot"}, UnknownNameError, "robot"),
        ({**ROBOTS, "scene": "no/such/file.ply"}, LoadError, "file.ply"),
        ({**ROBOTS, "scene": 3}, ArgumentError, "scene"),
        ({**ROBOTS, "camera": "allong"}, UnknownNameError, "along"),
        ({**ROBOTS, "light": "noon"}, UnknownNameError, "noon"),
        ({**ROBOTS, "light": [[0, 0, 0]]}, ArgumentError, "direction"),
        ({**ROBOTS, "resolution": 0}, ArgumentError, "resolution"),
        ({**ROBOTS, "resolution": []}, ArgumentError, "at least one value"),
        ({**ROBOTS, "resolution": 64, "memory": "4 MiB"}, ArgumentError, "both"),
        ({**ROBOTS, "memory": "4 MiBs"}, UnknownNameError, "MiBs"),
        ({**ROBOTS, "bias": "slop=1"}, UnknownNameError, "slop"),
        ({**ROBOTS, "filter": "blurry"}, UnknownNameError, "blurry"),
        ({**ROBOTS, "blend": 2}, ArgumentError, "blend"),
        ({**ROBOTS, "stored": "side"}, UnknownNameError, "side"),
        ({**ROBOTS, "resolution": {"min": 1, "max": 2}}, ArgumentError, "random"),
        ({**ROBOTS, "technique": "lispsm:near=1", "lispsm.near": [1, 2]}, ArgumentError, "remove one"),
        ({**ROBOTS, "technique": "lispsm", "lispsm.near": 1, "technique.near": 2}, ArgumentError, "remove one"),
        ({**ROBOTS, "resolution": range(1, 2000), "lispsm.near": range(2000)}, ArgumentError, "random"),
    ],
)  # fmt: skip
def test_what_is_no_space_is_an_error_before_the_work_starts(space, error, says):
    with pytest.raises(error, match=says):
        sl.sweep(space, size=SIZE, renderer="cpu", progress=False)


def test_views_have_labels_that_tell_them_apart():
    scene = sl.library.scene("robots")
    near = scene.camera.replace(fov_y=0.5)
    lights = [scene.light, sl.DirectionalLight((0, -1, 0)), (scene.light, sl.DirectionalLight((1, -1, 0)))]
    space = {**ROBOTS, "scene": scene, "camera": {"wide": scene.camera, "near": near}, "light": lights}
    plan = plan_of(space, size=SIZE)
    assert len({view.label for view in plan.views}) == len(plan.views) == 6
    assert [view.camera_label for view in plan.views] == ["wide"] * 3 + ["near"] * 3
    assert [view.light_label for view in plan.views[:3]] == ["light 32° up", "light 90° up", "2 lights"]
    assert plan.views[0].view.size == SIZE
    unnamed = plan_of({**space, "camera": [scene.camera, near], "light": "own"}, size=SIZE)
    assert [view.label for view in unnamed.views] == ["camera 1, own", "camera 2, own"]


def test_cameras_and_lights_by_name():
    assert cells({**ROBOTS, "camera": ["own", "along", "above"]}, "view") == [("own",), ("along",), ("above",)]
    assert cells({**ROBOTS, "camera": "along", "light": ["own", "against", "0.3,-1,0.1", (1, -1, 0)]}, "light") == [
        ("own",), ("against",), ("0.3,-1,0.1",), ("light 45° up",),
    ]  # fmt: skip
    scene = sl.library.scene("robots")
    scene.cameras, scene.lights = {"Door": scene.camera}, {"Lamp": scene.light}
    plan = plan_of({**ROBOTS, "scene": scene, "camera": "Door", "light": "Lamp"}, size=SIZE)
    assert (plan.views[0].label, plan.views[0].light) == ("Door, Lamp", scene.light)
    bare = sl.Scene.from_arrays(*scene.to_arrays())
    assert plan_of({**ROBOTS, "scene": bare}, size=None).views[0].label == "along"


def test_equal_rows_are_there_once():
    assert plan_of({**ROBOTS, "resolution": [64, 64, 128]}, size=SIZE).runs == 2
    scene = sl.library.scene("robots")
    assert plan_of({**ROBOTS, "scene": [scene, "@robots"]}, size=SIZE).runs == 2, "other objects have other labels"
    assert plan_of({**ROBOTS, "technique": "lispsm", "lispsm.near": [1, 1.0]}, size=SIZE).runs == 2


def test_rows_by_chance_are_those_of_their_seed():
    space = {
        **ROBOTS, "technique": ["lispsm", "tsm"], "lispsm.near": {"min": 0.1, "max": 10, "log": True},
        "resolution": {"min": 64, "max": 128, "log": True}, "blend": {"min": 0, "max": 0.5},
        "light": lambda rng: sl.DirectionalLight((rng.normal(), -1, rng.normal())),
        "camera": {"a": "own", "b": "along"},
    }  # fmt: skip
    rows = sl.random(space, 200, seed=3)
    assert rows == sl.random(space, 200, seed=3)
    assert rows[:50] == sl.random(space, 50, seed=3)
    assert rows != sl.random(space, 200, seed=4)
    fewer = {key: value for key, value in space.items() if key != "blend"}
    assert [row["resolution"] for row in sl.random(fewer, 200, seed=3)] == [row["resolution"] for row in rows]
    near = np.log([row["lispsm.near"] for row in rows])
    assert near.min() >= np.log(0.1)
    assert near.max() <= np.log(10)
    # Evenly in the logarithm: the mean of 200 is within four standard deviations.
    assert abs(near.mean()) < 4 * np.log(100) / np.sqrt(12 * 200)
    assert {type(row["resolution"]) for row in rows} == {int}
    assert {row["resolution"] for row in rows} <= set(range(64, 129))
    assert {name for row in rows for name in row["camera"]} == {"a", "b"}
    plan = plan_of(rows[:20], size=SIZE)
    assert 1 < plan.runs <= 20


@pytest.mark.parametrize(
    "value",
    [{"min": 2, "max": 1}, {"min": "a", "max": 1}, {"min": 0, "max": 1, "log": True}, {"min": 0, "max": np.inf},
     {"min": 1, "max": 2, "step": 1}, [], lambda rng: 1 / 0, {"min": 10**400, "max": 1}],
)  # fmt: skip
def test_what_cannot_be_drawn_from_is_an_error(value):
    with pytest.raises(ArgumentError):
        sl.random({**ROBOTS, "resolution": value}, 3, seed=1)


def test_an_estimate_times_a_few_runs_and_grows_with_the_sweep():
    space = {**ROBOTS, "technique": ["uniform", "lispsm"], "resolution": [64, 128, 256]}
    small, large = (plan_of(space, size=size, renderer="cpu") for size in (SIZE, (640, 360)))
    found = estimate(small)
    assert found.timed == 3
    assert found.seconds > 0
    assert estimate(large).bytes > found.bytes > 0
    assert estimate(small, timed=0).seconds is None
    whole = estimate(small, timed=100)
    assert whole.timed == small.runs


def deep(count):
    """Lists within one another."""
    value = "near"
    for _ in range(count):
        value = [value]
    return value


@pytest.mark.parametrize("value", [10**400, -(2**63) - 1, [deep(5000)], [[10**30, deep(3)]], [float("nan")]])
def test_a_value_that_no_setting_has_is_the_failure_of_its_row(value, tmp_path):
    space = {"scene": "@robots", "technique": ["uniform", "lispsm"], "lispsm.near": value, "resolution": 32}
    how = {"size": (32, 18), "renderer": "cpu"}
    for store in (None, tmp_path / "runs.sqlite"):
        found = sl.sweep(space, **how, store=store)
        assert list(found["failure_type"]) == ["", "ArgumentError"]
        assert len(str(found["lispsm.near"][1])) < 1000
        sl.to_xarray(found)


def test_whole_numbers_stay_numbers_of_64_bits():
    space = {"scene": "@robots", "technique": "lispsm", "lispsm.near": [2**63 - 1, 2**63, 1], "resolution": 32}
    cells = [row.cells["lispsm.near"] for row in plan_of(space, size=(32, 18)).rows]
    assert cells == [2**63 - 1, 2.0**63, 1]
    assert [type(cell) for cell in cells] == [int, float, int]
    assert sl.sweep(space, size=(32, 18), renderer="cpu")["lispsm.near"].dtype == "float64"


@pytest.mark.parametrize("key", ["scene", "technique", "resolution"])
def test_a_list_in_a_row_is_told_from_a_product(key):
    row = {"scene": "@robots", "technique": "uniform", "resolution": 32}
    with pytest.raises(
        ArgumentError, match=rf"^space, row 1: expected one value for '{key}', got \[.*one dict instead"
    ):
        plan_of([row, {**row, key: [row[key], row[key]]}])


def test_a_space_needs_a_scene_and_a_technique_and_says_so():
    for key in ("scene", "technique"):
        with pytest.raises(ArgumentError, match=f"at least one value for '{key}', got none; give one, as of"):
            plan_of({"scene": "@robots", "technique": "uniform", key: []})
    with pytest.raises(ArgumentError, match="at least one value for 'light', got none; leave the key out"):
        plan_of({"scene": "@robots", "technique": "uniform", "light": []})


def test_techniques_of_one_name_are_told_apart():
    near = [sl.technique("lispsm", near=value) for value in (1, 4)]
    matrix = [sl.Parameterization.from_matrix(np.eye(4) * [1, 1, 1 / scale, 1]) for scale in (2, 3)]
    plan = plan_of(
        {"scene": "@robots", "technique": [*near, "uniform", sl.technique("uniform"), *matrix], "resolution": [32, 64]}
    )
    labels = list(dict.fromkeys(row.cells["technique"] for row in plan.rows))
    assert labels[:4] == ["lispsm (near=1.0)", "lispsm (near=4.0)", "uniform (1)", "uniform (2)"]
    assert len(set(labels)) == 6
    beside = plan_of({"scene": "@robots", "technique": ["lispsm", near[1]]})
    assert [row.cells["technique"] for row in beside.rows] == ["lispsm", "lispsm (near=4.0)"]
    rows = [{"scene": "@robots", "technique": {"mine": name}} for name in ("uniform", "tsm", "uniform")]
    assert [row.cells["technique"] for row in plan_of(rows).rows] == ["mine (1)", "mine (2)"]
    settings = {"scene": "@robots", "technique": near[0], "lispsm.range": ["seen", "body"]}
    assert {row.cells["technique"] for row in plan_of(settings).rows} == {"lispsm"}


@pytest.mark.parametrize("key", ["scene", "camera", "light", "technique"])
def test_a_label_that_is_no_text_is_an_error(key):
    value = {"scene": "@robots", "technique": "uniform"}.get(key, "own")
    with pytest.raises(ArgumentError, match=f"^space: label of '{key}': expected text that UTF-8 encodes"):
        plan_of({"scene": "@robots", "technique": "uniform", key: {"\ud800": value}})


@pytest.mark.skipif(os.name != "posix", reason="file names are bytes there")
def test_a_file_whose_name_is_no_text_has_one_in_the_table(tmp_path):
    path = os.fsencode(tmp_path) + b"/caf\xe9.obj"
    try:
        with open(path, "w") as file:  # noqa: PTH123 - bytes
            file.write("v 0 0 0\nv 1 0 0\nv 0 0 1\nf 3 2 1\n")
    except OSError:
        pytest.skip("the file system takes texts alone")
    space = {"scene": os.fsdecode(path), "technique": "uniform", "resolution": 32}
    found = sl.sweep(space, size=(32, 18), renderer="cpu", store=tmp_path / "runs.sqlite")
    assert list(found["scene"]) == ["caf\\udce9.obj"]
    assert list(sl.read_store(tmp_path / "runs.sqlite")["scene"]) == list(found["scene"])


@pytest.mark.parametrize("size", [10**6, (64, 10**6)])
def test_a_picture_that_no_run_can_draw_is_an_error_before_the_work_starts(size):
    with pytest.raises(ArgumentError, match=r"^size: expected at most 16384 pixels a side, got "):
        plan_of({"scene": "@robots", "technique": "uniform"}, size=size)
