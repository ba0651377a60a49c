"""The page that `defaults.py` writes: tables of counts, of flips along camera paths, and of numbers of samples."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from defaults import (
    CANDIDATES,
    NEAR_SHARES,
    PLACED_BY_BODY,
    PLACED_BY_FIRST,
    SIDES,
    Case,
    Counts,
    held_out,
    ratio,
    summary,
    table,
    wrong,
)

import shadowlab as sl

#: Techniques whose flips are counted; the second is what the others are relative to.
MOVED = ("lispsm", PLACED_BY_BODY, PLACED_BY_FIRST, "lispsm:fit=seen", "uniform", "uniform:fit=shadow")
FRAMES = 4
#: Wrong pixels from which on a ratio of counts says something.
FEW = 50
INTRO = """# Defaults

Written by `python benches/defaults.py --scenes DIR`. {views} views of {scenes} scenes: the library's with two lights
each, and meshes of a folder that is not part of the project, with two lights each; {size} x {size} pixels, maps of
{resolution} x {resolution} texels, nearest filter, default bias, wrong pixels against traced truth.

Each candidate is drawn in each view. For each scene in turn, the candidate that is best in all other scenes (geometric
mean of wrong pixels relative to `uniform`) is chosen and counted in the scene that was left out. A default is the
candidate that is chosen most often; it stays where another one is better by no more than a per cent or two, by which
counts change where the texels shift. `uniform` keeps `range=body, fit=exact`, which is what an engine without samples
has and what the others are measured against; `uniform:fit=shadow` shows what cropping alone gains, so that the gain
of a warp can be told from it. `margin` stays at 1 texel, which does as well as none: room for receivers
that no sample shows.
"""


def page(all_cases: Sequence[Case], resolution: int) -> str:
    """The page as Markdown."""
    scenes = [case.scene for case in all_cases]
    names = dict.fromkeys(["uniform", PLACED_BY_BODY, PLACED_BY_FIRST, *itertools.chain(*CANDIDATES.values())])
    counts: Counts = {name: [wrong(case.view, name, resolution) for case in all_cases] for name in names}
    size = all_cases[0].view.size[0]
    intro = INTRO.format(views=len(scenes), scenes=len(dict.fromkeys(scenes)), size=size, resolution=resolution)
    lines = [intro, "## The default of lispsm", *of_lispsm(counts), "", "## Candidates", *of_candidates(counts, scenes)]
    lines += ["", "## How many samples, and whence their shadow states", *of_samples(all_cases, counts, resolution)]
    lines += ["", "## The camera's near plane", *of_near(all_cases, counts, resolution)]
    lines += ["", "## Flips along camera paths", *of_paths(all_cases, resolution)]
    return "\n".join(lines) + "\n"


def of_lispsm(counts: Counts) -> list[str]:
    """The default beside the formula's placements and the crop alone."""
    shown = ("lispsm", "lispsm:fit=seen", "lispsm:fit=exact", "lispsm:norm=flips", PLACED_BY_FIRST, PLACED_BY_BODY,
             "uniform:fit=shadow")  # fmt: skip
    head = ["technique", "of uniform, in sum", "views above uniform by > 5 % + 3 px", "worst, of uniform",
            "views above 1.1 times the better formula", "worst, of the better formula"]  # fmt: skip
    about = (
        f"The better formula is the better of `{PLACED_BY_BODY}` and `{PLACED_BY_FIRST}`, view by view: no rule that is"
        " known before a map is drawn."
    )
    return ["", about, "", *table(head, [[f"`{name}`", *summary(counts, name)] for name in shown])]


def of_candidates(counts: Counts, scenes: Sequence[str]) -> list[str]:
    """Each group of candidates."""
    lines = []
    for group, candidates in CANDIDATES.items():
        chosen, left_out = held_out(counts, candidates, scenes)
        everywhere = range(len(scenes))
        rows = [
            [f"`{name}`", f"{ratio(counts, name, everywhere):.3f}", f"{chosen[name]} of {sum(chosen.values())}"]
            for name in candidates
        ]
        lines += ["", f"**{group}** (chosen by the others, in the scene left out: {left_out:.3f} of uniform)", ""]
        lines += table(["candidate", "of uniform, geometric mean", "chosen"], rows)
    return lines


def of_samples(all_cases: Sequence[Case], counts: Counts, resolution: int) -> list[str]:
    """Techniques with samples of smaller pictures, mapped and traced."""
    rows: list[list[object]] = []
    uniform = sum(counts["uniform"])
    for technique, source in itertools.product(("lispsm", "scene_optimal:cap=32"), ("mapped", "traced")):
        found: dict[int | None, list[int]] = {}
        missed: dict[int | None, list[float]] = {}
        for side in (*SIDES, None):
            drawn = [case.view.samples(side, source, renderer="cpu") for case in all_cases]
            samples = [one for one in drawn if isinstance(one, sl.Samples)]
            pairs = list(zip(all_cases, samples, strict=True))
            found[side] = [wrong(case.view, technique, resolution, one) for case, one in pairs]
            missed[side] = [outside_share(case.view, one, technique, resolution) for case, one in pairs]
        for side, of in found.items():
            pixels = f"{side} x {side}" if side else "the view's own"
            shares = [f"{100 * np.median(missed[side]):.3f} %", f"{100 * max(missed[side]):.2f} %"]
            worst = max(a / max(b, FEW) for a, b in zip(of, found[SIDES[-1]], strict=True))
            share = f"{sum(of) / sum(found[SIDES[-1]]):.3f}"
            rows.append([f"`{technique}`", source, pixels, f"{sum(of) / uniform:.3f}", share, f"{worst:.2f}", *shares])
    head = ["technique", "shadow states", "samples", "of uniform, in sum", f"of {SIDES[-1]} x {SIDES[-1]}, in sum",
            "worst view", "receivers in shadow outside, median", "worst view"]  # fmt: skip
    return ["", *table(head, rows)]


