"""Work after a fork: the child of a parent that has worked gives the parent's numbers, and never waits for ever."""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor

import pytest
from fork_support import LIMIT, LIMIT_OF_A_NEW_ONE, SIZE, WORK, answer_of, made_scene, renderer, same, truth, view

import shadowlab as sl

pytestmark = [
    pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork"),
    # Python 3.12 and later warn of threads; that these do no harm is what is tested.
    pytest.mark.filterwarnings("ignore:.*multi-threaded, use of fork:DeprecationWarning"),
]
#: Forks while another thread works.
TRIES = 20


@pytest.mark.parametrize("work", WORK.values(), ids=WORK)
def test_a_child_gives_the_numbers_of_its_parent(work):
    here = work()
    assert same(answer_of(work), here)


@pytest.mark.parametrize("method", ["spawn", "forkserver"])
def test_other_ways_to_start_a_process_do_too(method):
    assert same(answer_of(all_of_it, method, LIMIT_OF_A_NEW_ONE), all_of_it())


def all_of_it():
    return WORK["shadow_map"](), WORK["truth"](), WORK["parameterize_with_samples"]()


def test_an_executor_of_forked_processes_works():
    here = all_of_it()
    with ProcessPoolExecutor(3, mp_context=multiprocessing.get_context("fork")) as executor:
        futures = [executor.submit(all_of_it) for _ in range(12)]
        try:
            assert all(same(future.result(timeout=LIMIT), here) for future in futures)
        finally:
            # What hangs would make leaving the block wait for it.
            for process in list((executor._processes or {}).values()):
                process.kill()


def test_a_fork_from_a_thread_works():
    here, answers = all_of_it(), []
    thread = threading.Thread(target=lambda: answers.append(answer_of(all_of_it)))
    thread.start()
    thread.join(2 * LIMIT)
    assert len(answers) == 1
    assert same(answers[0], here)


def test_a_grandchild_works_before_and_after_its_parent():
    here = all_of_it()
    first, own, second = answer_of(two_generations, limit=3 * LIMIT)
    assert same(first, here)
    assert same(own, here)
    assert same(second, here)


def two_generations():
    first = answer_of(all_of_it)
    return first, all_of_it(), answer_of(all_of_it)


def test_a_fork_while_another_thread_works():
    _, camera, light, p = view()
    here, stop, rounds = truth(), threading.Event(), []

    def work():
        while not stop.is_set():
            new = made_scene()
            sl.trace.shadow_mask(new, camera, light, size=SIZE)
            renderer().shadow_map(new, p)
            rounds.append(renderer().gbuffer(new, camera, size=SIZE).position.shape)

    thread = threading.Thread(target=work)
    thread.start()
    try:
        for k in range(TRIES):
            while len(rounds) < k:
                time.sleep(0.001)
            assert same(answer_of(all_of_it)[1], here)
    finally:
        stop.set()
        thread.join()
    assert len(rounds) >= TRIES - 1


def test_a_fork_while_another_thread_builds_what_the_child_needs():
    _, camera, light, _ = view()
    scene = sl.library.scene("courtyard")
    thread = threading.Thread(target=lambda: sl.trace.shadow_mask(scene, camera, light, size=SIZE))
    thread.start()
    there = answer_of(lambda: sl.trace.shadow_mask(scene, camera, light, size=SIZE), limit=3 * LIMIT)
    thread.join()
    assert same(there, sl.trace.shadow_mask(scene, camera, light, size=SIZE))


def test_a_child_keeps_the_number_of_threads_that_was_set():
    renderer().shadow_map(view()[0], view()[3])
    sl.set_threads(3)
    try:
        assert answer_of(lambda: (all_of_it()[0].shape, sl.threads())) == ((64, 64), 3)
    finally:
        sl.set_threads(None)


