"""What maps for what is seen cost a light: processor time of a fit on one thread, and of four lights in one view.

    python benches/scene_optimal_cost.py [--sides 70,128,256]

Four lights share the G-buffer of a view; samples and fit are each light's own. Quote ratios: machines are noisy.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from functools import partial

import numpy as np

import shadowlab as sl

TECHNIQUES = ("uniform", "lispsm", "plane_optimal", "scene_optimal:search=published", "scene_optimal",
              "scene_optimal:objective=flips", "rectilinear", "optimal_partition:count=2")  # fmt: skip
SCENES = ("robots", "courtyard", "forest")
#: Seconds of processor time that a measurement takes at least.
LEAST_S = 0.3
LIGHTS = ((0.3, -0.6, -0.8), (-0.4, -0.5, -0.7), (0.6, -0.7, 0.2))


def milliseconds(work: Callable[[], object]) -> float:
    """Processor time of one call."""
    work()
    begin, calls = time.process_time(), 0
    while time.process_time() - begin < LEAST_S:
        work()
        calls += 1
    return 1e3 * (time.process_time() - begin) / calls


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sides", default="70,128,256")
    sides = [int(side) for side in parser.parse_args().sides.split(",")]
    sl.set_threads(1)
    for name in SCENES:
        scene = sl.library.scene(name)
        camera = scene.camera.replace(aspect=1.0)
        lights = (scene.light, *(sl.DirectionalLight(way) for way in LIGHTS))
        for side in sides:
            view = sl.View(scene, camera, scene.light, size=(side, side))
            samples = view.samples(renderer="cpu")
            assert isinstance(samples, sl.Samples)
            edges = int(np.count_nonzero(np.any(samples.edge_normals != 0, axis=1)))
            print(f"{name}, samples of {side} x {side} pixels, {edges} at edges: ms a light")
            for text in TECHNIQUES:
                t = sl.technique(text)
                took = milliseconds(partial(t.parameterize, scene, camera, scene.light, samples=samples))
                print(f"  {text:34} {took:8.2f}")
            one = milliseconds(partial(drawn, scene, camera, lights[:1], side))
            four = milliseconds(partial(drawn, scene, camera, lights, side))
            print(
                f"  G-buffer, samples and scene_optimal: 1 light {one:.1f}, 4 lights {four:.1f}, {four / one:.2f} times"
            )


def drawn(scene: sl.Scene, camera: sl.Camera, lights: tuple[sl.DirectionalLight, ...], side: int) -> None:
    """A G-buffer, and for each light samples and a map."""
    gbuffer = sl.Renderer("cpu").gbuffer(scene, camera, size=(side, side))
    t = sl.technique("scene_optimal")
    for light in lights:
        states = sl._core.mapped_states(scene, camera, light, gbuffer)
        samples = sl.Samples.from_gbuffer(gbuffer, camera, light, shadows=states)
        t.parameterize(scene, camera, light, samples=samples)


if __name__ == "__main__":
    main()
