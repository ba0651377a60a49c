"""How the default bias was chosen: by leaving scenes out. Writes its tables into docs/bias.md.

    python benches/bias.py [--scenes DIR] [--size 512] [--out docs/bias.md]

Each map is drawn once and looked up with every candidate. For each scene in turn the candidate with the fewest wrong
pixels in all other scenes is chosen, of those that are nowhere above `MOST` times the bias of before, and is counted
in the scene that was left out; so no scene affects what it is judged by. The views are those of benches/defaults.py.
"""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from defaults import Case, cases

import shadowlab as sl
from shadowlab.reports.scene_optimal import markdown_table
from shadowlab.text import BIAS

#: The default before receivers' planes, which the others are measured against.
BEFORE = sl.Bias(texels=0.1, slope=1.02, slope_limit=16.0, plane=0.0)
#: Candidates that leave no acne on planes: plane and slope together are at least 1.
PLANES, SLOPES, TEXELS, LIMITS = (0.5, 0.65, 0.75, 0.85, 1.0), (0.3, 0.4, 0.5, 0.6), (0.25, 0.5), (8.0, 16.0)
#: Maps that are looked up in each view.
MAPS = (("lispsm", 1024), ("lispsm", 2048), ("uniform", 1024))
#: Of a candidate: the most times the wrong pixels of before, in any map with at least `FEW` of them.
MOST, FEW = 1.03, 50
#: Candidates in the table, by their sum.
SHOWN = 12
BEGIN, END = "<!-- chosen -->", "<!-- end chosen -->"


def candidates() -> list[sl.Bias]:
    """The biases that the default is chosen from, that of before first."""
    made = [BEFORE]
    for plane, slope, texels, limit in itertools.product(PLANES, SLOPES, TEXELS, LIMITS):
        if plane + slope >= 1.0:
            made.append(sl.Bias(plane=plane, slope=slope, texels=texels, slope_limit=limit))
    return made


def neighbours() -> dict[str, sl.Bias]:
    """The default, and with one part changed."""
    own = sl.Bias()
    changes: dict[str, Sequence[float]] = {
        "plane": (0.0, 0.5, 0.8, 1.0), "slope": (0.2, 0.3, 0.6, 1.02), "texels": (0.0, 0.25, 0.75, 1.0),
        "slope_limit": (4.0, 8.0, 32.0, float("inf")), "normal": (0.1, 0.25),
    }  # fmt: skip
    parts = {name: getattr(own, name) for name in BIAS}
    found = {"default": own}
    for part, values in changes.items():
        for value in values:
            found[f"{part} {value:g}"] = sl.Bias(**{**parts, part: value})
    return found


@dataclass(frozen=True)
class Looks:
    """The wrong pixels of one map, (candidates, 2): false shadow and false light."""

    scene: str
    technique: str
    resolution: int
    counts: np.ndarray


def looks_of(case: Case, biases: Sequence[sl.Bias]) -> Iterator[Looks]:
    """Every map of a view, looked up with every bias."""
    view, renderer = case.view, sl.Renderer("cpu")
    light, gbuffer = view.lights[0], view.gbuffer(renderer)
    for technique, resolution in MAPS:
        samples = view.samples(renderer=renderer)
        p = sl.technique(technique).parameterize(view.scene, view.camera, light, resolution=resolution, samples=samples)
        maps = renderer.shadow_map(view.scene, p, resolution=resolution)
        counts = []
        for bias in biases:
            mask = sl.aliasing.look_up(maps, gbuffer, view.camera, light, p, bias=bias)
            errors = sl.aliasing.misclassified(mask, view.truth())
            counts.append((int(errors.false_shadow), int(errors.false_light)))
        yield Looks(case.scene, technique, resolution, np.array(counts))


def wrong(looks: Sequence[Looks]) -> np.ndarray:
    """Wrong pixels, (maps, candidates)."""
    return np.array([one.counts.sum(axis=1) for one in looks])


def worst(counts: np.ndarray) -> np.ndarray:
    """The most times the bias of before in any map, for each candidate."""
    many = counts[counts[:, 0] >= FEW]
    return (many / many[:, :1]).max(axis=0)


def best(counts: np.ndarray) -> int:
    """The candidate with the fewest wrong pixels of those that are nowhere much worse than before."""
    return int(np.where(worst(counts) <= MOST, counts.sum(axis=0), np.inf).argmin())