def outside_share(view: sl.View, samples: sl.Samples, technique: str, resolution: int) -> float:
    """Share of the view's receivers in shadow that a map for other samples does not hold."""
    own = view.samples(shadows="traced", renderer="cpu")
    assert isinstance(own, sl.Samples)
    p = sl.technique(technique).parameterize(
        view.scene, view.camera, view.lights[0], resolution=resolution, samples=samples
    )
    shaded = int(np.count_nonzero(np.asarray(view.truth()) == sl.trace.Truth.SHADOW))
    return own.outside(p)[1] / max(1, shaded)


def of_near(all_cases: Sequence[Case], counts: Counts, resolution: int) -> list[str]:
    """The default with the camera's near plane elsewhere."""
    changes: dict[str, list[float]] = {"lispsm": [], PLACED_BY_BODY: []}
    for i, case in enumerate(all_cases):
        view = case.view
        depth = np.asarray(view.gbuffer("cpu").view_depth)
        first = float(depth.min())
        for name, found in changes.items():
            base = counts[name][i]
            moved = [
                wrong(replace(view, camera=view.camera.replace(near=share * first)), name, resolution)
                for share in NEAR_SHARES
            ]  # fmt: skip
            found.append(max(abs(count - base) for count in moved) / max(base, 1))
    shares = ", ".join(f"{share:g}" for share in NEAR_SHARES)
    head = ["technique", "median change", "90 % of the views", "worst"]
    rows = [
        [f"`{name}`", *(f"{100 * np.quantile(found, q, method='lower'):.1f} %" for q in (0.5, 0.9, 1.0))]
        for name, found in changes.items()
    ]
    about = f"Largest change of wrong pixels as the near plane moves to {shares} of the first visible depth."
    return ["", about, "", *table(head, rows)]


def of_paths(all_cases: Sequence[Case], resolution: int) -> list[str]:
    """Flips per frame on a walk, a turn and an orbit, in one view of each scene."""
    first = list({case.scene: case for case in reversed(all_cases)}.values())
    total: dict[str, dict[str, int]] = {name: {} for name in MOVED}
    by_scene: dict[str, dict[str, int]] = {name: {} for name in MOVED}
    for case in first:
        view = case.view
        for kind, cameras in paths(view).items():
            found = sl.aliasing.temporal(
                view.scene, cameras, view.lights[0], list(MOVED), resolution=resolution, size=view.size, renderer="cpu",
                progress=False,
            ).table  # fmt: skip
            for name, steps in found.groupby("technique"):
                flips = int(steps["flips"].sum())
                total[str(name)][kind] = total[str(name)].get(kind, 0) + flips
                by_scene[str(name)][case.scene] = by_scene[str(name)].get(case.scene, 0) + flips
    base = total[PLACED_BY_BODY]
    rows = []
    for name in MOVED:
        all_flips = sum(total[name].values()) / max(1, sum(base.values()))
        worst = max(
            (by_scene[name][scene] / max(1, by_scene[PLACED_BY_BODY][scene]), scene) for scene in by_scene[name]
        )
        kinds = [f"{total[name][kind] / max(1, base[kind]):.2f}" for kind in base]
        rows.append([f"`{name}`", *kinds, f"{all_flips:.2f}", f"{worst[0]:.2f} ({worst[1]})"])
    about = (
        f"Pixels whose shadow changes from frame to frame where the truth does not, {FRAMES} frames in one view of each"
        f" scene, relative to `{PLACED_BY_BODY}`."
    )
    return ["", about, "", *table(["technique", *base, "all", "worst scene"], rows)]


def paths(view: sl.View) -> dict[str, list[sl.Camera]]:
    """A walk ahead, a turn of the head and an orbit around what is seen, each a few pixels a frame."""
    camera = view.camera
    eye, forward, right, up = (np.asarray(v, float) for v in (camera.eye, camera.forward, camera.right, camera.up))
    depth = np.asarray(view.gbuffer("cpu").view_depth)
    middle = float(np.median(depth[np.isfinite(depth)]))
    step = np.linspace(0.0, 1.0, FRAMES)

    def looking(at: np.ndarray, way: np.ndarray) -> sl.Camera:
        return sl.Camera.look_at(
            at, at + way, up=up, fov_y=camera.fov_y, aspect=camera.aspect, near=camera.near, far=camera.far
        )

    walk = [looking(eye + forward * (0.02 * middle * s), forward) for s in step]
    turn = [looking(eye, forward * np.cos(0.05 * s) + right * np.sin(0.05 * s)) for s in step]
    target = eye + forward * middle
    orbit = []
    for s in step:
        way = forward * np.cos(0.05 * s) + right * np.sin(0.05 * s)
        orbit.append(looking(target - way * middle, way))
    return {"walk": walk, "turn": turn, "orbit": orbit}
