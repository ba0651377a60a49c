"""A limit of time for the work within: calls of the core, Python on the main thread, and other threads."""

from __future__ import annotations

import signal
import threading
import time

import pytest

import shadowlab as sl
from shadowlab import _core
from shadowlab.text.progress import Deadline, OutOfTimeError, Steps

SCENE = sl.library.scene("robots")


LARGE = (16000, 16000)


def long_call() -> None:
    """A truth that takes minutes, within steps of its own."""
    sl.trace.shadow_mask(SCENE, SCENE.camera, SCENE.light, size=LARGE, progress=False)


def test_no_limit_and_enough_time_change_nothing():
    for seconds in (None, 60.0):
        with Deadline(seconds):
            found = sl.trace.shadow_mask(SCENE, SCENE.camera, SCENE.light, size=(32, 18))
        assert found.shape == (18, 32)
    assert signal.getsignal(signal.SIGALRM) is signal.SIG_DFL
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


def test_a_call_of_the_core_ends_on_any_thread():
    raised = []

    def work():
        try:
            with Deadline(0.2):
                long_call()
        except OutOfTimeError as error:
            raised.append(str(error))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join(60)
    assert raised == ["took longer than the timeout of 0.2 s"]


def test_steps_around_it_are_told_on():
    told = []

    class Told(Steps):
        def tell(self, done, total):
            told.append((done, total))
            super().tell(done, total)

    def work():
        with Told(1, True) as step:
            step("truth")
            with pytest.raises(OutOfTimeError), Deadline(1.0):
                _core.trace_shadow_mask(SCENE, SCENE.camera, SCENE.light, size=LARGE)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join(60)
    assert len(told) > 1


def test_python_ends_on_the_main_thread_and_is_found_late_elsewhere():
    start = time.monotonic()
    with pytest.raises(OutOfTimeError), Deadline(0.1):
        time.sleep(60)
    assert time.monotonic() - start < 30
    found = []

    def work():
        try:
            with Deadline(0.05):
                time.sleep(0.2)
        except OutOfTimeError:
            found.append("late")

    thread = threading.Thread(target=work)
    thread.start()
    thread.join(60)
    assert found == ["late"]


def test_an_alarm_of_the_program_stays_its_own():
    def mine(*_):
        pass

    before = signal.signal(signal.SIGALRM, mine)
    try:
        with pytest.raises(OutOfTimeError), Deadline(0.05):
            time.sleep(0.1 if signal.getsignal(signal.SIGALRM) is mine else 60)
        assert signal.getsignal(signal.SIGALRM) is mine
    finally:
        signal.signal(signal.SIGALRM, before)


def test_another_error_comes_through():
    with pytest.raises(ZeroDivisionError), Deadline(60):
        _ = 1 / 0


def test_a_limit_that_nothing_meets_leaves_nothing_behind():
    for _ in range(20):
        with pytest.raises(OutOfTimeError), Deadline(1e-9):
            time.sleep(0.01)
        assert signal.getsignal(signal.SIGALRM) is signal.SIG_DFL
        with Deadline(None):
            sl.trace.shadow_mask(SCENE, SCENE.camera, SCENE.light, size=(160, 90))
