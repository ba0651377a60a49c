"""What all plots share: the axes that they take or make, pictures on them, the look of series, scales and labels."""

from __future__ import annotations

import math
import textwrap
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ArgumentError
from ..text import shown

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.legend import Legend

# Series of Okabe and Ito [okabe2008], the two that mean false shadow and false light left out.
SERIES = ("#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000", "#8A6D00")
MARKERS = ("o", "s", "^", "D", "v", "P")
# For many series in one plot: twelve markers with six colours and four kinds of line, no pair of which comes twice.
MANY_MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "p", "*", "h")
LINES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (6, 2, 1.2, 2)), (0, (1, 1.4)))

# Letters of a label in a legend.
WIDEST_LABEL = 40
# Maps that a legend has room for.
MOST_NAMED = 8
# A light grey that stays behind, and the grey of words that explain.
GRID, SOFT = "#B0B0B0", "#555555"


def _axes(ax: Axes | None) -> Axes:
    if ax is not None:
        from matplotlib.axes import Axes

        if not isinstance(ax, Axes):
            raise ArgumentError(f"ax: expected matplotlib axes, got {shown(ax)}; give title= and other words by name")
        return ax
    import matplotlib.pyplot as plt

    made: Axes = plt.subplots(layout="constrained")[1]
    return made


def _picture(ax: Axes | None, picture: np.ndarray, title: str, aspect: float) -> Axes:
    ax = _axes(ax)
    height, width = picture.shape[:2]
    of_pixels = float(width) / height / aspect
    if not 0 < of_pixels < math.inf:
        raise ArgumentError(f"aspect: expected width by height of the picture, got {shown(aspect)}; take the camera's")
    ax.imshow(picture, interpolation="antialiased", aspect=of_pixels)
    ax.set(title=title, xticks=[], yticks=[])
    ax.spines[:].set_visible(False)
    return ax


def series_style(index: int) -> dict[str, Any]:
    """Colour, marker and kind of line of a series: three ways to tell one from another, of which a print keeps two."""
    return {
        "color": SERIES[index % len(SERIES)],
        "marker": MANY_MARKERS[index % len(MANY_MARKERS)],
        "linestyle": LINES[index % len(LINES)],
        "markersize": 5.0,
        "linewidth": 1.6,
        "markeredgecolor": "white",
        "markeredgewidth": 0.5,
    }


def short_label(label: object) -> str:
    """The label as axes can draw it, its middle left out where it is too long for a legend."""
    text = str(label)
    return drawable(text if len(text) <= WIDEST_LABEL else f"{text[: WIDEST_LABEL - 13]}…{text[-12:]}")


def drawable(text: str) -> str:
    """A text from a table as axes can draw it.

    What no font has, such as control characters, is drawn as �. Dollars that are no mathematics are drawn as dollars.
    Legends leave out what begins with an underscore, so a space goes before it.
    """
    plain = "".join(one if one.isprintable() or one == "\n" else "\N{REPLACEMENT CHARACTER}" for one in text)
    if plain.count("$") > 1:
        from matplotlib.mathtext import MathTextParser

        try:
            MathTextParser("path").parse(plain)
        except ValueError:
            plain = plain.replace("$", r"\$")
    return f" {plain}" if plain.startswith("_") else plain


def curve_look(ax: Axes) -> None:
    """Turn axes to the look of all curves: a pale grid behind, no frame above and to the right."""
    ax.grid(True, which="major", color=GRID, alpha=0.45, linewidth=0.7)
    ax.set_axisbelow(True)
    ax.spines[["top", "right"]].set_visible(False)


