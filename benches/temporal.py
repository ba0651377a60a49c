"""What holding maps gains and costs along camera paths, and how slack and gain were chosen. Writes docs/temporal.md.

    python benches/temporal.py [--scenes DIR] [--size 512] [--resolution 1024] [--out docs/temporal.md] [--keep FILE]

Scenes are those of the library and the meshes of a folder with a scenes.json, where one is given; each has one path, as
a camera moves at 60 frames a second. Every candidate is held along every path. For each scene in turn, the candidate
with the fewest flips among those that cost little in all other scenes is chosen, and counted in the scene that was left
out. `--keep` stores the counts, and takes them from there where they are.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from defaults import BODY, LIGHTS, Case, cases, table

import shadowlab as sl

#: What is measured beside held maps; the first is what all are relative to.
EACH, BY_BODY = "scene_optimal", f"lispsm:near=delta-z,{BODY}"
OTHERS = (EACH, BY_BODY, "lispsm", "uniform", "uniform:stable=true")
SLACKS, GAINS = (1.03, 1.05, 1.08, 1.12), (1.15, math.inf)
#: Other techniques that are held, with slack and gain.
ALSO_HELD = (("lispsm", 1.05, 1.15), ("uniform:fit=shadow", 1.05, 1.15))
#: Steps ahead, aside and of turning; lengths as a share of the median visible depth.
AHEAD, ASIDE, TURNS, STEP, TURN_DEG = 5, 4, 4, 0.015, 1.0
#: Wrong pixels of held maps, relative to maps for each frame, that are accepted.
MOST_WRONG = 1.12
INTRO = """# Held maps

Written by {command}. Each has a path of {frames} frames: {ahead} steps ahead and {aside} aside, each {step:g} % of the
median visible depth, and {turns} turns of {turn:g} degree. {size} x {size} pixels, maps of {resolution} x {resolution}
texels, nearest filter, default bias. Wrong pixels are counted against traced truth in each frame. Flips are pixels
whose shadow changes from one frame to the next at points that both see, while the truth does not change.

Maps that are fitted for each frame move all their texels with each step of the camera, so that shadows shimmer.
`sl.TemporalFit` keeps maps as they are, bit for bit, while they hold every sample in shadow and its neighbours, and
while their texels are on average at most `gain` times as wide across the edges of visible shadows as those of new maps
(theory.md 10.6). Flips are then left to the frames in which maps are made anew. `uniform:stable=true` hardly flips, as
its texels stand still, but has more wrong pixels than all others.

## What is compared

`sl.aliasing.temporal(scene, cameras, light, techniques)` takes one scene, camera and light or a sequence of each;
sequences are equally long, an item per frame. Along the paths of this page only the camera moves.

- A **receiver** is the surface point that a pixel of the first frame sees. In the second frame it is the same point of
  the same instance: `scene.with_transforms` moves an instance, and its points keep their place in the frame of its
  mesh. Points that leave the second frustum are not compared; whether something hides them there does not matter.
- **Drift** compares the receiver's texel coordinates in both maps. On an object that moves it contains the object's
  own way over the map, so that it is not 0 under a map that stands still. `moving` is the share of such receivers.
- **Flips** compare both maps' verdicts on the receiver. They are counted where the truth, traced from the receiver
  itself in each frame's scene and under each frame's light, is the same: a shadow that really changes is no flip.
- **Wrong pixels** are those of each frame on its own.

A `TemporalFit` makes new maps whenever the scene or the light changes, since what is in the shadow of what may have
changed with it. [Scenes that move](moving.md) has an example.
"""


def path_of(view: sl.View) -> list[sl.Camera]:
    """The cameras of a path that begins at a view's."""
    camera = view.camera
    eye, forward, right = (np.asarray(v, float) for v in (camera.eye, camera.forward, camera.right))
    depth = np.asarray(view.gbuffer("cpu").view_depth)
    step = STEP * float(np.median(depth[np.isfinite(depth)]))
    found = []
    for i in range(AHEAD + ASIDE + TURNS + 1):
        ahead, aside = min(i, AHEAD), min(max(i - AHEAD, 0), ASIDE)
        angle = math.radians(TURN_DEG) * max(i - AHEAD - ASIDE, 0)
        at = eye + step * (ahead * forward + aside * right)
        way = forward * math.cos(angle) + right * math.sin(angle)
        found.append(
            sl.Camera.look_at(
                at, at + way, up=camera.up, fov_y=camera.fov_y, aspect=camera.aspect, near=camera.near, far=camera.far
            )
        )
    return found


