"""Long calls that are interrupted, in a process of their own: how long each takes to raise KeyboardInterrupt.

    python interrupt_support.py [NAME]

prints a line of JSON per call: its name, and the milliseconds from the signal to the exception, one for each moment at
which it was interrupted (none where the call was over before).
"""

from __future__ import annotations

import json
import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import shadowlab as sl
from shadowlab import _core

# Seconds after the begin of a call, beside those in which the sender starts.
MOMENTS = (0.0, 0.1, 0.3)
# Quads along each side of the sheet: three million triangles.
SIDE = 1250


def sheet(side: int) -> tuple[Any, Any]:
    """Vertices and faces of a bumpy sheet."""
    x, z = np.meshgrid(np.linspace(-1, 1, side + 1), np.linspace(-1, 1, side + 1))
    vertices = np.stack([x, 0.05 * np.sin(9 * x) * np.cos(7 * z), z], axis=-1).reshape(-1, 3)
    first = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    lower = np.stack([first, first + side + 1, first + 1], axis=1)
    upper = lower + np.array([1, 0, side + 1])
    return vertices, np.concatenate([lower, upper])[:, ::-1].astype(np.int64)


def calls() -> Iterator[tuple[str, Callable[[], Callable[[], Any]]]]:
    """Calls that take long by their names; each is made by a function that makes what it is given."""
    vertices, faces = sheet(SIDE)
    mesh = _core.Mesh(vertices, faces)
    scene = sl.Scene([mesh], [0], np.eye(4)[None])
    camera = sl.Camera.look_at((0, 1.5, 2), (0, 0, 0), aspect=1.0, near=0.1, far=10)
    light = sl.DirectionalLight((0.4, -1, 0.3))
    placed = np.tile(np.eye(4), (400_000, 1, 1))
    stone = sl.Scene.from_arrays(np.eye(3), [[0, 1, 2]])
    places = np.tile(np.eye(4), (1_000_000, 1, 1))
    places[:, :3, 3] = np.random.default_rng(3).uniform(-1e3, 1e3, (len(places), 3))
    crowd = sl.Scene(stone.meshes, np.zeros(len(places), np.int64), places)
    pickled = pickle.dumps(crowd)

    def fresh() -> Any:
        return sl.Scene([_core.Mesh(vertices, faces)], [0], np.eye(4)[None])

    def hashed(made: Any) -> Callable[[], Any]:
        return lambda: made.content_hash

    def traced(made: Any) -> Callable[[], Any]:
        return lambda: _core.trace_memory(made)

    yield "Scene.from_arrays", lambda: lambda: sl.Scene.from_arrays(vertices, faces)
    yield "_core.Mesh", lambda: lambda: _core.Mesh(vertices, faces)
    yield "_core.Scene", lambda: lambda: _core.Scene([mesh] * 40, range(40), placed[:40])
    yield "Scene of many instances", lambda: lambda: _core.Scene([mesh], np.zeros(400_000, np.int64), placed)
    yield "joined scenes", lambda: lambda: crowd + stone
    yield "moved instances", lambda: lambda: crowd.with_transforms(np.arange(len(places)), places)
    yield "moved scene", lambda: lambda: crowd.transformed(np.diag((2.0, 1, 1, 1)))
    yield "pickled scene", lambda: lambda: pickle.dumps(crowd)
    yield "unpickled scene", lambda: lambda: pickle.loads(pickled)
    yield "content_hash", lambda: hashed(fresh())
    yield "hierarchy", lambda: traced(fresh())
    yield "to_arrays", lambda: lambda: sl.Scene([mesh], [0] * 8, placed[:8]).to_arrays()
    yield "library scene", lambda: lambda: sl.library.scene("forest", trees=1_000_000)
    big = sl.Renderer("cpu").gbuffer(scene, camera, size=4096)
    yield "gbuffer", lambda: lambda: sl.Renderer("cpu").gbuffer(scene, camera, size=8192)
    shadows = np.zeros((4096, 4096), np.int8)
    shadows[::64] = 1
    yield "samples", lambda: lambda: sl.Samples.from_gbuffer(big, camera, light, shadows=shadows)
    samples = sl.Samples.from_gbuffer(big, camera, light, shadows=shadows)
    p = sl.technique("z_partition:count=16,inner=lispsm").parameterize(scene, camera, light, samples=samples)
    yield (
        "parameterize",
        lambda: (
            lambda: sl.technique("z_partition:count=16,inner=scene_optimal").parameterize(
                scene, camera, light, samples=samples
            )
        ),
    )
    gaps = np.zeros(shadows.shape, np.float32)
    yield "predict", lambda: lambda: _core.predict_wrong(samples, p, gaps)
    yield "outside", lambda: lambda: samples.outside(p)
    yield "hash of samples", lambda: lambda: hash(samples)
    yield "hash of a G-buffer", lambda: lambda: hash(big)
    yield "footprint", lambda: lambda: sl.aliasing.footprint(big, camera, light, p)
    footprint = sl.aliasing.footprint(big, camera, light, p)
    yield "summary", lambda: lambda: footprint.summary()
    wrong = np.random.default_rng(2).integers(-1, 6, (8192, 8192)).astype(np.int8)
    away, depths = np.ones(wrong.shape, np.float32), np.abs(wrong) + 1.0
    yield "causes by depth", lambda: lambda: _core.causes_by_depth(wrong, depths, limits=(1.0, 3.0, 9.0))
    yield "counts of causes", lambda: lambda: _core.cause_counts(wrong, away)
    rows = np.random.default_rng(1).normal(size=(6_000_000, 3))
    yield "project", lambda: lambda: p.partitions[0].project(rows)
    pixels = np.abs(rows[:, :2])
    yield "rays", lambda: lambda: camera.rays(pixels, 4096)
    long = rows[:1_500_000].tolist()
    yield "lists", lambda: lambda: camera.depth(long)
    wide, dark = np.zeros((16_000, 16_000), np.float32), np.zeros((16_000, 16_000), np.int8)
    yield "misclassified", lambda: lambda: sl.aliasing.misclassified(wide, dark)
    yield "usage", lambda: lambda: sl.aliasing.usage(big, camera, light, p)


