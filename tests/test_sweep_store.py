"""Sweeps with a store: what is done is not done again, whoever did it; what only the machine failed at is."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pandas as pd
import pytest
from sweep_support import HOW, ROBOTS, SPACE, kill_at_64, lit, same, sleep_at_64

import shadowlab as sl
from shadowlab.errors import ArgumentError, DeviceError, StoreError, UnsupportedError

PROGRAM = """
import sys, time
import shadowlab as sl

def slow(run):
    time.sleep(0.3)
    return 1

try:
    sl.sweep({"scene": "@robots", "technique": "uniform", "resolution": list(range(32, 64))}, size=(64, 36),
             metrics=[slow], renderer="cpu", store="runs.sqlite", workers=int(sys.argv[1]) or None)
except KeyboardInterrupt:
    print("interrupted")
"""


@pytest.fixture
def path(tmp_path):
    return tmp_path / "runs.sqlite"


def counted(space, path, **how):
    """The table, and how many runs were carried out for it."""
    calls = []

    def call(run):
        calls.append(run)
        return 1

    return sl.sweep(space, **{**HOW, **how}, store=path, metrics=["misclassified", call]), len(calls)


def test_what_is_done_is_not_done_again(path):
    first, ran = counted(SPACE, path)
    assert ran == (first["failure"] == "").sum() == 24
    again, ran = counted(SPACE, path)
    assert ran == 0
    pd.testing.assert_frame_equal(first, again, check_exact=True)
    more, ran = counted({**SPACE, "resolution": [32, 64, 48]}, path)
    assert ran == 12
    assert len(more) == 48
    with sl.Store(path) as store:
        fewer, ran = counted({**SPACE, "scene": "@robots", "technique": ["lispsm", "uniform"]}, store)
        assert len(store) == 36, "an open one stays open"
    assert ran == 0
    assert len(fewer) == 12


def test_labels_are_those_of_the_sweep_that_asks(path):
    scene = sl.library.scene("robots")
    rows = {"scene": scene, "camera": scene.camera, "light": scene.light, "resolution": 32}
    first, _ = counted({**rows, "technique": ["lispsm"], "lispsm.near": [2], "lispsm.norm": ["linf"]}, path)
    technique = sl.technique("lispsm", near=2, norm="linf")
    named = {"scene": {"yard": scene}, "camera": {"door": scene.camera}, "light": {"noon": scene.light}}
    again, ran = counted({**rows, **named, "technique": {"mine": technique}}, path)
    assert ran == 0
    assert again.iloc[0][["scene", "view", "camera", "light", "technique"]].tolist() == [
        "yard", "door, noon", "door", "noon", "mine"
    ]  # fmt: skip
    assert "lispsm.near" in first
    assert "lispsm.near" not in again
    assert again["misclassified"][0] == first["misclassified"][0]


def test_a_note_of_what_was_left_out_is_there_once(path):
    space = {**ROBOTS, "lispsm.near": [1], "resolution": 32}
    for _ in range(3):
        found, _ = counted(space, path)
        assert list(found["notes"]) == ["lispsm.near does not apply"]


def test_what_a_row_depends_on_is_in_its_key(path):
    counted({**ROBOTS, "resolution": 32}, path)
    for other in ({"bias": "none"}, {"filter": "bilinear"}, {"stored": "back"}, {"blend": 0.1}, {"light": "0,-1,0"},
                  {"memory": 4096, "resolution": None}):  # fmt: skip
        space = {key: value for key, value in {**ROBOTS, "resolution": 32, **other}.items() if value is not None}
        assert counted(space, path)[1] == 1, other
        assert counted(space, path)[1] == 0, other
    assert counted({**ROBOTS, "resolution": 32}, path, size=(32, 18))[1] == 1
    assert "lit" in sl.sweep({**ROBOTS, "resolution": 32}, **HOW, store=path, metrics=["misclassified", lit])


def test_refusals_are_kept_and_what_the_machine_did_is_not(path):
    point = {**ROBOTS, "technique": "tsm", "light": sl.PointLight((0, 9, 0), range=50), "resolution": 32}
    for _ in range(2):
        found = sl.sweep(point, **HOW, store=path)
        assert list(found["failure_type"]) == ["UnsupportedError"]
    late = sl.sweep({**ROBOTS, "resolution": 64}, **HOW, store=path, metrics=[sleep_at_64], timeout=0.2)
    died = sl.sweep({**ROBOTS, "resolution": 64}, **HOW, store=path, metrics=[kill_at_64], workers=1)
    assert [late["failure_type"][0], died["failure_type"][0]] == ["TimeoutError", "WorkerError"]
    kept = sl.read_store(path)
    assert len(kept) == 3, "failures can be looked at"
    with sl.Store(path) as store:
        assert len(store.missing(list(kept["key"]))) == 2


class Half:
    """A technique that refuses one kind of light, and whose device fails at the other."""

    name, settings, needs_samples = "half", {}, False

    def parameterize(self, scene, camera, light, *, resolution=1024, samples=None):
        raise UnsupportedError("no lamp") if light.kind == "spot" else DeviceError("lost")


def test_what_the_machine_did_with_one_of_several_lights_is_not_kept(path):
    lamp, sun = sl.SpotLight((0, 9, 0), (0, -1, 0.1), cone_angle=1.0, range=50), sl.DirectionalLight((0.3, -1, 0.1))
    space = {"scene": "@robots", "technique": Half(), "light": {"lamp": lamp, "both": (lamp, sun)}, "resolution": 32}
    found = sl.sweep(space, **HOW, store=path)
    assert list(found["failure_type"]) == ["UnsupportedError", "UnsupportedError, DeviceError"]
    kept = sl.read_store(path)
    with sl.Store(path) as store:
        assert store.missing(list(kept["key"])) == list(kept["key"][kept["light"] == "both"])


def test_workers_and_executors_fill_it_alike(path, tmp_path):
    first = sl.sweep(SPACE, **HOW, store=path, workers=2)
    kept = sl.read_store(path, where="failure == ''")
    assert len(kept) == 24
    assert set(kept["lispsm.near"].dropna()) == {1}
    same(first, sl.sweep(SPACE, **HOW, store=tmp_path / "other.sqlite"))
    other = sl.read_store(tmp_path / "other.sqlite", where="failure == ''")
    assert list(other["key"]) == list(kept["key"])
    assert list(other["misclassified"]) == list(kept["misclassified"])


@pytest.mark.parametrize("workers", [0, 2])
def test_an_interrupted_sweep_goes_on_where_it_was(workers, path):
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, str(workers)], stdout=subprocess.PIPE, cwd=path.parent, text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )  # fmt: skip
    end = time.monotonic() + 60
    while time.monotonic() < end and not (path.exists() and rows_in_store(path) >= 2):
        time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=30)
    assert out == "interrupted\n"
    assert 2 <= rows_in_store(path) < 32


def rows_in_store(path) -> int:
    """How many rows are kept; none where the file is being made."""
    try:
        return len(sl.read_store(path))
    except StoreError:
        return 0


@pytest.mark.parametrize("store", [3, sl.Store, object(), []])
def test_what_is_no_store_is_an_error(store):
    with pytest.raises(ArgumentError, match="store"):
        sl.sweep(ROBOTS, **HOW, store=store)
    with pytest.raises(StoreError):
        sl.sweep(ROBOTS, **HOW, store=__file__)


@pytest.mark.parametrize(
    ("numbers", "reason"),
    [
        ({"x" * 300: 1}, "expected names of 1 to 200 letters"),
        ({" ": 1}, "expected names of 1 to 200 letters"),
        ({f"c{i}": i for i in range(3000)}, "expected at most 1,000 numbers, got 3,000"),
        ({"failure": 1}, "expected a name that no column has"),
    ],
)
def test_numbers_that_no_store_takes_are_the_failure_of_their_row(numbers, reason, tmp_path):
    def given(run):
        return numbers if run.resolution == 48 else 1

    space = {"scene": "@robots", "technique": "uniform", "resolution": [32, 48, 64]}
    for store in (None, tmp_path / "runs.sqlite"):
        found = sl.sweep(space, **HOW, metrics=["misclassified", given], store=store)
        assert list(found["failure_type"]) == ["", "ArgumentError", ""]
        assert reason in found["failure"][1]


def test_a_path_that_is_none_is_told_with_one_of_a_store():
    with pytest.raises(ArgumentError, match=r"^store: expected a path, got ''; try \"runs.sqlite\"$"):
        sl.sweep({"scene": "@robots", "technique": "uniform"}, **HOW, store="")
