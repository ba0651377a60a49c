"""Sweeps on executors of others: the same table from each, processes that die, a Dask cluster, joblib."""

from __future__ import annotations

import functools
import multiprocessing
import os
import signal
import threading
import time
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor

import pytest
from conftest import imported
from sweep_support import HOW, ROBOTS, SIZE, SPACE, kill_at_64, kill_at_64_once, lit, pid, raise_at_64, same

import shadowlab as sl
from shadowlab.errors import ArgumentError, WorkerError
from shadowlab.experiments.sweeps.plan import plan_of
from shadowlab.scene.view import KEPT_VIEWS

METRICS = ["misclassified", "texels", lit, raise_at_64]
SPAWN = multiprocessing.get_context("spawn")


@pytest.fixture(scope="module")
def here():
    """The table of this process."""
    return sl.sweep(SPACE, **HOW, metrics=METRICS)


@pytest.fixture(scope="module")
def cluster():
    """Three Dask workers."""
    distributed = imported("distributed")
    # A worker that dies costs its task at once, not after four of them.
    with (
        imported("dask").config.set({"distributed.scheduler.allowed-failures": 0}),
        distributed.LocalCluster(
            n_workers=3, threads_per_worker=1, processes=True, dashboard_address=None, memory_limit=0
        ) as made,
    ):
        yield made


@pytest.fixture
def client(cluster):
    with imported("distributed").Client(cluster) as made:
        made.wait_for_workers(3, timeout=60)
        yield made


def views_of_space():
    """The views of the space of all tests."""
    return [one.view for one in plan_of(SPACE, size=SIZE, renderer="cpu").views]


def test_threads_give_the_same_table(here):
    for view in views_of_space():
        view.clear()
    with ThreadPoolExecutor(3) as executor:
        same(here, sl.sweep(SPACE, **HOW, metrics=METRICS, executor=executor))
        kept = sum(KEPT_VIEWS.holds(view._seen, ("truth", view.light)) for view in views_of_space())
        assert kept <= 2, "pictures of views that are done are not kept"
        lock = threading.Lock()
        found = sl.sweep(ROBOTS, **HOW, metrics=[lambda run: lock.locked()], executor=executor)
        assert list(found["failure"]) == [""], "nothing is sent"


@pytest.mark.parametrize("method", sorted({"spawn", "fork"} & {*multiprocessing.get_all_start_methods()}))
@pytest.mark.filterwarnings("ignore:.*multi-threaded, use of fork:DeprecationWarning")
def test_processes_give_the_same_table(here, method):
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context(method)) as executor:
        same(here, sl.sweep(SPACE, **HOW, metrics=METRICS, executor=executor))
        threads = sl.sweep(
            {**ROBOTS, "resolution": [32, 48]}, **HOW, metrics=[lambda run: sl.threads()], executor=executor
        )
        assert set(threads["<lambda>"]) == {max(1, (os.cpu_count() or 1) // 2)}


class Alone:
    """An executor that has nothing but `submit`; its calls find no files, as on another machine."""

    def __init__(self):
        self.lots, self.max_workers = [], 1

    def submit(self, function, lot, data):
        from dataclasses import replace

        self.lots.append(lot)
        made = Future()
        try:
            made.set_result(function(replace(lot, folder="/nowhere", process=("", 0), workers=None), data))
        except Exception as error:  # noqa: BLE001 - as executors do
            made.set_exception(error)
        return made


def test_scenes_are_sent_once_to_where_their_files_are_not(here):
    from shadowlab.experiments.sweeps import parcels

    parcels.HELD.forget("scene")
    executor = Alone()
    same(here, sl.sweep(SPACE, **HOW, metrics=METRICS, executor=executor))
    sent = [lot.group.view.scene for lot in executor.lots if lot.scene is not None]
    assert len(sent) == len(set(sent)) == 2
    assert len(executor.lots) > 4


def test_an_executor_that_breaks_is_replaced(tmp_path):
    space = {**ROBOTS, "technique": ["uniform", "tsm"], "resolution": [32, 64, 48]}
    with ProcessPoolExecutor(2, mp_context=SPAWN) as executor:
        found = sl.sweep(
            space, **HOW, metrics=[functools.partial(kill_at_64_once, mark=tmp_path / "mark")], executor=executor
        )
    assert list(found["kill_at_64_once"]) == [32, 64, 48] * 2


def test_a_dask_cluster_gives_the_same_table(here, client):
    same(here, sl.sweep(SPACE, **HOW, metrics=METRICS, executor=client))
    space = {**ROBOTS, "resolution": list(range(32, 56))}
    found = sl.sweep(space, **HOW, metrics=[pid, lambda run: sl.threads()], executor=client)
    assert len(set(found["pid"])) == 3
    assert set(found["<lambda>"]) == {1}


def test_a_dask_worker_that_is_killed_in_the_middle_costs_nothing(client):
    space = {**ROBOTS, "technique": ["uniform", "tsm", "lispsm"], "resolution": list(range(32, 48))}
    nothing = sl.sweep(space, **HOW)
    started = set(client.run(os.getpid).values())
    victim = min(started)
    timer = threading.Timer(1.5, lambda: os.kill(victim, signal.SIGKILL))
    timer.start()
    found = sl.sweep(space, **HOW, metrics=["misclassified", pid], executor=client)
    timer.join()
    assert victim not in set(client.run(os.getpid).values()), "it was killed"
    assert len(set(found["pid"])) >= 2
    same(nothing, found.drop(columns="pid"))


def test_a_run_that_kills_dask_workers_is_a_failure_of_no_other(client):
    # Several wait on a worker when it dies, and their scene brings them to the same one again.
    sizes = [32, 64, *range(40, 48)]
    found = sl.sweep({**ROBOTS, "resolution": sizes}, **HOW, metrics=[kill_at_64], executor=client)
    assert list(found["failure_type"]) == ["", "WorkerError", *[""] * 8]
    assert list(found["kill_at_64"].dropna()) == [size for size in sizes if size != 64]


@pytest.mark.parametrize("backend", ["loky", "threading"])
def test_joblib_gives_the_same_table(here, backend):
    joblib = imported("joblib")
    same(here, sl.sweep(SPACE, **HOW, metrics=METRICS, executor=joblib.Parallel(2, backend=backend)))


def test_a_joblib_worker_that_dies_costs_its_run_another_try(tmp_path):
    joblib = imported("joblib")
    found = sl.sweep(
        {**ROBOTS, "resolution": [32, 64, 48]},
        **HOW,
        metrics=[functools.partial(kill_at_64_once, mark=tmp_path / "mark")],
        executor=joblib.Parallel(2),
    )
    assert list(found["kill_at_64_once"]) == [32, 64, 48]


@pytest.mark.parametrize("executor", [3, "dask", object(), ProcessPoolExecutor, [], int])
def test_what_is_no_executor_is_an_error(executor):
    with pytest.raises(ArgumentError, match="executor"):
        sl.sweep(ROBOTS, **HOW, executor=executor)


def test_an_executor_that_is_closed_is_an_error():
    for kind in (ThreadPoolExecutor(1), ProcessPoolExecutor(1, mp_context=SPAWN)):
        kind.shutdown()
        with pytest.raises(ArgumentError, match="executor"):
            sl.sweep(ROBOTS, **HOW, executor=kind)


def test_what_an_executor_raises_is_an_error():
    class Broken:
        def submit(self, *args):
            made = Future()
            made.set_exception(ImportError("no module named shadowlab"))
            return made

    with pytest.raises(WorkerError, match="no module named shadowlab"):
        sl.sweep(ROBOTS, **HOW, executor=Broken())


def test_an_interruption_gives_up_what_has_not_begun():
    with ThreadPoolExecutor(1) as executor:
        begun = []

        def slow(run):
            begun.append(1)
            time.sleep(0.2)
            return 1

        timer = threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT))
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            sl.sweep({**ROBOTS, "resolution": list(range(32, 96))}, **HOW, metrics=[slow], executor=executor)
        timer.join()
    assert len(begun) < 32