def left_out(looks: Sequence[Looks]) -> list[tuple[str, int, np.ndarray]]:
    """Each scene, the candidate chosen without it, and the wrong pixels of that scene's maps with all candidates."""
    found = []
    for scene in dict.fromkeys(one.scene for one in looks):
        others = wrong([one for one in looks if one.scene != scene])
        found.append((scene, best(others), wrong([one for one in looks if one.scene == scene])))
    return found


def short(bias: sl.Bias) -> str:
    """The parts that differ from one candidate to the next."""
    return f"plane {bias.plane:g}, slope {bias.slope:g}, texels {bias.texels:g}, limit {bias.slope_limit:g}"


def cells(label: str, looks: Sequence[Looks], k: int) -> list[str]:
    """A row of a table about one candidate."""
    counts = wrong(looks)
    dark, light = (sum(int(one.counts[k, i]) for one in looks) for i in (0, 1))
    total = dark + light
    median = np.median(counts[:, k] / np.maximum(counts[:, 0], 1))
    return [
        label, f"{total:,}", f"{dark:,}", f"{light:,}", f"{total / counts[:, 0].sum():.3f}", f"{worst(counts)[k]:.2f}",
        f"{median:.2f}",
    ]  # fmt: skip


def tables(
    looks: Sequence[Looks], chosen_from: int, biases: Sequence[sl.Bias], changed: Sequence[str], size: int
) -> str:
    """What is written into the page: of candidates, `chosen_from` of them, and then of the default's neighbours."""
    head = ["bias", "wrong pixels", "false shadow", "false light", "of before", "worst map", "median map"]
    counts = wrong(looks)[:, :chosen_from]
    most, total = worst(counts), counts.sum(axis=0)
    order = [int(k) for k in np.argsort(total) if most[k] <= MOST and k > 0][:SHOWN]
    rows = [
        cells("before: slope 1.02, texels 0.1, limit 16", looks, 0),
        *(cells(short(biases[k]), looks, k) for k in order),
    ]
    own = []
    chosen = left_out([Looks(one.scene, one.technique, one.resolution, one.counts[:chosen_from]) for one in looks])
    for scene, k, c in chosen:
        old, new = int(c[:, 0].sum()), int(c[:, k].sum())
        own.append([scene, short(biases[k]), f"{old:,}", f"{new:,}", f"{new / max(old, 1):.3f}"])
    held, before = sum(int(c[:, k].sum()) for _, k, c in chosen), int(total[0])
    about = [cells(label, looks, chosen_from + k) for k, label in enumerate(changed)]
    maps = ", ".join(f"{name} {side}²" for name, side in MAPS)
    left = ["scene left out", "chosen by the others", "before", "with it", "ratio"]
    return (
        f"{len(looks)} maps ({maps} in {len(looks) // len(MAPS)} views of {len(chosen)} scenes), {size} x {size} "
        f"pixels, {chosen_from} candidates. Of those that are nowhere above {MOST} times the one before, in maps with "
        f"{FEW} wrong pixels or more, the ones with the fewest:\n\n{markdown_table(head, rows, right=range(1, 7))}\n\n"
        f"Each scene with the candidate that is chosen without it has {held:,} wrong pixels of {before:,}, "
        f"{held / before:.3f}:\n\n{markdown_table(left, own, right=range(2, 5))}\n\n"
        f"The default with one part changed:\n\n{markdown_table(head, about, right=range(1, 7))}\n"
    )


def main() -> None:
    """Looks up every candidate and writes the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=Path, help="a folder of meshes with a scenes.json")
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--out", type=Path, default=Path("docs/bias.md"))
    options = parser.parse_args()
    chosen_from, changed = candidates(), neighbours()
    biases, looks = [*chosen_from, *changed.values()], []
    for case in cases(options.scenes, options.size):
        looks += looks_of(case, biases)
        print(case.scene, *(one.counts.sum(axis=1)[:2] for one in looks[-len(MAPS) :]), flush=True)
    text = options.out.read_text("utf-8")
    before, _, rest = text.partition(BEGIN)
    made = tables(looks, len(chosen_from), biases, list(changed), options.size)
    options.out.write_text(f"{before}{BEGIN}\n{made}{END}{rest.partition(END)[2]}", "utf-8")


if __name__ == "__main__":
    main()
