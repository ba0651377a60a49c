"""What one part of a bias costs: acne, false light and wrong pixels over its value."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import ArgumentError
from ..experiments.smallest_bias import SmallestBias
from ..pictures.eye import FALSE_LIGHT_RGB, FALSE_SHADOW_RGB
from ..text import shown
from ..text.checked import a_text, checked
from .axes import SOFT, _axes, curve_look, legend_beside

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..types import RGB, BiasPart

# Counts of pixels are linear up to this: the last of the acne goes there.
FEW_WRONG_PX = 10.0
# What the axis shows beyond the last of the marks, and of a closed form further out than this many times the others
# nothing but its number.
ROOM_BEYOND, FAR_OUT = 1.3, 3.0
WHAT: dict[BiasPart, str] = {
    "world": "world bias, world units along the light ray",
    "texels": "texel bias, world sizes of a texel",
    "ndc": "NDC bias, depth of the map",
    "slope": "slope bias, times the depth that a plane gains",
}


@checked(title=a_text)
def bias_curve(found: SmallestBias, ax: Axes | None = None, *, title: str = "") -> Axes:
    """Axes with the pixels in acne, in false light and all wrong ones over the value of one part of a bias.

    Parameters
    ----------
    found : SmallestBias
        As `sl.smallest_bias` returns it.
    ax : matplotlib axes, optional
        Made where none are given.
    title : str
        The technique and its resolution where none is given.

    Returns
    -------
    matplotlib axes
        Pixels, linear below ten and logarithmic above. Thin lines mark the least value that leaves few enough in acne,
        that of fewest wrong pixels, and the closed form for planes; where it is far outside, the legend has it.

    Raises
    ------
    ArgumentError
        For something else than a `SmallestBias`.

    Examples
    --------
    >>> import shadowlab as sl
    >>> scene = sl.library.scene("robots")
    >>> view = sl.View(scene, scene.camera, scene.light, size=(160, 90))
    >>> found = sl.smallest_bias(view, "lispsm", resolution=256, renderer="cpu", progress=False)
    >>> ax = sl.plot.bias_curve(found)
    """
    if not isinstance(found, SmallestBias):
        raise ArgumentError(f"found: expected a SmallestBias, got {shown(found)}; sl.smallest_bias(...) makes one")
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    ax = _axes(ax)
    table = found.curve
    values = table["value"].to_numpy(np.float64)
    marks = [v for v in (found.value, found.least_wrong_value) if v is not None]
    end = max([*marks, 0.0]) or float(values.max())
    plane = found.closed_form
    is_near = plane is not None and plane <= FAR_OUT * end
    end = ROOM_BEYOND * max(end, plane if plane is not None and is_near else 0.0)
    lines = (
        ("wrong", "all wrong pixels", "#000000", "-"),
        ("leaks", "false light", _colour(FALSE_LIGHT_RGB), (0, (6, 2))),
        ("acne", "acne", _colour(FALSE_SHADOW_RGB), "-"),
    )
    for name, words, colour, dashes in lines:
        ax.plot(values, table[name], color=colour, linestyle=dashes, linewidth=1.8, label=words)
    ax.axhline(found.allowed, color=SOFT, linewidth=0.8, linestyle=(0, (1, 2)), label=f"allowed, {found.allowed:,} px")
    if found.value is not None:
        _mark(ax, found.value, found.acne, _colour(FALSE_SHADOW_RGB), f"least value, {found.value:.4g}")
    _mark(ax, found.least_wrong_value, found.least_wrong, "#000000", f"fewest wrong, {found.least_wrong_value:.4g}")
    if plane is not None and is_near:
        ax.axvline(plane, color=SOFT, linewidth=1.0, linestyle=(0, (4, 3)), label=f"endless planes, {plane:.4g}")
    elif plane is not None:
        ax.plot([], [], " ", label=f"endless planes, {plane:.4g}")
    ax.set_yscale("symlog", linthresh=FEW_WRONG_PX, linscale=0.5)
    top = float(table.loc[values <= end, ["wrong", "leaks", "acne"]].to_numpy().max(initial=1))
    ax.set(xlim=(0.0, end), ylim=(-0.5, 1.6 * top))
    ax.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:,.0f}"))
    ax.xaxis.set_major_locator(MaxNLocator(6))
    curve_look(ax)
    ax.set(xlabel=WHAT[found.part], ylabel="pixels", title=title or f"{found.label}, {found.resolution}²")
    legend_beside(ax, fontsize="small")
    return ax


def _mark(ax: Axes, value: float, count: int, colour: str, words: str) -> None:
    ax.axvline(value, color=colour, linewidth=0.8, alpha=0.6)
    ax.plot([value], [count], "o", color=colour, markersize=6, markeredgecolor="white", clip_on=False, label=words)


def _colour(rgb: RGB) -> str:
    return "#{:02X}{:02X}{:02X}".format(*rgb)