class Calls:
    """An executor that does with a call what a function says."""

    def __init__(self, answer):
        self.answer = answer

    def submit(self, function, *arguments):
        made = Future()
        self.answer(made, lambda: function(*arguments))
        return made


@pytest.mark.parametrize("wrong", [None, 3, "text", [None], [[1]], {}, object(), [4, "x"]])
def test_an_executor_that_gives_something_else_is_an_error(wrong):
    with pytest.raises(WorkerError, match=r"^executor: expected what its calls give, got .*; give another"):
        sl.sweep(ROBOTS, **HOW, executor=Calls(lambda made, call: made.set_result(wrong)))


def test_a_run_that_an_executor_leaves_out_is_a_failure():
    space = {**ROBOTS, "resolution": [32, 48, 64], "light": ["own", "above"]}
    found = sl.sweep(space, **HOW, executor=Calls(lambda made, call: made.set_result(call()[1:])))
    assert len(found) == 6
    assert set(found["failure_type"]) >= {"WorkerError"}
    assert set(found["failure"]) <= {"", "executor: it gave no answer"}


def test_an_executor_with_one_future_for_all_calls_is_an_error():
    class One:
        future = None

        def submit(self, function, *arguments):
            if self.future is None:
                self.future = Future()
            return self.future

    with pytest.raises(ArgumentError, match=r"^executor: expected a future of its own for each call"):
        sl.sweep({**ROBOTS, "resolution": [32, 48]}, **HOW, executor=One())


def test_an_executor_may_call_back_twice_and_with_anything(here):
    class Twice(Future):
        def add_done_callback(self, function):
            super().add_done_callback(lambda _: (function(3), function(None)))

    class Odd:
        def submit(self, function, *arguments):
            made = Twice()
            made.set_result(function(*arguments))
            return made

    same(here, sl.sweep(SPACE, **HOW, metrics=METRICS, executor=Odd()))


class LateThreads(set):
    """Threads of an executor that know of none at the first look, as right after a start."""

    looked = False

    def __contains__(self, thread):
        known, self.looked = self.looked and super().__contains__(thread), True
        return known


@pytest.mark.parametrize("threads", [set, LateThreads])
def test_a_sweep_in_a_call_of_its_own_executor_ends(here, threads):
    with ThreadPoolExecutor(1) as executor:
        executor._threads = threads()
        inside = executor.submit(lambda: sl.sweep(SPACE, **HOW, metrics=METRICS, executor=executor))
        same(here, inside.result(60))
        assert getattr(executor._threads, "looked", True)


def test_what_threads_that_are_shut_down_leave_undone_is_done(here):
    executor = ThreadPoolExecutor(1)

    def ends(run):
        executor.shutdown(wait=False, cancel_futures=True)
        return 1

    found = sl.sweep(SPACE, **HOW, metrics=[*METRICS, ends], executor=executor)
    assert found["ends"].notna().sum() >= 1
    same(here, found.drop(columns="ends"))
