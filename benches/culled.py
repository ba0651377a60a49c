"""A scene of many instances, made, fitted and drawn, whole and as far as it is seen: `python benches/culled.py`.

Processor time, which other programs disturb little, the least of several calls, and the most memory so far. An argument
sets the most instances.

- forest: trees at equal density, 10,000 in each square kilometre, from ten thousand on, seen 2.5 km deep;
- behind: the same ten thousand trees with more and more of them behind the camera.
"""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import shadowlab as sl

RESOLUTION = 2048
SIZE = (640, 360)
TECHNIQUE = "lispsm:near=basic,range=body,fit=exact"
DEPTH = 2500.0
REPEATS = 5


def least_ms(work: Callable[[], Any]) -> float:
    """Processor time of the quickest of several calls."""
    times = []
    for _ in range(REPEATS):
        begin = time.process_time()
        work()
        times.append(time.process_time() - begin)
    return 1e3 * min(times)


def peak_mb() -> int:
    """The most memory that the process has had."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024


def row(name: str, scene: sl.Scene, camera: sl.Camera, light: Any, made_s: float) -> None:
    """Prints the costs of a scene."""
    renderer, technique = sl.Renderer("cpu"), sl.technique(TECHNIQUE)
    fit = least_ms(lambda: technique.parameterize(scene, camera, light, resolution=RESOLUTION))
    p = technique.parameterize(scene, camera, light, resolution=RESOLUTION)
    whole = least_ms(lambda: renderer.shadow_map(scene, p))
    gbuffer = renderer.gbuffer(scene, camera, size=SIZE)
    seen = least_ms(lambda: renderer.seen_map(scene, gbuffer, camera, light, p))
    drawn = renderer.casters(scene, p).drawn
    asked = renderer.casters(scene, p, cull="seen", gbuffer=gbuffer, camera=camera, light=light).drawn
    print(
        f"| {name} | {scene.instance_count:,} | {made_s:.2f} | {fit:.2f} | {drawn:,} | {whole:.0f} | {asked:,} | "
        f"{seen:.0f} | {peak_mb()} |",
        flush=True,
    )


def behind(scene: Any, count: int) -> sl.Scene:
    """The scene with so many of its trees again, behind the camera."""
    transforms, index = np.asarray(scene.transforms), np.asarray(scene.mesh_index)
    trees = np.flatnonzero(index != index[0])
    chosen = trees[np.arange(count) % len(trees)]
    moved = transforms[chosen].copy()
    lowest, highest = np.asarray(scene.bounds)
    # Beyond the border at the viewer's back, square after square.
    moved[:, 2, 3] += (1 + np.arange(count) // len(trees)) * (highest[2] - lowest[2])
    return sl.Scene(scene.meshes, np.concatenate([index, index[chosen]]), np.concatenate([transforms, moved]))


def main() -> None:
    largest = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    print("| scene | instances | made, s | fit, ms | drawn | map, ms | drawn as seen | seen map, ms | peak MB |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    counts = [n for n in (10_000, 100_000, 1_000_000) if n <= largest]
    base: Any = sl.library.scene("forest", trees=counts[0])
    for count in counts:
        begin = time.process_time()
        scene = base if count == counts[0] else behind(base, count - counts[0])
        row("behind", scene, base.camera, base.light, time.process_time() - begin)
        del scene
    for count in counts:
        begin = time.process_time()
        forest: Any = sl.library.scene("forest", trees=count, extent=1000.0 * (count / counts[0]) ** 0.5)
        made = time.process_time() - begin
        camera = forest.camera.replace(far=min(DEPTH, forest.camera.far))
        row("forest", forest, camera, forest.light, made)
        del forest


if __name__ == "__main__":
    main()
