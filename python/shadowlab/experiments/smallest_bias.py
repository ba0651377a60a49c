"""The least bias of one part that removes acne, what it costs in false light, and the one of fewest wrong pixels.

The map is drawn once and the truth traced once; every value is one look-up in that map.
"""

from __future__ import annotations

import operator
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import reduce
from html import escape
from typing import TYPE_CHECKING, get_args

import numpy as np

from .. import _core
from ..aliasing.bias_parts import with_part
from ..errors import ArgumentError
from ..scene.view import checked_view
from ..techniques.labels import name_of, resolved
from ..techniques.variant import reading
from ..text.checked import a_number, a_word
from ..text.checks import check_bias, check_filter, checked_stored, renderer_of, whole
from ..text.progress import checked_progress, steps_of_call
from ..travel import Value
from ..types import BiasPart
from .bias_looks import UNLIMITED, BiasCounts, BiasLooks
from .bias_search import BiasSearch

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from ..scene.view import View
    from ..types import Filter, RendererArgument, TechniqueArgument

SEARCHED_PARTS: tuple[BiasPart, ...] = get_args(BiasPart)
# Values are told apart up to this share of them.
TOLERANCE = 1e-3
# Where a search begins whose closed form has no finite number above 0: by doubling and halving it gets anywhere.
STARTS: dict[BiasPart, float] = {"world": 0.1, "texels": 1.0, "ndc": 1e-4, "slope": 1.0}
# Steps of the curve from 0 to `CURVE_REACH` times the least value, closer towards 0 where counts are steepest. It has
# the values of the searches, too.
CURVE_STEPS, CURVE_REACH = 24, 2.0


@dataclass(frozen=True, eq=False, repr=False)
class SmallestBias(Value):
    """The least value of one part of a bias that leaves at most a share of acne, with its curve.

    Attributes
    ----------
    part : str
        "world", "texels", "ndc" or "slope".
    value : float or None
        The least, to one in a thousand above it; None where no value of this part removes enough acne.
    acne, leaks, wrong : int
        Pixels with `value`: in acne, in false light, and all wrong ones. Where it is None, with a value beyond all.
    least_wrong_value : float
        The value of fewest wrong pixels.
    least_wrong : int
        That many, over the values of `curve`.
    least_wrong_bound : int
        No value at all has fewer wrong pixels; as a rule 99 % of `least_wrong` or more.
    closed_form : float or None
        What would do if every lit pixel showed an endless plane and its place in its texel were the worst: for all
        but `allowed` pixels. None where that has no finite value, and of maps that store another surface than the
        front, since an endless plane has nothing behind it that they could store.
    curve : DataFrame
        A row per value that was looked up, rising from 0: value; acne, false_shadow, leaks and wrong (pixels). acne
        and false_shadow never rise, leaks never falls, and wrong is false_shadow + leaks.
    lit, allowed : int
        Pixels that are compared and lit in truth, and how many of them may stay in acne.
    share : float
        The share of acne that was allowed.
    label : str
        The technique.
    resolution : int
        Texels along each side of the map.
    bias : Bias
        The other parts; its own `part` is 0.
    filter : str
    stored : Stored
        What the map stores.
    """

    part: BiasPart
    value: float | None
    acne: int
    leaks: int
    wrong: int
    least_wrong_value: float
    least_wrong: int
    least_wrong_bound: int
    closed_form: float | None
    curve: pd.DataFrame
    lit: int
    allowed: int
    share: float
    label: str
    resolution: int
    bias: _core.Bias
    filter: Filter
    stored: _core.Stored = field(default_factory=_core.Stored)

    @property
    def verdict(self) -> str:
        """The answer in sentences."""
        dark, bright = (int(self.curve[name].iloc[0]) for name in ("acne", "leaks"))
        few = f"at most {100 * self.share:.3g} %" if self.share else "none"
        few = f"{few} of the {self.lit:,} lit pixels in acne"
        kept = "" if self.stored == _core.Stored() else f", {self.stored} stored"
        head = f"{self.label} at {self.resolution}²{kept}, {self.part}: "
        if self.value is None:
            said = f"no value leaves {few}; {self.acne:,} stay dark whatever it is. Add another part"
        elif self.value == 0.0:
            said = f"none is needed; {self.acne:,} pixels are in acne without it, and {self.allowed:,} may be"
        else:
            said = (
                f"{self.value:.4g} is the least that leaves {few} ({dark:,} without it, {self.acne:,} with it). It "
                f"takes false light from {bright:,} pixels to {self.leaks:,}"
            )
        most = f"The fewest wrong pixels, {self.least_wrong:,}, come with {self.least_wrong_value:.4g}"
        plane = "" if self.closed_form is None else f" Endless planes would need {self.closed_form:.4g}."
        return f"{head}{said}. {most}.{plane}"

    def figure(self, ax: Axes | None = None) -> Axes:
        """The curve: acne, false light and wrong pixels over the value, with the marks; see `plot.bias_curve`."""
        from ..plot.bias import bias_curve

        return bias_curve(self, ax)

    def __str__(self) -> str:
        return self.verdict

    def _repr_html_(self) -> str:
        return f"<p>{escape(self.verdict)}</p>{self.curve.to_html(index=False, border=0, float_format='{:.4g}'.format)}"

    def __repr__(self) -> str:
        value = "none" if self.value is None else f"{self.value:.4g}"
        return (
            f"SmallestBias({self.part}={value}: {self.acne:,} px acne, {self.leaks:,} px false light; fewest wrong: "
            f"{self.least_wrong:,} px with {self.least_wrong_value:.4g})"
        )


