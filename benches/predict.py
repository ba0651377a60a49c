"""How well wrong pixels are foretold without drawing: predicted counts beside drawn ones. Writes docs/predict.md.

    python benches/predict.py [--scenes DIR] [--size 512] [--resolution 1024] [--out docs/predict.md]

Every technique is drawn and predicted in every view of `benches/defaults.py`, several maps at the memory of one. The
doubt that a prediction tells of itself is chosen by leaving scenes out: bounds from all other scenes are counted in the
scene that was left out, and have to hold nine of ten counts there.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import numpy as np
from defaults import cases, wrong
from scipy.stats import spearmanr

import shadowlab as sl
from shadowlab.experiments.predict import LEAST, MOST, PIXELS

#: Techniques, each with the number of its maps.
TECHNIQUES = {
    "uniform": 1, "uniform:turn=rectangle": 1, "uniform:range=body,fit=exact": 1, "lispsm": 1,
    "lispsm:range=body,fit=exact": 1, "gmnpr": 1, "tsm": 1, "psm": 1, "glpr": 1, "xpsm": 1, "plane_optimal": 1,
    "log_psm": 1, "scene_optimal": 1, "scene_optimal:search=published": 1, "optimal_partition:count=2": 2,
    "z_partition:count=2,inner=lispsm,range=seen": 2, "z_partition:count=4,inner=lispsm,range=seen": 4,
    "z_partition:count=4,range=seen": 4,
}  # fmt: skip
#: What is right of the best: within this of its count.
CLOSE = 1.1
#: Share of the counts of scenes left out that bounds must hold, and shares of the others to leave out at either end.
INSIDE, TAILS = 0.9, (0.05, 0.04, 0.03, 0.02, 0.01)


def counts(view: sl.View, resolution: int) -> dict[str, tuple[int, float]]:
    """Drawn and predicted wrong pixels of every technique that serves the view."""
    found: dict[str, tuple[int, float]] = {}
    for name, maps in TECHNIQUES.items():
        side = round(resolution / math.sqrt(maps))
        try:
            found[name] = (wrong(view, name, side), float(sl.predict(view, name, side, renderer="cpu")))
        except sl.errors.UnsupportedError:
            continue
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=Path)
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--resolution", type=int, default=1024)
    parser.add_argument("--out", type=Path, default=Path(__file__).resolve().parents[1] / "docs" / "predict.md")
    args = parser.parse_args()
    rows: list[tuple[str, str, float, float, str]] = []
    pairs: list[tuple[str, float, float]] = []
    for case in cases(args.scenes, args.size):
        found = counts(case.view, args.resolution)
        drawn, predicted = (np.array([of[i] for of in found.values()], float) for i in (0, 1))
        names = list(found)
        # Where nothing is wrong there is no order.
        if drawn.max() == 0:
            continue
        first = int(np.argmin(predicted))
        rank = float(spearmanr(drawn, predicted).statistic)
        rows.append(
            (case.scene, names[first], rank, float(drawn[first] / max(drawn.min(), 1.0)), names[drawn.argmin()])
        )
        pairs += [(case.scene, a, b) for a, b in zip(drawn, predicted, strict=True)]
        print(*rows[-1], flush=True)
    args.out.write_text(page(rows, pairs, args), "utf-8")


def held_out(pairs: list[tuple[str, float, float]], tail: float) -> float:
    """The share of counts within bounds that were chosen from all other scenes."""
    inside = 0
    for scene in dict.fromkeys(scene for scene, *_ in pairs):
        low, high = bounds([pair for pair in pairs if pair[0] != scene], tail)
        own = [pair for pair in pairs if pair[0] == scene]
        inside += sum(low * b - PIXELS <= a <= high * b + PIXELS for _, a, b in own)
    return inside / len(pairs)


def bounds(pairs: list[tuple[str, float, float]], tail: float) -> tuple[float, float]:
    """The factors that leave out this share of the counts at either end, give or take `PIXELS`."""
    drawn, predicted = (np.array([pair[i] for pair in pairs]) for i in (1, 2))
    least = np.quantile((drawn + PIXELS) / np.maximum(predicted, 1.0), tail)
    most = np.quantile((drawn - PIXELS) / np.maximum(predicted, 1.0), 1.0 - tail)
    return float(least), float(most)


def widest_tail(pairs: list[tuple[str, float, float]]) -> float:
    """The largest of `TAILS` so that nine of ten counts of left out scenes are within."""
    return next((tail for tail in TAILS if held_out(pairs, tail) >= INSIDE), TAILS[-1])


def page(
    rows: list[tuple[str, str, float, float, str]], pairs: list[tuple[str, float, float]], args: argparse.Namespace
) -> str:
    """The page."""
    ranks, off = (np.array([row[i] for row in rows]) for i in (2, 3))
    tail = widest_tail(pairs)
    least, most = bounds(pairs, tail)
    ratio = np.quantile([(a + 1) / (b + 1) for _, a, b in pairs], (0.05, 0.5, 0.95))
    inside = np.mean([LEAST * b - PIXELS <= a <= MOST * b + PIXELS for _, a, b in pairs])
    lines = [
        "# Wrong pixels foretold", "",
        f"`sl.predict` against drawn counts: {len(rows)} views of {len({row[0] for row in rows})} scenes "
        f"({args.size} x {args.size} pixels), {len(TECHNIQUES)} techniques at the memory of one map of "
        f"{args.resolution} x {args.resolution} texels, with the default bias. Made by `python "
        f"benches/predict.py --scenes DIR --size {args.size} --resolution {args.resolution}`.", "",
        f"- Rank correlation with the drawn counts of a view: {np.median(ranks):.3f} in the median, at least 0.9 in "
        f"{np.sum(ranks >= 0.9)} views.",
        f"- The technique with the least predicted count is within {CLOSE} of the best drawn one in "
        f"{np.sum(off <= CLOSE)} of {len(rows)} views; at worst it has {off.max():.2f} times as many wrong pixels.",
        f"- Drawn over predicted: {ratio[1]:.2f} in the median, 5 to 95 % {ratio[0]:.2f} to {ratio[2]:.2f}.",
        f"- Bounds of {least:.2f} and {most:.2f} times the predicted count, give or take {PIXELS:.0f} pixels, leave "
        f"out {100 * tail:.0f} % of the counts at either end; chosen without a scene, they hold "
        f"{100 * held_out(pairs, tail):.0f} % of the counts in it. `Prediction.low` and `high` use {LEAST} and {MOST}, "
        f"which hold {100 * inside:.0f} %.", "",
        "A map is read as a lookup with the bias reads it, from what the picture's pixels show (docs/theory.md 10.3). "
        "What is not in it: filters, blending, what maps store other than the nearest depth, casters thinner than a "
        "pixel, and what the picture does not show.", "",
        "| scene | least predicted | rank correlation | times the best drawn | best drawn |",
        "| --- | --- | --- | --- | --- |",
        *(f"| {scene} | `{name}` | {rank:.3f} | {off:.2f} | `{best}` |" for scene, name, rank, off, best in rows),
        "",
    ]  # fmt: skip
    return "\n".join(lines)


if __name__ == "__main__":
    main()
