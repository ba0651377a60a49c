"""Sweeps in processes of their own: the same table, workers that die or hang, interruptions, programs of every kind."""

from __future__ import annotations

import functools
import os
import signal
import subprocess
import sys
import threading
import time

import pytest
from sweep_support import (
    HOW,
    ROBOTS,
    SPACE,
    hang_at_64,
    kill_at_64,
    kill_at_64_once,
    lit,
    pid,
    raise_at_64,
    same,
)

import shadowlab as sl
from shadowlab.errors import ArgumentError, WorkerError

TESTS = os.path.dirname(__file__)  # noqa: PTH120 - text for a variable
#: Sweeps without a guard for the main module.
PROGRAM = """
import sys
import shadowlab as sl

def wide(run):
    return run.mask.shape[1]

found = sl.sweep({"scene": "@robots", "technique": ["uniform", "lispsm"], "resolution": 32}, size=(64, 36),
                 workers=2, metrics=["misclassified", wide], renderer="cpu")
print("rows", len(found), [int(width) for width in found["wide"]], list(found["failure"]))
"""
INTERRUPTED = """
import os, pathlib, subprocess, time
import shadowlab as sl

def slow(run):
    pathlib.Path("begun").touch()
    time.sleep(60)
    return 1

try:
    space = {"scene": "@robots", "technique": "uniform", "resolution": list(range(32, 64))}
    sl.sweep(space, size=(64, 36), workers=2, metrics=[slow], renderer="cpu")
except KeyboardInterrupt:
    print("interrupted")
all = subprocess.run(["ps", "-eo", "ppid,args"], capture_output=True, text=True).stdout.splitlines()
print("left", [line for line in all if line.split()[0] == str(os.getpid()) and "sweeps.worker" in line])
"""


def children() -> set[int]:
    """The processes that this one started and that are still there."""
    found = set()
    for line in subprocess.run(["ps", "-eo", "pid,ppid"], capture_output=True, text=True).stdout.splitlines()[1:]:
        child, parent = map(int, line.split())
        if parent == os.getpid():
            found.add(child)
    return found


@pytest.fixture(autouse=True)
def no_child_stays():
    before = children()
    yield
    # That of `ps` has ended by now.
    assert not {one for one in children() - before if alive(one)}


