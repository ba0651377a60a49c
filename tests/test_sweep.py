"""`sl.sweep` in this process: rows, columns, failures, metrics that are functions, limits of time."""

from __future__ import annotations

import time
import warnings

import numpy as np
import pandas as pd
import pytest
from sweep_support import HOW, ROBOTS, SIZE, SPACE, lit, raise_at_64, same, sleep_at_64

import shadowlab as sl
from shadowlab.errors import ArgumentError, ShadowlabError
from shadowlab.experiments.columns import COLUMNS, TABLES


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    return sl.sweep(SPACE, **HOW)


def test_rows_are_those_of_evaluate(table):
    assert len(table) == 32
    good = table[table["failure"] == ""]
    for i in (0, 5, len(good) - 1):
        row = good.iloc[i]
        scene = sl.library.scene(row["scene"])
        light = scene.light if row["light"] == "own" else sl.DirectionalLight((0.3, -1, 0.1))
        item = sl.technique(row["spec"])
        run = sl.evaluate(
            sl.View(scene, scene.camera, light, SIZE), item, int(row["resolution"]), metrics=["misclassified"],
            renderer="cpu",
        )  # fmt: skip
        for name in ("misclassified", "false_shadow", "compared", "share", "maps", "bytes", "outside_shadow"):
            value = run.row()[name]
            assert value == row[name] or (value is None and pd.isna(row[name])), name


def test_settings_are_typed_columns_and_what_was_left_out_is_noted(table):
    assert list(table.columns)[:9] == [*TABLES["sweep"][:8], "lispsm.near"]
    assert str(table["lispsm.near"].dtype) == "Int64"
    assert table["lispsm.near"].isna().equals(table["technique"] != "lispsm")
    assert (table["notes"].str.contains("lispsm.near does not apply") == (table["technique"] != "lispsm")).all()
    mixed = sl.sweep({**ROBOTS, "technique": "lispsm", "lispsm.near": [1, 2.5], "resolution": 32}, **HOW)
    assert list(mixed["lispsm.near"]) == [1.0, 2.5]
    words = sl.sweep({**ROBOTS, "technique": ["lispsm", "tsm"], "lispsm.near": [1, "basic"], "resolution": 32}, **HOW)
    assert list(words["lispsm.near"]) == ["1", "basic", ""]
    flags = sl.sweep({**ROBOTS, "uniform.stable": [True, False], "resolution": 32}, **HOW)
    assert str(flags["uniform.stable"].dtype) == "boolean"


def test_a_failing_configuration_is_a_row(table):
    failed = table[table["failure"] != ""]
    assert set(failed["failure_type"]) == {"ArgumentError"}
    assert set(failed["lispsm.near"]) == {-5}
    assert failed["misclassified"].isna().all()
    point = sl.sweep({**ROBOTS, "technique": ["tsm", "uniform"], "light": sl.PointLight((0, 9, 0), range=50)}, **HOW)
    assert list(point["failure_type"]) == ["UnsupportedError", ""]
    assert list(point["misclassified"].isna()) == [True, False]


def test_a_table_says_what_it_is_of(table):
    assert table.attrs["swept"] == ["scene", "light", "technique", "lispsm.near", "resolution"]
    assert table.attrs["backend"] == "cpu"
    assert {"shadowlab", "python", "numpy", "pandas", "machine", "adapter"} <= table.attrs.keys()
    assert any("lispsm.near" in note for note in table.attrs["notes"])
    for name in table.columns:
        assert name in COLUMNS or "." in name


def test_how_maps_are_read_is_swept():
    space = {
        **ROBOTS, "technique": ["uniform", "lispsm:bias=none"], "bias": [None, "slope=3"],
        "filter": ["nearest", "pcf:size=3"], "stored": [None, "back"], "blend": [0.0, 0.1], "resolution": 64,
    }  # fmt: skip
    found = sl.sweep(space, **HOW)
    assert len(found) == 32
    assert list(found.attrs["swept"]) == ["technique", "bias", "filter", "stored", "blend"]
    assert set(found["bias"]) == {"default", "slope=3.0", "none"}
    one = found[(found["bias"] == "slope=3.0") & (found["filter"] == "pcf:size=3") & (found["stored"] == "back")].iloc[
        0
    ]
    scene = sl.library.scene("robots")
    run = sl.evaluate(
        sl.View(scene, scene.camera, scene.light, SIZE), "uniform", 64, metrics=["misclassified"], renderer="cpu",
        bias=sl.Bias(slope=3), filter="pcf:size=3", stored="back",
    )  # fmt: skip
    assert one["misclassified"] == run.numbers["misclassified"]


def test_a_memory_decides_the_resolution():
    space = {**ROBOTS, "technique": ["uniform", "z_partition:count=4"], "memory": ["64 KiB", "256 KiB"]}
    found = sl.sweep(space, **HOW)
    assert list(found["resolution"]) == [128, 256, 64, 128]
    assert (found["bytes"] <= found["memory"]).all()
    tight = sl.sweep({**ROBOTS, "technique": "z_partition:count=4", "memory": 512}, **HOW)
    assert tight["failure_type"][0] == "ArgumentError"
    assert "smallest drawn" in tight["failure"][0]


