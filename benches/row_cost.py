"""What a row of `compare` costs beside the sum of its parts, in processor time.

    python benches/row_cost.py [--size 640x360] [--resolution 256,1024] [--json FILE]

A row makes matrices, draws maps, looks every pixel up and measures; nothing else may cost much. The parts are called
through the public functions on a G-buffer and a truth that are there, as for a row. Both sides are measured in turn in
one process, and the least of several rounds is taken, so that a busy machine does not decide.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import shadowlab as sl

MOST = 1.25


def processor_ms(call: Callable[[], object]) -> float:
    """Milliseconds of processor time that a call takes, all threads together."""
    start = time.process_time()
    call()
    return 1e3 * (time.process_time() - start)


def parts_of(view: sl.View, technique: str, resolution: int) -> dict[str, Callable[[], object]]:
    """The parts of a row, each as a call."""
    renderer, light, camera = sl.Renderer("cpu"), view.light, view.camera
    gbuffer, truth = view.gbuffer(renderer), view.truth()
    made = sl.technique(technique)
    p = made.parameterize(view.scene, camera, light, resolution=resolution)
    maps = renderer.shadow_map(view.scene, p, resolution=resolution)
    looks = (gbuffer, camera, light, p)
    mask = sl.aliasing.look_up(maps, *looks)
    return {
        "fit": lambda: made.parameterize(view.scene, camera, light, resolution=resolution),
        "map": lambda: renderer.shadow_map(view.scene, p, resolution=resolution),
        "look-up": lambda: sl.aliasing.look_up(maps, *looks),
        "misclassified": lambda: sl.aliasing.misclassified(mask, truth),
        "causes": lambda: (
            sl.aliasing.causes(view.scene, camera, light, p, mask, truth, gbuffer=gbuffer, maps=maps).counts
        ),
        "texels": lambda: sl.aliasing.footprint(*looks, resolution=resolution).summary(),
        "usage": lambda: sl.aliasing.usage(*looks, resolution=resolution).unused,
    }


def measured(name: str, size: tuple[int, int], technique: str, resolution: int, rounds: int) -> dict[str, object]:
    """A row against its parts, processor milliseconds."""
    scene = sl.library.scene(name)
    view = sl.View(scene, scene.camera, scene.light, size)
    parts = parts_of(view, technique, resolution)
    least = dict.fromkeys(parts, float("inf"))
    row = float("inf")
    for _ in range(rounds):
        row = min(row, processor_ms(lambda: sl.evaluate(view, technique, resolution, renderer="cpu").row()))
        for part, call in parts.items():
            least[part] = min(least[part], processor_ms(call))
    total = sum(least.values())
    found = {"scene": name, "technique": technique, "resolution": resolution, "size": list(size)}
    return {**found, "row_ms": row, "parts_ms": total, "ratio": row / total, "parts": least}


def main() -> int:
    """Prints a line per case; 1 where a row costs more than `MOST` times its parts."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--size", default="640x360", help="pixels of the picture")
    options.add_argument("--resolution", default="256,1024", help="texels along each side of the maps")
    options.add_argument("--scene", default="robots,courtyard,forest", help="scenes of the library")
    options.add_argument("--technique", default="uniform,lispsm", help="techniques")
    options.add_argument("--rounds", type=int, default=7, help="rounds of which the least counts")
    options.add_argument("--json", help="file for the figures; - for standard output")
    given = options.parse_args()
    width, height = map(int, given.size.split("x"))
    warnings.simplefilter("ignore")
    rows = [
        measured(name, (width, height), technique, int(side), given.rounds)
        for name in given.scene.split(",")
        for technique in given.technique.split(",")
        for side in given.resolution.split(",")
    ]
    for row in rows:
        parts = ", ".join(f"{part} {ms:.1f}" for part, ms in row["parts"].items())  # type: ignore[attr-defined]
        print(
            f"{row['scene']:>10} {row['technique']:>8} {row['resolution']:>5}²: row {row['row_ms']:7.1f} ms, parts "
            f"{row['parts_ms']:7.1f} ms, ratio {row['ratio']:.2f} ({parts})",
            file=sys.stderr if given.json == "-" else sys.stdout,
        )
    if given.json == "-":
        print(json.dumps(rows, indent=1))
    elif given.json:
        Path(given.json).write_text(json.dumps(rows, indent=1), encoding="utf-8")
    return int(any(float(row["ratio"]) > MOST for row in rows))  # type: ignore[arg-type]


if __name__ == "__main__":
    sys.exit(main())
