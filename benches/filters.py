"""Filters here and in OpenGL through moderngl, the same kernels side by side: `python benches/filters.py`.

Two tables, times interleaved, ratios theirs / ours of the least times:

- look-up: the light at the points of a G-buffer through a map that is there, `sl.aliasing.look_up` of the cpu renderer
  against a GLSL program over the same points and map, result read back by both;
- picture: map and picture drawn and the mask read back, `Renderer("gpu").shadow_mask` against the same in OpenGL.

OpenGL runs on the adapter that EGL finds, as wgpu's: a software one on machines without a graphics card.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "tests"), str(HERE / "beside")]

RESOLUTION = 2048
SIZE = (1024, 768)
BIAS = 2e-4
TEXTS = (
    "nearest", "bilinear", "pcf:size=3", "pcf:size=7", "pcf:size=15", "poisson:count=16,radius=2.5,seed=2",
    "poisson:count=64,radius=5,seed=2",
)  # fmt: skip
OURS_ALONE = ("tent:size=6", "pcf:size=3px", "tent:size=6px", "poisson:count=16,radius=2px,seed=2")


def kernel_of(text: str) -> tuple[int, float, np.ndarray | None]:
    """The kernel of a text as `Filtered.kernel` takes it."""
    from filter_support import disc, settings_of

    name, settings = settings_of(text)
    if name == "poisson":
        return 2, 1.0, float(settings["radius"]) * disc(int(settings["count"]), int(settings["seed"]))
    return (0, 1.0, None) if name == "nearest" else (1, float(settings.get("size", 1)), None)


def row(text: str, times: dict[str, dict[str, float]], base: dict[str, float]) -> str:
    """One line of a table: times, their ratio, and how many times a nearest lookup each takes."""
    ours, theirs = times["ours"]["min_ms"], times.get("OpenGL", {}).get("min_ms")
    base.setdefault("ours", ours)
    beside = f"{ours:10.2f} {ours / base['ours']:8.2f}"
    if theirs is None:
        return f"  {text:36s}{beside}"
    base.setdefault("theirs", theirs)
    return f"  {text:36s}{beside} {theirs:12.2f} {theirs / base['theirs']:8.2f} {theirs / ours:10.2f}"


def main() -> None:
    """Prints both tables."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--seconds", type=float, default=3.0, help="of each kernel and table (default: 3)")
    seconds = options.parse_args().seconds

    from inputs import bench_scene
    from interleaved import interleaved
    from peers.filter_peer import Filtered
    from peers.moderngl_peer import ModernGL

    import shadowlab as sl

    vertices, faces = bench_scene()
    scene = sl.Scene.from_arrays(vertices, faces)
    camera = sl.Camera.look_at(
        (0.5, 2.2, 7.5), (0, 0.7, 0), fov_y=np.radians(50), aspect=SIZE[0] / SIZE[1], near=0.5, far=30.0
    )
    light = sl.DirectionalLight((-0.5, -0.8, -0.35))
    p = sl.technique("lispsm").parameterize(scene, camera, light, resolution=RESOLUTION)
    cpu, gl, bias = sl.Renderer("cpu"), ModernGL(), sl.Bias(ndc=BIAS, texels=0, slope=0, plane=0)
    g, depths = cpu.gbuffer(scene, camera, size=SIZE), cpu.shadow_map(scene, p)
    origin = np.asarray(g.origin)
    moved = np.eye(4)
    moved[:3, 3] = origin
    theirs = Filtered(gl, depths, np.asarray(p.matrix) @ moved, -np.asarray(light.direction), BIAS)
    theirs.surfaces(g.position - origin, g.normal)
    head = f"  {'':36s}{'ours, ms':>10s} {'nearest':>8s} {'OpenGL, ms':>12s} {'nearest':>8s} {'ratio':>10s}"
    print(f"look-up, {SIZE[0]} x {SIZE[1]} points, map of {RESOLUTION}², cpu beside {gl.renderer}\n{head}")
    base: dict[str, float] = {}
    for text in (*TEXTS, *OURS_ALONE):
        work = {"ours": lambda: sl.aliasing.look_up(depths, g, camera, light, p, bias=bias, filter=text)}  # noqa: B023
        if text in TEXTS:
            theirs.kernel(*kernel_of(text))
            work["OpenGL"] = theirs.mask
        print(row(text, interleaved(work, seconds), base), flush=True)

    try:
        gpu = sl.Renderer("gpu")
    except sl.errors.DeviceError as error:
        print(f"picture: not measured, {error}")
        return
    gl.upload(vertices - origin, faces)
    to_clip = gl.of_opengl(np.asarray(camera.clip_from_world) @ moved)
    theirs.scene(vertices - origin, faces, to_clip, np.asarray(camera.eye) - origin, SIZE)
    print(f"picture, map of {RESOLUTION}², {SIZE[0]} x {SIZE[1]} pixels, {gpu.adapter} beside {gl.renderer}\n{head}")
    base = {}
    for text in (*TEXTS, *OURS_ALONE):
        work = {
            "ours": lambda: gpu.shadow_mask(scene, camera, light, p, size=SIZE, bias=bias, filter=text)  # noqa: B023
        }
        if text in TEXTS:
            theirs.kernel(*kernel_of(text))
            work["OpenGL"] = theirs.drawn
        print(row(text, interleaved(work, seconds), base), flush=True)


if __name__ == "__main__":
    main()
