"""The chart of a page: wrong pixels over the resolution of the map, as SVG that follows the page's light or dark."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

from ...text import is_missing
from ..words import rows_of

if TYPE_CHECKING:
    import pandas as pd

# Of [okabe2008], in the lightness that stands on white and on near-black; each series has its own marker too.
LINE_COLOURS = ("#009e73", "#cc79a7", "#3f9fd8", "#c98500", "#7a7a7a", "#a05a2c")
WIDTH, HEIGHT = 760, 340
LEFT, RIGHT, TOP, BOTTOM = 78, 150, 16, 44


def error_chart(table: pd.DataFrame | Sequence[Mapping[str, Any]]) -> str:
    """A chart of the share of wrong pixels, both axes logarithmic; nothing for fewer than two resolutions."""
    measured = [row for row in rows_of(table) if not (row["failure"] or is_missing(row["share"])) and row["share"] > 0]
    resolutions = sorted({int(row["resolution"]) for row in measured})
    if len(resolutions) < 2:
        return ""
    shares = [100.0 * float(row["share"]) for row in measured]
    ticks = decades(min(shares), max(shares))
    low, high = math.log10(ticks[0]), math.log10(ticks[-1])
    first, last = math.log2(resolutions[0]), math.log2(resolutions[-1])

    def x(resolution: float) -> float:
        return LEFT + (WIDTH - LEFT - RIGHT) * (math.log2(resolution) - first) / (last - first)

    def y(share: float) -> float:
        return HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * (math.log10(share) - low) / (high - low)

    parts = [f'<line class="grid" x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y(t):.1f}" y2="{y(t):.1f}"/>' for t in ticks]
    parts += [f'<text x="{LEFT - 10}" y="{y(t) + 4:.1f}" text-anchor="end">{t:g} %</text>' for t in ticks]
    parts += [f'<text x="{x(r):.1f}" y="{HEIGHT - BOTTOM + 20}" text-anchor="middle">{r}²</text>' for r in resolutions]
    parts.append(
        f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 4}" text-anchor="middle">texels of the map</text>'
    )
    ends: list[tuple[float, str, str]] = []
    for i, label in enumerate(dict.fromkeys(row["technique"] for row in measured)):
        colour = LINE_COLOURS[i % len(LINE_COLOURS)]
        rows = sorted((row for row in measured if row["technique"] == label), key=lambda row: int(row["resolution"]))
        points = [(x(int(row["resolution"])), y(100 * float(row["share"]))) for row in rows]
        path = " ".join(f"{px:.1f},{py:.1f}" for px, py in points)
        parts.append(f'<polyline class="series" stroke="{colour}" points="{path}"/>')
        parts += [marker(i, px, py, colour) for px, py in points]
        ends.append((points[-1][1], str(label), colour))
    parts += labels(ends)
    text = "Wrong pixels over the resolution of the map, one line a technique; the table has the numbers"
    return f'<svg class="chart" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{text}">{"".join(parts)}</svg>'


def decades(low: float, high: float) -> list[float]:
    """Ticks 1, 2, 5, 10... that enclose both numbers, thinned to decades where there would be many."""
    start, end = math.floor(math.log10(low)), math.ceil(math.log10(high))
    steps = (1, 2, 5) if end - start <= 2 else (1,)
    ticks = [m * 10.0**e for e in range(start, end + 1) for m in steps]
    below = [t for t in ticks if t <= low]
    above = [t for t in ticks if t >= high]
    inside = [t for t in ticks if low < t < high]
    chosen = sorted({below[-1], *inside, above[0]})
    return chosen if len(chosen) > 1 else [chosen[0], 10 * chosen[0]]


def marker(series: int, x: float, y: float, colour: str) -> str:
    """The marker of a series: circle, square, triangle or diamond."""
    shapes = (
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4.5"',
        f'<rect x="{x - 4:.1f}" y="{y - 4:.1f}" width="8" height="8"',
        f'<path d="M{x:.1f} {y - 5.5:.1f}l5 9h-10z"',
        f'<path d="M{x:.1f} {y - 6:.1f}l6 6l-6 6l-6 -6z"',
    )
    return f'{shapes[series % len(shapes)]} fill="{colour}"/>'


def labels(ends: list[tuple[float, str, str]]) -> list[str]:
    """Names at the right ends of the lines, moved apart where they would overlap."""
    parts, previous = [], -math.inf
    for y, label, colour in sorted(ends):
        previous = max(y, previous + 16)
        short = label if len(label) <= 18 else label[:17] + "…"
        parts.append(
            f'<text x="{WIDTH - RIGHT + 12}" y="{previous + 4:.1f}" style="fill:{colour};font-weight:600">'
            f"{escape(short)}</text>"
        )
    return parts
