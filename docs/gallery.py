"""Draws the gallery: every technique on four scenes at five light angles, with its wrong pixels counted.

    python docs/gallery.py [--resolution 512] [--size 480x270] [--out docs/gallery]

Writes one contact sheet a scene (a row a technique, a column an angle between light and view) and docs/gallery.md with
the counts. An angle turns the light in the vertical plane through the view: 90 degrees is a light from above the
viewer, 5 degrees one that nearly runs along the view.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

import shadowlab as sl
from shadowlab import pictures

ROOT = Path(__file__).resolve().parents[1]
SCENES = ("courtyard", "robots", "ceiling", "dueling")
ANGLES_DEG = (90, 55, 35, 20, 5)
# The eye view of one cell, pixels; the label column and the header row beside it.
CELL = (200, 112)
LABEL, HEADER, FOOTER = 104, 20, 14


def light_at(camera: Any, angle_deg: float) -> Any:
    """The directional light at an angle to the view, in the plane of the view and the camera's up."""
    angle = np.radians(angle_deg)
    return sl.DirectionalLight(np.cos(angle) * np.asarray(camera.forward) - np.sin(angle) * np.asarray(camera.up))


def studies(name: str, resolution: int, size: tuple[int, int]) -> list[Any]:
    """One study an angle, of all techniques with their defaults."""
    scene = sl.library.scene(name)
    techniques = list(dict.fromkeys(sl.techniques()["name"]))
    return [
        sl.compare(
            scene, scene.camera, light_at(scene.camera, angle), techniques,
            resolution=resolution, size=size, renderer="cpu", progress=False,
        )
        for angle in ANGLES_DEG
    ]  # fmt: skip


def cell(study: Any, run: Any) -> Image.Image:
    """The wrong pixels of a run over a grey eye view; grey with the reason where there is none."""
    if run.errors is None:
        return Image.new("RGB", CELL, (236, 236, 236))
    marked = pictures.difference(study.gbuffer, study.light, study.truth, run.errors.image, width=2)
    return Image.fromarray(marked).resize(CELL, Image.Resampling.BOX)


def sheet(scene_studies: list[Any]) -> Image.Image:
    """The contact sheet of one scene."""
    labels = [run.label for run in scene_studies[0].runs]
    width, height = CELL
    picture = Image.new("RGB", (LABEL + len(ANGLES_DEG) * width, HEADER + len(labels) * (height + FOOTER)), "white")
    draw, font = ImageDraw.Draw(picture), ImageFont.load_default(11)
    for column, (angle, study) in enumerate(zip(ANGLES_DEG, scene_studies, strict=True)):
        left = LABEL + column * width
        draw.text((left + 4, 4), f"light at {angle}° to the view", fill="black", font=font)
        for row, run in enumerate(study.runs):
            top = HEADER + row * (height + FOOTER)
            picture.paste(cell(study, run), (left, top))
            text = "cannot serve this view" if run.errors is None else f"{run.errors.count:,} wrong"
            draw.text((left + 4, top + height), text, fill=(90, 90, 90) if run.errors is None else "black", font=font)
            if column == 0:
                draw.text((4, top + height // 2 - 6), run.label, fill="black", font=font)
    return picture


def counts(scene_studies: list[Any]) -> list[str]:
    """Markdown rows: a technique and its wrong pixels at each angle."""
    rows = []
    for index, run in enumerate(scene_studies[0].runs):
        cells = []
        for study in scene_studies:
            errors = study.runs[index].errors
            cells.append("cannot" if errors is None else f"{errors.count:,}")
        maps = [
            len(s.runs[index].parameterization.partitions) for s in scene_studies if s.runs[index].errors is not None
        ]
        many = "" if not maps else str(max(maps)) if min(maps) == max(maps) else f"{min(maps)} to {max(maps)}"
        rows.append(f"| `{run.label}` | {many} | " + " | ".join(cells) + " |")
    return rows


def main() -> None:
    """Draws all sheets and writes the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--resolution", type=int, default=512)
    parser.add_argument("--size", default="480x270")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "gallery")
    options = parser.parse_args()
    width, height = (int(n) for n in options.size.split("x"))
    options.out.mkdir(parents=True, exist_ok=True)
    page = [
        "# Gallery",
        "",
        f"Every technique with its defaults at {options.resolution}² texels a map, in pictures of {width} x {height}",
        "pixels; a column an angle between light and view. Orange: shadow where there is light; blue: light where",
        "there is shadow, both held against traced truth. *cannot*: the technique has no map for this view, and says",
        "why. Techniques with several maps use that many times the texels. Made by `python docs/gallery.py`.",
        "",
    ]
    for name in SCENES:
        done = studies(name, options.resolution, (width, height))
        sheet(done).quantize(128, dither=Image.Dither.NONE).save(options.out / f"{name}.png", optimize=True)
        head = " | ".join(f"{angle}°" for angle in ANGLES_DEG)
        page += [f"## {name}", "", f"| wrong pixels | maps | {head} |", "| --- | --- |" + " ---: |" * len(ANGLES_DEG)]
        page += [*counts(done), "", f"![{name}]({options.out.name}/{name}.png)", ""]
    (options.out.parent / "gallery.md").write_text("\n".join(page), encoding="utf-8")


if __name__ == "__main__":
    main()
