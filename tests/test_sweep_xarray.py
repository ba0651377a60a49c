"""`sl.to_xarray`: axes, units, techniques without a setting, and tables that are no grid."""

from __future__ import annotations

import sys

import numpy as np
import pandas as pd
import pytest
from conftest import imported
from sweep_support import HOW, SIZE, lit

import shadowlab as sl
from shadowlab.errors import ArgumentError, UnsupportedError
from shadowlab.experiments.sweeps.collected import Collected
from shadowlab.experiments.sweeps.plan import plan_of
from shadowlab.experiments.sweeps.work import Answer

SPACE = {
    "scene": ["@robots", "@dueling"], "light": ["own", "0.3,-1,0.1"], "technique": ["uniform", "lispsm"],
    "lispsm.near": [2, 1, -5], "resolution": [64, 32],
}  # fmt: skip


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    imported("xarray")
    return sl.sweep(SPACE, **HOW, metrics=["misclassified", lit])


def test_axes_are_the_swept_keys_and_every_row_is_at_its_place(table):
    ds = sl.to_xarray(table)
    assert dict(ds.sizes) == {"scene": 2, "light": 2, "technique": 2, "lispsm.near": 3, "resolution": 2}
    assert list(ds["resolution"].values) == [32, 64]
    assert list(ds["lispsm.near"].values) == [-5, 1, 2]
    for _, row in table.iterrows():
        at = {name: row[name] for name in ("scene", "light", "technique", "resolution")}
        near = [-5, 1, 2] if row["technique"] == "uniform" else [row["lispsm.near"]]
        for value in near:
            cell = ds.sel({**at, "lispsm.near": value})
            assert cell["failure"].item() == row["failure"]
            for name in ("misclassified", "share", "lit"):
                found = cell[name].item()
                assert np.isnan(found) if pd.isna(row[name]) else found == row[name]
            assert cell["view"].item() == row["view"]


def test_units_and_meanings_are_attributes(table):
    ds = sl.to_xarray(table)
    assert ds["misclassified"].attrs["units"] == "px"
    assert ds["resolution"].attrs["units"] == "texels"
    assert ds["light_angle"].attrs["units"] == "rad"
    assert "Wrong pixels" in ds["misclassified"].attrs["long_name"]
    assert ds.attrs["shadowlab"] == sl.__version__
    assert all(isinstance(value, (str, int, float)) for value in ds.attrs.values())


def test_what_describes_a_view_has_the_axes_on_which_it_depends(table):
    ds = sl.to_xarray(table)
    assert set(ds["light_angle"].dims) == {"scene", "light"}
    assert set(ds["view"].dims) <= {"scene", "light"}
    assert set(ds["spec"].dims) == {"technique", "lispsm.near"}
    assert ds["camera"].dims == ()


def test_columns_without_missing_values_keep_their_types(table):
    ds = sl.to_xarray(table[table["failure"] == ""])
    assert ds["misclassified"].dtype == np.int64
    assert ds["lit"].dtype == np.float64
    assert "texel_mean" not in ds
    assert dict(ds.sizes)["lispsm.near"] == 2


def test_rows_that_are_left_out_are_missing(table):
    some = table[(table["failure"] == "") & ~((table["technique"] == "lispsm") & (table["resolution"] == 64))]
    ds = sl.to_xarray(some)
    gone = ds["misclassified"].sel(technique="lispsm", resolution=64)
    assert bool(np.isnan(gone).all())
    assert not bool(np.isnan(ds["misclassified"].sel(resolution=32)).any())


def test_a_store_is_a_grid_too(tmp_path):
    imported("xarray")
    path = tmp_path / "runs.sqlite"
    sl.sweep(SPACE, **HOW, store=path)
    ds = sl.to_xarray(sl.read_store(path))
    assert set(ds.sizes) == {"scene", "light", "technique", "lispsm.near", "resolution"}


def test_a_single_row_has_no_axis():
    imported("xarray")
    ds = sl.to_xarray(sl.sweep({"scene": "@robots", "technique": "uniform", "resolution": 32}, **HOW))
    assert ds.sizes == {}
    assert ds["misclassified"].shape == ()


def test_rows_that_are_no_grid_are_an_error(table):
    with pytest.raises(ArgumentError, match="one row at each place"):
        sl.to_xarray(pd.concat([table, table]))
    rows = [
        {"scene": "@robots", "technique": "lispsm", "lispsm.near": i, "resolution": 16 + i, "blend": i / 2000}
        for i in range(1, 1200)
    ]
    made = Collected(plan_of(rows, size=SIZE, renderer="cpu"))
    for place in made.missing():
        made.add(Answer(place, {"misclassified": place}))
    with pytest.raises(ArgumentError, match="grid"):
        sl.to_xarray(made.table())


@pytest.mark.parametrize("wrong", [3, [], pd.DataFrame(), pd.DataFrame({"a": [1]})])
def test_what_is_no_table_of_runs_is_an_error(wrong):
    imported("xarray")
    with pytest.raises(ArgumentError, match="table"):
        sl.to_xarray(wrong)


def test_without_xarray_it_is_said_how_to_get_it(table, monkeypatch):
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(UnsupportedError, match=r"pip install 'shadowlab\[tables\]'"):
        sl.to_xarray(table)


def test_a_light_for_each_scene_is_no_axis():
    """Rows with a light of their own for each scene: the light follows from the scene, with or without `attrs`."""
    imported("xarray")
    rows = [
        {"scene": scene, "light": light, "technique": technique, "resolution": 32}
        for scene, light in (("@robots", "0.3,-1,0.1"), ("@dueling", "own"))
        for technique in ("uniform", "lispsm")
    ]
    table = sl.sweep(rows, **HOW)
    assert table.attrs["swept"] == ["scene", "technique"]
    for one in (table, table.copy().pipe(lambda copy: (copy.attrs.clear(), copy)[1])):
        ds = sl.to_xarray(one)
        assert dict(ds.sizes) == {"scene": 2, "technique": 2}
        assert list(ds["light"].values) == ["0.3,-1,0.1", "own"]
        assert ds["light"].dims == ("scene",)


@pytest.mark.parametrize("value", [object(), [1], 10**30, 1j, {"a": 1}], ids=lambda value: type(value).__name__)
def test_a_column_of_something_else_is_an_error(value):
    table = sl.sweep({"scene": "@robots", "technique": ["uniform", "tsm"], "resolution": 32}, **HOW)
    table["mine"] = [value] * len(table)
    with pytest.raises(ArgumentError, match=r"^table: expected numbers or texts in the column 'mine', got .*; drop it"):
        sl.to_xarray(table)
