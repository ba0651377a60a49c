"""`shadowlab advise`: what it prints and writes, its lights, and one line with exit status 2 for what is wrong."""

from __future__ import annotations

import json
import math
import shlex

import numpy as np
import pandas as pd
import pytest
import trimesh

import shadowlab as sl
from shadowlab import cli
from shadowlab.cli.advise import elevated, parse_elevations

SMALL = ("--size", "32x18", "--backend", "cpu", "--technique", "uniform", "--technique", "lispsm")


@pytest.fixture
def run(run):
    """Runs `shadowlab advise`."""
    return lambda *words: run("advise", *words)


def test_it_ranks_and_writes_and_says_where(run, tmp_path):
    out_dir = tmp_path / "out"
    words = ("--memory", "16KiB,64KiB", "--memory=256KiB", "--lights", "15,60", "--error", "p95", "--over", "worst")
    status, out, err = run("@robots", *words, *SMALL, "--out", out_dir)
    assert (status, err) == (0, "")
    assert "by texel length of 95 % of the pixels" in out
    assert "At 16 KiB, " in out
    assert str(out_dir / "report.html") in out
    assert {f.name for f in out_dir.iterdir()} == {
        "report.html", "advice.csv", "runs.csv", "switches.csv", "advice.json", "advice.png",
    }  # fmt: skip
    data = json.loads((out_dir / "advice.json").read_text(encoding="utf-8"))
    assert data["memory"] == [2**14, 2**16, 2**18]
    assert (data["measure"]["name"], data["over"]) == ("p95", "worst")
    np.testing.assert_allclose([v["light_elevation"] for v in data["views"]], np.radians([15, 60]))
    assert len(pd.read_csv(out_dir / "runs.csv")) == 2 * 3 * 2


@pytest.mark.parametrize(
    "lights",
    [
        ("--lights", "15,60"),
        ("--light", "1,-2,0.5", "--light=-1,-1,0"),
        ("--light-position", "0,6,0", "--cone-deg", "70", "--light", "0,-1,0", "--light", "0.5,-1,0"),
    ],
)
def test_the_options_that_are_printed_repeat_the_views(run, tmp_path, lights):
    words = ("@robots", "--memory", "64KiB", *SMALL)
    status, out, err = run(*words, *lights, "--out", tmp_path / "a")
    assert (status, err) == (0, "")
    assert "View: that of the scene; --view along" in out
    flags = shlex.split(next(line for line in out.splitlines() if line.startswith("  --eye=")))
    assert run(*words, *flags, "--out", tmp_path / "b")[0] == 0
    first, second = (json.loads((tmp_path / d / "advice.json").read_text(encoding="utf-8")) for d in "ab")
    assert len(first["views"]) == 2
    for before, after in zip(first["views"], second["views"], strict=True):
        # Through degrees and a target point: a few last digits may differ.
        np.testing.assert_allclose(after["light_elevation"], before["light_elevation"], rtol=1e-12)
    errors = [pd.read_csv(tmp_path / d / "runs.csv")["error"] for d in "ab"]
    np.testing.assert_array_equal(*errors)
    assert errors[0].notna().all()


def test_the_python_in_the_data_gives_the_number(run, tmp_path):
    run("@skylight", "--memory", "16KiB", *SMALL, "--bias", "world=0.02", "--out", tmp_path)
    data = json.loads((tmp_path / "advice.json").read_text(encoding="utf-8"))
    for row in data["table"]:
        names: dict = {}
        exec(compile(row["reproduce"], "snippet", "exec"), names)
        assert abs(names["error_mean"] - row["error_mean"]) <= 1 / (32 * 18)


def test_lights_are_repeated_and_in_the_axes_of_the_file(run, tmp_path):
    path = tmp_path / "box.ply"
    trimesh.creation.box().export(path)
    words = ("--up", "z", "--ground", "--light", "1,0,-1", "--light", "-1 -1 -1", "--memory", "16KiB")
    status, _, err = run(path, *words, *SMALL, "--out", tmp_path / "a")
    assert (status, err) == (0, "")
    data = json.loads((tmp_path / "a" / "advice.json").read_text(encoding="utf-8"))
    directions = [v["light"]["direction"] for v in data["views"]]
    np.testing.assert_allclose(directions, [np.array([1, -1, 0]) / math.sqrt(2), np.array([-1, -1, 1]) / math.sqrt(3)])
    for row in data["runs"]:
        assert "sl.load_scene" in row["reproduce"]


