"""Parts of a page: pictures as SVG with their data inside, figures, the document around them."""

from __future__ import annotations

import base64
import re
from collections.abc import Sequence
from html import escape
from importlib import resources

from ...types import RGB
from .. import study_record

# The two kinds of wrong pixels as the style sheet colours them, lighter on dark pages.
FALSE_SHADOW, FALSE_LIGHT = "var(--shadow)", "var(--light)"
# The head of a column of bars.
BAR_HEAD = '<th scope="col" class="bar-cell"></th>'


def document(title: str, shared: str, body: str) -> str:
    """The whole page."""
    style = resources.files(__package__).joinpath("report.css").read_text(encoding="utf-8")
    policy = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
        f"<title>{escape(title)}</title><style>\n{style}</style></head>\n<body>"
        f'<svg width="0" height="0" style="position:absolute" aria-hidden="true"><defs>{shared}</defs></svg>\n'
        f"{body}</body></html>\n"
    )


def page_head(kind: str, name: str, facts: Sequence[str], sentences: Sequence[str]) -> str:
    """What stands on top: the kind of page, what it is of, facts, and the verdict with its first sentence by itself."""
    first, *others = sentences
    paragraphs = "".join(f"<p>{escape(text)}</p>" for text in (first, " ".join(others)) if text)
    return (
        f'<header class="top"><p class="eyebrow">shadowlab · {escape(kind)}</p><h1>{escape(name)}</h1>'
        f'<p class="facts">{"".join(f"<span>{escape(f)}</span>" for f in facts)}</p>'
        f'<div class="verdict" role="note" aria-label="Verdict">{paragraphs}</div></header>\n<main>'
    )


def page_foot(more: str = "") -> str:
    """What stands below: when the page was made and with which versions, and more."""
    versions = ", ".join(f"{k} {v}" for k, v in study_record.versions().items())
    return f"</main>\n<footer>Made {escape(study_record.now())} with {escape(versions)}{escape(more)}.</footer>\n"


def figure(content: str, caption: str, aspect: float) -> str:
    """A figure with its caption, both HTML; figures of one row share its width so that they are equally high."""
    return f'<figure style="flex:{aspect:.4g} 1 0">{content}<figcaption>{caption}</figcaption></figure>'


def head_cell(text: str, kind: str = "") -> str:
    """The head of a column, in a class of the style sheet if it has one."""
    classes = f' class="{kind}"' if kind else ""
    return f'<th scope="col"{classes}>{text}</th>'


def table_html(heads: Sequence[str], rows: Sequence[str]) -> str:
    """A table of heads and rows that are HTML already."""
    return f"<table><thead><tr>{''.join(heads)}</tr></thead><tbody>{''.join(rows)}</tbody></table>"


def bar(segments: Sequence[tuple[int, str]], most: int) -> str:
    """A cell with a bar as long as its share of the largest count; segments are counts with their colours in CSS."""
    if not segments or most == 0:
        return '<td class="bar-cell"></td>'
    parts = "".join(f'<i style="width:{100 * n / most:.3f}%;background:{colour}"></i>' for n, colour in segments)
    return f'<td class="bar-cell"><span class="bar" aria-hidden="true">{parts}</span></td>'


def swatch(colour: str) -> str:
    """A square in a colour of CSS."""
    return f'<i style="background:{colour}"></i>'


def css_rgb(colour: RGB) -> str:
    """A colour as CSS."""
    return f"rgb{tuple(colour)}"


def data_uri(content: bytes) -> str:
    """A PNG as text."""
    return "data:image/png;base64," + base64.b64encode(content).decode("ascii")


def image(source: str, aspect: float) -> str:
    """The picture of an SVG whose view box is 100 wide and has this aspect, by its data URI or its mark in an album."""
    return f'<image width="100" height="{100 / aspect:.6g}" preserveAspectRatio="none" href="{source}"/>'


def symbol(name: str, source: str, aspect: float) -> str:
    """A picture stored once, for `use`; drawn in the camera's aspect whatever its pixels are."""
    return f'<symbol id="{name}" viewBox="0 0 100 {100 / aspect:.6g}">{image(source, aspect)}</symbol>'


def svg(content: str, text: str, aspect: float, classes: str = "", extra: str = "") -> str:
    """An SVG of this aspect with its alternative text."""
    return (
        f'<svg class="pic{classes}" viewBox="0 0 100 {100 / aspect:.6g}" role="img" '
        f'aria-label="{escape(text, quote=True)}"{extra}>'
        f"<title>{escape(text)}</title>{content}</svg>"
    )


def use(name: str, aspect: float, text: str, extra: str = "") -> str:
    """A stored picture, with more drawn on it."""
    return svg(f'<use href="#{name}" width="100" height="{100 / aspect:.6g}"/>{extra}', text, aspect)


def picture(source: str, text: str, aspect: float, pixels: bool = False) -> str:
    """A picture with its alternative text."""
    return svg(image(source, aspect), text, aspect, " pixels" if pixels else "")


def flipping(source: str, text: str, aspect: float) -> str:
    """A picture that gives way to the truth under the pointer or the focus."""
    over = f'<use class="over" href="#truth" width="100" height="{100 / aspect:.6g}"/>'
    return svg(image(source, aspect) + over, text, aspect, " flip", ' tabindex="0"')


def slug(label: str) -> str:
    """A label as part of a file name."""
    return re.sub(r"[^A-Za-z0-9]+", "-", label).strip("-").lower()[:60] or "run"
