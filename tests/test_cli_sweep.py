"""`shadowlab sweep`: the table is that of `sl.sweep`, a dry run runs nothing, and mistakes have file, line and key."""

from __future__ import annotations

import functools
import json
import re
from pathlib import Path

import pandas as pd
import pytest
from cli_support import fails, fails_in

import shadowlab as sl
from shadowlab.cli.config import read_config
from shadowlab.cli.sweep import duration_text
from shadowlab.cli.sweep_config import sweep_config

DOCUMENT = Path(__file__).resolve().parents[1] / "docs" / "sweep_config.md"
HEAD = 'size = "32x18"\nbackend = "cpu"\n[space]\n'
GOOD = f'{HEAD}scene = "@robots"\ntechnique = ["uniform", "lispsm"]\n'


@pytest.fixture
def sweep(run_config):
    """Runs `shadowlab sweep` on a text."""
    return functools.partial(run_config, "sweep", "s.toml")


def test_the_table_is_that_of_sweep_in_csv_and_json(sweep):
    text = f'{GOOD}lispsm.near_factor = [0.5, 2.0]\nlight = ["own", [-0.3, -1, -0.2]]\nresolution = [32, 64]\n'
    status, out, err = sweep(text, "--out", "a.csv")
    assert (status, err) == (0, "")
    assert "12 runs\n" in out
    space = {
        "scene": "@robots", "technique": ["uniform", "lispsm"], "lispsm.near_factor": [0.5, 2.0],
        "light": ["own", (-0.3, -1, -0.2)], "resolution": [32, 64],
    }  # fmt: skip
    expected = sl.sweep(space, size=(32, 18), renderer="cpu", progress=False)
    columns = ["scene", "light", "technique", "lispsm.near_factor", "resolution", "misclassified", "share", "failure"]
    read = pd.read_csv("a.csv", keep_default_na=False, na_values={"lispsm.near_factor": ""})
    assert list(read.columns) == list(expected.columns)
    pd.testing.assert_frame_equal(read[columns], expected[columns], check_dtype=False)
    assert sweep(text, "--out", "a.json")[0] == 0
    rows = json.loads(Path("a.json").read_text(encoding="utf-8"))
    assert [row["misclassified"] for row in rows] == list(expected["misclassified"])
    assert rows[0]["lispsm.near_factor"] is None
    assert rows[0]["failure"] == ""


def test_the_configuration_of_the_page_has_the_runs_that_a_dry_run_counts(sweep):
    text = re.findall(r"```toml\n(.*?)```", DOCUMENT.read_text(encoding="utf-8"), re.DOTALL)[0]
    status, out, err = sweep(text, "--dry-run", "--workers", "2", "--store", "runs.sqlite")
    assert (status, err) == (0, "")
    # Two scenes under three lights, of uniform and of lispsm with three factors, at two resolutions.
    assert f"s.toml: {2 * 3 * (1 + 3) * 2} runs in 6 views of 2 scenes, on cpu" in out
    assert "technique, lispsm.near_factor, resolution\n" in out
    assert "Note: lispsm.near_factor does not apply to uniform" in out
    assert "from 3 timed runs" in out
    assert "Workers share the cores" in out
    assert sorted(path.name for path in Path().iterdir()) == ["s.toml"]


def test_rows_and_drawn_rows(sweep, tmp_path):
    rows = 'size = "32x18"\nbackend = "cpu"\n' + "".join(
        f'[[space]]\nscene = "@robots"\ntechnique = "uniform"\nresolution = {n}\n' for n in (16, 24, 32)
    )
    assert sweep(rows, "--out", "a.csv")[0] == 0
    assert list(pd.read_csv("a.csv")["resolution"]) == [16, 24, 32]
    assert "\n1 run\n" in sweep(f'{HEAD}scene = "@robots"\ntechnique = "uniform"\nresolution = 16\n')[1]
    text = f"{GOOD}lispsm.near_factor = {{ min = 0.5, max = 4.0, log = true }}\n[random]\nn = 5\nseed = 3\n"
    (tmp_path / "r.toml").write_text(text)
    drawn = sweep_config(read_config("r.toml")).space
    space = {
        "scene": "@robots", "technique": ["uniform", "lispsm"],
        "lispsm.near_factor": {"min": 0.5, "max": 4.0, "log": True},
    }  # fmt: skip
    assert drawn == sl.random(space, 5, seed=3)


