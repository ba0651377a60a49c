"""The same work here and in other programs, side by side in one process: `make bench`, or `python benches/peers.py`.

Runs are interleaved (ours, theirs, ours, theirs, ...), so that a busy moment of the machine meets both; minimum and
median of each are told, and ratios are of the minima. Beside the ratio of times stands that of processor time, all
threads together: it says who does less work, and says it on a busy machine too. What is compared:

- shadow map to numpy: `Renderer.shadow_map` against OpenGL through moderngl (the same vertices and matrix, geometry
kept on
  the device, 32-bit float depth, read back to numpy), with every core for both;
- rays: the same rays, prepared beforehand, against embreex. embreex works on one thread and keeps the interpreter's
lock;
  ours uses every core, so a second table gives ours one thread (in a process of its own, since the number of threads is
  settled when the first is used);
- `parameterize` from Python, in microseconds;
- memory: what a process grows by for each triangle of the scene, beside the arrays it was given.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

RESOLUTIONS = (1024, 2048, 4096)
IMAGE = (1024, 1024)
# What the project set itself; a ratio is theirs / ours.
CPU_GOAL = {1024: 5.0, 2048: 3.0, 4096: 2.0}
GPU_GOAL = 1.0
TRUTH_GOAL = 1.5
PARAMETERIZE_GOAL_US = 20.0
RENDER_BYTES_GOAL = 100.0
TRACE_BYTES_GOAL = 250.0


def _icosphere(level: int) -> tuple[np.ndarray, np.ndarray]:
    """A unit sphere of 20 * 4^level triangles."""
    golden = (1 + 5**0.5) / 2
    corner = np.array([[-1, golden, 0], [1, golden, 0], [-1, -golden, 0], [1, -golden, 0]], float)
    vertices = np.concatenate([corner, np.roll(corner, 1, axis=1), np.roll(corner, 2, axis=1)])
    distance = np.linalg.norm(vertices[:, None] - vertices, axis=2)
    near = distance < 2.1
    faces = [
        (a, b, c)
        for a in range(12)
        for b in range(a + 1, 12)
        for c in range(b + 1, 12)
        if near[a, b] & near[b, c] & near[a, c]
    ]
    faces = np.array(faces)
    for _ in range(level):
        edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edges, of_face = np.unique(edges, axis=0, return_inverse=True)
        middle = len(vertices) + of_face.reshape(-1, 3)
        vertices = np.concatenate([vertices, vertices[edges].mean(axis=1)])
        a, b, c = faces.T
        ab, bc, ca = middle.T
        faces = np.concatenate([np.column_stack(t) for t in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))])
    return vertices / np.linalg.norm(vertices, axis=1, keepdims=True), faces


def bench_scene() -> tuple[np.ndarray, np.ndarray]:
    """Five lumpy spheres of 81,920 triangles over a rolling ground of 31,752: 441,352 triangles, always the same."""
    rng = np.random.default_rng(20)
    sphere, sphere_faces = _icosphere(6)
    parts, faces, count = [], [], 0
    for k, (x, z) in enumerate([(0, 0), (2.6, 0.8), (-2.4, 1.1), (1.2, -2.7), (-1.6, -2.4)]):
        waves = rng.normal(size=(6, 3)) * [[3], [5], [8], [13], [21], [34]]
        lumps = sum(np.sin(sphere @ w + k) / np.linalg.norm(w) for w in waves)
        parts.append(sphere * (1 + 0.35 * lumps[:, None]) + [x, 1.1, z])
        faces.append(sphere_faces + count)
        count += len(sphere)
    n = 127
    x, z = np.meshgrid(np.linspace(-6, 6, n), np.linspace(-6, 6, n))
    ground = np.column_stack([x.ravel(), 0.15 * (np.sin(2 * x) * np.cos(3 * z)).ravel(), z.ravel()])
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).reshape(-1, 1)
    faces.append(np.concatenate([corner + np.array([0, n, 1]), corner + np.array([1, n, n + 1])]) + count)
    parts.append(ground)
    # Rounded to single precision, so that every program is given the same numbers.
    return np.concatenate(parts).astype(np.float32).astype(np.float64), np.concatenate(faces).astype(np.int32)


def interleaved(work: dict, seconds: float, least: int = 5) -> dict[str, dict[str, float]]:
    """Minimum and median milliseconds of each function, called in turn until `seconds` have gone by."""
    for run in work.values():
        run()
    wall: dict[str, list[float]] = {name: [] for name in work}
    cpu: dict[str, list[float]] = {name: [] for name in work}
    begin = time.perf_counter()
    while time.perf_counter() - begin < seconds or min(map(len, wall.values())) < least:
        for name, run in work.items():
            start, start_cpu = time.perf_counter(), time.process_time()
            run()
            wall[name].append(1e3 * (time.perf_counter() - start))
            cpu[name].append(1e3 * (time.process_time() - start_cpu))
    return {
        name: {"min_ms": min(t), "median_ms": float(np.median(t)), "cpu_ms": min(cpu[name]), "runs": len(t)}
        for name, t in wall.items()
    }


class Bench:
    """The scene in every program, and the rows of the tables."""

    def __init__(self, seconds: float):
        import shadowlab as sl

        self.sl, self.seconds = sl, seconds
        self.vertices, self.faces = bench_scene()
        self.scene = sl.Scene.from_arrays(self.vertices, self.faces)
        self.camera = sl.Camera.look_at(
            (0.5, 2.2, 7.5), (0, 0.7, 0), fov_y=np.radians(50), aspect=1.0, near=0.5, far=30.0
        )
        self.light = sl.DirectionalLight((0.6, -1.0, -0.45))
        self.rows: list[dict] = []

    def row(self, table: str, what: str, ours: dict, theirs: dict, peer: str, goal: float | None) -> None:
        """Keep and print one comparison."""
        ratio, cpu_ratio = theirs["min_ms"] / ours["min_ms"], theirs["cpu_ms"] / ours["cpu_ms"]
        row = {"table": table, "what": what, "peer": peer, "ours": ours, "theirs": theirs, "ratio": ratio, "goal": goal}
        row["cpu_ratio"] = cpu_ratio
        self.rows.append(row)
        verdict = "" if goal is None else f"   goal {goal:.1f}x {'reached' if ratio >= goal else 'MISSED'}"
        times = "".join(f"{t['min_ms']:9.2f} /{t['median_ms']:8.2f}" for t in (ours, theirs))
        print(f"  {what:<34}{times}{ratio:8.2f}x{cpu_ratio:8.2f}x{verdict}", flush=True)

    def shadow_maps(self) -> None:
        """Shadow map to numpy, both renderers, against moderngl."""
        from peers.moderngl_peer import ModernGL

        sl, peer = self.sl, ModernGL()
        renderers = {"cpu": sl.Renderer(backend="cpu")}
        try:
            renderers["gpu"] = sl.Renderer(backend="gpu")
        except sl.ShadowlabError as error:
            print(f"  no gpu renderer: {error}")
        middle = 0.5 * (self.vertices.min(axis=0) + self.vertices.max(axis=0))
        peer.upload(self.vertices - middle, self.faces)
        to_middle = np.eye(4)
        to_middle[:3, 3] = middle
        adapters = ", ".join(f"{name}: {r.adapter}" for name, r in renderers.items())
        head("Shadow map to numpy, milliseconds (minimum / median)", f"moderngl ({peer.renderer})", adapters)
        for technique in ("uniform", "lispsm"):
            for n in RESOLUTIONS:
                p = sl.technique(technique).parameterize(self.scene, self.camera, self.light, resolution=n)
                clip = np.asarray(p.matrix) @ to_middle
                work = {name: self._map(r, p, n) for name, r in renderers.items()}
                work["moderngl"] = lambda clip=clip, n=n: peer.draw(clip, (n, n))
                # Timing two different pictures would say nothing.
                theirs = work["moderngl"]()
                for name in renderers:
                    share = float((np.abs(work[name]() - theirs) > 1e-5).mean())
                    if share > 1e-3:
                        raise SystemExit(f"{name} and moderngl draw different maps: {100 * share:.3f} % of the texels")
                times = interleaved(work, self.seconds)
                for name in renderers:
                    goal = CPU_GOAL[n] if name == "cpu" else GPU_GOAL
                    self.row("shadow map", f"{name} {technique} {n}²", times[name], times["moderngl"], "moderngl", goal)
        peer.release()

    def _map(self, renderer, p, n: int):
        return lambda: renderer.shadow_map(self.scene, p, resolution=n)

    def rays(self, label: str, goal: float | None) -> None:
        """Primary and shadow rays against embreex, and the whole mask."""
        from peers.embreex_peer import EmbreexScene
        from peers.rays import pixel_rays

        sl, scene = self.sl, self.scene
        embree = EmbreexScene(self.vertices, self.faces, robust=False)
        origins32, directions32 = embree.rounded(*pixel_rays(self.camera, IMAGE))
        origins, directions = origins32.astype(np.float64) + embree.origin, directions32.astype(np.float64)
        t, triangle = embree.first_hit(origins32, directions32)
        hit = triangle >= 0
        corner = self.vertices[self.faces[triangle[hit]]]
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        to_light = -np.asarray(self.light.direction, np.float64)
        # Only what faces the light needs a ray; a thousandth of a unit off the surface.
        lit = np.abs(normal @ to_light) > 1e-3
        points = origins[hit] + t[hit, None] * directions[hit]
        points = points[lit] + 1e-3 * normal[lit] * np.sign(normal[lit] @ to_light)[:, None]
        shadow32, towards32 = embree.rounded(points, np.tile(to_light, (len(points), 1)))
        shadow, towards = shadow32.astype(np.float64) + embree.origin, towards32.astype(np.float64)
        reach32 = np.full(len(shadow), 1e3, np.float32)
        reach = reach32.astype(np.float64)
        ours_hit = sl.trace.first_hit(scene, origins, directions)[1] >= 0
        ours_blocked = sl.trace.occluded(scene, shadow, towards, reach)
        apart = max((ours_hit != hit).mean(), (ours_blocked != embree.occluded(shadow32, towards32, reach32)).mean())
        if apart > 1e-3:
            raise SystemExit(f"embreex and ours see different scenes: {100 * apart:.3f} % of the rays")
        title = f"{len(origins):,} primary and {len(shadow):,} shadow rays, milliseconds; {label}"
        head(title, "embreex, one thread", "")
        work = {
            "primary": lambda: sl.trace.first_hit(scene, origins, directions),
            "embree primary": lambda: embree.triangle(origins32, directions32),
            "shadow": lambda: sl.trace.occluded(scene, shadow, towards, reach),
            "embree shadow": lambda: embree.occluded(shadow32, towards32, reach32),
            "mask": lambda: sl.trace.shadow_mask(scene, self.camera, self.light, size=IMAGE),
        }
        times = interleaved(work, 3 * self.seconds)
        both = [
            {key: times[a][key] + times[b][key] for key in ("min_ms", "median_ms", "cpu_ms")}
            for a, b in (("primary", "shadow"), ("embree primary", "embree shadow"))
        ]
        self.row(f"rays, {label}", "primary rays", times["primary"], times["embree primary"], "embreex", None)
        self.row(f"rays, {label}", "shadow rays", times["shadow"], times["embree shadow"], "embreex", None)
        self.row(f"rays, {label}", "primary + shadow", *both, "embreex", goal)
        self.row(f"rays, {label}", "whole mask (both, and the pixels)", times["mask"], both[1], "embreex", None)

    def parameterize(self) -> None:
        """Microseconds a call from Python."""
        head("parameterize from Python, microseconds (minimum / median of batches)", "", "")
        for name in ("uniform", "lispsm"):
            technique, calls = self.sl.technique(name), 500
            batches = []
            begin = time.perf_counter()
            while time.perf_counter() - begin < self.seconds:
                start = time.perf_counter()
                for _ in range(calls):
                    technique.parameterize(self.scene, self.camera, self.light, resolution=1024)
                batches.append(1e6 * (time.perf_counter() - start) / calls)
            least, median = min(batches), float(np.median(batches))
            goal = PARAMETERIZE_GOAL_US if name == "lispsm" else None
            verdict = "" if goal is None else f"   goal {goal:.0f} {'reached' if least <= goal else 'MISSED'}"
            self.rows.append(
                {"table": "parameterize", "what": name, "min_us": least, "median_us": median, "goal": goal}
            )
            print(f"  {name:<34}{least:9.2f} /{median:8.2f}{verdict}", flush=True)


def head(title: str, peer: str, note: str) -> None:
    """Print a table's title."""
    print(f"\n{title}{': ours, ' + peer + ', ratio, ratio of processor time' if peer else ''}")
    if note:
        print(f"  ({note})")


