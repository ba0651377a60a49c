"""The command `shadowlab explain`: why one pixel of a view is wrong, or right, and what would mend it."""

from __future__ import annotations

import click

from ..errors import ArgumentError
from ..text import parse_pixel
from .command import Command, Option, Options
from .options import (
    light_option,
    lookup_given,
    lookup_options,
    one_resolution,
    resolution_option,
    scene_argument,
    size_given,
    technique_option,
    view_options,
    writable_file,
)
from .view import load_view

# What matplotlib writes without anything else installed.
FIGURE_FORMATS = (".png", ".svg", ".pdf")
DEFAULT_TECHNIQUE = "lispsm"


def explain_command(options: Options) -> int:
    """Explains a pixel: its surface, its texel and what that stores, the comparison, the cause, and what would mend it.

    Exit status 0 where the pixel is right or not compared, 1 where it is wrong.
    """
    from ..experiments.explain_pixel import explain_pixel
    from ..scene.view import View

    resolution = one_resolution(options)
    x, y = parse_pixel(options.pixel)
    specs = options.technique or [DEFAULT_TECHNIQUE]
    if len(specs) != 1:
        raise ArgumentError(f"technique: expected one, got {' and '.join(specs)}; explain a pixel of one at a time")
    size, read = size_given(options), lookup_given(options)
    file = None if options.figure is None else writable_file("figure", options.figure)
    if file is not None and file.suffix.lower() not in FIGURE_FORMATS:
        ends = ", ".join(FIGURE_FORMATS)
        raise ArgumentError(f"figure: expected a file that ends in one of {ends}, got {options.figure!r}; rename it")
    scene, camera, light, _ = load_view(options, size)
    found = explain_pixel(
        View(scene, camera, light, size), specs[0], x, y, resolution=resolution, renderer=options.backend, **read,
        trials=not options.no_trials,
    )  # fmt: skip
    print(found)
    if file is not None:
        found.figure().savefig(file)
        print(f"\nFigure: {file}")
    return int(found.is_wrong)


EXPLAIN = Command(
    "explain",
    explain_command,
    [
        scene_argument(),
        Option("--pixel", metavar="X,Y", required=True, help="column and row of the pixel, from 0,0 at the upper left"),
        technique_option(f"(default: {DEFAULT_TECHNIQUE})"),
        resolution_option("texels along each side of the maps"),
        *lookup_options(),
        Option("--no-trials", is_flag=True, help="leave out what would mend it: draws no other map"),
        Option(
            "--figure", metavar="FILE", type=click.Path(), help="write a figure there: png, svg or pdf, by its ending"
        ),
        light_option(),
        *view_options(),
    ],
)