def held(technique: str, slack: float, gain: float) -> tuple[str, sl.TemporalFit]:
    """A held technique with its label."""
    return f"{technique}, slack {slack:g}, gain {gain:g}", sl.TemporalFit(technique, slack, gain)


def counted(case: Case, techniques: Mapping[str, sl.TemporalFit | str], resolution: int) -> pd.DataFrame:
    """Flips, wrong pixels and frames with new maps of each technique along the path of a case."""
    view = case.view
    found = sl.aliasing.temporal(
        view.scene, path_of(view), view.lights[0], techniques, resolution=resolution, size=view.size, renderer="cpu",
        progress=False,
    )  # fmt: skip
    failed = found.table[found.table["failure"] != ""]
    if len(failed):
        raise SystemExit(f"{case.scene}, {failed.iloc[0]['technique']}: {failed.iloc[0]['failure']}")
    steps = found.table.groupby("technique", sort=False)[["flips", "judged"]].sum()
    frames = found.frames.groupby("technique", sort=False)[["misclassified", "refit"]].sum()
    return steps.join(frames).astype(int).assign(scene=case.scene, frames=len(path_of(view))).reset_index()


def totals(counts: pd.DataFrame) -> pd.DataFrame:
    """Sums over scenes: one row per technique."""
    return counts.groupby("technique", sort=False)[["flips", "misclassified", "refit", "frames"]].sum()


def chosen(counts: pd.DataFrame, candidates: Sequence[str]) -> str:
    """Of those with few wrong pixels that with the fewest flips; where none has few, that with the fewest."""
    sums = totals(counts)
    wrong = sums.loc[candidates, "misclassified"] / sums.loc[EACH, "misclassified"]
    few = wrong[wrong <= MOST_WRONG].index
    return str(sums.loc[few, "flips"].idxmin() if len(few) else wrong.idxmin())


def left_out(counts: pd.DataFrame, candidates: Sequence[str]) -> tuple[dict[str, int], pd.Series]:
    """How often each candidate is chosen, and the counts of those chosen in the scenes left out."""
    times = dict.fromkeys(candidates, 0)
    rows = []
    for scene in counts["scene"].unique():
        best = chosen(counts[counts["scene"] != scene], candidates)
        times[best] += 1
        rows.append(counts[(counts["scene"] == scene) & (counts["technique"] == best)])
    return times, pd.concat(rows)[["flips", "misclassified", "refit", "frames"]].sum()


