"""The page of a study: one file that stands alone, with its pictures inside, and the tables and pictures beside it.

The page names no other resource: pictures are data URIs, its style is in it, it runs no script, and its content policy
says so. A picture that is shown more than once (the truth) is stored once, as an SVG symbol.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from ... import pictures
from ...experiments.records import csv_text
from ...experiments.run import done
from ...pictures.backdrop import Backdrop, Once
from ...pictures.eye import difference_over
from ...text import share_text
from .. import study_record as record
from ..reproduce import command_line, python_snippet
from ..saved import STUDY_FILE, file_text
from ..terminal import STUDY_HEADS, noise_text, study_cells
from .album import Album
from .chart import error_chart
from .errors import error_figures, section_errors
from .folder import report_folder
from .maps import chosen_figure, map_figure, map_table
from .parts import (
    BAR_HEAD,
    FALSE_LIGHT,
    FALSE_SHADOW,
    bar,
    data_uri,
    document,
    figure,
    flipping,
    head_cell,
    page_foot,
    page_head,
    picture,
    slug,
    swatch,
    symbol,
    table_html,
    use,
)

if TYPE_CHECKING:
    import numpy as np

    from ..._core import Misclassified
    from ...experiments.run import Run
    from ...experiments.study import Study

# What the pictures of a report are called: letters, digits and the like, no folder.
PNG_NAME = re.compile(r"[\w-][\w.-]*\.png")
# The close look is this part of the picture's shorter side: pixels become visible, and where they are stays clear.
WINDOW_SHARE = 8
# Width that the page shows a picture of the eye view in, pixels of the screen; single pixels of larger ones would fade.
SHOWN_PX = 520


def save_study(study: Study, directory: Path, progress: bool | None = None) -> Path:
    """Writes report.html, results.csv, results.json and PNGs into a directory, which is made; the report's path.

    Pictures that an earlier report in the directory names as its own, and this one has not, are removed.

    Raises
    ------
    ArgumentError
        Where it cannot be made or written.
    """
    with report_folder(directory):
        page, files = build(study, progress)
        stale = own_pictures(directory / STUDY_FILE) - files.keys()
        for name, content in files.items():
            (directory / name).write_bytes(content)
        (directory / "results.csv").write_text(csv_text("compare", study.rows), encoding="utf-8")
        (directory / STUDY_FILE).write_text(file_text(record.study_data(study, sorted(files)), study), encoding="utf-8")
        path = directory / "report.html"
        path.write_text(page, encoding="utf-8")
        for name in stale:
            (directory / name).unlink(missing_ok=True)
    return path


def own_pictures(results: Path) -> set[str]:
    """The pictures that an earlier report names as its own: bare names of PNGs, whatever else the file may say."""
    try:
        data = json.loads(results.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return set()  # no earlier report, or a file of somebody else
    named = data.get("pictures") if isinstance(data, dict) else None
    names = {name for name in named if isinstance(name, str)} if isinstance(named, list) else set()
    return {name for name in names if PNG_NAME.fullmatch(name) and (results.parent / name).is_file()}


def build(study: Study, progress: bool | None = False) -> tuple[str, dict[str, bytes]]:
    """The page, and its pictures by file name."""
    album, shared = Album(), ""
    truth = study.truth
    backdrop = Backdrop(study.gbuffer, study.light, truth)
    shaded = {id(run): Once(partial(_shaded, backdrop, run)) for run in study.runs if not run.failure}
    if truth is not None:
        shared = symbol("truth", album.add(lambda: backdrop.lit, "truth.png"), study.camera.aspect)
    body = [
        head_of(study),
        section_table(study),
        section_errors(study),
        section_look(study, shaded, backdrop, album),
        "<section><h2>Each run</h2>",
        *(section_run(study, run, shaded, backdrop, album) for run in study.runs),
        "</section>",
        section_record(study),
    ]
    return album.finished(document(f"Shadow report: {study.source.name}", shared, "".join(body)), progress)


def _shaded(backdrop: Backdrop, run: Run) -> np.ndarray:
    """The eye view with the shadows of a run."""
    return backdrop.shaded(done(run.mask))


def head_of(study: Study) -> str:
    """Title, facts and verdict."""
    scene = study.scene
    instances = f" in {scene.instance_count:,} instances" if scene.instance_count > 1 else ""
    facts = [
        f"{scene.triangle_count:,} triangles{instances}",
        f"{study.light.kind} light",
        f"{study.size[0]} × {study.size[1]} pixels",
        f"{study.lookup} lookup",
        f"{study.backend} renderer",
    ]
    return page_head("shadow report", study.source.name, facts, study.sentences)


def section_table(study: Study) -> str:
    """The numbers, with a bar for the wrong pixels, and a chart where there are several resolutions."""
    rows = study.rows
    wrong = [int(run.errors.count) for run in study.runs if run.errors is not None]
    most, least = max(wrong, default=0), min(wrong, default=0)
    lines = []
    for i, (run, row) in enumerate(zip(study.runs, rows, strict=True)):
        label, *values = (escape(cell) for cell in study_cells(row))
        best = run.errors is not None and len(wrong) > 1 and int(run.errors.count) == least
        link = f'<td><a href="#run-{i}">{label}</a></td>'
        middle = "".join(f"<td>{value}</td>" for value in values[:3])
        times = "".join(f'<td class="timing">{value}</td>' for value in values[6:])  # texels have a table of their own
        kinds = "".join(f"<td>{value}</td>" for value in values[3:5])
        lines.append(
            f"<tr{' class=best' if best else ''}>{link}{middle}{bar(both_kinds(run.errors), most)}{kinds}{times}</tr>"
        )
    key = f'<p class="key">{swatch(FALSE_SHADOW)}<span>false shadow: dark in the map, lit in truth</span>'
    key += f"{swatch(FALSE_LIGHT)}<span>false light: lit by the map, dark in truth</span></p>"
    heads = [head_cell(text) for text in ("technique", "resolution", "wrong pixels", "share")]
    heads += [BAR_HEAD, head_cell("false shadow"), head_cell("false light")]
    heads += [head_cell(text, "timing") for text in ("fit", "map", "look-up")]
    return (
        '<section><h2>The numbers</h2><p class="lede">Every pixel of the eye view is held against a ray traced from '
        "the surface to the light. Pixels that see nothing, and those whose truth is undecided within rounding, are "
        "not compared; surfaces that face away from the light are dark in both.</p>"
        f'<div class="scroll">{table_html(heads, lines)}</div>{key}{error_chart(study.rows)}</section>\n'
    )


def both_kinds(errors: Misclassified | None) -> list[tuple[int, str]]:
    """What a bar of both kinds of error is made of; nothing where none were counted."""
    return [] if errors is None else [(int(errors.false_shadow), FALSE_SHADOW), (int(errors.false_light), FALSE_LIGHT)]


def section_look(study: Study, shaded: Mapping[int, Once], backdrop: Backdrop, album: Album) -> str:
    """The same small window of the truth and of every run, magnified: where most pixels are wrong."""
    runs = [(run, errors) for run in study.runs if (errors := run.errors) is not None]
    if not any(int(errors.count) for _, errors in runs):
        return ""
    width, height = study.size
    side = max(1, min(width, height) // WINDOW_SHARE)
    row, column = pictures.densest_window([errors.image for _, errors in runs], side)
    window = (slice(row, row + side), slice(column, column + side))
    aspect = study.camera.aspect * height / width
    frame = (
        f'<rect x="{100 * column / width}" y="{100 * row / height / study.camera.aspect}" width="{100 * side / width}" '
        f'height="{100 * side / height / study.camera.aspect}" fill="none" stroke="#d00068" stroke-width="1.2"/>'
    )
    place = use("truth", study.camera.aspect, "Where the window lies in the picture", frame)
    lit = picture(album.add(lambda: backdrop.lit[window]), "Truth, magnified", aspect, True)
    figures = [f"<figure>{lit}{place}<figcaption><b>truth</b></figcaption></figure>"]
    for run, errors in runs:
        name = f"{run.label}, {run.resolution}²"
        inside = errors.image[window]
        eye = album.add(partial(_part, shaded[id(run)], window))
        wrong = album.add(partial(_difference_in, backdrop, inside, window))
        counts = f"{int((inside == 1).sum()):,} false shadow, {int((inside == 2).sum()):,} false light here"
        figures.append(
            f"<figure>{picture(eye, f'{name}, magnified', aspect, True)}"
            f"{picture(wrong, f'Wrong pixels of {name}, magnified: {counts}', aspect, True)}"
            f"<figcaption><b>{escape(run.label)}</b> {run.resolution}²<br>{counts}</figcaption></figure>"
        )
    return (
        f'<section><h2>A close look</h2><p class="lede">The {side} × {side} pixels where most are wrong, the same for '
        "every run: the shadow above, its wrong pixels below.</p>"
        f'<div class="look">{"".join(figures)}</div></section>\n'
    )


def _part(whole: Once, window: tuple[slice, slice]) -> np.ndarray:
    """A window of a picture."""
    return whole()[window]


def _difference_in(backdrop: Backdrop, inside: np.ndarray, window: tuple[slice, slice]) -> np.ndarray:
    """The wrong pixels of a window."""
    return difference_over(backdrop.grey[window], inside)


def section_run(study: Study, run: Run, shaded: Mapping[int, Once], backdrop: Backdrop, album: Album) -> str:
    """One run: its pictures, which the album takes up, its notes, and how to get it again."""
    index = study.runs.index(run)
    title = f'<h3>{escape(run.label)} <span class="res">{run.resolution}²</span></h3>'
    notes = "".join(f"<li>{escape(str(note))}</li>" for note in run.notes)
    tail = (f'<ul class="notes">{notes}</ul>' if notes else "") + again(study, [run], "Run it again")
    if run.failure:
        return (
            f'<article class="run" id="run-{index}">{title}<p class="failure">{escape(run.failure)}</p>{tail}</article>'
        )
    stem = f"{slug(run.label)}_{run.resolution}"
    stem = stem if f"{stem}_eye.png" not in album else f"{stem}_{index}"
    aspect, name = study.camera.aspect, f"{run.label} at {run.resolution}²"
    width = max(1, round(max(study.size) / SHOWN_PX))
    eye_source = album.add(shaded[id(run)], f"{stem}_eye.png")
    light_view = map_figure(study.camera, run, name, stem, album)
    eye_text = f"Eye view with the shadows of {name}"
    if run.errors is None:
        eye = figure(picture(eye_source, eye_text, aspect), "<b>Eye view</b> with its shadows", aspect)
        rows = [eye + light_view]
    else:
        hint = '<span class="screen-only"> Point at it or tap it to see the truth in its place.</span>'
        flip = flipping(eye_source, eye_text, aspect)
        image = run.errors.image
        album.add(partial(backdrop.difference, image), f"{stem}_difference.png")
        wide = album.add(partial(backdrop.difference, image, width))
        drawn = f", each drawn {width} pixels wide" if width > 1 else ""
        counts = f"{int(run.errors.false_shadow):,} of false shadow, {int(run.errors.false_light):,} of false light"
        swatches = f'<span class="key">{swatch(FALSE_SHADOW)}false shadow {swatch(FALSE_LIGHT)}false light</span>'
        rows = [
            figure(flip, f"<b>Eye view</b> with its shadows.{hint}", aspect) + light_view,
            figure(use("truth", aspect, "Eye view with traced shadows"), "<b>Truth</b>, traced ray by ray.", aspect)
            + figure(
                picture(wide, f"Wrong pixels of {name}: {counts}", aspect),
                f"<b>Wrong pixels</b>{drawn}: {counts}.<br>{swatches}",
                aspect,
            ),
        ]
    rows += [error_figures(study, run, name, stem, backdrop, album, width)]
    rows += [chosen_figure(study, run, name, stem, album)] if run.chosen is not None else []
    grid = "".join(f'<div class="pictures">{row}</div>' for row in rows) + map_table(run, study.camera)
    return f'<article class="run" id="run-{index}">{title}{numbers_line(run)}{grid}{tail}</article>\n'


def numbers_line(run: Run) -> str:
    """The line under the title of a run."""
    parts = []
    if run.errors is not None:
        e = run.errors
        noise = noise_text(run.numbers)
        parts.append(f"<b>{int(e.count):,}</b>{noise} wrong of {int(e.compared):,} pixels ({share_text(e.fraction)})")
        parts.append(f"{int(e.undecided):,} undecided")
        if e.unmatched:
            parts.append(f"{int(e.unmatched):,} on silhouettes seen by one alone")
    times = run.numbers
    parts += [f"fit {times['fit_us']:.1f} µs"] if "fit_us" in times else []
    parts += [f"map {times['map_ms']:.1f} ms", f"look-up {times['lookup_ms']:.1f} ms"]
    return f'<p class="numbers">{" · ".join(parts)}</p>'


def again(study: Study, runs: Sequence[Run], title: str) -> str:
    """The Python and the command line that compute these runs again."""
    command = command_line(study, runs)
    shell = (
        f'<pre class="wrap">{escape(command)}</pre>'
        if command
        else "<p>The command line cannot say all of this; Python can.</p>"
    )
    return f"<details><summary>{title}</summary><pre>{escape(python_snippet(study, runs))}</pre>{shell}</details>"


def section_record(study: Study) -> str:
    """What the study was: scene, camera, light, settings, versions."""
    lines = "".join(f"<dt>{escape(k)}</dt><dd>{escape(v)}</dd>" for k, v in record.facts(study))
    return (
        f"<section><h2>What was run</h2><dl>{lines}</dl>{again(study, study.runs, 'Run all of it again')}</section>"
        f"{page_foot()}"
    )


def study_html(study: Study) -> str:
    """What a notebook shows: the verdict, the table, small pictures."""
    rows = study.rows
    cell = "padding:4px 12px 4px 0;text-align:right"
    head = "".join(f'<th style="{cell}">{h}</th>' for h in STUDY_HEADS)
    lines = "".join(
        "<tr>" + "".join(f'<td style="{cell}">{escape(c)}</td>' for c in study_cells(row)) + "</tr>" for row in rows
    )
    images = []
    for run in study.runs:
        if run.mask is None:
            continue
        step = max(1, -(-max(study.size) // 320))
        shaded = pictures.shade(study.gbuffer, study.light, done(run.mask))[::step, ::step]
        uri = data_uri(pictures.png(shaded))
        text = escape(f"{run.label}, {run.resolution}²", quote=True)
        width = f"width:240px;aspect-ratio:{study.camera.aspect}"
        images.append(
            f'<figure style="margin:0"><img alt="{text}" style="{width}" src="{uri}">'
            f"<figcaption>{text}</figcaption></figure>"
        )
    failures = "".join(f"<p>{escape(f'{r.label}: {r.failure}')}</p>" for r in study.runs if r.failure)
    return (
        f"<div><p><b>{escape(study.verdict)}</b></p><table><thead><tr>{head}</tr></thead><tbody>{lines}</tbody></table>"
        f"{failures}"
        f'<div style="display:flex;flex-wrap:wrap;gap:12px;margin-top:8px">{"".join(images)}</div></div>'
    )
