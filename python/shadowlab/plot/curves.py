"""Errors as curves: over the depth along the view, and over the angle between light and view.

The first is figure 6 of Wimmer, Scherzer, Purgathofer, "Light space perspective shadow maps", 2004 [wimmer2004].
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from ..errors import ArgumentError
from ..experiments.light_angles import LightAngles
from ..text import shown
from ..text.checked import a_length, a_text, checked, optional
from .arguments import column_label, columns_of, current_columns, dictionary_of, numbers_of, pair_of, title_and_unit
from .axes import (
    _axes,
    curve_look,
    last_finite,
    legend_beside,
    level,
    log_axis,
    padded,
    say,
    series_style,
    short_label,
    wrapped,
)

if TYPE_CHECKING:
    import numpy.typing as npt
    import pandas as pd
    from matplotlib.axes import Axes

DEPTH_LABEL = "depth along the view, world units"
DP_DS_LABEL = "dp/ds, world units on the near plane per map"

#: Depths and values (N,) of a line.
Curve: TypeAlias = "tuple[npt.ArrayLike, npt.ArrayLike]"


@checked(near=a_length, far=a_length, ylabel=a_text, title=a_text)
def error_along_view(
    curves: Mapping[str, Curve],
    ax: Axes | None = None,
    *,
    near: float,
    far: float,
    measured: Mapping[str, Curve] | None = None,
    ylabel: str = DP_DS_LABEL,
    title: str = "",
) -> Axes:
    """Axes with errors over the depth along the view, both logarithmic: lines of theory, and dots of what was measured.

    Parameters
    ----------
    curves : dict
        Label to depths and values, ``(z, values)``, each (N,): world units, and the unit of `ylabel`. A value of NaN or
        infinity is a gap.
    ax : matplotlib axes, optional
        Made where none are given.
    near, far : float
        Ends of the axis of depth, world units, 0 < near < far.
    measured : dict, optional
        The same of dots; one whose label is that of a curve takes its colour.
    ylabel : str
        What the values are, and their unit.
    title : str

    Returns
    -------
    matplotlib axes

    Raises
    ------
    ArgumentError
        For no curve, depths and values of different shapes, and numbers that a logarithmic axis cannot show.

    References
    ----------
    Wimmer, Scherzer, Purgathofer, "Light space perspective shadow maps", 2004 [wimmer2004], figure 6.

    Examples
    --------
    >>> import numpy as np, shadowlab as sl
    >>> z, view = np.geomspace(1, 100), {"near": 1, "far": 100}
    >>> forms = {t: (z, sl.aliasing.closed_form.dp_ds(z, technique=t, **view)) for t in ("uniform", "psm", "lispsm")}
    >>> ax = sl.plot.error_along_view(forms, **view)
    """
    if not near < far:
        raise ArgumentError(f"near, far: expected 0 < near < far, got {shown((near, far))}; take the camera's")
    lines = {k: pair_of(v, f"curves[{k!r}]") for k, v in dictionary_of(curves, "curves", "(z, values)").items()}
    dots = {} if measured is None else dictionary_of(measured, "measured", "(z, values)")
    dots = {k: pair_of(v, f"measured[{k!r}]") for k, v in dots.items()}
    ax = _axes(ax)
    styles = {label: series_style(i) for i, label in enumerate([*lines, *(k for k in dots if k not in lines)])}
    for label, (z, values) in lines.items():
        style = {**styles[label], "marker": "", "linewidth": 2.0}
        ax.plot(z, values, label=short_label(label), **style)
    for label, (z, values) in dots.items():
        style = {**styles[label], "linestyle": "", "markersize": 5.5, "markeredgewidth": 0.8}
        ax.plot(z, values, label=f"{short_label(label)}, measured", zorder=3, **style)
    within = [values[(near <= z) & (z <= far)] for z, values in (*lines.values(), *dots.values())]
    log_axis(ax, "x", (near, far))
    log_axis(ax, "y", padded(np.concatenate(within)))
    curve_look(ax)
    ax.set(xlabel=DEPTH_LABEL, ylabel=wrapped(ylabel), title=title)
    if not np.isfinite(np.concatenate(within)).any():
        say(ax, "no finite value between near and far")
    legend_beside(ax)
    return ax


@checked(x=a_text, y=a_text, baseline=optional(a_text), xlabel=optional(a_text), ylabel=optional(a_text), title=a_text)
def error_over_angle(
    table: pd.DataFrame | LightAngles,
    ax: Axes | None = None,
    *,
    x: str = "angle_deg",
    y: str = "texel_p95",
    baseline: str | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
    title: str = "",
) -> Axes:
    """Axes with an error over the angle of the light, one line a technique, the error logarithmic.

    Twelve techniques stay apart in print: marker, kind of line and colour differ. The legend has them in the order in
    which the lines end.

    Parameters
    ----------
    table : pandas.DataFrame or LightAngles
        One row a technique and angle: columns technique, `x` and `y`. A value that is no positive finite number is a
        gap in the line.
    ax : matplotlib axes, optional
        Made where none are given.
    x, y : str
        Names of columns.
    baseline : str, optional
        A technique: all others are divided by it, angle for angle, and it is the line at 1.
    xlabel, ylabel : str, optional
        What the axes say, with units; the column's own words where none are given.
    title : str

    Returns
    -------
    matplotlib axes

    Raises
    ------
    ArgumentError
        For a column or a baseline that the table does not have, and several rows of one technique and angle.

    Examples
    --------
    >>> import pandas as pd, shadowlab as sl
    >>> rows = [("uniform", 30, 9.0), ("uniform", 90, 8.0), ("lispsm", 30, 4.0), ("lispsm", 90, 2.0)]
    >>> table = pd.DataFrame(rows, columns=["technique", "angle_deg", "texel_p95"])
    >>> ax = sl.plot.error_over_angle(table, baseline="uniform")
    """
    if not (x and y):
        raise ArgumentError(f"x, y: expected names of columns, got {x!r} and {y!r}; angle_deg and texel_p95 are two")
    if isinstance(table, LightAngles):
        table = table.table
    table = current_columns(table, ["technique", x, y])
    columns_of(table, ["technique", x, y])
    rows = table.assign(**{x: numbers_of(table, x), y: numbers_of(table, y)})
    rows = rows[rows["technique"].notna()]
    if rows.duplicated(["technique", x]).any():
        first = rows[rows.duplicated(["technique", x])].iloc[0]
        raise ArgumentError(
            f"table: expected one row a technique and {x}, got several of {first['technique']!r} at {first[x]:g}; "
            f'average them first, e.g. table.groupby(["technique", "{x}"], as_index=False)["{y}"].median()'
        )
    wide = rows.pivot(index=x, columns="technique", values=y)[list(dict.fromkeys(rows["technique"]))]  # noqa: PD010
    wide = wide[np.isfinite(wide.index.to_numpy(np.float64))].sort_index()
    # A logarithm shows neither zero nor what failed.
    wide = wide.where((wide > 0) & np.isfinite(wide))
    if baseline is not None:
        if baseline not in wide.columns:
            names = ", ".join(map(str, wide.columns)) or "none"
            raise ArgumentError(
                f"baseline: expected one of {names}, got {shown(baseline)}; add its rows or name another"
            )
        wide = wide.div(wide[baseline], axis=0)
    ax = _axes(ax)
    drawn = []
    for i, technique in enumerate(wide.columns):
        if technique == baseline:
            continue
        values = wide[technique].to_numpy()
        (line,) = ax.plot(wide.index.to_numpy(), values, label=short_label(technique), **series_style(i))
        drawn.append((last_finite(values), line))
    positive = wide.to_numpy(np.float64)
    log_axis(ax, "y", padded(np.append(positive.ravel(), [1.0] if baseline is not None else [])))
    curve_look(ax)
    _angles(ax, wide.index.to_numpy(np.float64), x)
    said = ylabel or column_label(y)
    if baseline is not None and ylabel is None:
        # A ratio has no unit.
        said = f"{title_and_unit(y)[0]}, over that of {short_label(baseline)}"
    ax.set(xlabel=xlabel or column_label(x), ylabel=wrapped(said), title=title)
    if baseline is not None:
        level(ax, 1.0, "no warp" if str(baseline).startswith("uniform") else f"as {short_label(baseline)}")
    if not np.isfinite(positive).any():
        say(ax, "no technique has a positive finite value")
    elif drawn:
        legend_beside(ax, [line for _, line in sorted(drawn, key=lambda pair: -pair[0])], fontsize="small")
    return ax


def _angles(ax: Axes, values: np.ndarray, column: str) -> None:
    """Limits around the values, and ticks that divide a turn where they are degrees."""
    from matplotlib.ticker import MultipleLocator

    if values.size == 0:
        return
    low, high = float(values.min()), float(values.max())
    slack = 0.02 * (high - low) or max(abs(low) * 0.05, 1.0)
    ax.set_xlim(low - slack, high + slack)
    if column.endswith("_deg") and high > low:
        steps = (1, 2, 5, 10, 15, 30, 45, 90)
        ax.xaxis.set_major_locator(MultipleLocator(next((s for s in steps if (high - low) / s <= 7), 90)))
