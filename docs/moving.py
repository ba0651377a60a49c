"""Makes docs/moving.md: the animation, and the dynamic scene of Scherzer 2005 rebuilt from the library's scenes.

    python docs/moving.py [--animation-only]

Times are processor times, printed as ratios of medians that were taken in turn, so that they mean the same on another
machine.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from moving_scene import Moving
from PIL import Image

import shadowlab as sl

ROOT = Path(__file__).resolve().parents[1]
PAGE, PICTURE = ROOT / "docs" / "moving.md", ROOT / "docs" / "moving" / "forest.gif"
# What is below it is made here.
MARK = "<!-- measured -->"

# Of the animation: pixels, frames of a period and how long each is shown, ms, and colours.
PICTURE_SIZE, PICTURE_FRAMES, FRAME_MS, COLOURS = (608, 342), 24, 80, 64
# Of the study, as published: pixels, texels, field of view, near and far plane.
SIZE, RESOLUTION, FOV_DEG, NEAR, FAR = (512, 512), 2048, 60.0, 0.1, 70.0
FILTER = "bilinear"
# Our own: frames, the part of a period between two of them, and the way of the camera in one, m.
FRAMES, PHASE, STEP = 9, 1 / 24, 0.25
TECHNIQUES = (
    "uniform", "uniform:stable=true", "lispsm:near=delta-z,range=body,fit=exact", "lispsm", "scene_optimal",
)  # fmt: skip
ROUNDS, FEW = 3, 100


def animation(world: Moving) -> None:
    """Writes the animation: shaded pictures whose shadows come from one LiSPSM map per frame."""
    draw, technique = sl.Renderer("cpu"), sl.technique("lispsm")
    pictures = []
    for i in range(PICTURE_FRAMES):
        scene, camera = world.at(i / PICTURE_FRAMES), world.camera
        p = technique.parameterize(scene, camera, world.light, resolution=2048)
        mask = draw.shadow_mask(scene, camera, world.light, p, size=PICTURE_SIZE, filter="bilinear")
        picture = sl.plot.shade(draw.gbuffer(scene, camera, size=PICTURE_SIZE), world.light, mask)
        pictures.append(Image.fromarray(picture))
    # One palette for all, so that what stands still stays as it is from frame to frame.
    all_at_once = Image.fromarray(np.concatenate([np.asarray(p) for p in pictures]))
    palette = all_at_once.quantize(COLOURS, dither=Image.Dither.NONE)
    frames = [p.quantize(palette=palette, dither=Image.Dither.NONE) for p in pictures]
    PICTURE.parent.mkdir(exist_ok=True)
    frames[0].save(PICTURE, save_all=True, append_images=frames[1:], duration=FRAME_MS, loop=0, optimize=True)
    print(f"{PICTURE.relative_to(ROOT)}: {PICTURE.stat().st_size:,} bytes")


def path_of(world: Moving) -> tuple[list[sl.Scene], list[sl.Camera]]:
    """Scenes and cameras of the study: everything moves, and the camera goes ahead."""
    own = world.camera
    forward = np.asarray(own.forward)
    cameras = [
        sl.Camera.look_at(
            at, at + forward, fov_y=np.radians(FOV_DEG), aspect=SIZE[0] / SIZE[1], near=NEAR, far=FAR
        )
        for at in (np.asarray(own.eye) + STEP * i * forward for i in range(FRAMES))
    ]  # fmt: skip
    return [world.at(PHASE * i) for i in range(FRAMES)], cameras


def seen(scenes: list[sl.Scene], cameras: list[sl.Camera]) -> tuple[int, int]:
    """How many triangles and instances a frame shows, in the middle of the frames."""
    draw, counts = sl.Renderer("cpu"), []
    for scene, camera in zip(scenes, cameras, strict=True):
        g = draw.gbuffer(scene, camera, size=SIZE)
        shown = np.asarray(g.triangle) >= 0
        pairs = np.column_stack([np.asarray(g.instance)[shown], np.asarray(g.triangle)[shown]])
        counts.append((len(np.unique(pairs, axis=0)), len(np.unique(pairs[:, 0]))))
    return sorted(counts)[len(counts) // 2]


def times(world: Moving, scenes: list[sl.Scene], camera: sl.Camera) -> list[tuple[str, float]]:
    """Medians of what a frame costs, as ratios."""
    taken: dict[str, list[float]] = {}

    def clocked(name: str, work: Callable[[], Any]) -> Any:
        start = time.process_time()
        made = work()
        taken.setdefault(name, []).append(time.process_time() - start)
        return made

    draw = sl.Renderer("cpu")
    p = sl.technique("lispsm").parameterize(world.scene, camera, world.light, resolution=RESOLUTION)
    sl.trace.occluded(world.scene, [[0, 0, 0]], [[0, 1, 0]])  # builds the hierarchies
    draw.shadow_map(world.scene, p)
    base, everything = world.scene, np.arange(world.scene.instance_count)
    for scene in scenes[1 : 1 + ROUNDS]:
        places = scene.transforms
        moved = clocked("moved", partial(base.with_transforms, everything, places))
        clocked("few moved", partial(base.with_transforms, everything[::FEW], places[::FEW]))
        anew = clocked("made anew", partial(sl.Scene, base.meshes, base.mesh_index, places))
        for name, one in (("along", moved), ("built", anew)):
            clocked(f"hierarchy {name}", partial(sl.trace.occluded, one, [[0, 0, 0]], [[0, 1, 0]]))
            clocked(f"truth {name}", partial(sl.trace.shadow_mask, one, camera, world.light, size=SIZE))
        clocked("map", partial(draw.shadow_map, moved, p))
        clocked("map again", partial(draw.shadow_map, moved, p))
        clocked("picture", partial(draw.gbuffer, moved, camera, size=SIZE))
    of = {name: statistics.median(values) for name, values in taken.items()}
    return [
        ("the scene with all instances moved, by a scene made anew of the same meshes", of["moved"] / of["made anew"]),
        (f"the same with one instance of {FEW} moved", of["few moved"] / of["made anew"]),
        ("hierarchies taken along by hierarchies built anew", of["hierarchy along"] / of["hierarchy built"]),
        ("tracing the truth with the former by tracing it with the latter", of["truth along"] / of["truth built"]),
        ("the first map of a moved scene by the second", of["map"] / of["map again"]),
        (f"a map of {RESOLUTION}² texels by a G-buffer of {SIZE[0]}² pixels", of["map again"] / of["picture"]),
    ]


def markdown(head: list[str], rows: list[list[str]]) -> list[str]:
    """A table whose numbers are on the right."""
    return ["| " + " | ".join(row) + " |" for row in (head, ["---", *["---:"] * (len(head) - 1)], *rows)]


def measured(world: Moving) -> str:
    """The part of the page that is measured."""
    scenes, cameras = path_of(world)
    how = {"resolution": RESOLUTION, "size": SIZE, "renderer": "cpu", "filter": FILTER}
    found = sl.aliasing.temporal(scenes, cameras, world.light, TECHNIQUES, **how)
    still = sl.aliasing.temporal(world.scene, cameras, world.light, TECHNIQUES, **how)
    failed = found.table[found.table["failure"] != ""]
    if len(failed):
        raise SystemExit(failed.iloc[0]["failure"])
    triangles, instances = seen(scenes, cameras)
    moving, standing = (one.summary.set_index("technique") for one in (found, still))
    base = moving.loc["uniform"]

    def row(name: str, of: pd.Series) -> list[str]:
        at_rest = standing.loc[name]
        return [
            f"`{name}`", f"{of['misclassified'] / base['misclassified']:.2f}",
            f"{of['flip_share'] / base['flip_share']:.2f}", f"{of['drift_mean']:.2f}",
            f"{at_rest['misclassified'] / base['misclassified']:.2f}",
            f"{at_rest['flip_share'] / base['flip_share']:.2f}", f"{at_rest['drift_mean']:.2f}",
        ]  # fmt: skip

    head = ["technique", "wrong", "flips", "drift", "at rest: wrong", "flips", "drift"]
    scene = world.scene
    facts = [
        ["objects", "10,000, tree-like", f"{len(world.trees):,} trees, {scene.instance_count - 1:,} instances in all"],
        ["triangles", "not given; 100,000 or more visible is called rich",
         f"{scene.triangle_count:,}; {triangles:,} of {instances:,} instances in the middle frame"],
        ["what moves", "not given", "every tree, every robot, the camera"],
        ["light", "one directional", "one directional"],
        ["picture, map", "512², 2048²", f"{SIZE[0]}², {RESOLUTION}²"],
        ["field of view, near, far", "60°, 0.1, 70", f"{FOV_DEG:g}°, {NEAR:g}, {FAR:g} m"],
        ["filter", "2x2 percentage closer", f"`{FILTER}`, the same"],
        ["bias", "slope-scaled, linear depth", "the default, by the receiver's plane"],
        ["near distance of the warp", "Δz from visibility", "`near=delta-z` in the third row, optimal in the fourth"],
        ["culling", "coherent hierarchical, on the device",
         "instances outside each map's volume; for wrong pixels also those that no pixel looks up"],
        ["machine", "Pentium 4 at 2.4 GHz, Radeon 9600", "any"],
        ["frame times", "none printed; asks for a matter of milliseconds", "ratios below"],
    ]  # fmt: skip
    share = found.table["moving"].astype(float).mean()
    return "\n".join([
        "",
        *markdown(["what", "published", "here"], facts),
        "",
        f"Means over {FRAMES} frames, relative to `uniform` while everything moves; drift in texels. On average"
        f" {100 * share:.0f} % of the receivers move.",
        "The last three columns have the same cameras before the scene at rest.",
        "",
        *markdown(head, [row(name, moving.loc[name]) for name in TECHNIQUES]),
        "",
        "Processor time of parts of a frame, with the `cpu` renderer:",
        "",
        *markdown(["time of", "ratio"], [[what, f"{ratio:.2g}"] for what, ratio in times(world, scenes, cameras[0])]),
        "",
    ])  # fmt: skip


def main() -> None:
    """Writes the page and its picture."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--animation-only", action="store_true")
    options = parser.parse_args()
    world = Moving.made()
    animation(world)
    if not options.animation_only:
        before = PAGE.read_text(encoding="utf-8")
        PAGE.write_text(before[: before.index(MARK)] + MARK + "\n" + measured(world), encoding="utf-8")


if __name__ == "__main__":
    main()
