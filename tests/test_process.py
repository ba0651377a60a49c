"""No call ends or hangs the process, whatever it is asked for; each in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

# Seconds that a call may take: none takes one.
PATIENCE = 60
# Bytes of a process: what is refused for want of memory is refused here, on every machine.
MEMORY = 3 << 30

HEAD = """
import sys
import numpy as np, shadowlab as sl
from shadowlab import _core
scene = sl.Scene.from_arrays([[-1, 0, -1], [1, 0, -1], [0, 0, 1]], [[0, 2, 1]])
camera = sl.Camera.look_at((0, 2, 3), (0, 0, 0), aspect=1.0, near=0.1, far=10)
light = sl.DirectionalLight((0.2, -1, 0.1))
def refused(name, call, *words):
    try:
        call()
    except sl.errors.ArgumentError as error:
        text = str(error)
        assert name in text and "\\n" not in text and len(text) < 1000, text
        assert all(word in text for word in words), text
    else:
        raise AssertionError(f"{name} was taken")
"""

LIMITED = f"""
import resource
resource.setrlimit(resource.RLIMIT_AS, ({MEMORY}, {MEMORY}))
"""

NESTED = {
    "by text": 'sl.technique("z_partition:inner=" * 5000 + "uniform")',
    "by text, in parentheses": 'sl.technique("z_partition:inner=(" * 5000 + "uniform" + ")" * 5000)',
    "by parentheses alone": 'sl.technique("z_partition:inner=" + "(" * 100_000 + "uniform" + ")" * 100_000)',
    "by tuples": 'sl.technique("plane_optimal:plane=" + "(" * 5000 + "1,2" + ")" * 5000)',
    "in the core": '_core.Technique("z_partition", inner="z_partition:inner=" * 50_000 + "uniform")',
    "of faces": 'sl.technique("face_partition:inner=" * 2000 + "lispsm")',
}


def run(code: str, *, limited: bool = False) -> str:
    """What a process prints; its end by itself is part of the answer."""
    text = (LIMITED if limited else "") + HEAD + code + "\nprint('alive')\n"
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert done.returncode == 0, f"{done.returncode}: {done.stderr[-2000:]}"
    assert done.stdout.endswith("alive\n")
    return done.stdout


@pytest.mark.parametrize("call", NESTED.values(), ids=NESTED)
def test_techniques_within_techniques(call):
    run(f"refused('techni' if 'plane' not in {call[:40]!r} else 'plane', lambda: {call})")


def test_techniques_within_techniques_by_objects():
    run("""
t = sl.technique("uniform")
def deeper():
    global t
    for _ in range(5000):
        t = sl.technique("z_partition", count=1, inner=t)
refused("technique", deeper, "within one another")
assert sl.technique("z_partition", count=2, inner="face_partition:inner=(z_partition:count=2,inner=lispsm)").name
""")


def test_huge_numbers_of_maps():
    run("""
refused("count", lambda: sl.technique("z_partition", count=10**9))
refused("count", lambda: sl.technique("z_partition", count=10**30))
refused("count", lambda: sl.technique("optimal_partition", count=10**9))
refused("technique", lambda: sl.technique(
    "z_partition:count=16,inner=(z_partition:count=16,inner=(z_partition:count=16))"), "4096")
refused("technique", lambda: sl.technique("face_partition:inner=" + "(face_partition:inner=" * 5 + "psm" + ")" * 5))
refused("parameterization", lambda: sl.Renderer("cpu").shadow_map(
    scene, sl.Parameterization.from_matrix(np.tile(np.eye(4), (40_000, 1, 1))), resolution=1), "32767")
refused("trees", lambda: sl.library.scene("forest", trees=1e12))
""")


def test_sequences_that_lie_about_their_length():
    run(
        """
class Liar:
    def __init__(self, n): self.n = n
    def __len__(self): return self.n
    def __getitem__(self, i): return 1.0
class LyingList(list):
    def __len__(self): return 1 << 40
for liar in (Liar(1 << 40), Liar(3), LyingList([1.0, 2.0, 3.0])):
    refused("direction", lambda: sl.DirectionalLight(liar))
    refused("matrix", lambda: sl.Parameterization.from_matrix(liar))
    refused("post_warp", lambda: sl.Parameterization.from_matrix(np.eye(4), post_warp=liar))
    refused("regions", lambda: sl.Parameterization.from_matrix(np.eye(4), regions=liar))
    refused("meshes", lambda: sl.Scene(liar, [0], np.eye(4)[None]))
    refused("vertices", lambda: sl.Scene.from_arrays(liar, [[0, 1, 2]]))
    refused("distances", lambda: sl.technique("z_partition", distances=liar))
    refused("maps", lambda: sl.Note("nothing_seen", maps=liar))
    refused("size", lambda: sl.Renderer("cpu").gbuffer(scene, camera, size=liar))