def test_spots_and_points(run, tmp_path):
    place = ("@robots", "--light-position", "0,6,0", "--memory", "96KiB", *SMALL)
    assert run(*place, "--out", tmp_path / "a")[0] == 0
    spots = ("--cone-deg", "60", "--light", "0,-1,0.1", "--light", "0.3,-1,0.1")
    assert run(*place, *spots, "--out", tmp_path / "b")[0] == 0
    data = json.loads((tmp_path / "b" / "advice.json").read_text(encoding="utf-8"))
    assert [v["light"]["kind"] for v in data["views"]] == ["spot", "spot"]


def test_elevations_keep_the_azimuth():
    camera = sl.Camera.look_at((0, 0, 5), (0, 0, 0))
    light = elevated(sl.DirectionalLight((3, -9, 4)), camera, math.radians(30))
    np.testing.assert_allclose(light.direction, [0.6 * math.cos(math.pi / 6), -0.5, 0.8 * math.cos(math.pi / 6)])
    overhead = elevated(sl.DirectionalLight((0, -1, 0)), camera, math.radians(30))
    np.testing.assert_allclose(overhead.direction, [math.cos(math.pi / 6), -0.5, 0], atol=1e-12)
    np.testing.assert_allclose(parse_elevations("0, 45 90"), [0, math.pi / 4, math.pi / 2])


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        (("--memory", "lots"), ("memory: expected bytes",)),
        (("--memory", "4XB"), ("memory: unknown unit 'XB'", "MiB")),
        (("--memory", "10"), ("memory: expected at least 256 bytes",)),
        (("--memory", "1MiB,1MiB"), ("memory: 1 MiB comes twice",)),
        (("--memory", "1MiB,"), ("memory: expected bytes",)),
        (("--memory", "1MiB", "--error", "psnr"), ("error: unknown error 'psnr'", "misclassified, worst, p95")),
        (("--memory", "1MiB", "--over", "max"), ("over: unknown choice 'max'", "mean, worst")),
        (("--memory", "1MiB", "--technique", "unifrom"), ("unifrom", "uniform")),
        (("--memory", "1MiB", "--technique", "uniform", "--technique", "uniform"), ("'uniform' is given twice",)),
        (("--memory", "1MiB", "--lights", "steep"), ("lights: expected elevations from 0 to 90 degrees",)),
        (("--memory", "1MiB", "--lights", "100"), ("lights: expected elevations",)),
        (("--memory", "1MiB", "--lights", "nan"), ("lights: expected elevations",)),
        (("--memory", "1MiB", "--lights", ""), ("lights: expected elevations",)),
        (("--memory", "1MiB", "--lights", "10,10"), ("lights: an elevation comes twice",)),
        (("--memory", "1MiB", "--lights", "10", "--light", "1,-1,0"), ("lights: expected elevations or --light",)),
        (("--memory", "1MiB", "--light", "1,-1,0", "--light", "1,-1,0"), ("light: '1,-1,0' is given twice",)),
        (("--memory", "1MiB", "--light", "1,-1"), ("light: expected three numbers",)),
        (("--memory", "1MiB", "--size", "x"), ("size",)),
        (("--memory", "1MiB", "--out", ""), ("out: expected the name of a directory",)),
        (("--memory", "1MiB", "--frobnicate"), ("--frobnicate", "--help")),
    ],
)
def test_what_is_wrong_is_one_line(run, words, parts):
    status, out, err = run("@robots", "--size", "16x9", "--backend", "cpu", *words)
    assert (status, out) == (2, "")
    assert err.startswith("shadowlab: error: ")
    assert err.count("\n") == 1
    for part in parts:
        assert part in err


def test_a_technique_that_serves_no_such_light_is_an_error_where_it_is_alone(run, tmp_path):
    words = ("--light-position", "0,4,0", "--memory", "1MiB", "--size", "16x9", "--backend", "cpu")
    status, out, err = run("@robots", *words, "--technique", "tsm", "--out", tmp_path)
    assert (status, out) == (2, "")
    assert "does not support a point light" in err


def test_compare_still_takes_one_light(capfd):
    with pytest.raises(SystemExit):
        cli.main(["compare", "--help"])
    assert "--light DX,DY,DZ" in capfd.readouterr().out
