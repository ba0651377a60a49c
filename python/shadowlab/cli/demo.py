"""The command `shadowlab demo`: a first look, without a file of one's own."""

from __future__ import annotations

import shlex
from typing import TYPE_CHECKING

from .command import Command, Options
from .options import backend_option, directory_option, writable_directory

if TYPE_CHECKING:
    from ..experiments.run import Run

# Small enough that all of it takes seconds on a laptop, large enough that the pictures show what is wrong.
DEMO_SCENE, DEMO_SIZE, DEMO_RESOLUTION = "courtyard", (640, 360), 1024
DEMO_TECHNIQUES = ("uniform", "lispsm")


def demo_command(options: Options) -> int:
    """Shows in seconds what shadowlab does: two shadow maps of a bundled scene against the ray-traced truth.

    Prints the table, the verdict and what to try next, and writes a report with pictures.
    """
    from .._core import Renderer
    from ..experiments.compare import compare
    from ..reports.terminal import study_table
    from ..scene import library

    directory = writable_directory(options.out)
    scene = library.scene(DEMO_SCENE)
    size = f"{DEMO_SIZE[0]}x{DEMO_SIZE[1]}"
    print(
        f"@{DEMO_SCENE}: a scene of the library, {scene.triangle_count:,} triangles, in {size} pixels.\n"
        f"Two techniques draw a shadow map of {DEMO_RESOLUTION} x {DEMO_RESOLUTION} texels each. Rays that are traced "
        "from every pixel to the light\nare the truth; a pixel is wrong where the map says otherwise.\n",
        flush=True,
    )
    study = compare(
        scene, scene.camera, scene.light, list(DEMO_TECHNIQUES), resolution=DEMO_RESOLUTION, size=DEMO_SIZE,
        renderer=Renderer(options.backend),
    )  # fmt: skip
    report = study.save(directory)
    print(f"{study_table(study.rows)}\n\n{study.verdict}\n\nPictures, and the cause of each wrong pixel: {report}\n")
    print("What to try next:")
    for command, what in next_commands(study.runs[0], size):
        print(f"  {command}\n    {what}")
    return 0


def next_commands(run: Run, size: str) -> list[tuple[str, str]]:
    """Commands that lead on, with what each is for."""
    scene = f"@{DEMO_SCENE}"
    found = [("shadowlab compare city.glb", "the same for a file of yours; a camera and a light that fit are chosen")]
    pixel = wrong_pixel(run)
    if pixel is not None:
        words = ("shadowlab", "explain", scene, "--size", size, "--technique", run.label, "--pixel", pixel)
        found.append((shlex.join(words), "why this pixel is wrong, and what would mend it"))
    return [
        *found,
        (f"shadowlab advise {scene} --memory 1MiB,4MiB", "techniques and splits at equal memory: about a minute"),
        ("shadowlab techniques", "the techniques and their parameters"),
        ("shadowlab --help", "everything else"),
    ]


def wrong_pixel(run: Run) -> str | None:
    """A wrong pixel of a run, the middle one of all in reading order; None where none is wrong."""
    import numpy as np

    wrong = np.argwhere(np.asarray(run.difference) > 0)
    if not len(wrong):
        return None
    y, x = wrong[len(wrong) // 2]
    return f"{x},{y}"


DEMO = Command("demo", demo_command, [directory_option("shadowlab-demo", "report.html and the rest"), backend_option()])
