"""Memory, bytes a triangle beside the arrays that were given: `python benches/beside/memory.py [--backend cpu]`.

What the process grows by for a scene of 441,352 triangles, kept and at the peak, when a map and a mask are rendered and
then a truth is traced. Threads, device and code are there after a small scene. Linux only: the peak is the kernel's.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from inputs import LIGHT, bench_scene, camera

import shadowlab as sl

# What the project set itself for the cpu renderer, kept bytes a triangle.
GOALS = {"render": 100.0, "trace": 250.0}
SIZE = 256


def measured(backend: str) -> dict[str, float]:
    """Bytes a triangle by which this process grows for rendering and for tracing, kept and at the peak."""
    vertices, faces = bench_scene()
    eye, light, renderer = camera(), sl.DirectionalLight(LIGHT), sl.Renderer(backend=backend)

    def use(scene: sl.Scene) -> None:
        p = sl.technique("lispsm").parameterize(scene, eye, light, resolution=SIZE)
        renderer.shadow_map(scene, p, resolution=SIZE)
        renderer.shadow_mask(scene, eye, light, p, resolution=SIZE, size=(SIZE, SIZE))

    small = sl.Scene.from_arrays(vertices[faces[:64]].reshape(-1, 3), np.arange(192).reshape(-1, 3))
    use(small)
    sl.trace.shadow_mask(small, eye, light, size=(SIZE, SIZE))
    before = _bytes("VmRSS")
    _forget_peak()
    scene = sl.Scene.from_arrays(vertices, faces)
    use(scene)
    kept, peak = _bytes("VmRSS") - before, _bytes("VmHWM") - before
    _forget_peak()
    sl.trace.shadow_mask(scene, eye, light, size=(SIZE, SIZE))
    traced, traced_peak = _bytes("VmRSS") - before, _bytes("VmHWM") - before
    of_all = {"render": kept, "render at the peak": peak, "trace": traced, "trace at the peak": max(peak, traced_peak)}
    return {name: value / len(faces) for name, value in of_all.items()}


def _bytes(field: str) -> int:
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(field + ":"):
            return 1024 * int(line.split()[1])
    raise SystemExit(f"/proc/self/status has no {field}")


def _forget_peak() -> None:
    # 5 resets the peak to what is resident now (proc(5)).
    Path("/proc/self/clear_refs").write_text("5")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--backend", default="cpu", choices=("cpu", "gpu"))
    backend = parser.parse_args().backend
    if not Path("/proc/self/clear_refs").exists():
        print("  memory is measured on Linux only")
        return
    for name, value in measured(backend).items():
        goal = GOALS.get(name) if backend == "cpu" else None
        verdict = "" if goal is None else f"   at most {goal:g} {'reached' if value <= goal else 'missed'}"
        print(f"  {backend} {name:<20}{value:9.1f} bytes a triangle{verdict}")


if __name__ == "__main__":
    main()
