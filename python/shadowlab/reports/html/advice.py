"""The page of an advice: one file that stands alone, with its pictures inside, and the tables and data beside it.

The pictures are of the best candidate and of uniform, or of the best warp or split where uniform is the best: in the
view where the best has its largest error, and in some others.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from ...errors import ShadowlabError
from ...experiments.counts import WrongPixels
from ...experiments.memory import memory_text
from ...experiments.run import done
from ...pictures.backdrop import Backdrop
from ...text import listed
from ...text.progress import steps_of_call
from ..advice_record import advice_data, figure_png
from ..reproduce_advice import snippet_of, whole_advice
from ..saved import ADVICE_FILE, file_text
from ..terminal import ADVICE_HEADS, advice_cells
from ..words import wrong_text
from .album import Album
from .folder import report_folder
from .page import SHOWN_PX
from .parts import (
    BAR_HEAD,
    FALSE_LIGHT,
    FALSE_SHADOW,
    bar,
    data_uri,
    document,
    figure,
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
    from ...experiments.advice import Advice
    from ...experiments.candidates import Outcome
    from ...experiments.ranking import Standing
    from ...experiments.tried import Untried
    from ...types import TruthImage

# Views whose pictures the page shows; the tables have all of them.
MOST_VIEWS = 3
# The column of candidates in a row of the ranking.
CANDIDATE = ADVICE_HEADS.index("candidate")


def save_advice(advice: Advice, directory: Path, progress: bool | None = None) -> Path:
    """Writes report.html, the tables, the data and the figure into a directory, which is made; the report's path.

    Raises
    ------
    ArgumentError
        Where it cannot be made or written.
    """
    path = directory / "report.html"
    with steps_of_call(3, progress) as step, report_folder(directory):
        step("report: tables")
        data = file_text(advice_data(advice), advice)
        for name, table in (("advice", advice.table), ("runs", advice.runs), ("switches", advice.switches)):
            table.to_csv(directory / f"{name}.csv", index=False)
        step("report: figure")
        drawn = figure_png(advice)
        (directory / "advice.png").write_bytes(drawn)
        (directory / ADVICE_FILE).write_text(data, encoding="utf-8")
        step("report: pictures")
        path.write_text(advice_page(advice, drawn), encoding="utf-8")
    return path


def advice_page(advice: Advice, drawn: bytes) -> str:
    """The page; `drawn` is the figure of the advice as a PNG."""
    ranking = advice.standings
    shown = pictured(advice, ranking)
    shared: list[str] = []
    album = Album()
    body = [
        advice_head(advice),
        section_ranking(advice, ranking, shown),
        section_figure(advice, drawn),
        section_pictures(advice, shown, shared, album),
        section_untried(advice, ranking),
        section_again(advice, shown),
    ]
    page = document(f"Shadow advice: {advice.source.name}", "".join(shared), "".join(body))
    return album.finished(page)[0]


def pictured(advice: Advice, ranking: Sequence[Standing]) -> list[Standing]:
    """The best of all and uniform with as much memory; the best warp or split where uniform is the best."""
    valid = [one for one in ranking if one.ranked]
    if not valid:
        return []
    best = min(valid, key=lambda one: (float(one.error or 0.0), one.memory))
    beside = [one for gain in advice.gains if gain.memory == best.memory for one in (gain.baseline, gain.best)]
    return [best, *[one for one in beside if one.candidate != best.candidate][:1]]


def advice_head(advice: Advice) -> str:
    """Title, facts and verdict."""
    many = len(advice.views)
    sizes = listed([f"{w} × {h}" for w, h in dict.fromkeys(view.size for view in advice.views)])
    facts = [
        f"{advice.scene.triangle_count:,} triangles", f"{many} view{'s' * (many > 1)}", f"{sizes} pixels",
        listed([memory_text(one) for one in advice.budgets]), f"by {advice.measure.title}",
        f"{advice.read.lookup} lookup", f"{advice.backend} renderer",
    ]  # fmt: skip
    return page_head("shadow advice", advice.source.name, facts, advice.sentences)


def section_ranking(advice: Advice, ranking: Sequence[Standing], shown: Sequence[Standing]) -> str:
    """The table of the ranking, with a bar of the wrong pixels over all views."""
    kinds = [both_kinds_of(advice, one) for one in ranking]
    most = max((sum(count for count, _ in of) for of in kinds), default=0)
    lines = []
    for one, of in zip(ranking, kinds, strict=True):
        cells = [escape(cell) for cell in advice_cells(one, advice.measure)]
        if one in shown:
            cells[CANDIDATE] = f'<a href="#{anchor(one)}">{cells[CANDIDATE]}</a>'
        if one.failure:
            cells[-1] = "failed"  # why is told below
        row = "".join(f"<td{' class=text' * (i == CANDIDATE)}>{cell}</td>" for i, cell in enumerate(cells))
        lines.append(f"<tr{' class=best' * (one.rank == 1)}>{row}{bar(of, most)}</tr>")
    heads = [head_cell(text, "text" if text == "candidate" else "") for text in ADVICE_HEADS]
    key = f"{swatch(FALSE_SHADOW)}<span>false shadow</span>{swatch(FALSE_LIGHT)}<span>false light</span>"
    noise = (
        " The noise behind ± is the standard deviation where the texels of the maps shift by parts of a texel; it was "
        "counted for those candidates that it can decide between."
        if any(one.sd is not None for one in ranking)
        else ""
    )
    return (
        '<section><h2>The ranking</h2><p class="lede">Every candidate has the largest square maps that fit into the '
        f"memory. It is ranked by the {escape(advice.measure.title)} ({escape(advice.measure.doc)}), the {advice.over} "
        f"of the views.{noise} Bars are the wrong pixels of all views.</p>"
        f'<div class="scroll">{table_html([*heads, BAR_HEAD], lines)}</div><p class="key">{key}</p></section>\n'
    )


def both_kinds_of(advice: Advice, one: Standing) -> list[tuple[int, str]]:
    """The wrong pixels of a candidate with a budget over all views, by kind with their colours."""
    of = [o.numbers for o in advice.outcomes if (o.candidate, o.memory) == (one.candidate, one.memory)]
    of = [numbers for numbers in of if numbers.get("misclassified") is not None]
    names = (("false_shadow", FALSE_SHADOW), ("false_light", FALSE_LIGHT))
    return [(sum(int(numbers[name] or 0) for numbers in of), colour) for name, colour in names] if of else []


def section_figure(advice: Advice, drawn: bytes) -> str:
    """The figure over views and memory; nothing of one view with one budget, which the table has."""
    if len(advice.counted) < 2 and len(advice.budgets) < 2:
        return ""
    text = escape(f"{advice.measure.title} of every candidate over the views and the memory", quote=True)
    image = f'<img alt="{text}" style="width:100%;background:#fff;border-radius:4px" src="{data_uri(drawn)}">'
    return f"<section><h2>Over views and memory</h2><figure>{image}</figure></section>\n"


def section_pictures(advice: Advice, shown: Sequence[Standing], shared: list[str], album: Album) -> str:
    """The best and uniform beside the truth in some views; adds the truths to the shared pictures."""
    if not shown:
        return ""
    views = sorted(advice.counted, key=lambda view: view.label != shown[0].worst_view)
    parts = []
    for i, view in enumerate(views[:MOST_VIEWS]):
        truth: TruthImage = view.view.truth()
        backdrop = Backdrop(advice.gbuffer(view.label), view.light, truth)
        lit = album.add(partial(getattr, backdrop, "lit"))
        shared.append(symbol(f"truth-{i}", lit, view.camera.aspect))
        rows = []
        for one in shown:
            keys = (one.candidate, one.memory, view.label)
            found = next(o for o in advice.outcomes if (o.candidate, o.memory, o.view.label) == keys)
            place = f' id="{anchor(one)}"' * (i == 0)
            rows.append(f'<div class="pictures"{place}>{row_of_pictures(found, backdrop, album, f"truth-{i}")}</div>')
        parts.append(f'<article class="run"><h3>{escape(view.label)}</h3><br>{"".join(rows)}</article>')
    more = len(views) - MOST_VIEWS
    rest = f" {more} more view{'s have' if more > 1 else ' has'} numbers alone, in runs.csv." if more > 0 else ""
    who = listed([f"<b>{escape(one.candidate)}</b>" for one in shown])
    return (
        f'<section><h2>In the picture</h2><p class="lede">{who} at {memory_text(shown[0].memory)}, beside the traced '
        f"truth.{rest}</p>{''.join(parts)}</section>\n"
    )


def row_of_pictures(one: Outcome, backdrop: Backdrop, album: Album, shared: str) -> str:
    """The eye view of an outcome, the truth by its shared name, and the pixels in which they differ."""
    run, view = done(one.run), one.view
    aspect = view.camera.aspect
    width = max(1, round(max(view.size) / SHOWN_PX))
    name = f"{one.candidate} at {one.resolution}²"
    shaded = album.add(partial(backdrop.shaded, done(run.mask)))
    differs = album.add(partial(backdrop.difference, done(run.errors).image, width))
    fitted = [int(one.numbers[kind] or 0) for kind in ("false_shadow", "false_light")]
    drawn = f", each drawn {width} pixels wide" if width > 1 else ""
    caption = (
        f"<b>{wrong_text(WrongPixels.of(one.numbers))}</b>{drawn}. As fitted {fitted[0]:,} of false shadow, "
        f"{fitted[1]:,} of false light."
    )
    return (
        figure(picture(shaded, f"Eye view with the shadows of {name}", aspect), f"<b>{escape(name)}</b>", aspect)
        + figure(use(shared, aspect, "Eye view with traced shadows"), "<b>Truth</b>, traced ray by ray", aspect)
        + figure(picture(differs, f"Wrong pixels of {name}", aspect), caption, aspect)
    )


def section_untried(advice: Advice, ranking: Sequence[Standing]) -> str:
    """What failed and what was not drawn, each with its cause."""
    failed = dict.fromkeys((one.candidate, one.failure) for one in ranking if one.failure)
    rows = [f'<tr><td>{escape(name)}</td><td class="text">failed: {escape(text)}</td></tr>' for name, text in failed]
    rows += [f'<tr><td>{escape(one.technique)}</td><td class="text">{cause(one)}</td></tr>' for one in advice.untried]
    if not rows:
        return '<section><h2>What was not drawn</h2><p class="lede">Every technique was drawn.</p></section>\n'
    heads = [head_cell("technique"), head_cell("cause", "text")]
    return (
        '<section><h2>What was not drawn</h2><p class="lede">Nothing is said of the techniques and candidates here.</p>'
        f'<div class="scroll">{table_html(heads, rows)}</div></section>\n'
    )


def cause(one: Untried) -> str:
    """Why a technique was not drawn."""
    if one.cause == "light":
        return f"does not serve {escape(listed(list(one.lights)))} lights"
    if one.cause == "not_asked":
        return "not asked for"
    if one.cause == "same":
        return f"the map of {escape(one.twin)}"
    at = "" if one.memory is None else f" at {memory_text(one.memory)}"
    wrong = "" if one.predicted is None else f": about {one.predicted:,.0f} wrong pixels over all views"
    return f"predicted to be worse{at}{wrong}"


def section_again(advice: Advice, shown: Sequence[Standing]) -> str:
    """How to compute all of it again, and what is shown in pictures; when and with which versions it was made."""
    scripts = [("Run all of it again", whole_advice(advice))]
    for one in shown:
        try:
            script = snippet_of(advice, {"candidate": one.candidate, "memory": one.memory})
        except ShadowlabError:
            continue  # of several views one may have no number
        scripts.append((f"The error of {one.candidate} at {memory_text(one.memory)}", script))
    details = "".join(
        f"<details><summary>{escape(title)}</summary><pre>{escape(text)}</pre></details>" for title, text in scripts
    )
    return (
        '<section><h2>How to reproduce it</h2><p class="lede">Python with every number and setting; advice.json has '
        f"as much for every row.</p>{details}</section>{page_foot(f', on {advice.adapter}')}"
    )


def anchor(one: Standing) -> str:
    """The place of a candidate's pictures in the page."""
    return f"pictures-{slug(one.candidate)}"