""",
        limited=sys.platform == "linux",
    )


def test_objects_whose_methods_raise():
    run("""
def raising(method):
    def fail(self, *a, **k): raise RuntimeError("no")
    return type("Raising", (), {method: fail})()
for method in ("__array__", "__float__", "__index__", "__len__", "__iter__", "__getitem__", "__repr__", "__getattr__"):
    bad = raising(method)
    refused("vertices", lambda: sl.Scene.from_arrays(bad, [[0, 1, 2]]))
    refused("points", lambda: camera.depth([bad, bad]))
    refused("slack", lambda: sl.technique("lispsm").with_slack(bad))
    refused("name", lambda: sl.technique(bad))
deep = []
for _ in range(10_000): deep = [deep]
refused("vertices", lambda: sl.Scene.from_arrays(deep, [[0, 1, 2]]))
refused("direction", lambda: sl.DirectionalLight(deep))
""")


@pytest.mark.skipif(sys.platform != "linux", reason="limits of memory and what is free are asked of Linux here")
def test_more_memory_than_there_is():
    run(
        """
r = sl.Renderer("cpu")
many = sl.Parameterization.from_matrix(np.tile(np.eye(4), (20_000, 1, 1)), resolution=16384)
one = sl.technique("uniform").parameterize(scene, camera, light)
g = r.gbuffer(scene, camera, size=64)
refused("resolution", lambda: r.shadow_map(scene, many), "20000", "16384")
refused("resolution", lambda: sl.aliasing.usage(g, camera, light, many), "20000", "16384")
refused("size", lambda: r.gbuffer(scene, camera, size=16384))
refused("size", lambda: r.footprint(scene, camera, light, one, size=16384))
refused("size", lambda: r.shadow_mask(scene, camera, light, one, size=16384))
refused("size", lambda: sl.View(scene, camera, light, size=16384).samples(renderer="cpu"))
mesh = _core.Mesh(np.random.default_rng(1).normal(size=(3000, 3)), np.arange(3000).reshape(-1, 3))
crowd = sl.Scene([mesh], np.zeros(60_000, int), np.tile(np.eye(4), (60_000, 1, 1)))
refused("scene", crowd.to_arrays)
refused("steps", lambda: sl.aliasing.outline(camera, steps=10**9))
refused("count", lambda: sl.aliasing.closed_form.splits(near=1, far=2, count=10**9))
""",
        limited=True,
    )


@pytest.mark.skipif(sys.platform != "linux", reason="the size of a process is asked of Linux here")
def test_little_memory_left_is_refused():
    """A limit of the address space that leaves 200 MB, of which some are kept free."""
    run(
        """
import resource
many = np.random.default_rng(1).normal(size=(600_000, 3))
faces = np.tile(np.arange(600_000).reshape(-1, 3), (16, 1))
crowd = sl.Scene.from_arrays(many, faces)
used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + (200 << 20),) * 2)
refused("size", lambda: sl.trace.shadow_mask(scene, camera, light, size=16384))
refused("scene", lambda: sl.trace.first_hit(crowd, [[0, 0, 9]], [[0, 0, -1]]))
assert sl.trace.shadow_mask(scene, camera, light, size=64).shape == (64, 64)
"""
    )


def test_renderers_made_by_threads_at_once():
    """None takes away a variable of the environment that another looks for."""
    run(
        """
import os, threading
os.environ.pop("XDG_RUNTIME_DIR", None)
raised = []
def make():
    try:
        for _ in range(3): sl.Renderer("auto")
    except BaseException as error: raised.append(repr(error))
threads = [threading.Thread(target=make) for _ in range(8)]
for one in threads: one.start()
for one in threads: one.join()
assert not raised, raised
assert "XDG_RUNTIME_DIR" not in os.environ
"""
    )


@pytest.mark.skipif(sys.platform == "win32", reason="signals to a process work differently there")
def test_ctrl_c_comes_back_within_a_fifth_of_a_second():
    script = Path(__file__).with_name("interrupt_support.py")
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(rows) > 15
    hit = 0
    for row in rows:
        late = [ms for ms in row["late_ms"] if ms is not None]
        hit += bool(late)
        # By how much the processor is shared with others.
        assert all(ms < 200.0 * row["slowdown"] for ms in late), row
    # On a fast machine some are over before the first signal.
    assert hit > 10