def test_a_renderer_on_a_device_is_refused_in_a_child_and_a_new_one_answers(gpu_renderer):
    scene, camera, light, p = view()
    calls = [
        lambda r: r.shadow_map(scene, p),
        lambda r: r.gbuffer(scene, camera, size=SIZE),
        lambda r: r.shadow_mask(scene, camera, light, p, size=SIZE),
        lambda r: r.chosen_map(scene, camera, light, p, size=SIZE),
        lambda r: r.footprint(scene, camera, light, p, size=SIZE),
        lambda r: sl.compare(scene, camera, light, ["uniform"], resolution=64, size=SIZE, renderer=r, progress=False),
    ]
    here = gpu_renderer.shadow_map(scene, p)
    for call in calls:
        there = answer_of(lambda call=call: call(gpu_renderer))
        assert there.startswith("DeviceError: ")
        assert f"made by process {os.getpid()}" in there
        assert "new Renderer" in there
        assert "spawn" in there
    # Names need no device.
    assert answer_of(lambda: repr(gpu_renderer)) == repr(gpu_renderer)
    # Drivers that a child inherits may refuse; they must say so. Mesa's work.
    there = answer_of(lambda: sl.Renderer("gpu").shadow_map(scene, p))
    assert same(there, here) or there.startswith("DeviceError: ")
    assert same(answer_of(lambda: sl.Renderer("cpu").shadow_map(scene, p)), renderer().shadow_map(scene, p))


@pytest.mark.parametrize(
    "child",
    [
        "pass",
        "del r",
        "r = sl.Renderer('gpu'); r.shadow_map(scene, p); del r",
        # Threads that end give their stacks back, and with them those of the threads that the child does not have.
        "[(sl.set_threads(n), WORK['truth']()) for n in (8, 1, 8, 1)]; time.sleep(0.2)",
    ],
    ids=["nothing", "drops", "new", "threads"],
)
@pytest.mark.usefixtures("gpu_renderer")
def test_a_child_that_inherits_a_renderer_on_a_device_ends(child):
    # Not by multiprocessing, whose children leave out what Python and the drivers do at the end.
    code = (
        "import os, sys, time, shadowlab as sl\n"
        "from fork_support import WORK, view\n"
        "scene, camera, light, p = view()\n"
        "r = sl.Renderer('gpu')\n"
        "r.shadow_map(scene, p)\n"
        "child = os.fork()\n"
        "if child == 0:\n"
        f"    {child}\n"
        "    print('said', end=' ')\n"
        "    sys.exit(7)\n"
        "print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))\n"
    )
    environment = os.environ | {"PYTHONPATH": os.path.dirname(__file__)}  # noqa: PTH120 - text for a variable
    # A child that hangs holds the pipe, so the whole group is ended.
    process = subprocess.Popen(
        [sys.executable, "-W", "ignore::DeprecationWarning", "-c", code],
        env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    try:
        out, err = process.communicate(timeout=LIMIT_OF_A_NEW_ONE)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, 9)
        out, err = process.communicate()
        err += "\nkilled: it hung"
    assert out.split() == ["said", "7"], err


def test_a_fork_while_a_device_draws(gpu_renderer):
    scene, _, _, p = view()
    here, stop = gpu_renderer.shadow_map(scene, p), threading.Event()

    def work():
        while not stop.is_set():
            gpu_renderer.shadow_map(scene, p)

    thread = threading.Thread(target=work)
    thread.start()
    try:
        for _ in range(TRIES // 4):
            there = answer_of(lambda: sl.Renderer("gpu").shadow_map(scene, p), limit=2 * LIMIT)
            assert same(there, here) or there.startswith("DeviceError: ")
            assert answer_of(lambda: gpu_renderer.shadow_map(scene, p)).startswith("DeviceError: ")
            assert same(answer_of(truth), truth())
    finally:
        stop.set()
        thread.join()


def test_a_child_that_hangs_is_killed_and_a_failure():
    start = time.monotonic()
    with pytest.raises(pytest.fail.Exception, match="no answer"):
        answer_of(lambda: time.sleep(60), limit=0.2)
    assert time.monotonic() - start < 30
    assert answer_of(lambda: 1 / 0) == "ZeroDivisionError: division by zero"


def test_answers_that_differ_in_a_bit_are_not_the_same():
    a = truth()
    b = a.copy()
    b[0, 0] += 1
    assert same((a, 1), (a.copy(), 1))
    assert not same((a, 1), (b, 1))
    assert not same((a, 1), (a, 2))
    assert not same(a, a.astype(int))
    assert not same((a,), (a, a))