def smallest_bias(
    view: View,
    technique: TechniqueArgument,
    part: BiasPart = "slope",
    *,
    resolution: int = 1024,
    acne: float = 0.001,
    renderer: RendererArgument = None,
    bias: _core.Bias | None = None,
    filter: Filter = "nearest",
    stored: _core.Stored | str | None = None,
    progress: bool | None = None,
) -> SmallestBias:
    """The least value of one part of a bias that leaves at most a share of acne, and what it costs in false light.

    A pixel is in acne where it is lit in truth, dark in the mask, and `aliasing.causes` names acne as its cause with
    the part at 0: its own surface shadows it, so what a pixel loses to a displaced silhouette does not count. A larger
    value moves every receiver nearer to the light and darkens none, hence a pixel that is in acne with a value is in
    acne with 0, and with every value between. So the causes are found once, and the count of every other value is
    that of one look-up. For the front surface and the nearest texel it equals what `causes` counts with that value; on
    other surfaces a few pixels at edges change their cause with the bias.

    Parameters
    ----------
    view : View
        Of several lights, all get the same value, and pixels add up.
    technique : str, Technique, Preset or Parameterization
        As `sl.technique` takes it.
    part : "slope", "world", "texels" or "ndc"
        As of `Bias`, with its unit.
    resolution : int
        Texels along each side of the map.
    acne : float
        Share of the pixels lit in truth that may stay in acne, 0 to 1; 0 removes all of it.
    renderer : Renderer or str, optional
        What draws the map.
    bias : Bias, optional
        The other parts, of which its `part` is left out; all 0 and no limit of the slope where none is given.
    filter : str
        One of `sl.filters()`, with its settings.
    stored : Stored or str, optional
        What the map stores; the nearest depth as it is where none is given.
    progress : bool, optional
        Whether to show a progress bar; on terminals and in notebooks where nothing is given, True anywhere.

    Returns
    -------
    SmallestBias
        Its `value` is None where no value of this part removes enough acne, as where a surface straight across the
        light, which has no slope, is in acne by rounding. 0 where there is not more acne than allowed.

    Raises
    ------
    ArgumentError
        For arguments of another type, or a share out of range.
    UnknownNameError
        For a part, technique, filter or renderer that does not exist, or a surface, spacing or format to store.
    UnsupportedError
        What the technique cannot do with this view or light.

    References
    ----------
    docs/theory.md, (13.1) and (13.2); docs/bias.md.

    Examples
    --------
    >>> import shadowlab as sl
    >>> scene = sl.library.scene("robots")
    >>> view = sl.View(scene, scene.camera, scene.light, size=(160, 90))
    >>> found = sl.smallest_bias(view, "lispsm", resolution=256, renderer="cpu", progress=False)
    >>> found.acne <= found.allowed < found.curve.acne[0], found.closed_form
    (True, 1.0)
    """
    checked_view(view), checked_progress(progress)
    item = resolved(technique, "technique")
    part = a_word(SEARCHED_PARTS, "slope is what planes need")("part", part)
    share = a_number("acne", acne)
    if not 0.0 <= share <= 1.0:
        raise ArgumentError(f"acne: expected a share of the lit pixels from 0 to 1, got {share:g}; try 0.001")
    check_bias(bias)
    check_filter(filter)
    read = reading(item, _core.Bias.none() if bias is None else bias, filter, 0.0, checked_stored(stored))
    rest = with_part(read.bias, part, 0.0)
    side, draw = whole("resolution", resolution), renderer_of(renderer)
    views = view.views
    with steps_of_call(len(views) + 3, progress) as step:
        looks = []
        for one in views:
            step(one.label or "map and truth")
            looks.append(BiasLooks(one, item, side, draw, part, rest, read.filter, read.stored))
        lit = sum(int(np.count_nonzero(one.lit)) for one in looks)
        allowed = int(share * lit)
        # An endless plane has nothing behind it that other surfaces could store.
        plane = _closed_form(looks, allowed) if read.stored.surface == "front" else None
        step("the least value")
        search = BiasSearch(lambda value: _sum_of([one.counts(value) for one in looks]), TOLERANCE)
        start = plane if plane is not None and plane > 0.0 else STARTS[part]
        value = search.least(allowed, start)
        step("the curve")
        # Where no value does, up to where no more acne goes.
        reach = search.least(search.at(UNLIMITED).acne, start) if value is None else value
        for i in range(CURVE_STEPS + 1):
            search.at((reach or start) * CURVE_REACH * (i / CURVE_STEPS) ** 2)
        step("the fewest wrong pixels")
        best = search.fewest_wrong()
    at = search.at(UNLIMITED if value is None else value)
    label = technique if isinstance(technique, str) else name_of(item)
    return SmallestBias(
        part, value, at.acne, at.leaks, at.wrong, best, search.at(best).wrong, search.bound, plane,
        _curve(search), lit, allowed, share, label, side, rest, read.filter, read.stored,
    )  # fmt: skip


def _sum_of(counts: Sequence[BiasCounts]) -> BiasCounts:
    return reduce(operator.add, counts)


def _closed_form(looks: Sequence[BiasLooks], allowed: int) -> float | None:
    """What all planes but `allowed` need at most; None where that is infinite."""
    needed = np.concatenate([one.of_planes() for one in looks])
    if needed.size <= allowed:
        return 0.0
    k = needed.size - 1 - allowed
    found = float(np.partition(needed, k)[k])
    return found if np.isfinite(found) else None


def _curve(search: BiasSearch) -> pd.DataFrame:
    import pandas as pd

    rows = [
        (value, counts.acne, counts.false_shadow, counts.leaks, counts.wrong)
        for value, counts in sorted(search.known.items())
        if value < UNLIMITED
    ]
    return pd.DataFrame(rows, columns=["value", "acne", "false_shadow", "leaks", "wrong"])
