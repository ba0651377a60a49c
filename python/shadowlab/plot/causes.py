"""Why pixels are wrong: bars of the causes of each technique, and where they are in the image."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, cast

import numpy as np

from ..aliasing.causes import CAUSES, Causes
from ..errors import ArgumentError
from ..experiments.study import Study
from ..pictures.causes import CAUSE_RGB, HATCH, NOT_COMPARED, cause_picture
from ..pictures.errors import rgb
from ..text.checked import a_text, checked
from .arguments import an_aspect, columns_of, numbers_of
from .axes import _axes, _picture, curve_look, legend_below, say, short_label

if TYPE_CHECKING:
    import numpy.typing as npt
    import pandas as pd
    from matplotlib.axes import Axes

    from .._core import GBuffer
    from ..types import Light

# The causes in the words of a legend.
LEGEND = {
    "acne": "acne: a surface shadows itself",
    "edge": "edge: a silhouette displaced",
    "leak": "leak: bias passes the caster",
    "missing": "missing: no caster in the map",
    "other": "other: the map is wrong",
}
CAUSE_HATCHES = {"acne": "", "edge": "///", "leak": "...", "missing": "xxx", "other": "\\\\\\"}
# Lines of the hatching, on its own colour: paler on dark ones.
HATCH_COLOURS = {"acne": "white", "edge": "#7A3560", "leak": "#CFE6F5", "missing": "#BBBBBB", "other": "white"}


@checked(title=a_text)
def causes(table: pd.DataFrame | Study | Mapping[str, Causes], ax: Axes | None = None, *, title: str = "") -> Axes:
    """Axes with the wrong pixels of each technique as a bar, divided by cause.

    Parameters
    ----------
    table : pandas.DataFrame, Study, or dict of Causes by label
        Column technique, and of the causes (acne, edge...; pixels) those that were counted; one that is absent
        counts as none. Rows from the top; those of one technique tell their resolution.
    ax : matplotlib axes, optional
        Made where none are given.
    title : str

    Returns
    -------
    matplotlib axes
        The sum stands at the end of each bar; a row with a count that is no number says that it was not measured.

    Raises
    ------
    ArgumentError
        For a table without the column technique or any cause, and negative counts.

    Examples
    --------
    >>> import pandas as pd, shadowlab as sl
    >>> rows = [("uniform", 12, 530, 4, 0), ("lispsm", 3, 170, 8, 1)]
    >>> ax = sl.plot.causes(pd.DataFrame(rows, columns=["technique", "acne", "edge", "leak", "missing"]))
    """
    table = cause_table(table)
    columns_of(table, ["technique"])
    names = [name for name in CAUSES.values() if name in table.columns]
    if not names:
        columns_of(table, list(CAUSES.values()))
    counts = {name: numbers_of(table, name) for name in names}
    if any((values < 0).any() for values in counts.values()):
        raise ArgumentError("table: expected counts of pixels, 0 or more, got a negative one; count the wrong pixels")
    ax = _axes(ax)
    rows = np.arange(len(table))
    total = np.sum(list(counts.values()), axis=0)
    measured = np.isfinite(total)
    left = np.zeros(len(table))
    for code, name in CAUSES.items():
        if name not in names:
            continue
        widths = np.where(measured, counts[name], 0.0)
        ax.barh(
            rows, widths, left=left, height=0.68, color=rgb(CAUSE_RGB[code]), edgecolor=HATCH_COLOURS[name],
            hatch=CAUSE_HATCHES[name], linewidth=0, label=LEGEND[name],
        )  # fmt: skip
        left += widths
    widest = float(left.max(initial=0.0))
    for row, value, known in zip(rows, left, measured, strict=True):
        ax.annotate(
            f"{value:,.0f}" if known else "not measured", (value, row), xytext=(4, 0), textcoords="offset points",
            va="center", fontsize="small", color="#333333",
        )  # fmt: skip
    curve_look(ax)
    ax.grid(False, axis="y")
    ax.tick_params(axis="y", length=0)
    ax.set_yticks(rows, [short_label(t) for t in row_labels(table)])
    # Room for the number at the end of the longest bar.
    ax.set_xlim(0.0, 1.16 * widest or 1.0)
    ax.set_ylim(max(len(rows), 1) - 0.5, -0.5)
    _thousands(ax)
    ax.set(xlabel="misclassified pixels, count", title=title)
    if not len(rows):
        say(ax, "no technique was compared")
    # Below the ticks and the axis label.
    legend_below(ax, gap_pt=38.0, ncols=2)
    return ax


def cause_table(given: pd.DataFrame | Study | Mapping[str, Causes]) -> pd.DataFrame:
    """The table of what has one, or of causes by label."""
    if isinstance(given, Mapping) and given and all(isinstance(of, Causes) for of in given.values()):
        import pandas as pd

        return pd.DataFrame([{"technique": label, **of.counts} for label, of in given.items()])
    return cast("pd.DataFrame", given.table if isinstance(given, Study) else given)


def row_labels(table: pd.DataFrame) -> list[str]:
    """What rows are called: their technique, and their resolution where another row is called the same."""
    names = [str(name) for name in table["technique"]]
    if len(set(names)) == len(names) or "resolution" not in table.columns:
        return names
    return [f"{name}, {size}²" for name, size in zip(names, table["resolution"], strict=True)]


def _thousands(ax: Axes) -> None:
    """Whole numbers with separators on the x axis, few enough to stand apart."""
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    ax.xaxis.set_major_locator(MaxNLocator(5, integer=True))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:,.0f}"))


@checked(title=a_text, aspect=an_aspect)
def cause_map(
    gbuffer: GBuffer,
    light: Light,
    truth: npt.ArrayLike,
    cause_image: npt.ArrayLike | Causes,
    ax: Axes | None = None,
    *,
    title: str = "",
    aspect: float | None = None,
    width: int = 1,
) -> Axes:
    """Axes with the wrong pixels in the colours of their causes over a pale grey eye view; a legend counts them.

    Parameters
    ----------
    gbuffer, light, truth, cause_image, width
        As in `pictures.causes.cause_picture`.
    ax : matplotlib axes, optional
        Made where none are given.
    title : str
    aspect : float, optional
        Of the camera; square pixels where none is given.

    Returns
    -------
    matplotlib axes

    Raises
    ------
    ArgumentError
        For images of another shape than the G-buffer's, unknown codes, and a width below 1.
    """
    from matplotlib.patches import Patch

    if isinstance(cause_image, Causes):
        cause_image = cause_image.image
    picture = cause_picture(gbuffer, light, truth, cause_image, width=width)
    ax = _picture(ax, picture, title, aspect or picture.shape[1] / picture.shape[0])
    codes = np.asarray(cause_image)
    handles = []
    for code, name in CAUSES.items():
        count = int(np.count_nonzero(codes == code))
        handles.append(Patch(color=rgb(CAUSE_RGB[code]), label=f"{name}: {count:,} px"))
    if (codes == NOT_COMPARED).any():
        grey = rgb((HATCH - 60,) * 3)
        handles.append(Patch(facecolor="white", edgecolor=grey, hatch="////", linewidth=0.5, label="not compared"))
    if (codes == NOT_COMPARED).all():
        say(ax, "no pixel is compared")
    legend_below(ax, handles, ncols=3, handlelength=1.2, handletextpad=0.5)
    return ax