def test_functions_are_metrics():
    found = sl.sweep({**ROBOTS, "resolution": [32, 64]}, **HOW, metrics=["misclassified", lit, raise_at_64])
    assert str(found["width"].dtype) == "Int64"
    assert 0 < found["lit"][0] < 1
    assert list(found.columns).index("lit") < list(found.columns).index("seconds")
    assert found["raise_at_64"][0] == 32
    assert list(found["failure_type"]) == ["", "RuntimeError"]
    assert found["failure"][1] == "metric raise_at_64: no good at 64"
    assert pd.isna(found["misclassified"][1])
    assert pd.isna(found["lit"][1])
    alone = sl.sweep({**ROBOTS, "resolution": 32}, **HOW, metrics=lit)
    assert alone["lit"][0] == found["lit"][0]


@pytest.mark.parametrize("value", ["a text", [1, 2], {"a": "b"}, {"misclassified": 1}, {3: 1}, object()])
def test_a_function_that_gives_no_number_is_the_failure_of_its_row(value):
    found = sl.sweep({**ROBOTS, "resolution": 32}, **HOW, metrics=[lambda run: value])
    assert list(found["failure_type"]) == ["ArgumentError"]


def test_numbers_of_functions_keep_their_types():
    numbers = {"a": np.float32(0.5), "b": np.int64(3), "c": True, "d": None, "e": float("nan"), "f": np.array(2.0)}
    found = sl.sweep({**ROBOTS, "resolution": 32}, **HOW, metrics=[lambda run: numbers])
    assert [str(found[name].dtype) for name in "abcdef"] == [
        "float64", "Int64", "boolean", "float64", "float64", "float64"
    ]  # fmt: skip
    assert found["d"].isna().all()
    assert found["e"].isna().all()


@pytest.mark.parametrize("metrics", [[lit, lit], "nothing", [3], lambda run: 1 if run else 2, 7])
def test_metrics_that_are_none_are_an_error_before_the_work_starts(metrics):
    if callable(metrics):
        metrics.__name__ = "misclassified"
    with pytest.raises(ShadowlabError, match="metric"):
        sl.sweep(ROBOTS, **HOW, metrics=metrics)


def test_a_run_that_is_late_is_a_failure():
    start = time.monotonic()
    found = sl.sweep({**ROBOTS, "resolution": [32, 64, 128]}, **HOW, metrics=[sleep_at_64], timeout=0.3)
    assert list(found["failure_type"]) == ["", "TimeoutError", ""]
    assert "timeout of 0.3 s" in found["failure"][1]
    assert time.monotonic() - start < 30


@pytest.mark.parametrize(
    "wrong", [{"timeout": 0}, {"timeout": "soon"}, {"workers": 0}, {"workers": 2.5}, {"progress": 3},
              {"renderer": "tpu"}, {"size": (0, 3)}]
)  # fmt: skip
def test_arguments_that_are_none_are_errors(wrong):
    with pytest.raises(ShadowlabError):
        sl.sweep(ROBOTS, **{**HOW, **wrong})


def test_the_order_of_the_rows_given_is_that_of_the_table():
    rows = [{**ROBOTS, "scene": name, "resolution": side} for side in (64, 32) for name in ("@robots", "@dueling")]
    found = sl.sweep(rows, **HOW)
    assert list(found["resolution"]) == [64, 64, 32, 32]
    assert list(found["scene"]) == ["robots", "dueling"] * 2
    back = sl.sweep(rows[::-1], **HOW)
    same(found, back.iloc[::-1].reset_index(drop=True))


def test_a_metric_that_ends_the_program_is_the_failure_of_its_row():
    def leave(run):
        raise SystemExit("enough")

    found = sl.sweep({**ROBOTS, "resolution": 32}, **HOW, metrics=[leave])
    assert list(found["failure_type"]) == ["SystemExit"]
    assert "enough" in found["failure"].iloc[0]


def test_an_interruption_comes_through():
    def interrupt(run):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sl.sweep(ROBOTS, **HOW, metrics=[interrupt])
    with pytest.raises(ArgumentError, match="executor"):
        sl.sweep(ROBOTS, **HOW, workers=2, executor=object())


def test_a_metric_that_raises_where_its_name_is_asked_for_is_measured():
    class Rude:
        def __getattr__(self, name):
            raise RuntimeError(name)

        def __call__(self, run):
            return run.resolution

    assert list(sl.sweep(ROBOTS, **HOW, metrics=[Rude()])["Rude"]) == [ROBOTS.get("resolution", 1024)]


def test_hundreds_of_numbers_are_columns_without_a_warning():
    def many(run):
        return {f"c{i}": i for i in range(300)}

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = sl.sweep(ROBOTS, **HOW, metrics=[many])
    assert [found[f"c{i}"][0] for i in range(300)] == list(range(300))
