"""The command `shadowlab compare`: techniques side by side on a scene, and a report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import click

from ..errors import ArgumentError
from .brought import brought_text
from .command import Command, Option, Options
from .options import (
    check_once,
    directory_option,
    light_option,
    lookup_given,
    lookup_options,
    resolution_option,
    resolutions_given,
    scene_argument,
    size_given,
    technique_option,
    view_options,
    writable_directory,
    writable_file,
)
from .view import load_view, view_text

if TYPE_CHECKING:
    from .._core import Note
    from ..experiments.run import Run

DEFAULT_TECHNIQUES = ("uniform", "lispsm")


def compare_command(options: Options) -> int:
    """Compares techniques on a scene and writes a report: report.html, results.csv, results.json and pictures."""
    from .._core import Renderer
    from ..experiments.compare import compare
    from ..reports.terminal import study_table
    from ..techniques.registry import technique_of, with_all
    from ..text.checks import picture_size

    resolutions = resolutions_given(options)
    asked: list[str] = options.technique or list(DEFAULT_TECHNIQUES)
    named = with_all(asked)
    techniques = {spec: technique_of(spec) for spec in named}
    check_once("technique", named)
    if len(set(resolutions)) < len(resolutions):
        raise ArgumentError("resolution: the same one is given twice; give each once")
    size = size_given(options)
    scene, camera, light, source = load_view(options, size)
    size = size or picture_size(camera.aspect)
    read = lookup_given(options)
    renderer = Renderer(options.backend)
    arrays = None if options.save_arrays is None else writable_file("save-arrays", options.save_arrays)
    directory = writable_directory(options.out)
    study = compare(
        scene,
        camera,
        light,
        {spec: techniques[spec] for spec in with_all(asked, light)},
        resolution=resolutions,
        size=size,
        renderer=renderer,
        **read,
        source=replace(source, out=options.out),
    )
    if all(run.failure for run in study.runs):
        raise ArgumentError(study.runs[0].failure)
    report = study.save(directory)
    print(f"{source.name} on {study.backend} ({study.adapter}), {size[0]} x {size[1]} pixels")
    print(f"{view_text(camera, [light], size, source)}{brought_text(scene, source)}\n")
    print(study_table(study.rows))
    for line in notes_of(study.runs):
        print(line)
    print(f"\n{study.verdict}\n\nReport: {report}")
    if arrays is not None:
        print(f"Arrays: {study.save_arrays(arrays)}")
    return 0


def notes_of(runs: Sequence[Run]) -> list[str]:
    """At most a line for each technique: its first note, and how many others there are."""
    notes: dict[str, list[Note]] = {}
    for run in runs:
        of = notes.setdefault(run.label, [])
        of += [note for note in run.notes if note not in of]
    more = {label: f" (and {len(of) - 1} more, in the report)" if len(of) > 1 else "" for label, of in notes.items()}
    return [f"{label}: {of[0]}{more[label]}" for label, of in notes.items() if of]


COMPARE = Command(
    "compare",
    compare_command,
    [
        scene_argument(),
        technique_option(
            'repeat for several; "all" for every technique that serves the light; preset:NAME for what an engine '
            "ships; matrix:file=F,convention=C for matrices of your own; `shadowlab techniques` lists the names "
            "(default: uniform and lispsm)"
        ),
        resolution_option("texels along each side of the maps", metavar="N[,N...]"),
        *lookup_options(),
        directory_option("report", "report.html and the rest"),
        Option(
            "--save-arrays",
            metavar="FILE.npz",
            type=click.Path(),
            help="write G-buffer, truth, matrices, maps and masks there, for numpy.load; docs/arrays.md lists the keys",
        ),
        light_option(),
        *view_options(),
    ],
)
