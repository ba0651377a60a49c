"""What a sweep costs beside the sum of its parts, its memory, and what a second worker gains.

    python benches/sweep.py [--views 20] [--techniques 50] [--size 640x360] [--resolution 512] [--rounds 3]

Parts are what `evaluate` does in its runs (fit, maps, look-up, counts of wrong pixels), with the G-buffer, the samples
and the truth of each view once, timed by hand in a loop that does nothing else. Loop and sweep alternate in
one process. Workers are one of one thread, and two of one thread each. Beside the clock's there are ratios of processor
time, which other work on the machine disturbs less; that of two workers is their mean.
"""

from __future__ import annotations

import argparse
import itertools
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

import shadowlab as sl
from shadowlab.experiments.sweeps.plan import plan_of
from shadowlab.text import parse_size

TECHNIQUES = (
    "uniform",
    "lispsm",
    "tsm",
    "gmnpr",
    "plane_optimal",
    "z_partition:count=2",
    "log_psm",
    "xpsm",
    "psm",
    "glpr",
)
SLACKS = (1.0, 1.02, 1.04, 1.06, 1.08)


def space_of(scene: str, views: int, techniques: int, resolution: int) -> dict[str, object]:
    """So many lights in one scene, and so many techniques."""
    turns = np.linspace(0.0, 2 * np.pi, views, endpoint=False)
    lights = {f"sun {i}": sl.DirectionalLight((np.cos(a), -0.8, np.sin(a))) for i, a in enumerate(turns)}
    # Splits have no slack: the blend of their schemes tells them apart.
    named = [
        f"{text},blend={slack - 0.5}" if text.startswith("z_") else f"{text}:slack={slack}"
        for slack, text in itertools.product(SLACKS, TECHNIQUES)
    ]
    return {"scene": scene, "light": lights, "technique": named[:techniques], "resolution": resolution}


class Times(NamedTuple):
    """Seconds by the clock and of processors."""

    clock: float
    processor: float

    @classmethod
    def now(cls) -> Times:
        """From any moment on."""
        return cls(time.perf_counter(), time.process_time())

    def since(self) -> Times:
        """Between a moment and now."""
        now = Times.now()
        return Times(now.clock - self.clock, now.processor - self.processor)

    def over(self, other: Times) -> Times:
        """Ratios."""
        return Times(self.clock / other.clock, self.processor / other.processor)


def spent(run: sl.Run) -> dict[str, float]:
    """Which worker it is, and its processor time up to now."""
    return {"worker": os.getpid(), "processor_s": time.process_time()}


def parts(space: dict[str, object], size: tuple[int, int]) -> Times:
    """The parts of all runs: G-buffer and truth of each view, and the calls of each run."""
    plan = plan_of(space, size=size, renderer="cpu")
    renderer = sl.Renderer("cpu")
    begun = Times.now()
    for group in plan.groups():
        view = group.view
        view.clear()
        gbuffer, truth = view.gbuffer(renderer), view.truth()
        if any(one.item.needs_samples for one in group.requests):
            samples = view.samples(renderer=renderer)
        for one in group.requests:
            seen = {"samples": samples} if one.item.needs_samples else {}
            p = one.item.parameterize(view.scene, view.camera, view.light, resolution=one.resolution, **seen)
            if seen:
                samples.outside(p)
            if sl._core.looking_pays(view.scene, view.size):
                maps = renderer.seen_map(
                    view.scene, gbuffer, view.camera, view.light, p, resolution=one.resolution, bias=one.read.bias,
                    filter=one.read.filter, blend=one.read.blend, stored=one.read.stored,
                )  # fmt: skip
            else:
                maps = renderer.shadow_map(view.scene, p, resolution=one.resolution)
            mask, _ = sl._core.look_up(maps, gbuffer, view.camera, view.light, p, bias=one.read.bias)
            sl._core.misclassified(mask, truth)
        view.clear()
    return begun.since()


def whole(space: dict[str, object], size: tuple[int, int], **how: object) -> Times:
    """A sweep; of workers their mean processor time, since those that others disturb less do more."""
    begun = Times.now()
    metrics = ["misclassified", spent] if "workers" in how else ["misclassified"]
    found = sl.sweep(space, size=size, renderer="cpu", progress=False, metrics=metrics, **how)
    took = begun.since()
    assert (found["failure"] == "").all(), set(found["failure"])
    if "workers" in how:
        took = took._replace(processor=float(found.groupby("worker")["processor_s"].max().mean()))
    return took


def memory_of(arguments: list[str]) -> tuple[float, float]:
    """Most memory of a process that sweeps, and of its workers, MB."""
    done = subprocess.run(
        [sys.executable, __file__, *arguments, "--memory"], capture_output=True, text=True, check=True
    )
    own, children = map(float, done.stdout.split()[-2:])
    return own, children


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="@robots")
    parser.add_argument("--views", type=int, default=20)
    parser.add_argument("--techniques", type=int, default=50)
    parser.add_argument("--size", type=parse_size, default=(640, 360))
    parser.add_argument("--resolution", type=int, default=512)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--memory", action="store_true", help="one sweep with two workers; prints MB")
    args = parser.parse_args()
    space = space_of(args.scene, args.views, args.techniques, args.resolution)
    if args.memory:
        with tempfile.TemporaryDirectory() as folder:
            whole(space, args.size, store=Path(folder) / "runs.sqlite")
            whole(space, args.size, workers=2)
        kib = [resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        print(*(k / 1000 for k in kib))
        return
    print(f"{args.views} views x {args.techniques} techniques, {args.size}, {args.resolution}²; {os.cpu_count()} cores")
    ratios, kept, gains = [], [], []
    for _ in range(args.rounds):
        one = parts(space, args.size)
        ratios.append(whole(space, args.size).over(one))
        with tempfile.TemporaryDirectory() as folder:
            kept.append(whole(space, args.size, store=Path(folder) / "runs.sqlite").over(one))
        sl.set_threads(1)
        alone = whole(space, args.size, workers=1)
        sl.set_threads(2)
        gains.append(alone.over(whole(space, args.size, workers=2)))
        sl.set_threads(None)
        print(f"parts {one.clock:.1f} s; {text_of(ratios[-1:], kept[-1:], gains[-1:])}", flush=True)
    own, children = memory_of(sys.argv[1:])
    print(f"median: {text_of(ratios, kept, gains)}; memory {own:.0f} MB, of a worker {children:.0f} MB")


def text_of(ratios: list[Times], kept: list[Times], gains: list[Times]) -> str:
    """Medians of ratios."""

    def both(of: list[Times]) -> str:
        clock, processor = (statistics.median(column) for column in zip(*of, strict=True))
        return f"{clock:.3f} (processor {processor:.3f})"

    return (
        f"sweep {both(ratios)} times its parts, {both(kept)} with a store; "
        f"two workers of one thread {both(gains)} times as fast as one"
    )


if __name__ == "__main__":
    main()
