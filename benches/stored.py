"""What a map stores, how its depth is spaced and in which format, under five biases. Writes docs/stored.md.

    python benches/stored.py [--size 320x180] [--resolution 512] [--out docs/stored.md]

One table of `sl.compare` per scene of the library, a technique's text for each combination; the page has their sums.
"""

from __future__ import annotations

import argparse
import itertools
import warnings
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

import shadowlab as sl
from shadowlab.errors import ShadowlabWarning
from shadowlab.reports.scene_optimal import markdown_table
from shadowlab.text import parse_size

SCENES = ("courtyard", "robots", "ceiling", "skylight", "dueling", "forest", "statues")
SURFACES = ("front", "back", "second", "midpoint", "dual")
SPACINGS = ("projective", "linear")
FORMATS = ("f32", "unorm24", "unorm16", "f16")
#: What the biases are called, and their texts.
BIASES = {
    "none": "none",
    "constant, 2 texels": "texels=2,ndc=0,slope=0,plane=0",
    "slope 1.02": "texels=0,slope=1.02,plane=0",
    "plane 1": "texels=0,slope=0.02,plane=1",
    "default": "default",
}
INTRO = """# What a map stores: surface, spacing, format and bias

Written by `python benches/stored.py`: `sl.compare` with a technique's text for each combination, such as
`lispsm:stored=(midpoint:spacing=linear,format=unorm16),bias=none`. LiSPSM at {resolution}², {width} x {height} pixels,
nearest lookup, the {count} scenes of the library with their lights, the forest with 300 trees. Wrong pixels in sum, and
in parentheses those that are acne. Floors of the library are open: `second` and `midpoint` store nothing below them.
"""


def texts() -> dict[tuple[str, str, str, str], str]:
    """The text of each combination: surface, spacing, format, bias."""
    return {
        (surface, spacing, form, name): f"lispsm:stored=({surface}:spacing={spacing},format={form}),bias=({bias})"
        for surface, spacing, form, (name, bias) in itertools.product(SURFACES, SPACINGS, FORMATS, BIASES.items())
    }


def table_of(name: str, size: tuple[int, int], resolution: int) -> pd.DataFrame:
    """The table of a scene: one row per combination."""
    scene = sl.library.scene(name, **({"trees": 300} if name == "forest" else {}))
    made = texts()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ShadowlabWarning)  # of open floors, which the page names
        study = sl.compare(
            scene, scene.camera, scene.light, list(made.values()), resolution=resolution, size=size, renderer="cpu",
            metrics=("misclassified", "causes"), phases=1, progress=False,
        )  # fmt: skip
    found = study.table
    failed = found[found["failure"] != ""]
    if len(failed):
        raise SystemExit(f"{name}: {failed.iloc[0]['technique']}: {failed.iloc[0]['failure']}")
    index = pd.MultiIndex.from_tuples(list(made), names=["surface", "spacing", "format", "bias"])
    return found[["misclassified", "acne", "leak"]].astype(int).set_index(index)


def page(total: pd.DataFrame, scenes: int, size: tuple[int, int], resolution: int) -> str:
    """The page as Markdown."""
    rows: list[Sequence[str]] = []
    for surface, spacing, form in itertools.product(SURFACES, SPACINGS, FORMATS):
        cells = [total.loc[(surface, spacing, form, name)] for name in BIASES]
        rows.append([surface, spacing, form, *(f"{c.misclassified:,} ({c.acne:,})" for c in cells)])
    head = ["surface", "spacing", "format", *BIASES]
    intro = INTRO.format(resolution=resolution, width=size[0], height=size[1], count=scenes)
    return f"{intro}\n{markdown_table(head, rows, right=range(3, 3 + len(BIASES)))}\n\n{said(total)}"


def said(total: pd.DataFrame) -> str:
    """What the table says, in sentences with its numbers."""

    def wrong(surface: str, spacing: str, form: str, bias: str) -> int:
        return int(total.loc[(surface, spacing, form, bias), "misclassified"])

    front = {(spacing, bias): wrong("front", spacing, "f32", bias) for spacing in SPACINGS for bias in BIASES}
    constant, slope = "constant, 2 texels", "slope 1.02"
    second = {name: wrong(name, "linear", "f32", "none") for name in ("back", "second", "midpoint")}
    bits = {bias: wrong("front", "linear", "unorm16", bias) for bias in (slope, "plane 1", "default")}
    halves = wrong("front", "linear", "f16", "default")
    return f"""## What it says
- **Linear depth with a slope bias** is what Wimmer and Scherzer find best [wimmer2006]. That holds among their nine
  combinations, {front["linear", slope]:,} wrong pixels in sum and {front["projective", slope]:,} with projective depth;
  but the slope does nearly all of it. What linear depth mends is the constant bias, {front["projective", constant]:,}
  and {front["linear", constant]:,}: in a warped map even a surface straight across the light has a slope in projective
  depth.
- **With the default bias** the spacing makes no difference ({front["projective", "default"]:,} and
  {front["linear", "default"]:,}), and no other surface has fewer wrong pixels in f32.
- **Without any bias** the back and the second surface in linear depth come close: {second["back"]:,} and
  {second["second"]:,}, `midpoint` {second["midpoint"]:,}. What is left is acne where a caster is thinner than a texel,
  and light at contacts.
- **16 bits** are enough for whole numbers and a bias with a margin: {bits["default"]:,} with the default and linear
  depth. The receiver's plane alone has no margin for the rounding of depth ({bits["plane 1"]:,}): add half a step as
  `ndc`. Halves have {halves:,} in linear depth: near 1 their steps are 2^-11.
"""


def main() -> None:
    """Draws all combinations and writes the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=parse_size, default=(320, 180))
    parser.add_argument("--resolution", type=int, default=512)
    parser.add_argument("--scene", action="append", choices=SCENES, help="some of the scenes; all where none is named")
    parser.add_argument("--out", type=Path, default=Path("docs/stored.md"))
    options = parser.parse_args()
    names = options.scene or SCENES
    total = sum(table_of(name, options.size, options.resolution) for name in names)
    options.out.write_text(page(total, len(names), options.size, options.resolution), "utf-8")


if __name__ == "__main__":
    main()
