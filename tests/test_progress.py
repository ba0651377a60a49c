"""The progress of long work: an estimate of the time left above a second, nothing below, nothing without a terminal."""

from __future__ import annotations

import inspect
import re
import sys
import threading
import time

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.text import progress
from shadowlab.text.progress import Steps, Waiting, waiting

ROBOTS = sl.library.scene("robots")
VIEW = (ROBOTS, ROBOTS.camera, ROBOTS.light)


@pytest.fixture
def terminal(monkeypatch):
    """Standard error is a terminal, and work has taken long enough from its begin on."""
    monkeypatch.setattr(progress, "on_terminal", lambda: True)
    monkeypatch.setattr(progress, "SHOWN_AFTER_S", 0.0)
    monkeypatch.setattr(progress, "REFRESH_S", 0.0)


@pytest.fixture
def told(monkeypatch):
    """What calls of the core report: their steps, in the order of the reports."""
    found = []
    original = Waiting.__call__

    def noted(self, done, total):
        found.append((done, total))
        original(self, done, total)

    monkeypatch.setattr(Waiting, "__call__", noted)
    return found


def long_truth(seconds=0.5):
    """Traces a picture that takes a while."""
    side, start = 512, time.monotonic()
    while time.monotonic() - start < seconds:
        side *= 2
        sl._core.trace_shadow_mask(*VIEW, size=side)


@pytest.mark.usefixtures("terminal")
def test_steps_show_what_is_done_and_an_estimate_of_the_time_left(capsys):
    with Steps(4, True) as step:
        for name in ("one", "two", "three"):
            step(name)
            time.sleep(0.02)
    shown = capsys.readouterr().err
    assert "one:   0%" in shown
    assert "two:  25%" in shown
    assert "three:  50%" in shown
    assert "00:00 left" in shown


@pytest.mark.usefixtures("terminal")
def test_the_estimate_is_what_the_rest_takes_at_the_pace_so_far(capsys, monkeypatch):
    monkeypatch.setattr(progress, "SHOWN_AFTER_S", 30.0)
    with Steps(4, True) as step:
        step("first")
        # As if a minute had passed.
        now = time.monotonic
        monkeypatch.setattr(time, "monotonic", lambda: now() + 60.0)
        step("second")
    shown = capsys.readouterr().err
    assert "first" not in shown
    assert "second:  25%" in shown
    assert "01:00 so far, 03:00 left" in shown


@pytest.mark.usefixtures("terminal")
def test_work_that_is_over_soon_shows_nothing(capsys, monkeypatch):
    monkeypatch.setattr(progress, "SHOWN_AFTER_S", 1.0)
    with Steps(2, True) as step:
        step("one")
        step("two")
    single = waiting()
    single(1, 2)
    single.close()
    assert capsys.readouterr() == ("", "")


def test_nothing_shows_where_standard_error_is_no_terminal_unless_asked(capsys, monkeypatch):
    monkeypatch.setattr(progress, "SHOWN_AFTER_S", 0.0)
    with Steps(1, True) as step:
        step("one")
    single = waiting()
    single(1, 2)
    single.close()
    assert capsys.readouterr() == ("", "")
    with Steps(1, True, anywhere=True) as step:
        step("asked")
    assert "asked" in capsys.readouterr().err


@pytest.mark.usefixtures("terminal")
def test_steps_that_are_not_shown_silence_the_calls_within(capsys):
    with Steps(1, False) as step:
        step("one")
        call = waiting()
        call(1, 2)
        call.close()
    assert capsys.readouterr() == ("", "")


@pytest.mark.usefixtures("terminal")
def test_a_call_within_a_step_moves_its_bar_on(capsys):
    with Steps(2, True) as step:
        step("first")
        call = waiting()
        call(1, 2)
        call.close()
        step("second")
    shown = capsys.readouterr().err
    assert "first:  25%" in shown
    assert "second:  50%" in shown


@pytest.mark.usefixtures("terminal")
def test_a_call_alone_shows_itself_and_is_gone_afterwards(capsys):
    call = waiting()
    call(1, 4)
    call(0, 0)
    call.close()
    call(3, 4)
    shown = capsys.readouterr().err
    assert "shadowlab:  25%" in shown
    assert "shadowlab: 00:00 so far" in shown
    assert "75%" not in shown


@pytest.mark.usefixtures("terminal")
def test_calls_of_other_threads_show_nothing(capsys):
    def work():
        call = waiting()
        call(1, 2)
        call.close()

    with Steps(1, True):  # those of this thread do not count for another
        thread = threading.Thread(target=work)
        thread.start()
        thread.join()
    assert capsys.readouterr() == ("", "")


def test_a_long_call_of_the_core_reports_how_far_it_is(told):
    long_truth()
    assert told
    assert all(0 <= done <= total for done, total in told)
    # Rows of the picture: most reports know how many there are.
    assert sum(total > 0 for _, total in told) > 0.5 * len(told)
    assert max(done / total for done, total in told if total) > 0.2


