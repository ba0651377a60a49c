"""Why pixels are wrong and how large texels are, in the page: tables of all runs, and two pictures of each."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from html import escape
from typing import TYPE_CHECKING, Any

from ...aliasing.causes import CAUSES, MEANINGS
from ...experiments.run import done
from ...pictures.causes import CAUSE_RGB
from ...pictures.errors import error_scale_svg
from ...text import digits, is_missing, px_text, share_text
from ..words import size_text
from .parts import BAR_HEAD, bar, css_rgb, figure, head_cell, picture, swatch, table_html

if TYPE_CHECKING:
    from ...aliasing.causes import Causes
    from ...experiments.run import Run
    from ...experiments.study import Study
    from ...pictures.backdrop import Backdrop
    from .album import Album

COLOURS = {name: css_rgb(CAUSE_RGB[code]) for code, name in CAUSES.items()}


def section_errors(study: Study) -> str:
    """Why pixels are wrong, and how large the runs' texels are; nothing where no run was measured."""
    rows = [(i, run, row) for i, (run, row) in enumerate(zip(study.runs, study.rows, strict=True))]
    rows = [entry for entry in rows if entry[1].summary is not None]
    parts = [why(rows)] if any(run.causes is not None for _, run, _ in rows) else []
    parts += [how_large(rows)] if rows else []
    return "".join(parts)


def why(rows: Sequence[tuple[int, Run, Mapping[str, Any]]]) -> str:
    """The table of causes."""
    most = max((run.causes.count for _, run, _ in rows if run.causes is not None), default=0)
    lines = [
        f"<tr>{head(i, row)}{bar(all_causes(run.causes), most)}"
        f"{''.join(cell(row, name, '{:,}'.format) for name in COLOURS)}{cell(row, 'edge_px', px_text)}</tr>"
        for i, run, row in rows
    ]
    words = "; ".join(f"<b>{name}</b>, {escape(MEANINGS[name])}" for name in COLOURS)
    keys = "".join(f"{swatch(colour)}<span>{name}</span>" for name, colour in COLOURS.items())
    return (
        '<section><h2>Why pixels are wrong</h2><p class="lede">Each wrong pixel has one cause: '
        f"{words}. Edges are moved by the distance to the nearest pixel whose truth is what the map says.</p>"
        f"{table_of_runs([BAR_HEAD, *map(head_cell, (*COLOURS, 'edges moved'))], lines)}"
        f'<p class="key">{keys}</p></section>\n'
    )


def how_large(rows: Sequence[tuple[int, Run, Mapping[str, Any]]]) -> str:
    """The table of texels."""
    forms: dict[str, Callable[[Any], str]] = {
        "texel_mean": px_text, "texel_p95": px_text, "texel_max": px_text, "undersampled": share_text,
        "perspective_max": px_text,
        "storage_factor": digits, "unused": share_text,
    }  # fmt: skip
    lines = [
        f"<tr>{head(i, row)}{''.join(cell(row, key, form) for key, form in forms.items())}</tr>" for i, _, row in rows
    ]
    heads = ("mean", "95 %", "worst", "undersampled", "by perspective", "storage", "unread")
    table = table_of_runs(list(map(head_cell, heads)), lines)
    return (
        '<section><h2>How large texels are</h2><p class="lede">The longest extent of a texel in the picture: its '
        "mean, what 95 % of the pixels do not exceed, the worst, and the worst that remains where slopes add nothing. "
        "Above one pixel it shows: the pixel is undersampled. Storage is texels over pixels that would leave no error "
        f"of perspective; unread texels are seen by no pixel.</p>{table}</section>\n"
    )


def table_of_runs(heads: list[str], lines: Sequence[str]) -> str:
    """A table whose rows begin with `head`."""
    found = table_html([head_cell("technique"), head_cell("resolution"), *heads], lines)
    return f'<div class="scroll">{found}</div>'


def all_causes(causes: Causes | None) -> list[tuple[int, str]]:
    """What a bar of all causes is made of; nothing where they were not counted."""
    return [] if causes is None else [(causes.counts[name], colour) for name, colour in COLOURS.items()]


def head(index: int, row: Mapping[str, Any]) -> str:
    """The first cells of a row."""
    return f'<td><a href="#run-{index}">{escape(str(row["technique"]))}</a></td><td>{escape(size_text(row))}</td>'


def cell(row: Mapping[str, Any], key: str, form: Callable[[Any], str]) -> str:
    """A cell; a dash where nothing was measured."""
    return f"<td>{'–' if is_missing(row[key]) else escape(form(row[key]))}</td>"


def error_figures(
    study: Study, run: Run, name: str, stem: str, backdrop: Backdrop, album: Album, width: int
) -> str:  # fmt: skip
    """The size of texels at every pixel of a run, and the causes of its wrong pixels, `width` pixels wide each."""
    aspect = study.camera.aspect
    source = album.add(lambda: backdrop.texels(study.footprint(run.label, run.resolution)), f"{stem}_texels.png")
    s = done(run.summary)
    told = "Nothing looks up a texel."
    if s.percentiles is not None and s.undersampled is not None:
        told = f"95 % of the pixels up to {px_text(s.percentiles[95])}, {share_text(s.undersampled)} undersampled."
    text = f"Length of a texel of {name} at every pixel. {told}"
    caption = f"<b>Length of a texel</b> in the picture. {escape(told)}{error_scale_svg((), label='pixels')}"
    found = figure(picture(source, text, aspect), caption, aspect)
    if run.causes is None:
        return found
    causes = run.causes
    album.add(partial(backdrop.causes, causes.image), f"{stem}_causes.png")
    wide = album.add(partial(backdrop.causes, causes.image, width))
    counts = ", ".join(f"{count:,} {cause}" for cause, count in causes.counts.items())
    keys = "".join(f"{swatch(colour)}{cause} " for cause, colour in COLOURS.items())
    caption = f'<b>Why pixels are wrong</b>: {counts}.<br><span class="key">{keys}</span>'
    return found + figure(picture(wide, f"Causes of the wrong pixels of {name}: {counts}", aspect), caption, aspect)
