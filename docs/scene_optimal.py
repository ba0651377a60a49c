"""Makes docs/scene_optimal.md: the experiment of the scene-optimized shadow maps, counted again, with its figures.

    python docs/scene_optimal.py [--rows target/scene_optimal] [--backend cpu]

Rows are kept in the folder of --rows, so that only what is new is counted again; a technique that is added to
`experiments.scene_optimal.TECHNIQUES` takes half a minute.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from PIL import Image

import shadowlab as sl
from shadowlab.experiments import scene_optimal as experiment
from shadowlab.experiments.scene_optimal_table import FIGURES, NORMAL, OPTIMAL, PUBLISHED, SceneOptimalTable
from shadowlab.experiments.scene_optimal_views import other_scenes
from shadowlab.reports import scene_optimal as report

ROOT = Path(__file__).resolve().parents[1]
PAGE, PICTURES = ROOT / "docs" / "scene_optimal.md", ROOT / "docs" / "scene_optimal"
OTHER_SIDE = 1000
# The paper's last column, by size.
PAPER_MORE = {750: 34.2, 1000: 37.8, 1250: 37.0, 1500: 41.2, 1750: 36.9, 2000: 32.9}
COLOURS = 256
#: Techniques that search over all homographies.
BY_SAMPLES = ("scene_optimal", "rectilinear", "optimal_partition")


def intro(result: SceneOptimalTable) -> str:
    """What was counted."""
    triangles = f"{sl.library.scene('statues').triangle_count:,}"
    return f"""# Scene-optimized shadow maps: the experiment

Chong and Gortler [chong2007] counted misclassified pixels in 28 configurations of light and camera of a scene of
about 444,000 triangles, in pictures of 1024 x 1024 pixels, with maps of 750 to 2000 texels a side. Their truth was
a normal shadow map of 3700 x 3700 texels. Their scene and configurations were not published. Here the library scene
`@statues` ({triangles} triangles) takes their place, with 28 configurations that were fixed before anything was
counted.

- **Normal** is the paper's normal map, `{NORMAL}`: the smallest rectangle around the part of the view frustum that
  the light reaches.
- **Truth** is traced. Counts against a normal map of {result.reference}² texels, as in the paper, stand beside it.
  That map has mistakes of its own, which the normal map shares and the others do not.
- **Percent more** is how many more mistakes the normal map makes, in sum over the configurations that both serve.
- **Equal memory**: a technique with K maps has maps of N / sqrt(K) texels a side.
- Counts are of the maps as fitted. Where texels shift, the count of one configuration changes by 0.7 to 4 percent;
  the sums change by less.

`shadowlab experiment scene-optimal` counts it again (`--quick`: four configurations, with bounds that are checked).
`sl.scene_optimal_experiment` is the same in Python, and [a notebook](../notebooks/scene_optimal.ipynb) goes through
it. This page is made by `python docs/scene_optimal.py`."""


def table_of_paper(result: SceneOptimalTable) -> str:
    """The paper's table, ours beside."""
    totals = result.totals[result.totals["technique"] == PUBLISHED]
    paper = "; ".join(f"{side}²: {PAPER_MORE[side]:g} %" for side in totals["single_side"] if side in PAPER_MORE)
    return f"""## The paper's table

With the paper's own search, `{PUBLISHED}`:

{report.paper_markdown(result, PUBLISHED)}

The paper has in its last column, by its map ({paper}). With the search over all homographies, `{OPTIMAL}`:

{report.paper_markdown(result, OPTIMAL)}"""


def table_of_techniques(result: SceneOptimalTable) -> str:
    """All techniques."""
    common = result.served_by_all
    failed = "\n".join(f"- {line}" for line in report.failures(result))
    some = ""
    if failed:
        some = f"""

Some techniques do not serve every light, so their sums above are over other configurations:

{failed}

In sum over the {common.table["view"].nunique()} configurations that all techniques serve:

{report.totals_markdown(common)}"""
    return f"""## All techniques at equal memory

How many percent more mistakes the normal map makes than each technique, by traced truth; wins are configurations,
over all sizes together, in which the normal map makes more mistakes, and at least 1.1 times as many.

{report.totals_markdown(result)}{some}

![Percent more mistakes of the normal map, over the size of the map](scene_optimal/percent_more.png)"""


def where_it_pays(result: SceneOptimalTable, others: SceneOptimalTable) -> str:
    """By configuration, and where something else is as good."""
    beside = report.as_good(result)
    views = result.table["view"].nunique()
    lines = []
    for technique in result.techniques:
        if technique == NORMAL or technique.partition(":")[0] in BY_SAMPLES:
            continue
        of = beside[beside["technique"] == technique]
        served = len(result.ratios(technique))
        better = int((of["ratio"] < 1.0).sum())
        names = "; ".join(of["view"]) or "none"
        lines.append(f"- `{technique}` in {len(of)} of {served} ({better} with fewer mistakes): {names}.")
    any_other = beside["view"][~beside["technique"].str.partition(":")[0].isin(BY_SAMPLES)].nunique()
    return f"""## Where it does not pay

In {any_other} of the {views} configurations a technique that searches over no homographies makes at most 5 percent more
mistakes than `{OPTIMAL}`, over all sizes together. The search buys little there:

{chr(10).join(lines)}

How many times the mistakes of each technique the normal map makes, by configuration, over all sizes together; the
largest in bold:

{report.ratios_markdown(result)}

The other scenes of the library, under their own cameras (square pictures) and lights, with maps of {OTHER_SIDE}²:

{report.ratios_markdown(others)}"""


def figures() -> str:
    """The paper's figures 3 to 5."""
    return """## Samples and maps

The samples that the search looks at, and the world in the map of each technique (256 x 256 texels, as in the
paper's figures 3 and 4; drawn finer). Orange lines are the edges of the camera's frustum.

Three lights cast shadows towards the viewer (`@dueling`):

![Samples and maps under three lights](scene_optimal/dueling.png)

A skylight under the sun and under a spot (`@skylight`):

![Samples and maps under two lights](scene_optimal/skylight.png)

The statues:

![Samples and maps of the statues](scene_optimal/statues.png)"""


def configurations() -> str:
    """Cameras and lights."""
    return f"""## The configurations

Every camera with every sun and every spot; square pictures, +y is up. Declared in
`shadowlab.experiments.scene_optimal_views`.

{report.configurations_markdown()}"""


def main() -> None:
    """Counts what is missing, and writes the page and its pictures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rows", type=Path, default=ROOT / "target" / "scene_optimal")
    parser.add_argument("--backend", default="cpu")
    options = parser.parse_args()
    folders = [options.rows / name for name in ("statues", "others")]
    for folder in (*folders, PICTURES):
        folder.mkdir(parents=True, exist_ok=True)
    result = sl.scene_optimal_experiment(renderer=options.backend, out=folders[0])
    others = sl.scene_optimal_experiment(
        renderer=options.backend, out=folders[1], sizes=(OTHER_SIDE,), views=other_scenes()
    )
    parts = [
        intro(result), table_of_paper(result), table_of_techniques(result), where_it_pays(result, others), figures(),
        configurations(),
    ]  # fmt: skip
    PAGE.write_text("\n\n".join(parts) + "\n", encoding="utf-8")
    for name in FIGURES:
        figure = result.figure(name)
        figure.canvas.draw()
        picture = Image.fromarray(np.asarray(figure.canvas.buffer_rgba())[..., :3])
        picture.quantize(COLOURS, dither=Image.Dither.NONE).save(PICTURES / f"{name}.png", optimize=True)
    print(f"{experiment.ROWS_FILE} in {options.rows}; wrote {PAGE.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