def test_some_failures_are_told_and_all_are_an_error(sweep):
    text = f'{HEAD}scene = "@robots"\nresolution = 32\ntechnique = %s\n'
    status, out, err = sweep(text % '["uniform", "lispsm:near=-3"]')
    assert (status, err) == (0, "")
    assert "2 runs, 1 of them failed" in out
    assert "near" in out.splitlines()[-1]
    status, out, err = sweep(text % '"lispsm:near=-3"')
    assert (status, out) == (2, "")
    assert err.startswith("shadowlab: error: the only run failed: ")


def test_a_sweep_goes_on_where_it_was(sweep):
    text = f"{GOOD}resolution = %s\n"
    assert "Store: runs.sqlite, a new file\n" in sweep(text % "[16, 24]", "--store", "runs.sqlite", "--dry-run")[1]
    assert not Path("runs.sqlite").exists()
    assert sweep(text % "[16, 24]", "--store", "runs.sqlite", "--out", "a.csv")[0] == 0
    out = sweep(text % "[16, 24, 32]", "--store", "runs.sqlite", "--dry-run")[1]
    assert "s.toml: 6 runs" in out
    assert "Store: runs.sqlite, 4 of them are there" in out
    status, out, err = sweep(f'store = "runs.sqlite"\nworkers = 1\n{text}' % "[16, 24, 32]", "--out", "b.csv")
    assert (status, err) == (0, "")
    first, second = (pd.read_csv(name) for name in ("a.csv", "b.csv"))
    # Times are those of the first sweep: nothing was run again.
    kept = second[second["resolution"] < 32].reset_index(drop=True)
    pd.testing.assert_series_equal(kept["seconds"], first["seconds"])
    assert len(second) == 6
    assert len(sl.read_store("runs.sqlite")) == 6
    out = sweep(text % "[16, 24, 32]", "--store", "runs.sqlite", "--dry-run")[1]
    assert "Estimate: 0.0 s in one process" in out


def test_a_store_that_is_none_is_an_error(sweep):
    Path("runs.sqlite").write_bytes(b"no store at all, but long enough for a head" * 40)
    for words in ((), ("--dry-run",)):
        fails(sweep(GOOD, "--store", "runs.sqlite", *words), "runs.sqlite")


def test_a_store_that_is_there_may_be_refused(sweep):
    Path("runs.sqlite").write_bytes(b"")
    status, out, err = sweep(GOOD, "--store", "runs.sqlite", "--no-resume")
    assert (status, out) == (2, "")
    assert "no-resume: 'runs.sqlite' is there" in err