@pytest.mark.parametrize(("technique", "resolution"), [("z_partition:count=4", 8192), ("log_psm", 4096)])
def test_a_large_map_reports_how_far_it_is(told, technique, resolution):
    side = 1200
    x, z = np.meshgrid(np.linspace(-1, 1, side + 1), np.linspace(-1, 1, side + 1))
    first = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    faces = np.concatenate([np.stack([first, first + side + 1, first + 1], 1), np.stack([first + 1, first + side + 1, first + side + 2], 1)])  # fmt: skip  # noqa: E501
    scene = sl.Scene.from_arrays(np.stack([x, 0.1 * np.sin(9 * x * z), z], -1).reshape(-1, 3), faces)
    camera = sl.Camera.look_at((0, 2, 2), (0, 0, 0), aspect=1.0, near=0.1, far=10)
    p = sl.technique(technique).parameterize(scene, camera, ROBOTS.light, resolution=resolution)
    sl.Renderer("cpu").shadow_map(scene, p)
    known = [done / total for done, total in told if total]
    # Later maps begin where earlier ones end.
    assert known
    assert max(known) > 0.5
    assert known[-1] > known[0]


@pytest.mark.usefixtures("terminal")
def test_a_terminal_that_is_gone_does_not_end_the_work(monkeypatch):
    class Gone:
        def write(self, text):
            raise BrokenPipeError

        def flush(self):
            raise BrokenPipeError

        def isatty(self):
            return True

    monkeypatch.setattr(sys, "stderr", Gone())
    with Steps(2, True) as step:
        step("one")
        step("two")


@pytest.mark.parametrize("value", [1, "yes", [True]])
def test_what_is_no_flag_is_refused(value):
    with pytest.raises(sl.errors.ArgumentError, match="progress: expected True or False"):
        sl.trace.shadow_mask(*VIEW, size=8, progress=value)


def test_truths_are_the_same_with_and_without(capsys, monkeypatch):
    monkeypatch.setattr(progress, "SHOWN_AFTER_S", 0.0)
    masks = [sl.trace.shadow_mask(*VIEW, size=64, progress=flag) for flag in (None, False, True)]
    assert "truth:" in capsys.readouterr().err
    np.testing.assert_array_equal(masks[0], masks[1])
    np.testing.assert_array_equal(masks[0], masks[2])


@pytest.mark.parametrize(
    "function",
    [
        sl.advise, sl.compare, sl.explain_pixel, sl.prefiltered_maps, sl.scene_optimal_experiment, sl.smallest_bias,
        sl.sweep, sl.aliasing.temporal, sl.aliasing.over_light_angle, sl.Advice.save, sl.Study.save,
        sl.trace.shadow_mask, sl.blur,
    ],
)  # fmt: skip
def test_nothing_said_is_none_wherever_a_bar_may_be_asked_for(function):
    assert inspect.signature(function).parameters["progress"].default is None


def test_none_is_what_nothing_said_means_and_shows_no_bar_off_terminals(capfd):
    scene = sl.library.scene("robots")
    view = sl.View(scene, scene.camera, scene.light, size=(16, 9))
    sl.compare(
        scene, scene.camera, scene.light, ["uniform"], resolution=16, size=(16, 9), renderer="cpu", progress=None
    )
    sl.explain_pixel(view, "uniform", 8, 6, resolution=16, renderer="cpu", progress=None)
    assert capfd.readouterr().err == ""


@pytest.mark.usefixtures("terminal")
def test_an_advice_shows_how_far_it_is_from_its_first_fit_to_its_report(capsys, tmp_path):
    names, how = ("uniform", "lispsm"), {"size": (32, 18), "memory": "4 KiB", "renderer": "cpu", "phases": 1}
    foretold = iter(range(100))
    advice = sl.advise(*VIEW, techniques=names, predict=lambda *_, resolution: next(foretold), **how)
    told = capsys.readouterr().err
    assert all(f"{what} of {name}" in told for what in ("fits", "prediction") for name in names)
    advice.save(tmp_path / "advice")
    told = capsys.readouterr().err
    assert all(f"report: {part}" in told for part in ("tables", "figure", "pictures"))
    advice.save(tmp_path / "silent", progress=False)
    assert capsys.readouterr().err == ""


@pytest.mark.usefixtures("terminal")
def test_a_file_that_is_read_shows_how_much_of_it_is(capsys, tmp_path):
    file = tmp_path / "triangle.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    sl.load_scene(file)
    told = capsys.readouterr().err
    assert "reading:   0%" in told
    assert re.search(r"reading: +[1-4]\d%", told), told
    assert "making the scene:  50%" in told
    with Steps(1, False) as step:
        step("silent")
        sl.load_scene(file)
    assert capsys.readouterr().err == ""
