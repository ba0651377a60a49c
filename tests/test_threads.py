"""The number of threads: set, told, refused, and without a say in any result."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
from fork_support import WORK, same, truth

import shadowlab as sl
from shadowlab import doctor


@pytest.fixture(autouse=True)
def default_again():
    yield
    sl.set_threads(None)


def run(code, **variables):
    """What a fresh Python prints."""
    environment = {k: v for k, v in os.environ.items() if k != "SHADOWLAB_THREADS"} | variables
    environment["PYTHONPATH"] = os.path.dirname(__file__)  # noqa: PTH120 - text for a variable
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_results_do_not_depend_on_the_number_of_threads():
    answers = {}
    for threads in (1, 2, 5):
        sl.set_threads(threads)
        assert sl.threads() == threads
        answers[threads] = {name: work() for name, work in WORK.items() if name != "named_renderer"}
    for name, alone in answers[1].items():
        assert same(answers[2][name], alone), name
        assert same(answers[5][name], alone), name


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="this system does not list threads")
@pytest.mark.parametrize("name", [name for name in WORK if name not in ("compare", "advise")])
def test_no_thread_is_started_beside_the_pool(name):
    # Those of rayon's own pool are as many as there are cores, whatever is asked for, and no child of a fork has them.
    code = (
        "import shadowlab as sl\n"
        "from pathlib import Path\n"
        "from fork_support import WORK\n"
        "def names(): return sorted(p.read_text().strip() for p in Path('/proc/self/task').glob('*/comm'))\n"
        "before = names()\n"
        "sl.set_threads(1)\n"
        f"WORK[{name!r}]()\n"
        "after = names()\n"
        "for one in before: after.remove(one)\n"
        "print(*after)\n"
    )
    assert set(run(code).split()) <= {"shadowlab-0"}


def test_the_renderer_tells_how_many_there_are():
    for threads in (1, np.int64(4)):
        sl.set_threads(threads)
        assert f"({threads} thread" in sl.Renderer("cpu").adapter


def test_the_default_is_what_this_process_may_use():
    if hasattr(os, "sched_getaffinity"):
        code = (
            "import os, shadowlab as sl; os.sched_setaffinity(0, {min(os.sched_getaffinity(0))}); print(sl.threads())"
        )
        assert run(code) == "1"
    sl.set_threads(7)
    sl.set_threads(None)
    assert 1 <= sl.threads() <= os.cpu_count()


@pytest.mark.parametrize("wrong", [0, -1, 1025, 2.0, True, "2", [1], 2**70], ids=repr)
def test_what_is_no_number_of_threads_is_refused(wrong):
    sl.set_threads(2)
    with pytest.raises(sl.errors.ArgumentError, match="n: expected a whole number between 1 and 1024, or None, got"):
        sl.set_threads(wrong)
    assert sl.threads() == 2


def test_the_environment_tells_at_the_first_use():
    code = "import os, shadowlab as sl; from fork_support import truth\n"
    assert run(code + "print(sl.threads()); truth(); print(sl.threads())", SHADOWLAB_THREADS="3").split() == ["3", "3"]
    assert run(code + "os.environ['SHADOWLAB_THREADS'] = '3'; truth(); print(sl.threads())") == "3"
    assert run(code + "sl.set_threads(2); truth(); print(sl.threads())", SHADOWLAB_THREADS="3") == "2"
    assert run(code + "sl.set_threads(2); sl.set_threads(None); print(sl.threads())", SHADOWLAB_THREADS="3") == "3"
    assert run(code + "truth(); print(sl.threads() > 0)", SHADOWLAB_THREADS="") == "True"


@pytest.mark.parametrize("wrong", ["0", "many", "-2", "1.5", "2000"])
def test_a_wrong_environment_is_named_wherever_threads_are_needed(wrong):
    code = (
        "import shadowlab as sl\n"
        "from fork_support import WORK\n"
        "for work in [sl.threads, WORK['library_scene'], WORK['shadow_map'], WORK['truth'], WORK['named_renderer']]:\n"
        "    try: work()\n"
        "    except sl.errors.ArgumentError as error: print(error)\n"
        "found = {f.name: f for f in sl.report().findings}\n"
        "assert found['threads'].state == 'failed' and found['threads'].fix, found\n"
        "assert 'core' not in found and not sl.report().works\n"
        "sl.set_threads(1); WORK['truth']()\n"
    )
    lines = run(code, SHADOWLAB_THREADS=wrong).splitlines()
    assert len(lines) == 5
    for line in lines:
        assert line.startswith(f'SHADOWLAB_THREADS: expected a whole number between 1 and 1024, got "{wrong}"; ')


def test_the_doctor_tells_how_many_there_are():
    sl.set_threads(3)
    finding = doctor.threads()
    assert (finding.state, finding.text[:2]) == ("ok", "3 ")
    assert finding in sl.report().findings


def test_the_number_may_change_while_another_thread_works():
    scene = sl.library.scene("courtyard")
    expected = sl.trace.shadow_mask(scene, scene.camera, scene.light, size=64)
    answers, stop = [], threading.Event()

    def work():
        while not stop.is_set():
            answers.append(sl.trace.shadow_mask(scene, scene.camera, scene.light, size=64))

    workers = [threading.Thread(target=work) for _ in range(3)]
    for worker in workers:
        worker.start()
    for k in range(100):
        sl.set_threads(1 + k % 4)
        if k % 10 == 0:
            answers.append(sl.trace.shadow_mask(scene, scene.camera, scene.light, size=64))
    stop.set()
    for worker in workers:
        worker.join()
    assert len(answers) > 10
    assert all(same(answer, expected) for answer in answers)


def test_threads_that_ask_for_one_new_scene_at_once_agree():
    built = sl.library.scene("courtyard")
    answers = []
    together = threading.Barrier(6)

    def work():
        together.wait()
        answers.append(sl.trace.shadow_mask(built, built.camera, built.light, size=48))

    workers = [threading.Thread(target=work) for _ in range(6)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join(60)
    assert len(answers) == 6
    assert all(same(answer, answers[0]) for answer in answers)


def test_threads_take_turns_at_a_device(gpu_renderer):
    scene = sl.library.scene("robots")
    expected = gpu_renderer.gbuffer(scene, scene.camera, size=96).depth
    sl.set_threads(1)
    answers = []

    def work():
        answers.extend(gpu_renderer.gbuffer(scene, scene.camera, size=96).depth for _ in range(5))
        answers.extend(truth()[:0].astype(np.float32) for _ in range(5))

    workers = [threading.Thread(target=work) for _ in range(4)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join(120)
    drawn = [answer for answer in answers if answer.size]
    assert len(answers) == 40
    assert len(drawn) == 20
    assert all(same(answer, expected) for answer in drawn)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_no_thread_works_but_those_that_were_asked_for():
    code = (
        "import pathlib, shadowlab as sl\n"
        "import pandas, matplotlib, tqdm\n"
        # It would watch its bars from a thread of its own.
        "tqdm.tqdm.monitor_interval = 0\n"
        "from fork_support import WORK\n"
        "def names(): return [(t / 'comm').read_text().strip() for t in pathlib.Path('/proc/self/task').iterdir()]\n"
        "before = names()\n"
        "sl.set_threads(3)\n"
        "for work in WORK.values(): work()\n"
        "new = names()\n"
        "for name in before: new.remove(name)\n"
        "print(sorted(new))\n"
    )
    assert run(code) == "['shadowlab-0', 'shadowlab-1', 'shadowlab-2']"


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_threads_of_former_numbers_end():
    code = (
        "import pathlib, time, shadowlab as sl\n"
        "from fork_support import truth\n"
        "def count(): return len(list(pathlib.Path('/proc/self/task').iterdir()))\n"
        "before = count()\n"
        "for k in range(40):\n"
        "    sl.set_threads(1 + k % 8)\n"
        "    truth()\n"
        "sl.set_threads(2)\n"
        "truth()\n"
        "end = time.monotonic() + 30\n"
        "while count() > before + 2 and time.monotonic() < end: time.sleep(0.01)\n"
        "print(count() - before)\n"
    )
    assert run(code) == "2"