def log_axis(ax: Axes, which: str, limits: tuple[float, float] | None = None) -> None:
    """Turn the x or y axis logarithmic, with numbers as one writes them at 1, 2, 5 or at decades if there are many."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    getattr(ax, f"set_{which}scale")("log")
    if limits is not None:
        getattr(ax, f"set_{which}lim")(*limits)
    low, high = getattr(ax, f"get_{which}lim")()
    axis = getattr(ax, f"{which}axis")
    subs: tuple[float, ...] = (1.0, 2.0, 5.0) if high < low * 10**2.5 else (1.0,)
    if high < low * 3:
        subs = tuple(float(i) for i in range(1, 10))
    axis.set_major_locator(LogLocator(subs=subs, numticks=12))
    axis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:,.0f}" if v >= 1000 else f"{v:.6g}"))
    axis.set_minor_formatter(NullFormatter())


def padded(values: Iterable[float], *, least: float = 1.25) -> tuple[float, float]:
    """Limits of a logarithmic axis around positive values, those that are not finite left out."""
    v = np.asarray(values, np.float64).ravel()
    v = v[np.isfinite(v) & (v > 0)]
    if v.size == 0:
        return 0.1, 10.0
    low, high = float(v.min()), float(v.max())
    factor = max(least, (high / low) ** 0.05)
    tiny, huge = float(np.finfo(np.float64).tiny), float(np.finfo(np.float64).max)
    return max(low / factor, tiny), min(high, huge / factor) * factor


def level(ax: Axes, value: float, words: str, *, vertical: bool = False) -> None:
    """A thin dark line across the axes at a value, with words beside it; last, after all lines and limits."""
    from matplotlib.transforms import blended_transform_factory as blended

    style: dict[str, Any] = {"textcoords": "offset points", "fontsize": "small", "color": "#333333", "zorder": 1.5}
    if vertical:
        ax.axvline(value, color="#333333", linewidth=1.0, zorder=1.5)
        # On the side of the line that has more room.
        before = ax.transData.transform((value, 1.0))[0] > ax.transAxes.transform((0.5, 0.5))[0]
        ha, shift = ("right", -4) if before else ("left", 4)
        across = blended(ax.transData, ax.transAxes)
        ax.annotate(words, (value, 1.0), xycoords=across, xytext=(shift, -3), ha=ha, va="top", **style)
        return
    height = float(ax.transAxes.inverted().transform(ax.transData.transform((1.0, value)))[1])
    x, va, shift = _clearest(ax, height)
    ax.axhline(value, color="#333333", linewidth=1.0, zorder=1.5)
    across, ha = blended(ax.transAxes, ax.transData), {0.0: "left", 0.5: "center", 1.0: "right"}[x]
    ax.annotate(words, (x, value), xycoords=across, xytext=(4 - 8 * x, shift), ha=ha, va=va, **style)


def _clearest(ax: Axes, height: float) -> tuple[float, str, int]:
    """Where along a level line, above or below it, words meet the fewest lines: x of the axes, va, shift in points."""
    # Width and height of a few small words, in axes a hand wide.
    wide, high = 0.3, 0.07
    to_axes = ax.transData + ax.transAxes.inverted()
    traces = [to_axes.transform(np.column_stack(line.get_data(orig=False))) for line in ax.lines]
    places = []
    for x in (1.0, 0.0, 0.5):
        at = np.linspace(x * (1 - wide), x * (1 - wide) + wide, 24)
        for va, shift, low in (("bottom", 3, height), ("top", -3, height - high)):
            crossed = 0
            for trace in traces:
                known = trace[np.isfinite(trace).all(axis=1)]
                if len(known) > 1:
                    y = np.interp(at, known[:, 0], known[:, 1], left=np.inf, right=np.inf)
                    crossed += int(np.count_nonzero((y >= low) & (y <= low + high)))
            places.append((crossed + 100 * (low < 0 or low + high > 1), (x, va, shift)))
    return min(places, key=lambda place: place[0])[1]


def wrapped(label: str) -> str:
    """The label of an upright axis in lines that fit beside axes of 300 pixels."""
    lines = math.ceil(len(label) / 44)
    return drawable("\n".join(textwrap.wrap(label, 44 if lines < 2 else math.ceil(len(label) / lines) + 6)))


def legend_below(ax: Axes, handles: Sequence[Artist] | None = None, *, gap_pt: float = 4.0, **options: Any) -> Legend:
    """The legend below the axes, by a gap in points whatever the height of the axes."""
    from matplotlib.transforms import ScaledTranslation

    where = ax.transAxes + ScaledTranslation(0.0, -gap_pt / 72.0, ax.figure.dpi_scale_trans)
    options = {"frameon": False, "fontsize": "small", "columnspacing": 1.3, "borderaxespad": 0.0, **options}
    options |= {"loc": "upper center", "bbox_to_anchor": (0.5, 0.0), "bbox_transform": where}
    return ax.legend(**options) if handles is None else ax.legend(handles=handles, **options)


def say(ax: Axes, words: str) -> None:
    """Words in the middle of axes that have nothing to show."""
    ax.text(0.5, 0.5, words, transform=ax.transAxes, ha="center", va="center", color=SOFT, wrap=True)


def legend_beside(ax: Axes, handles: Sequence[Artist] | None = None, **options: Any) -> Legend:
    """The legend to the right of the axes, where it hides no line."""
    options = {"loc": "upper left", "bbox_to_anchor": (1.01, 1.0), "frameon": False, "handlelength": 3.0, **options}
    return ax.legend(**options) if handles is None else ax.legend(handles=handles, **options)


def last_finite(values: Iterable[float]) -> float:
    """The last number that is finite; minus infinity where none is."""
    finite = [float(v) for v in values if math.isfinite(v)]
    return finite[-1] if finite else -math.inf
