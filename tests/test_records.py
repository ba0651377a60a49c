"""Rows of tables without pandas: they hold what the tables hold, and their CSV is that of pandas letter by letter."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

import shadowlab as sl
from shadowlab.experiments.columns import COLUMNS, TABLES, table
from shadowlab.experiments.records import csv_text, records
from shadowlab.reports.html.chart import error_chart
from shadowlab.reports.terminal import study_table
from shadowlab.text import is_missing


@pytest.fixture(scope="module")
def study():
    """Runs with numbers, one that failed, and one with a label that CSV has to quote."""
    scene = sl.library.scene("robots")
    techniques = {"uniform": "uniform", 'a, "b"\nc': "lispsm", "psm": "psm"}
    light = sl.PointLight((0, 6, 0), range=40)
    return sl.compare(
        scene, scene.camera, light, techniques, resolution=[16, 32], size=(32, 18), renderer="cpu", progress=False
    )


def test_rows_are_those_of_the_table(study):
    assert any(row["failure"] for row in study.rows)
    assert list(study.rows[0]) == list(TABLES["compare"]) == list(study.table.columns)
    pd.testing.assert_frame_equal(table("compare", study.rows), study.table)
    for row, other in zip(study.rows, study.table.to_dict("records"), strict=True):
        for name, value in row.items():
            assert (value is None) == is_missing(other[name])
            assert value is None or value == other[name]


def test_csv_is_that_of_pandas(study):
    assert csv_text("compare", study.rows) == study.table.to_csv(index=False)


def test_any_number_is_written_as_pandas_writes_it():
    numbers = [0.1, 1e300, 5e-324, 1e16, 123456789.125, np.float32(0.1), 3, -0.0, None, float("nan")]
    rows = [
        {"technique": "x", "texel_max": number, "misclassified": None if i % 3 else i, "share": number}
        for i, number in enumerate(numbers)
    ]
    assert csv_text("compare", records("compare", rows)) == table("compare", rows).to_csv(index=False)
    flags = [{"technique": "x", "frame": 1, "refit": flag} for flag in (True, None, np.False_)]
    assert csv_text("temporal.frames", records("temporal.frames", flags)) == table("temporal.frames", flags).to_csv(
        index=False
    )


def test_whoever_shows_rows_shows_the_same_of_the_table(study):
    assert study_table(study.rows) == study_table(study.table)
    assert error_chart(study.rows) == error_chart(study.table)
    assert "polyline" in error_chart(study.rows)


@pytest.mark.parametrize("value", [None, float("nan"), np.nan, pd.NA, pd.NaT, np.float32("nan")])
def test_what_is_missing(value):
    assert is_missing(value)


@pytest.mark.parametrize("value", [0, 0.0, "", False, float("inf"), np.int64(3)])
def test_what_is_not_missing(value):
    assert not is_missing(value)


def test_every_kind_of_column_has_its_type():
    assert {column.dtype for column in COLUMNS.values()} == {"str", "Int64", "float64", "boolean"}
