"""How far the texels of a shadow map wander from frame to frame, which shadows flip, and what holding maps costs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ArgumentError
from ..experiments.temporal import Temporal
from ..text import shown
from ..text.checked import a_text, checked
from .arguments import columns_of, current_columns, numbers_of
from .axes import _axes, curve_look, legend_beside, say, series_style, short_label

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

# Drifts that span more than this are read on a logarithm only; below a thousandth of a texel a frame, at which a
# lattice takes half a minute to move by one, the axis is linear.
WIDE, SLOW_TEXELS = 30.0, 1e-3
# Counts of pixels are linear up to this, as those of held maps are 0 in most frames.
FEW_PX = 10.0
# Around the marks of frames with new maps.
RINGS: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 11, "markerfacecolor": "none"}
# Root mean square of the distance of a point of a texel from its middle: of a lattice that lies anywhere each frame.
RANDOM_RMS = float(np.sqrt(1 / 6))


@checked(title=a_text)
def drift(table: pd.DataFrame | Temporal, ax: Axes | None = None, *, title: str = "") -> Axes:
    """Axes with the drift of the texel lattice over the frames, a line a label: root mean square, and thin the largest.

    Parameters
    ----------
    table : pandas.DataFrame or Temporal
        Columns label, frame, drift_rms, drift_max (texels per frame) and flips (pixels whose shadow changes while the
        truth does not). A drift that is no number is a gap.
    ax : matplotlib axes, optional
        Made where none are given.
    title : str

    Returns
    -------
    matplotlib axes
        The legend has the flips, on average a frame. Drifts that span decades are on a logarithm that is linear below a
        thousandth of a texel. A line marks the root mean square of a lattice that lies anywhere in each frame.

    Raises
    ------
    ArgumentError
        For a column that the table does not have, and negative drifts.

    Examples
    --------
    >>> import pandas as pd, shadowlab as sl
    >>> rows = [("uniform", 0, 0.41, 0.7, 12), ("uniform", 1, 0.4, 0.7, 9), ("stable", 0, 0, 0, 0)]
    >>> table = pd.DataFrame(rows, columns=["technique", "frame", "drift_rms", "drift_max", "flips"])
    >>> ax = sl.plot.drift(table)
    """
    if isinstance(table, Temporal):
        table = table.table
    table = current_columns(table, ["technique", "drift_rms"])
    columns_of(table, ["technique", "frame", "drift_rms", "drift_max", "flips"])
    names = ("frame", "drift_rms", "drift_max", "flips")
    rows = table.assign(**{name: numbers_of(table, name) for name in names})
    drifts = rows[["drift_rms", "drift_max"]].to_numpy(np.float64)
    if (drifts < 0).any():
        raise ArgumentError("table: expected drifts of 0 texels per frame or more, got a negative one; take its length")
    ax = _axes(ax)
    finite = drifts[np.isfinite(drifts)]
    for i, (label, group) in enumerate(rows.groupby("technique", sort=False)):
        group = group.sort_values("frame")
        flips = group["flips"].to_numpy(np.float64)
        flips = flips[np.isfinite(flips)]
        mean = float(flips.mean()) if flips.size else np.nan
        count = f"{mean:,.0f}" if mean >= 10 else f"{mean:.2g}"
        said = "flips not counted" if np.isnan(mean) else f"{count} flips a frame"
        frames, style = group["frame"].to_numpy(np.float64), series_style(i)
        rms, largest = (np.where(np.isfinite(group[c]), group[c], np.nan) for c in ("drift_rms", "drift_max"))
        every = max(1, len(frames) // 12)
        ax.plot(frames, rms, label=f"{short_label(label)}\n{said}", **style, markevery=(i % every, every))
        ax.plot(frames, largest, color=style["color"], linestyle=style["linestyle"], linewidth=0.8)
    ax.margins(x=0.03)
    curve_look(ax)
    ax.set(xlabel="frame, number", ylabel="drift of the texel lattice, texels per frame", title=title)
    if not finite.size:
        say(ax, "no drift was measured")
        return ax
    ax.plot([], [], color="#555555", marker="o", markersize=4, linewidth=1.6, label="root mean square")
    ax.plot([], [], color="#555555", linewidth=0.8, label="largest")
    _drift_scale(ax, finite)
    legend_beside(ax, fontsize="small")
    return ax


@checked(title=a_text)
def flips(temporal: Temporal, ax: Axes | None = None, *, title: str = "") -> Axes:
    """Axes with the flips of each frame, a line with marks per label, and its wrong pixels, a thin line.

    Parameters
    ----------
    temporal : Temporal
        Of techniques along a path, as `sl.aliasing.temporal` returns it; a held one beside the same fitted each frame.
    ax : matplotlib axes, optional
        Made where none are given.
    title : str

    Returns
    -------
    matplotlib axes
        Pixels over the number of the frame, linear below ten and logarithmic above. Flips are those since the frame
        before. Rings mark the frames in which a technique that keeps its maps made new ones. The legend has both as
        means per frame. A frame without a number is a gap.

    Raises
    ------
    ArgumentError
        For something else than a `Temporal`.

    Examples
    --------
    >>> import shadowlab as sl
    >>> scene = sl.library.scene("robots")
    >>> path = [scene.camera.replace(eye=scene.camera.eye + 0.02 * i) for i in range(3)]
    >>> how = {"each frame": "scene_optimal", "held": sl.TemporalFit("scene_optimal")}
    >>> found = sl.aliasing.temporal(
    ...     scene, path, scene.light, how, resolution=256, size=(160, 90), renderer="cpu", progress=False
    ... )
    >>> ax = sl.plot.flips(found)
    """
    if not isinstance(temporal, Temporal):
        raise ArgumentError(
            f"temporal: expected a Temporal, got {shown(temporal)}; sl.aliasing.temporal(...) makes one"
        )
    ax = _axes(ax)
    ringed = False
    for i, (label, frames) in enumerate(temporal.frames.groupby("technique", sort=False)):
        steps = temporal.table[temporal.table["technique"] == label]
        since, flipped = (steps[name].to_numpy(np.float64, na_value=np.nan) for name in ("frame", "flips"))
        at, wrong = (frames[name].to_numpy(np.float64, na_value=np.nan) for name in ("frame", "misclassified"))
        refit = frames["refit"].fillna(False).to_numpy(bool)
        said = ", ".join(f"{_mean_text(values)} {what}" for values, what in ((flipped, "flips"), (wrong, "wrong")))
        style = series_style(i)
        ax.plot(since + 1, flipped, label=f"{short_label(label)}\n{said}", **style)
        ax.plot(at, wrong, color=style["color"], linestyle=style["linestyle"], linewidth=0.8)
        if not refit.all():
            new = np.isin(since + 1, at[refit])
            ringed = True
            ax.plot(since[new] + 1, flipped[new], **(RINGS | {"markeredgecolor": style["color"]}))
    curve_look(ax)
    ax.set_yscale("symlog", linthresh=FEW_PX, linscale=0.5)
    ax.set(xlabel="frame, number", ylabel="pixels", title=title)
    if not ax.lines or not any(np.isfinite(line.get_ydata()).any() for line in ax.lines):
        say(ax, "no frame was measured")
        return ax
    ax.set_ylim(bottom=-0.5)
    ax.margins(x=0.03)
    ax.plot([], [], color="#555555", marker="o", markersize=4, linewidth=1.6, label="flips since the frame before")
    ax.plot([], [], color="#555555", linewidth=0.8, label="wrong pixels")
    if ringed:
        ax.plot([], [], **(RINGS | {"markeredgecolor": "#555555"}), label="new maps")
    legend_beside(ax, fontsize="small")
    return ax


def _mean_text(values: np.ndarray) -> str:
    """The mean of the numbers that are there, per frame."""
    there = values[np.isfinite(values)]
    return f"{there.mean():,.0f}" if there.size else "no"


def _drift_scale(ax: Axes, values: np.ndarray) -> None:
    """The scale of the axis of drifts, and its limits."""
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    top = float(values.max(initial=0.0)) or 1.0
    notable = values[values >= SLOW_TEXELS]
    if notable.size and notable.max() > WIDE * notable.min():
        ax.set_yscale("symlog", linthresh=SLOW_TEXELS, linscale=0.5)
        ax.set_ylim(-0.1 * SLOW_TEXELS, 1.3 * top)
        ax.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
        ax.yaxis.minorticks_off()
    else:
        ax.set_ylim(-0.03 * top, 1.12 * top)
    if top > 0.75 * RANDOM_RMS and values.size:
        ax.axhline(RANDOM_RMS, color="#333333", linewidth=1.0, zorder=1.5, label="root mean square of chance")
