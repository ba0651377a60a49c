"""`shadowlab experiment scene-optimal`: what it prints and writes, its exit status, and one line for what is wrong."""

from __future__ import annotations

import json
from functools import partial

import pytest

import shadowlab as sl
from shadowlab.experiments import scene_optimal, scene_optimal_table, scene_optimal_views
from shadowlab.reports import scene_optimal as report


@pytest.fixture
def small(monkeypatch):
    """The command with small pictures of a scaled scene, and without figures."""
    scene = sl.library.scene("statues", facets=12, leaves=20)
    monkeypatch.setattr(scene_optimal_views, "configurations", partial(scene_optimal_views.configurations, 128, scene))
    monkeypatch.setattr(report, "FIGURES", ())  # tests of plots look at them
    monkeypatch.setattr(scene_optimal, "QUICK_SIZES", (128,))
    # Of small pictures with few samples the gain is less.
    small = {name: 0.75 * least for name, least in scene_optimal_table.BOUNDS.items()}
    monkeypatch.setattr(scene_optimal_table, "BOUNDS", small)


def test_quick_counts_four_configurations_and_checks_bounds(run, tmp_path, small):
    words = ("experiment", "scene-optimal", "--quick", "--backend", "cpu", "--out", tmp_path)
    status, out, err = run(*words)
    assert err == ""
    assert "4 configurations on cpu" in out
    assert "4 of 4" in out
    assert status == 0, out
    assert "Bounds hold: scene_optimal:search=published at least" in out
    names = {"runs.sqlite", "runs.csv", "totals.csv", "views.csv", "results.json", "table.md"}
    assert {file.name for file in tmp_path.iterdir()} == names
    data = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert {row["view"] for row in data["runs"]} == set(scene_optimal_views.QUICK)


def test_a_bound_that_fails_is_exit_status_1(run, tmp_path, small, monkeypatch):
    monkeypatch.setattr(scene_optimal_table, "BOUNDS", {"scene_optimal": 1e6})
    status, out, _ = run("experiment", "scene-optimal", "--quick", "--backend", "cpu", "--out", tmp_path)
    assert status == 1
    assert "scene_optimal: expected that the normal map makes at least 1e+06 % more mistakes at 128², got" in out


def test_options_choose_what_is_counted(run, tmp_path, small):
    words = ("--sizes", "64,96", "--technique", "uniform", "--configuration", "walk, noon", "--backend", "cpu")
    status, out, err = run("experiment", "scene-optimal", *words, "--out", tmp_path)
    assert (status, err) == (0, "")
    assert "1 configurations" not in out
    assert "1 configuration on cpu" in out
    assert "Bounds" not in out
    data = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert [(row["technique"], row["single_side"]) for row in data["runs"]] == [
        ("uniform:turn=rectangle", 64), ("uniform", 64), ("uniform:turn=rectangle", 96), ("uniform", 96),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--sizes", "abc"), "abc"),
        (("--sizes", "64,64"), "sizes: expected at least one, each once"),
        (("--technique", "lispsn"), "lispsn"),
        (("--configuration", "moon"), "configurations: unknown 'moon'; expected a camera (walk"),
        (("--backend", "tpu"), "tpu"),
        (("--out", ""), "out: expected the name of a directory"),
    ],
)
def test_wrong_words_are_one_line_and_exit_status_2(run, small, tmp_path, words, message):
    status, out, err = run("experiment", "scene-optimal", "--out", tmp_path, *words)
    assert (status, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1


def test_an_experiment_must_be_named(run):
    for words in ((), ("scene-optimum",)):
        status, _, err = run("experiment", *words)
        assert status == 2
        assert err.count("\n") == 1
