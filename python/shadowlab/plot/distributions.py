"""Errors as distributions: how many pixels have which, and how they grow with depth."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Literal, cast

import numpy as np
from numpy.typing import NDArray

from ..aliasing.footprint import Footprint
from ..aliasing.summary import HISTOGRAM_LIMITS_PX, Summary, checked_bands
from ..errors import ArgumentError
from ..text import shown
from ..text.checked import a_text, checked
from .arguments import count_of, footprints_of
from .axes import _axes, curve_look, legend_beside, level, log_axis, padded, say, series_style, short_label
from .curves import DEPTH_LABEL

if TYPE_CHECKING:
    import numpy.typing as npt
    from matplotlib.axes import Axes

# What a histogram may be of, and what its axis says.
#: What of a footprint is counted.
Quantity = Literal[
    "major", "minor", "perspective_major", "m_s", "m_t", "area", "perspective", "projection", "texels_per_pixel"
]
QUANTITIES: dict[Quantity, str] = {
    "major": "longest extent of a texel, pixels per texel",
    "minor": "extent of a texel across its longest, pixels per texel",
    "perspective_major": "longest extent of a texel by perspective alone, pixels per texel",
    "m_s": "length of a texel along the map's y, pixels per texel",
    "m_t": "length of a texel along the map's x, pixels per texel",
    "area": "area of a texel, square pixels",
    "perspective": "area of a texel by perspective alone, square pixels",
    "projection": "share of the slope in the error, a ratio of cosines",
    "texels_per_pixel": "texels in the area of a pixel",
}
# What stands at 1.
AT_ONE: dict[Quantity, str] = {"projection": "slope adds nothing"}
# Bins in an octave, and octaves at the most: beyond, the outer bins hold the rest.
BINS, MOST_OCTAVES = 2, 20
# Share of the pixels that the axis may leave to each of the outer bins.
TAIL = 0.003
BEYOND = "\n(the outer bins hold what is beyond)"
NOTHING_MEASURED = "no pixel looks up a texel"


@checked(title=a_text)
def error_histogram(
    footprints: Footprint | Summary | Mapping[str, Footprint | Summary],
    ax: Axes | None = None,
    *,
    quantity: Quantity = "major",
    by_depth: bool | int = False,
    title: str = "",
) -> Axes:
    """Axes with the share of pixels that have an error, over its logarithm; a line at one texel a pixel.

    Parameters
    ----------
    footprints : dict, Footprint or Summary
        Label to `Footprint`, or to `Summary`, whose bins are half octaves of `major`.
    ax : matplotlib axes, optional
        Made where none are given.
    quantity : str
        What of the footprint: major, minor, perspective_major, m_s, m_t (pixels per texel), area, perspective (square
        pixels), projection (a ratio), texels_per_pixel.
    by_depth : bool or int
        One line a band of depth, of one footprint; a number is how many bands, true is 3. Shares are of the band.
    title : str

    Returns
    -------
    matplotlib axes
        Shares of the measured pixels of each label sum to 100 %; the outer bins hold what is beyond them.

    Raises
    ------
    ArgumentError
        For no footprint, an unknown quantity, a summary asked for more than it holds, several footprints by depth.

    Examples
    --------
    >>> import shadowlab as sl
    >>> s = sl.library.scene("robots")
    >>> g = sl.Renderer("cpu").gbuffer(s, s.camera, size=(160, 90))
    >>> maps = {t: sl.technique(t).parameterize(s, s.camera, s.light) for t in ("uniform", "lispsm")}
    >>> found = {t: sl.aliasing.footprint(g, s.camera, s.light, p) for t, p in maps.items()}
    >>> ax = sl.plot.error_histogram(found)
    """
    given = footprints_of(footprints)
    if not isinstance(quantity, str) or quantity not in QUANTITIES:
        raise ArgumentError(
            f"quantity: expected one of {', '.join(QUANTITIES)}, got {shown(quantity)}; choose from these"
        )
    if not isinstance(by_depth, (bool, np.bool_)):
        by_depth = count_of(by_depth, "by_depth", most=100, least=0)
    summaries = [label for label, value in given.items() if isinstance(value, Summary)]
    if summaries and (quantity != "major" or by_depth):
        raise ArgumentError(
            f"footprints: expected footprints for {'bands of depth' if by_depth else quantity}, got the summary of "
            f"{summaries[0]!r}, which counts major alone; give the footprint"
        )
    if by_depth:
        bands = 3 if isinstance(by_depth, (bool, np.bool_)) else by_depth
        series: dict[str, Summary | NDArray[np.float64]] = dict(_by_band(given, quantity, bands))
    else:
        series = {k: v if isinstance(v, Summary) else _measured_values(v, quantity) for k, v in given.items()}
    ax = _axes(ax)
    edges = _edges([v for v in series.values() if not isinstance(v, Summary)], coarse=bool(summaries))
    counted = {label: _bin_counts(values, edges) for label, values in series.items()}
    # Half octaves around 1, and out to the last bin that has a pixel.
    filled = np.flatnonzero(np.sum(list(counted.values()), axis=0)) if counted else np.empty(0)
    one = int(np.searchsorted(edges, 1.0))
    first, last = int(min([*filled, one - 1])), int(max([*filled, one])) + 1
    ends = any(_beyond(values, edges) for values in series.values())
    edges = edges[first : last + 1]
    middles, highest = np.sqrt(edges[:-1] * edges[1:]), 0.0
    for i, (label, counts) in enumerate(counted.items()):
        counts = counts[first:last]
        if not counts.sum():
            ax.plot([], [], " ", label=f"{short_label(label)}: {NOTHING_MEASURED}")
            continue
        share = 100.0 * counts / counts.sum()
        highest = max(highest, float(share.max()))
        # Dashes would hide the steps; markers tell the lines apart in print.
        style = {**series_style(i), "linestyle": "-"}
        ax.stairs(share, edges, color=style["color"], linewidth=1.7, baseline=None)
        ax.plot(middles[share > 0], share[share > 0], **{**style, "linestyle": ""}, zorder=3)
        ax.plot([], [], label=short_label(label), **style)
    ax.set_ylim(0.0, 1.12 * highest or 1.0)
    log_axis(ax, "x", (float(edges[0]), float(edges[-1])))
    curve_look(ax)
    level(ax, 1.0, AT_ONE.get(quantity, "one texel a pixel"), vertical=True)
    of = "of the band's" if by_depth else "of those measured"
    ax.set(xlabel=QUANTITIES[quantity] + (BEYOND if ends else ""), ylabel=f"pixels, % {of}", title=title)
    if highest == 0.0:
        say(ax, NOTHING_MEASURED)
    elif ax.get_legend_handles_labels()[0]:
        legend_beside(ax, title=DEPTH_LABEL.replace(", ", ",\n") if by_depth else None)
    return ax


def _measured_values(footprint: Footprint, quantity: str) -> NDArray[np.float64]:
    """The quantity (N,) of the pixels that look up a texel."""
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        values = np.asarray(getattr(footprint, quantity))[footprint.measured].astype(np.float64)
    known: NDArray[np.float64] = values[~np.isnan(values)]
    return known


def _by_band(given: Mapping[str, Footprint | Summary], quantity: str, bands: int) -> dict[str, NDArray[np.float64]]:
    """The quantity of the pixels of each band of depth, even in its logarithm."""
    if len(given) > 1:
        raise ArgumentError(
            f"by_depth: expected one footprint, got {len(given)}; draw each on axes of its own, or see error_by_depth"
        )
    footprint = cast("Footprint", next(iter(given.values())))
    if not footprint.measured.any():
        return {str(next(iter(given))): np.empty(0)}
    values, depth = np.asarray(getattr(footprint, quantity))[footprint.measured], footprint.depth[footprint.measured]
    rows = footprint.summary(bands=bands).bands
    found = {}
    for i, (near, far) in enumerate(rows[["near", "far"]].to_numpy(np.float64)):
        inside = (depth >= near) & ((depth < far) if i < len(rows) - 1 else True)
        chosen = values[inside].astype(np.float64)
        found[f"{near:.3g} to {far:.3g}"] = chosen[~np.isnan(chosen)]
    return found


def _edges(series: list[NDArray[np.float64]], *, coarse: bool) -> NDArray[np.float64]:
    """Limits of the bins: fractions of octaves around 1 that hold all but the tails."""
    if coarse:
        return np.asarray(HISTOGRAM_LIMITS_PX)
    reached = []
    for values in series:
        positive = values[np.isfinite(values) & (values > 0)]
        if positive.size:
            reached += list(np.log2(np.quantile(positive, (TAIL, 1 - TAIL))))
    low, high = math.floor(min([*reached, -1.0])), math.ceil(max([*reached, 1.0]))
    low, high = max(low, -MOST_OCTAVES), min(high, MOST_OCTAVES)
    edges: NDArray[np.float64] = 2.0 ** np.linspace(low, high, BINS * (high - low) + 1)
    return edges


def _bin_counts(values: Summary | NDArray[np.float64], edges: NDArray[np.float64]) -> NDArray[np.int64]:
    """Pixels of each bin; the outer ones hold what is beyond them."""
    if isinstance(values, Summary):
        counts = values.histogram["pixels"].to_numpy()
        return np.concatenate([[counts[:2].sum()], counts[2:-2], [counts[-2:].sum()]])
    if values.size == 0:
        return np.zeros(len(edges) - 1, np.int64)
    inside = np.clip(values, edges[0], np.nextafter(edges[-1], 0))
    return np.histogram(inside, edges)[0]


def _beyond(values: Summary | NDArray[np.float64], edges: NDArray[np.float64]) -> bool:
    """Whether an outer bin holds more than its own."""
    if isinstance(values, Summary):
        return bool(values.histogram["pixels"].iloc[[0, -1]].any())
    return bool(((values < edges[0]) | (values >= edges[-1])).any())


@checked(title=a_text)
def error_by_depth(
    footprints: Footprint | Summary | Mapping[str, Footprint | Summary],
    ax: Axes | None = None,
    *,
    bands: int | npt.ArrayLike = 12,
    title: str = "",
) -> Axes:
    """Axes with the error over the depth along the view, both logarithmic: mean and 95th percentile of each band.

    Parameters
    ----------
    footprints : dict, Footprint or Summary
        Label to `Footprint`, or to `Summary`, whose bands are taken as they are.
    ax : matplotlib axes, optional
        Made where none are given.
    bands : int or (B + 1,) array_like
        As for `Footprint.summary`.
    title : str

    Returns
    -------
    matplotlib axes
        Of each label the mean, with markers, and above it the 95th percentile, thin; both at the band's middle.

    Raises
    ------
    ArgumentError
        For no footprint, less than one band, or limits that do not rise.

    Examples
    --------
    >>> import shadowlab as sl
    >>> s = sl.library.scene("robots")
    >>> g = sl.Renderer("cpu").gbuffer(s, s.camera, size=(160, 90))
    >>> maps = {t: sl.technique(t).parameterize(s, s.camera, s.light) for t in ("uniform", "lispsm")}
    >>> found = {t: sl.aliasing.footprint(g, s.camera, s.light, p) for t, p in maps.items()}
    >>> ax = sl.plot.error_by_depth(found, bands=8)
    """
    given = footprints_of(footprints)
    checked_bands(bands)
    tables = {k: (v if isinstance(v, Summary) else v.summary(bands=bands)).bands for k, v in given.items()}
    ax = _axes(ax)
    shown_values: list[float] = []
    depths: list[float] = []
    for i, (label, table) in enumerate(tables.items()):
        table = table[table["pixels"] > 0]
        if not len(table):
            ax.plot([], [], " ", label=f"{short_label(label)}: {NOTHING_MEASURED}")
            continue
        middle = np.sqrt(table["near"].to_numpy(np.float64) * table["far"].to_numpy(np.float64))
        mean, p95 = (table[c].to_numpy(np.float64) for c in ("mean", "p95"))
        style = series_style(i)
        ax.plot(middle, mean, label=short_label(label), **style)
        ax.plot(middle, p95, color=style["color"], linestyle=style["linestyle"], linewidth=0.8)
        shown_values += [*mean, *p95]
        depths += [float(table["near"].iloc[0]), float(table["far"].iloc[-1])]
    log_axis(ax, "y", padded([*shown_values, 1.0] if shown_values else []))
    log_axis(ax, "x", padded(depths, least=1.05) if depths else (0.1, 10.0))
    curve_look(ax)
    level(ax, 1.0, "one texel a pixel")
    ax.set(xlabel=DEPTH_LABEL, ylabel=QUANTITIES["major"], title=title)
    if not shown_values:
        say(ax, NOTHING_MEASURED)
        return ax
    ax.plot([], [], color="#555555", marker="o", markersize=4, linewidth=1.6, label="mean of the band")
    ax.plot([], [], color="#555555", linewidth=0.8, label="95th percentile")
    legend_beside(ax)
    return ax