def memory_worker(backend: str) -> dict[str, float]:
    """Bytes a triangle by which this process grows for rendering and for tracing, beside the arrays."""
    import shadowlab as sl

    vertices, faces = bench_scene()
    camera = sl.Camera.look_at((0.5, 2.2, 7.5), (0, 0.7, 0), fov_y=np.radians(50), aspect=1.0, near=0.5, far=30.0)
    light = sl.DirectionalLight((0.6, -1.0, -0.45))
    size = 256
    renderer = sl.Renderer(backend=backend)

    def use(scene) -> None:
        p = sl.technique("lispsm").parameterize(scene, camera, light, resolution=size)
        renderer.shadow_map(scene, p, resolution=size)
        renderer.shadow_mask(scene, camera, light, p, resolution=size, size=(size, size))

    # Threads, device and code are there after a small scene; what is left is the large one's.
    small = sl.Scene.from_arrays(vertices[faces[:64]].reshape(-1, 3), np.arange(192).reshape(-1, 3))
    use(small)
    sl.trace.shadow_mask(small, camera, light, size=(size, size))
    before = _resident()
    _forget_peak()
    scene = sl.Scene.from_arrays(vertices, faces)
    use(scene)
    kept, peak = _resident() - before, _peak() - before
    _forget_peak()
    sl.trace.shadow_mask(scene, camera, light, size=(size, size))
    kept_traced, peak_traced = _resident() - before, _peak() - before
    count = len(faces)
    return {
        "render_kept": kept / count,
        "render_peak": peak / count,
        "trace_kept": kept_traced / count,
        "trace_peak": max(peak, peak_traced) / count,
    }