def page(counts: pd.DataFrame, size: int, resolution: int) -> str:
    """The page as Markdown."""
    sums, scenes = totals(counts), list(counts["scene"].unique())
    default, _ = held(EACH, sl.TemporalFit().slack, sl.TemporalFit().gain)
    also = [held(*one)[0] for one in ALSO_HELD]
    grid = [held(EACH, slack, gain)[0] for slack in SLACKS for gain in GAINS]
    command = f"`python benches/temporal.py`. The {len(scenes)} scenes of the library"
    if not set(scenes) <= LIGHTS.keys():
        meshes = "the library's, and meshes of a folder that is not part of the project"
        command = f"`python benches/temporal.py --scenes DIR`. {len(scenes)} scenes: {meshes}"
    intro = INTRO.format(
        command=command, frames=int(counts["frames"].iloc[0]), ahead=AHEAD, aside=ASIDE, turns=TURNS,
        step=100 * STEP, turn=TURN_DEG, size=size, resolution=resolution,
    )  # fmt: skip

    def row(name: str, of: pd.Series) -> list[object]:
        relative = [
            f"{of[what] / sums.loc[base, what]:.2f}"
            for base in (EACH, BY_BODY, "uniform") for what in ("flips", "misclassified")
        ]  # fmt: skip
        return [name, f"{of['refit']} of {of['frames']}", *relative]

    head = ["technique", "new maps", "flips", "wrong", "flips, of lispsm", "wrong, of lispsm", "flips, of uniform",
            "wrong, of uniform"]  # fmt: skip
    main_rows = [row(f"`{n}`" if n in OTHERS else f"held: {n}", sums.loc[n]) for n in (*OTHERS, default, *also)]
    times, out = left_out(counts, grid)
    grid_rows = [
        [n.partition(", ")[2], f"{sums.loc[n, 'refit']} of {sums.loc[n, 'frames']}",
         f"{sums.loc[n, 'flips'] / sums.loc[EACH, 'flips']:.3f}",
         f"{sums.loc[n, 'misclassified'] / sums.loc[EACH, 'misclassified']:.3f}", f"{times[n]} of {len(scenes)}"]
        for n in grid
    ]  # fmt: skip
    by_scene = counts.set_index(["scene", "technique"])
    scene_rows = [
        [scene, by_scene.loc[(scene, default), "refit"],
         *(f"{by_scene.loc[(scene, name), what]:,}" for what in ("flips", "misclassified")
           for name in (EACH, default, BY_BODY))]
        for scene in scenes
    ]  # fmt: skip
    lines = [
        intro,
        "## Flips and wrong pixels",
        "",
        f"Sums over all paths, relative to `{EACH}` fitted for each frame, to `{BY_BODY}` and to `uniform`.",
        "",
        *table(head, main_rows),
        "",
        "## Slack and gain",
        "",
        f"Relative to `{EACH}` fitted for each frame. For each scene in turn, the pair with the fewest flips among",
        f"those with at most {MOST_WRONG} times the wrong pixels in all other scenes is chosen and counted in the",
        f"scene that was left out: {out['flips'] / sums.loc[EACH, 'flips']:.3f} of the flips,"
        f" {out['misclassified'] / sums.loc[EACH, 'misclassified']:.3f} of the wrong pixels, new maps in",
        f"{out['refit']} of {out['frames']} frames. The default, slack {sl.TemporalFit().slack:g} and gain",
        f"{sl.TemporalFit().gain:g}, stays clear of that limit, as scenes differ in what a slack costs.",
        "",
        *table(["held", "new maps", "flips", "wrong", "chosen"], grid_rows),
        "",
        "## Scenes",
        "",
        f"Counts along each path: `{EACH}` for each frame, held with the defaults, and `{BY_BODY}`.",
        "",
        *table(["scene", "new maps", "flips: each frame", "held", "lispsm", "wrong: each frame", "held", "lispsm"],
               scene_rows),
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def main() -> None:
    """Walks all paths and writes the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=Path, help="folder with meshes and a scenes.json")
    parser.add_argument("--size", type=int, default=512, help="pixels along each side of a picture")
    parser.add_argument("--resolution", type=int, default=1024, help="texels along each side of a map")
    parser.add_argument("--keep", type=Path, help="file of counts")
    parser.add_argument("--out", type=Path, default=Path(__file__).resolve().parents[1] / "docs" / "temporal.md")
    options = parser.parse_args()
    techniques: dict[str, sl.TemporalFit | str] = {name: name for name in OTHERS}
    techniques |= dict(held(EACH, slack, gain) for slack in SLACKS for gain in GAINS)
    techniques |= dict(held(*one) for one in ALSO_HELD)
    kept = options.keep is not None and options.keep.exists()
    known = pd.read_csv(options.keep) if kept else pd.DataFrame({"scene": [], "technique": []})
    seen: set[str] = set()
    for case in cases(options.scenes, options.size):
        if case.scene in seen:
            continue
        seen.add(case.scene)
        done = set(known.loc[known["scene"] == case.scene, "technique"])
        missing = {label: one for label, one in techniques.items() if label not in done}
        if not missing:
            continue
        known = pd.concat([known, counted(case, missing, options.resolution)], ignore_index=True)
        if options.keep:
            known.to_csv(options.keep, index=False)
        print(case.scene, flush=True)
    options.out.write_text(page(known, options.size, options.resolution), "utf-8")


if __name__ == "__main__":
    main()
