"""What maps for what is seen cost on one thread: samples once per view, then fits and searches beside that of the body.

    python benches/samples_cost.py [--rounds 5] [SCENE ...]

Processor time in milliseconds, the least of some rounds: of the samples with their hulls and edge normals from pictures
of 128 x 128 and 1024 x 1024 pixels (G-buffer and shadow states aside), and of `parameterize` with these samples.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import shadowlab as sl

SIDES = (128, 1024)
FITS = {
    "exact": "lispsm:near=delta-z,range=body,fit=exact",
    "seen": "lispsm:near=delta-z,fit=seen",
    "shadow": "lispsm:near=delta-z",
    "search": "lispsm",
    "flips": "lispsm:norm=flips",
}


def least_ms(work: Callable[[], object], rounds: int, calls: int) -> float:
    """Processor time of a call, the least over rounds of so many calls."""
    found = []
    for _ in range(rounds):
        start = time.process_time()
        for _ in range(calls):
            work()
        found.append((time.process_time() - start) / calls)
    return 1e3 * min(found)


def row(name: str, side: int, rounds: int) -> list[str]:
    """The times of one scene and picture."""
    scene = sl.library.scene(name)
    view = sl.View(scene, scene.camera.replace(aspect=1.0), scene.light, size=(side, side))
    g, camera, light = view.gbuffer("cpu"), view.camera, view.lights[0]
    states = sl._core.mapped_states(scene, camera, light, g)

    def made() -> sl.Samples:
        return sl.Samples.from_gbuffer(g, camera, light, shadows=states)

    samples = made()
    cells = [name, str(side), f"{least_ms(made, rounds, 5 if side < 500 else 1):.2f}"]
    for text in FITS.values():
        technique = sl.technique(text)

        def fitted(technique: sl.Technique = technique) -> sl.Parameterization:
            return technique.parameterize(scene, camera, light, samples=samples)

        cells.append(f"{least_ms(fitted, rounds, 20):.3f}")
    return cells


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5, help="rounds, of which the least counts")
    parser.add_argument("scenes", nargs="*", default=["courtyard", "robots", "forest"], help="names in the library")
    options = parser.parse_args()
    sl.set_threads(1)
    print("  ".join(f"{head:>9}" for head in ("scene", "pixels", "samples", *FITS)))
    for name in options.scenes:
        for side in SIDES:
            print("  ".join(f"{cell:>9}" for cell in row(name, side, options.rounds)))


if __name__ == "__main__":
    main()