def _status(field: str) -> int:
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(field + ":"):
            return 1024 * int(line.split()[1])
    raise SystemExit(f"/proc/self/status has no {field}")


def _resident() -> int:
    return _status("VmRSS")


def _peak() -> int:
    return _status("VmHWM")


def _forget_peak() -> None:
    # 5 resets the peak to what is resident now (proc(5)).
    Path("/proc/self/clear_refs").write_text("5")


def in_a_process_of_its_own(*arguments: str, **environment: str) -> dict | list:
    """What this script says as JSON when it is run with other arguments."""
    command = [sys.executable, __file__, *arguments, "--json", "-"]
    done = subprocess.run(command, env=os.environ | environment, check=True, stdout=subprocess.PIPE, text=True)
    *lines, result = done.stdout.splitlines()
    print("\n".join(lines), flush=True)
    return json.loads(result)


def memory(rows: list[dict]) -> None:
    """Print and keep the table of memory."""
    if not Path("/proc/self/clear_refs").exists():
        print("\nMemory is measured on Linux only")
        return
    head("Memory, bytes a triangle beside the input: kept / peak", "", "")
    for backend in ("cpu", "gpu"):
        try:
            result = in_a_process_of_its_own("--part", "memory", "--backend", backend)
        except subprocess.CalledProcessError:
            print(f"  {backend}: not available")
            continue
        for what, goal in (("render", RENDER_BYTES_GOAL), ("trace", TRACE_BYTES_GOAL)):
            kept, peak = result[f"{what}_kept"], result[f"{what}_peak"]
            name = f"{backend}, rendering" if what == "render" else f"{backend}, rendering and tracing"
            # On a software adapter the "device" is this process too; the goal is the renderer's that always works.
            goal = goal if backend == "cpu" else None
            verdict = "" if goal is None else f"   goal {goal:.0f} {'reached' if kept <= goal else 'MISSED'}"
            rows.append({"table": "memory", "what": name, "kept": kept, "peak": peak, "goal": goal})
            print(f"  {name:<34}{kept:9.1f} /{peak:8.1f}{verdict}", flush=True)