BAD = {
    "unknown key": (f"{GOOD}resolutoin = 3\n", ":6: space.resolutoin: unknown key; did you mean 'resolution'?"),
    "unknown key at the top": (f"workesr = 3\n{GOOD}", ":1: workesr: unknown key; did you mean 'workers'?"),
    "unknown technique of a setting": (
        f"{GOOD}lipsm.near = 3\n", ":6: space.lipsm.near: unknown technique 'lipsm'; did you mean 'lispsm'?"
    ),
    "unknown setting": (
        f"{GOOD}lispsm.nera = 3\n", ":6: space.lispsm.nera: unknown setting 'nera' of lispsm; did you mean 'near'?"
    ),
    "unknown setting in quotes": (f'{GOOD}"technique.nera" = 3\n', ":6: space.technique.nera: unknown setting 'nera'"),
    "setting twice": (f'{GOOD}lispsm.near = 3\n"lispsm.near" = 2\n', ":7: space.lispsm.near: lispsm.near is given"),
    "unknown metric": (f'metrics = "causse"\n{GOOD}', ":1: metrics: unknown metric 'causse'; did you mean"),
    "unknown renderer": (f"{GOOD}".replace('"cpu"', '"cup"'), ":2: backend: unknown renderer 'cup'; did you mean"),
    "size": (f"{GOOD}".replace('"32x18"', "[32]"), ":1: size: expected width x height"),
    "workers": (f"workers = 0\n{GOOD}", ":1: workers: expected a whole number of 1 or more, got 0"),
    "timeout": (f"timeout = 0\n{GOOD}", ":1: timeout: expected seconds above 0, got 0"),
    "store nowhere": (f'store = "no/such/a.sqlite"\n{GOOD}', ":1: store: expected a file in a folder that is there"),
    "no space": ("size = [32, 18]\n", ":1: space: expected a table, got none; try [space]"),
    "no scene": (f'{HEAD}technique = "uniform"\n', ":3: space.scene: expected one or several, got none"),
    "unknown scene": (GOOD.replace("@robots", "@robot"), ":4: space.scene: unknown scene '@robot'; did you mean"),
    "missing file": (GOOD.replace("@robots", "no.glb"), ":4: space.scene: cannot find the file 'no.glb'"),
    "unknown technique": (
        GOOD.replace("uniform", "unifrom"), ":5: space.technique: unknown technique 'unifrom'; did you mean 'uniform'?"
    ),
    "unknown preset": (GOOD.replace("uniform", "preset:filamint"), ":3: space: ", "filamint"),
    "resolution": (f"{GOOD}resolution = [32, 0]\n", ":6: space.resolution: expected a whole number above 0, got 0"),
    "memory": (f'{GOOD}memory = "lots"\n', ":6: space.memory: expected bytes"),
    "both": (f'{GOOD}memory = "4MiB"\nresolution = 32\n', ":6: space.memory: expected resolution or memory"),
    "bias": (f'{GOOD}bias = ["none", "wrold=1"]\n', ":6: space.bias: ", "wrold"),
    "interval": (f"{GOOD}resolution = {{ min = 1, max = 2 }}\n", ":6: space.resolution: expected a list of values"),
    "labels": (f"{GOOD}resolution = {{ small = 16 }}\n", ":6: space.resolution: ", "without labels"),
    "unknown view": (f'{GOOD}camera = "below"\n', ":3: space: camera: unknown camera 'below'"),
    "random of nothing": (f"{GOOD}[random]\nseed = 1\n", ":6: random.n: expected how many rows are drawn"),
    "random of rows": ('[[space]]\nscene = "@robots"\ntechnique = "uniform"\n[random]\nn = 1\n', ":4: random: "),
    "unknown key of random": (f"{GOOD}[random]\nn = 1\nsede = 1\n", ":8: random.sede: unknown key; did you mean"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_a_mistake_is_one_line_with_file_line_and_key(sweep, name):
    text, *says = BAD[name]
    fails_in("s.toml", sweep(text, "--dry-run"), *says)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--out", "a.xlsx"), "out: expected a file that ends in one of .csv, .json, .parquet"),
        (("--out", "s.toml/a.csv"), "out: cannot write"),
        (("--workers", "0"), "'--workers'"),
        (("--workers", "two"), "'--workers'"),
    ],
)
def test_a_wrong_option_is_one_line(sweep, words, says):
    fails(sweep(GOOD, *words), says)


def test_times_as_people_say_them():
    assert [duration_text(s) for s in (0.31, 12.4, 240.0, 9000.0)] == ["0.3 s", "12 s", "4 min", "2.5 h"]


def test_a_mistake_is_told_with_its_line_once(sweep):
    for text in (GOOD.replace('"lispsm"', '"lipsm"'), GOOD.replace("@robots", "@robot"), f"{GOOD}[random]\nn = 0\n"):
        status, _, err = sweep(text)
        assert status == 2
        assert err.count("s.toml:") == 1, err


def test_numbers_with_thousands_of_digits_are_a_mistake_of_the_file(sweep):
    status, _, err = sweep(f"{GOOD}lispsm.near = {'9' * 5000}\n")
    assert status == 2
    assert err.startswith("shadowlab: error: s.toml: no valid TOML: ")


def test_the_table_does_not_take_the_place_of_the_store(sweep):
    for words in (("--store", "a.csv", "--out", "./a.csv"), ("--store", "./a.csv", "--out", "a.csv")):
        status, _, err = sweep(GOOD, *words)
        assert status == 2
        assert err.startswith("shadowlab: error: out: expected another file than the store")
        assert not Path("a.csv").exists()


def test_limits_of_the_configuration_are_told_where_they_stand(sweep):
    for key, value in (("timeout", "inf"), ("timeout", "nan"), ("workers", "2000")):
        status, _, err = sweep(f"{key} = {value}\n{GOOD}")
        assert status == 2
        assert err.startswith(f"shadowlab: error: s.toml:1: {key}: expected ")