def interrupted(work: Callable[[], Any], moment: float) -> float | None:
    """Milliseconds from the signal to the exception; None where the work was over before.

    Another process sends the signal: a thread of this one would wait for work that does not release the GIL.
    """
    code = (
        f"import os, signal, time; time.sleep({moment}); print(time.monotonic()); os.kill({os.getpid()}, signal.SIGINT)"
    )
    over = False
    with subprocess.Popen([sys.executable, "-S", "-c", code], stdout=subprocess.PIPE, text=True) as sender:
        try:
            work()
            over = True
            sender.wait()
            time.sleep(0.05)  # the signal comes too late
        except KeyboardInterrupt:
            raised = time.monotonic()
        sent = float(sender.stdout.read())  # type: ignore[union-attr]
    return None if over else 1e3 * (raised - sent)


def slowdown() -> float:
    """How much longer this process waits for the processor than it computes: 1 on a machine of its own."""
    start, own = time.monotonic(), time.process_time()
    while time.process_time() - own < 0.05:
        pass
    return max(1.0, (time.monotonic() - start) / 0.05)


def main() -> None:
    signal.signal(signal.SIGINT, signal.default_int_handler)
    wanted = sys.argv[1] if len(sys.argv) > 1 else ""
    for name, make in calls():
        if wanted not in name:
            continue
        found, waits = [], slowdown()
        for moment in MOMENTS:
            work = make()
            late = interrupted(work, moment)
            if late is None:
                found.append(None)
                break
            found.append(late)
            waits = max(waits, slowdown())
            del work
        print(json.dumps({"call": name, "late_ms": found, "slowdown": waits}), flush=True)


if __name__ == "__main__":
    main()