def alive(process: int) -> bool:
    """Whether a process is there."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


def test_workers_give_the_same_table():
    metrics = ["misclassified", "texels", lit, raise_at_64]
    here = sl.sweep(SPACE, **HOW, metrics=metrics)
    same(here, sl.sweep(SPACE, **HOW, metrics=metrics, workers=3))


def test_workers_share_the_work_and_the_threads():
    found = sl.sweep(
        {**ROBOTS, "resolution": list(range(32, 48))}, **HOW, workers=2, metrics=[pid, lambda run: sl.threads()]
    )
    assert len(set(found["pid"])) == 2, "a view is divided where there are more workers than views"
    assert os.getpid() not in set(found["pid"])
    assert set(found["<lambda>"]) == {max(1, sl.threads() // 2)}


def test_a_worker_that_dies_costs_its_run_another_try(tmp_path):
    space = {**ROBOTS, "technique": ["uniform", "tsm"], "resolution": [32, 64, 48]}
    found = sl.sweep(space, **HOW, workers=2, metrics=[functools.partial(kill_at_64_once, mark=tmp_path / "mark")])
    assert list(found["failure"]) == [""] * 6
    assert list(found["kill_at_64_once"]) == [32, 64, 48] * 2


def test_a_run_that_kills_its_worker_twice_is_a_failure():
    found = sl.sweep({**ROBOTS, "resolution": [32, 64, 48]}, **HOW, workers=2, metrics=[kill_at_64])
    assert list(found["failure_type"]) == ["", "WorkerError", ""]
    assert "SIGKILL" in found["failure"][1]
    assert list(found["kill_at_64"].dropna()) == [32, 48]


def test_a_worker_that_hangs_is_ended():
    start = time.monotonic()
    space = {**ROBOTS, "resolution": [64, 32, 48]}
    found = sl.sweep(space, **HOW, workers=1, metrics=[hang_at_64], timeout=0.3)
    assert list(found["failure_type"]) == ["TimeoutError", "", ""]
    assert "timeout of 0.3 s" in found["failure"][0]
    assert time.monotonic() - start < 30


def test_what_cannot_be_sent_is_an_error_before_the_work_starts():
    lock = threading.Lock()

    def locked(run):
        return int(lock.locked())

    with pytest.raises(ArgumentError, match=r"locked.*cannot be sent"):
        sl.sweep(ROBOTS, **HOW, workers=1, metrics=[locked])

    class Odd:
        name, settings, needs_samples = "odd", {}, False

        def __init__(self):
            self.lock = lock

        def parameterize(self, *args, **keywords):
            return sl.technique("uniform").parameterize(*args, resolution=keywords["resolution"])

    space = {"scene": "@robots", "technique": [Odd()], "resolution": 32}
    assert list(sl.sweep(space, **HOW)["failure"]) == [""], "in this process it works"
    with pytest.raises(ArgumentError, match=r"odd.*cannot be sent"):
        sl.sweep(space, **HOW, workers=1)


def test_what_cannot_be_read_in_the_worker_is_an_error(monkeypatch, tmp_path):
    (tmp_path / "gone_module.py").write_text("def metric(run):\n    return 1\n")
    monkeypatch.syspath_prepend(tmp_path)
    import gone_module

    (tmp_path / "gone_module.py").unlink()
    with pytest.raises(WorkerError, match="gone_module"):
        sl.sweep(ROBOTS, **HOW, workers=1, metrics=[gone_module.metric])


def test_without_an_interpreter_to_start_it_is_said_what_to_do(monkeypatch):
    monkeypatch.setattr(sys, "frozen", True, raising=False)
    with pytest.raises(WorkerError, match="leave workers out"):
        sl.sweep(ROBOTS, **HOW, workers=2)
    monkeypatch.delattr(sys, "frozen")
    monkeypatch.setattr(sys, "executable", str(os.devnull) + "/python")
    with pytest.raises(WorkerError, match="cannot start"):
        sl.sweep(ROBOTS, **HOW, workers=2)


def test_workers_that_end_before_they_work_are_an_error(monkeypatch):
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(WorkerError, match="end before they work"):
        sl.sweep(ROBOTS, **HOW, workers=2)


@pytest.mark.parametrize("how", ["file", "stdin"])
def test_programs_without_a_guard_work(how, tmp_path):
    (tmp_path / "program.py").write_text(PROGRAM)
    words = {"file": ["program.py"], "stdin": ["-"]}[how]
    done = subprocess.run(
        [sys.executable, *words], input=PROGRAM if how == "stdin" else None, capture_output=True, text=True,
        timeout=120, cwd=tmp_path, env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )  # fmt: skip
    assert done.stdout == "rows 2 [64, 64] ['', '']\n", done.stderr


@pytest.mark.parametrize("send", [os.kill, os.killpg])
def test_ctrl_c_ends_a_sweep_and_its_workers(send, tmp_path):
    (tmp_path / "program.py").write_text(INTERRUPTED)
    process = subprocess.Popen(
        [sys.executable, "program.py"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}, start_new_session=True,
    )  # fmt: skip
    end = time.monotonic() + 60
    while not (tmp_path / "begun").exists() and time.monotonic() < end:
        time.sleep(0.05)
    # To the program alone, and as a terminal does it, to all processes of its group.
    send(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=30)
    assert "interrupted" in out, err
    assert "Traceback" not in err, err
    assert "left []" in out


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")
def test_a_metric_that_forks_and_goes_on_leaves_no_copy_of_its_worker(tmp_path):
    def forks(run):
        child = os.fork()
        if child:
            (tmp_path / str(child)).touch()
        return 1

    found = sl.sweep({**ROBOTS, "resolution": [32, 48, 64]}, **HOW, workers=1, metrics=[forks])
    assert list(found["forks"]) == [1, 1, 1]
    copies = [int(path.name) for path in tmp_path.iterdir()]
    assert len(copies) == 3
    until = time.monotonic() + 10
    while any(map(alive, copies)) and time.monotonic() < until:
        time.sleep(0.05)
    assert not any(map(alive, copies))