def main() -> None:
    """Run the parts and print their tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=3.0, help="time for each comparison (default %(default)s)")
    parser.add_argument("--json", metavar="FILE", help="write the rows there too; - for the last line of the output")
    parser.add_argument("--part", choices=["maps", "rays", "parameterize", "memory"], help="one part alone")
    parser.add_argument("--backend", default="cpu", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.part == "memory" and options.json == "-":
        print(json.dumps(memory_worker(options.backend)))
        return
    rows: list[dict] = []
    if options.part != "memory":
        bench = Bench(options.seconds)
        rows = bench.rows
        print(f"{bench.scene.triangle_count:,} triangles, {os.cpu_count()} cores")
    if options.part in (None, "maps"):
        bench.shadow_maps()
    threads = os.environ.get("SHADOWLAB_THREADS")
    if options.part in (None, "rays"):
        bench.rays(f"ours with {threads or os.cpu_count()} threads", None if threads else TRUTH_GOAL)
    if options.part is None and threads is None:
        alone = in_a_process_of_its_own("--part", "rays", "--seconds", str(options.seconds), SHADOWLAB_THREADS="1")
        rows += alone
    if options.part in (None, "parameterize"):
        bench.parameterize()
    if options.part in (None, "memory"):
        memory(rows)
    if options.json == "-":
        print(json.dumps(rows))
    elif options.json:
        Path(options.json).write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
