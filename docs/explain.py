"""Makes the examples of docs/explain.md: pixels explained, with their figures.

    python docs/explain.py [--check]

With --check nothing is written, and the exit status is 1 where the page is out of date; pictures are not compared.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

from PIL import Image

import shadowlab as sl

ROOT = Path(__file__).resolve().parents[1]
PAGE, PICTURES = ROOT / "docs" / "explain.md", ROOT / "docs" / "explain"
DPI, COLOURS = 90, 128
# What is below it is made here.
MARK = "<!-- examples -->"


@dataclass(frozen=True)
class Example:
    """A pixel of a library scene's own view."""

    title: str
    words: str
    scene: str
    technique: str
    resolution: int
    size: tuple[int, int]
    pixel: tuple[int, int]
    bias: sl.Bias | None = None
    stored: str | None = None

    def explained(self) -> sl.PixelExplanation:
        """The explanation."""
        scene = sl.library.scene(self.scene)
        view = sl.View(scene, scene.camera, scene.light, size=self.size)
        return sl.explain_pixel(
            view, self.technique, *self.pixel, resolution=self.resolution, renderer="cpu", bias=self.bias,
            stored=self.stored,
        )  # fmt: skip

    @property
    def command(self) -> str:
        """What prints it."""
        bias = "" if self.bias is None else " --bias none"
        stored = "" if self.stored is None else f" --stored {self.stored}"
        return (
            f"shadowlab explain @{self.scene} --technique {self.technique} --resolution {self.resolution} "
            f"--size {self.size[0]}x{self.size[1]} --backend cpu{bias}{stored} --pixel {self.pixel[0]},{self.pixel[1]}"
        )


EXAMPLES = (
    Example(
        "Acne",
        "The floor without any bias. In the cut, the depth that the texel stores lies on the receiver's own plane, but "
        "nearer to the light than the pixel's point: a texel covers a slanted patch, and half of it shades itself. The "
        "pixel lies well within its texel, so that half of the slope mends it; a slope of 1 mends all of the floor.",
        "robots", "uniform", 512, (480, 270), (320, 113), sl.Bias.none(),
    ),
    Example(
        "A leak",
        "A shadow under a robot's foot. The blocker lies between the pixel's point and the end of the bias: the bias "
        "carries the point past it. The texel holds the foot, and without bias the pixel would be dark.",
        "robots", "lispsm", 256, (320, 180), (108, 105),
    ),
    Example(
        "A missing caster",
        "The shadow of a thin lath. In the map, the triangle that truth's ray meets passes between the centres of the "
        "texels, and those around hold other surfaces. No bias brings the lath back.",
        "ceiling", "uniform", 512, (480, 270), (136, 195),
    ),
    Example(
        "A contact in a map of second surfaces",
        "A robot's leg meets the floor, seen in a map that stores the second surface of each ray. The texel's centre "
        "lies in the shadow, too, but there the leg's far side is so near to the floor that the depth of the floor "
        "changes more within the texel. A map of the front, or of a depth between, holds the leg.",
        "robots", "lispsm", 256, (320, 180), (42, 158), None, "second",
    ),
)  # fmt: skip


def section(example: Example, found: sl.PixelExplanation, picture: str) -> str:
    """An example with its text and figure."""
    return (
        f"## {example.title}\n\n{example.words}\n\n```\n$ {example.command}\n{found}\n```\n\n"
        f"![{example.title}](explain/{picture})\n"
    )


def main() -> int:
    """Writes the page and its pictures, or checks the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    sections = []
    for example in EXAMPLES:
        found = example.explained()
        name = f"{example.title.lower().split()[-1]}.png"
        sections.append(section(example, found, name))
        if options.check:
            continue
        PICTURES.mkdir(exist_ok=True)
        file = BytesIO()
        found.figure().savefig(file, dpi=DPI)
        picture = Image.open(file).convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
        picture.save(PICTURES / name, optimize=True)
    before, text = PAGE.read_text(encoding="utf-8"), "\n".join(sections)
    made = f"{before[: before.index(MARK)]}{MARK}\n{text}"
    if options.check:
        return int(before != made)
    PAGE.write_text(made, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
