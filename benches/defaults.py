"""How the defaults of the warps were chosen: by leaving scenes out. Writes docs/defaults.md.

    python benches/defaults.py [--scenes DIR] [--size 512] [--resolution 1024] [--out docs/defaults.md]

Every candidate of a setting is drawn in every view. For each scene in turn the candidate that does best in all other
scenes is chosen, and is counted in the scene that was left out; so no scene affects what it is judged by. Views are
those of the library, with a second light each, and of the meshes of a folder with a scenes.json, where one is given.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import shadowlab as sl

BODY = "range=body,fit=exact"
#: Settings that a default could have; the first of each is the default.
CANDIDATES: Mapping[str, Sequence[str]] = {
    "lispsm, near": (
        "lispsm", "lispsm:norm=flips", "lispsm:norm=linf", "lispsm:norm=storage", "lispsm:norm=mean",
        "lispsm:near=delta-z", "lispsm:near=basic",
    ),
    "lispsm, fit and range": (
        "lispsm", "lispsm:fit=seen", "lispsm:fit=exact", "lispsm:range=body",
        f"lispsm:near=optimal,over=body,{BODY}", f"lispsm:near=delta-z,{BODY}",
    ),
    "margin": ("lispsm", "lispsm:margin=0", "lispsm:margin=2", "lispsm:margin=8"),
    "gmnpr": ("gmnpr", "gmnpr:fit=seen", "gmnpr:fit=exact", f"gmnpr:{BODY}"),
    "tsm": ("tsm", "tsm:fit=seen", "tsm:fit=exact", f"tsm:{BODY}"),
    "psm": ("psm", "psm:fit=seen", "psm:fit=exact", f"psm:{BODY}"),
    "glpr": ("glpr", "glpr:fit=seen", "glpr:fit=exact", f"glpr:{BODY}"),
    "xpsm": tuple(f"xpsm:coefficient=lispsm{more}" for more in ("", ",fit=seen", ",fit=exact", f",{BODY}")),
    "log_psm": ("log_psm", "log_psm:fit=seen", "log_psm:fit=exact", f"log_psm:{BODY}"),
    "uniform": ("uniform", "uniform:fit=seen", "uniform:fit=shadow", "uniform:turn=rectangle",
                "uniform:turn=rectangle,fit=shadow"),
    "scene_optimal": (
        "scene_optimal", *(f"scene_optimal:cap={cap}" for cap in (8, 32, 64, "none")),
        *(f"scene_optimal:objective={objective}" for objective in ("l1", "l2", "area", "flips")),
        "scene_optimal:search=published", "scene_optimal:fit=seen",
    ),
}  # fmt: skip
#: The warp as it was placed before there were samples, and with the near plane at the first visible surface.
PLACED_BY_BODY, PLACED_BY_FIRST = f"lispsm:near=delta-z,{BODY}", "lispsm:near=delta-z,fit=exact"
SIDES = (70, 128, 256)
NEAR_SHARES = (1e-3, 0.1, 0.9)
LIGHTS = {
    "courtyard": (0.3, -0.5, -0.8), "robots": (-0.1, -0.35, -1), "ceiling": (0.5, -0.7, 0.3),
    "skylight": (0.6, -0.5, 0.3), "dueling": (0.5, -0.4, 0.3), "forest": (0.4, -0.5, 0.6),
}  # fmt: skip
#: Degrees about the up axis by which the second light of a mesh is turned.
TURN_DEG = 130.0


@dataclass(frozen=True)
class Case:
    """A view and the scene that is left out with it."""

    scene: str
    view: sl.View


def square(camera: sl.Camera) -> sl.Camera:
    """The camera with an aspect of 1."""
    return camera.replace(aspect=1.0)


def cases(folder: Path | None, size: int) -> Iterator[Case]:
    """All views, scene by scene."""
    for name, second in LIGHTS.items():
        scene = sl.library.scene(name, **({"trees": 1000} if name == "forest" else {}))
        for light in (scene.light, sl.DirectionalLight(second)):
            yield Case(name, sl.View(scene, square(scene.camera), light, size=(size, size), label=f"@{name}"))
    if folder is None:
        return
    known = json.loads((folder / "scenes.json").read_text("utf-8"))
    for name, entry in known.items():
        # Of a mesh that is there in two finenesses the finer one.
        twins = [known[other]["triangles"] for other in known if other.split("_")[0] == name.split("_")[0]]
        if entry["triangles"] < max(twins):
            continue
        scene = with_ground(sl.load_scene(folder / name), entry.get("ground"))
        for view in entry["views"]:
            camera = sl.Camera.look_at(
                view["eye"], view["target"], up=view["up"], fov_y=math.radians(view["fov_y_deg"]), aspect=1.0,
                near=view["near"], far=view["far"],
            )  # fmt: skip
            for way in (view["light_direction"], turned(view["light_direction"], view["up"], TURN_DEG)):
                yield Case(name, sl.View(scene, camera, sl.DirectionalLight(way), size=(size, size), label=name))


def with_ground(scene: sl.Scene, ground: Mapping[str, Any] | None) -> sl.Scene:
    """The scene on its square of ground."""
    if ground is None:
        return scene
    up = "xyz".index(ground["axis"])
    across = [axis for axis in range(3) if axis != up]
    corners = np.tile(np.asarray(scene.bounds).mean(axis=0), (4, 1))
    corners[:, up] = ground["height"]
    corners[:, across] += ground["half_width"] * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    return scene + sl.Scene.from_arrays(corners, np.array([(0, 1, 2), (0, 2, 3)]))


def turned(way: Sequence[float], up: Sequence[float], degrees: float) -> np.ndarray:
    """A direction turned about an axis (Rodrigues)."""
    v, k, a = np.asarray(way, float), np.asarray(up, float), math.radians(degrees)
    return v * math.cos(a) + np.cross(k, v) * math.sin(a) + k * (k @ v) * (1 - math.cos(a))


def wrong(view: sl.View, technique: str, resolution: int, samples: sl.Samples | None = None) -> int:
    """Wrong pixels of a technique in a view, with samples of another picture where they are given."""
    item: Any = technique
    if samples is not None:
        made = sl.technique(technique)
        item = made.parameterize(view.scene, view.camera, view.lights[0], resolution=resolution, samples=samples)
    run = sl.evaluate(view, item, resolution, metrics=["misclassified"], renderer="cpu")
    if run.failure:
        raise SystemExit(f"{view.label}, {technique}: {run.failure}")
    return int(run.row()["misclassified"])


Counts = dict[str, list[int]]


def ratio(counts: Counts, technique: str, which: Sequence[int]) -> float:
    """Wrong pixels relative to uniform: the geometric mean over views, each with a pixel to spare."""
    logs = [math.log((counts[technique][i] + 1) / (counts["uniform"][i] + 1)) for i in which]
    return math.exp(sum(logs) / len(logs))


def held_out(counts: Counts, group: Sequence[str], scenes: Sequence[str]) -> tuple[dict[str, int], float]:
    """How often each candidate is chosen while a scene is left out, and what the chosen ones have of uniform there."""
    chosen = dict.fromkeys(group, 0)
    logs: list[float] = []
    for scene in dict.fromkeys(scenes):
        others = [i for i, other in enumerate(scenes) if other != scene]
        best = min(group, key=lambda technique: ratio(counts, technique, others))
        chosen[best] += 1
        left = [i for i, other in enumerate(scenes) if other == scene]
        logs += [math.log((counts[best][i] + 1) / (counts["uniform"][i] + 1)) for i in left]
    return chosen, math.exp(sum(logs) / len(logs))


def table(header: Sequence[str], rows: Sequence[Sequence[object]]) -> list[str]:
    """Lines of a table."""
    lines = ["| " + " | ".join(header) + " |", "| " + " | ".join(["---"] + ["---:"] * (len(header) - 1)) + " |"]
    return lines + ["| " + " | ".join(map(str, row)) + " |" for row in rows]


def summary(counts: Counts, technique: str) -> list[object]:
    """Of uniform in sum; views worse by more than 5 % and 3 pixels; the worst; against the better placement."""
    uniform, own = counts["uniform"], counts[technique]
    better = [min(pair) for pair in zip(counts[PLACED_BY_BODY], counts[PLACED_BY_FIRST], strict=True)]
    against = [a / max(1, b) for a, b in zip(own, better, strict=True)]
    return [
        f"{sum(own) / sum(uniform):.3f}",
        sum(a > 1.05 * u + 3 for a, u in zip(own, uniform, strict=True)),
        f"{max(a / max(1, u) for a, u in zip(own, uniform, strict=True)):.2f}",
        sum(a > 1.1 for a in against),
        f"{max(against):.2f}",
    ]


def main() -> None:
    """Draws all candidates and writes the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=Path, help="folder with meshes and a scenes.json")
    parser.add_argument("--size", type=int, default=512, help="pixels along each side of a picture")
    parser.add_argument("--resolution", type=int, default=1024, help="texels along each side of a map")
    parser.add_argument("--out", type=Path, default=Path(__file__).resolve().parents[1] / "docs" / "defaults.md")
    options = parser.parse_args()
    from defaults_page import page

    options.out.write_text(page(list(cases(options.scenes, options.size)), options.resolution), "utf-8")


if __name__ == "__main__":
    main()
