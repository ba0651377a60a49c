"""What an advice ranks by: the errors by name, and how each of them scatters."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

from ..errors import ArgumentError, UnknownNameError
from ..text import share_text, shown
from .thresholds import ABOUT_EQUAL, LATTICE_SCATTER, NOISE_SIGMAS

if TYPE_CHECKING:
    from .run import Run

#: What is ranked by.
ErrorName = Literal["misclassified", "worst", "p95", "mean", "undersampled", "perspective"]
#: How views are put together.
Over = Literal["mean", "worst"]
OVER: tuple[Over, ...] = get_args(Over)
# Lengths of texels scatter with the pixels that happen to see a surface: measured as the standard deviation of the
# ratio of two candidates, over the root of two, while the camera turns by parts of a pixel; in robots, skylight and
# forest, 480 x 270 pixels. The longest texel is of one grazing pixel: 13 to 75 per cent, in robots 0.04; with 0.3 only
# a factor of ten is more than noise. One such pixel can make the mean, too: up to 0.2 per cent, in the forest 2 to 44;
# with 0.1 it takes a half more.
WORST_SCATTER, MEAN_SCATTER = 0.3, 0.1
# Of all pixels but the longest twentieth 0.02 to 1.6 per cent, of shares 0.01 to 0.07, without slopes 0.02 to 6.
P95_SCATTER, SHARE_SCATTER, PERSPECTIVE_SCATTER = 0.01, 0.001, 0.02
NO_CHOICE = "within one part in twenty"
LONG_TEXELS = "texels are as long as the worst that published pictures show"


@dataclass(frozen=True)
class Measure:
    """One error of a view.

    Attributes
    ----------
    name, title, doc : str
        What it is called in arguments, in sentences, and what it means.
    unit : str
        "share" of pixels, from 0 to 1, or "px" of the image.
    direction : str
        Which end is good: "lower" of all there are.
    poor_from : float
        From here on an advice warns, whatever is best: in `unit`.
    poor_because : str
        Why there.
    python : str
        The expression that gives it, of `errors` (`aliasing.Misclassified`) or `summary` (`aliasing.Summary`).
    column : str
        The column of a run that has it.
    population : str
        The column of a run that counts the pixels of which it is a share; "" where that has no part in its noise.
    scatter : float
        By which part of itself it changes where texels or pixels are shifted by parts of their size: one standard
        deviation.
    falls_with : str
        "side" where it is a length that falls as the sides of maps grow, so that the memory which it would take to
        reach another value is known; "" where one pixel or an edge decides.
    caveat : str
        Why nobody should choose by it; a verdict then tells its numbers and this, and no more.
    """

    name: ErrorName
    title: str
    unit: str
    doc: str
    poor_from: float
    poor_because: str
    python: str
    column: str
    population: str = ""
    scatter: float = 0.0
    falls_with: str = ""
    caveat: str = ""
    direction: str = "lower"

    def of(self, run: Run) -> float | None:
        """The error of a run; None where nothing is measured."""
        return run.numbers.get(self.column)

    def text(self, value: float) -> str:
        """A value as people read it."""
        return share_text(value) if self.unit == "share" else f"{value:,.3g} px" if value < 1e3 else f"{value:,.0f} px"

    def noisy_text(self, value: float, sd: float | None) -> str:
        """A value with its standard deviation, where that is known, as people read both."""
        if sd is None or self.unit != "share":
            return self.text(value)
        # The deviation has two digits, and the value as many places.
        places = max(0, 1 - math.floor(math.log10(100 * sd))) if sd > 0 else 3
        return f"{100 * value:.{places}f} ± {100 * sd:.{places}f} %"

    @property
    def equal_because(self) -> str:
        """Why candidates are told as about equal: the scatter, or a ratio where that is wider."""
        return "within the noise" if NOISE_SIGMAS * math.sqrt(2) * self.scatter > ABOUT_EQUAL - 1 else NO_CHOICE

    def variance(self, value: float, population: float) -> float:
        """The variance of a value: of the count behind a share, and of where the texels happen to lie."""
        count = value / population if self.population and population > 0 else 0.0
        return count + (self.scatter * value) ** 2


MEASURES = (
    Measure(
        "misclassified", "share of wrong pixels", "share", "pixels lit or dark other than by traced truth, of those "
        "compared", 0.05, "one pixel in twenty is wrong, which shows at a glance",
        "errors.fraction", "share", "compared",
        LATTICE_SCATTER,
    ),
    Measure(
        "worst", "longest texel", "px", "the longest extent of a texel in the image; one pixel decides it, use p95 "
        "to choose", 10.0, LONG_TEXELS, "summary.max", "texel_max", scatter=WORST_SCATTER,
        caveat="One pixel decides this length, most often of a surface that the light grazes: p95 is the measure to "
        "choose by.",
    ),
    Measure(
        "p95", "texel length of 95 % of the pixels", "px", "the extent of a texel in the image that 95 % of the pixels "
        "do not exceed", 2.0, "stairs of texels show even through a filter of 2 x 2 texels",
        "summary.percentiles[95]", "texel_p95",
        scatter=P95_SCATTER, falls_with="side",
    ),
    Measure(
        "mean", "mean texel length", "px", "the mean over the pixels of the longest extent of a texel in the image",
        2.0, "stairs of texels show even through a filter of 2 x 2 texels",
        "summary.mean", "texel_mean", scatter=MEAN_SCATTER,
    ),
    Measure(
        "undersampled", "share of undersampled pixels", "share", "pixels in which a texel is longer than a pixel, of "
        "those that look one up", 0.25, "texels show as stairs in a quarter of the picture",
        "summary.undersampled", "undersampled", scatter=SHARE_SCATTER,
    ),
    Measure(
        "perspective", "longest texel by perspective alone", "px", "the longest extent of a texel in the image, of all "
        "pixels, without what the slopes of surfaces add", 10.0, LONG_TEXELS,
        "summary.perspective_max", "perspective_max", scatter=PERSPECTIVE_SCATTER,
        falls_with="side",
    ),
)  # fmt: skip


def measure_of(name: object) -> Measure:
    """The error of that name.

    Raises
    ------
    ArgumentError
        For something that is no name.
    UnknownNameError
        For a name that does not exist; the message lists those that do.
    """
    names = ", ".join(measure.name for measure in MEASURES)
    if not isinstance(name, str):
        raise ArgumentError(f"error: expected one of {names}, got {shown(name)}")
    for measure in MEASURES:
        if measure.name == name:
            return measure
    raise UnknownNameError(f"error: unknown error {name!r}; expected one of {names}")


def over_of(value: object) -> Over:
    """How views are put together.

    Raises
    ------
    ArgumentError, UnknownNameError
        For anything but "mean" and "worst".
    """
    if not isinstance(value, str):
        raise ArgumentError(f"over: expected one of {', '.join(OVER)}, got {shown(value)}")
    if value not in OVER:
        raise UnknownNameError(f"over: unknown choice {value!r}; expected one of {', '.join(OVER)}")
    return value


def docs() -> Mapping[str, str]:
    """What each error means, by name."""
    return {measure.name: f"{measure.doc} ({measure.unit}; lower is better)" for measure in MEASURES}
