"""What is known of one pixel: the result of `explain_pixel`, which shows itself as text and as a figure."""

from __future__ import annotations

from base64 import b64encode
from dataclasses import dataclass
from html import escape
from io import BytesIO
from typing import TYPE_CHECKING, Literal

from ..travel import Value

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..aliasing.causes import CauseName
    from ..aliasing.pixel_comparison import PixelComparison
    from ..aliasing.pixel_held import Held
    from ..aliasing.pixel_surface import Met, PixelSurface
    from ..aliasing.pixel_texel import MapChain, PixelTexel
    from .pixel_trials import PixelTrial
    from .run import Run

#: What truth says of a pixel.
TruthName = Literal["lit", "shadow", "undecided", "nothing"]
#: What a map makes of it.
PixelVerdict = Literal["right", "false shadow", "false light", "not compared"]
#: How a pixel finds its map, or why there is none.
MapReason = Literal["only", "depth", "containment", "later", "outside", "averted", "nothing"]

# Of the figure in a notebook.
HTML_DPI = 90


@dataclass(frozen=True, eq=False)
class PixelBlend(Value):
    """How two maps blend at a pixel.

    Attributes
    ----------
    maps : (int, int)
        Index of the map that the pixel asks, and of the one that is mixed in.
    shares : (float, float)
        Of the light; they sum to 1.
    lights : (float, float)
        Share of the light that arrives by each alone.
    """

    maps: tuple[int, int]
    shares: tuple[float, float]
    lights: tuple[float, float]


@dataclass(frozen=True, eq=False, repr=False)
class PixelExplanation(Value):
    """Why a pixel is wrong, or right.

    `str` is the explanation in plain words, the most important line first, and `figure` shows it.

    Attributes
    ----------
    run : Run
        The technique at its resolution in its view, with maps, mask, errors and causes of the whole picture.
    x, y : int
        Column and row of the pixel, from the upper left.
    technique : str
        The technique's text.
    truth : str
        "lit", "shadow", "undecided" or "nothing".
    light : float or None
        Share of the light that arrives by the map; None where the pixel shows nothing.
    verdict : str
        "right", "false shadow", "false light", or "not compared" where truth is undecided or nothing is there.
    cause : str or None
        Of a wrong pixel the cause that `aliasing.causes` gives it; None of others.
    edge_px : float or None
        Of a displaced edge, how far it lies from the pixel's centre, pixels; infinite behind the camera.
    surface : PixelSurface or None
        What the pixel sees; None where it shows nothing.
    blocker : Met or None
        What truth's ray to the light meets first, `distance` from the surface; None where nothing is in the way, and
        of a surface that faces away from the light.
    blocker_depth : float or None
        NDC depth of that in the pixel's map, whatever it stores; outside of 0 to 1 the map cuts it off. None without
        either, and behind the centre of the map's projection.
    map : int or None
        Index of the map that is explained: the one that serves the pixel or, where two blend and that one alone is
        right, the one that is mixed in. None where none is asked.
    maps : int
        How many maps there are.
    reason : str
        How it finds its map: "only" (there is one), "depth" (the first whose depths reach it), "later" (the first does
        not hold it), "containment" (the first that holds it). Why it asks none: "outside" (no map holds it, so that it
        is lit), "averted" (it faces away from the light or is beyond its reach, so that it is dark), "nothing".
    blend : PixelBlend or None
        Of a pixel at which two maps blend, how.
    eye_depth : (float, float) or None
        Camera depths that the map serves, world units.
    chain : MapChain or None
        The way of the point into its map.
    texel : PixelTexel or None
        The texel that it falls into.
    held : Held or None
        What that texel stores, and whose triangles it comes from.
    comparison : PixelComparison or None
        Reference depths, bias and verdict of each texel that the filter reads.
    trials : tuple of PixelTrial
        What was tried to make a wrong pixel right; empty of others.
    """

    run: Run
    x: int
    y: int
    technique: str
    truth: TruthName
    light: float | None
    verdict: PixelVerdict
    cause: CauseName | None
    edge_px: float | None
    surface: PixelSurface | None
    blocker: Met | None
    blocker_depth: float | None
    map: int | None
    maps: int
    reason: MapReason
    blend: PixelBlend | None
    eye_depth: tuple[float, float] | None
    chain: MapChain | None
    texel: PixelTexel | None
    held: Held | None
    comparison: PixelComparison | None
    trials: tuple[PixelTrial, ...] = ()

    @property
    def is_wrong(self) -> bool:
        """Whether map and truth disagree."""
        return self.verdict in ("false shadow", "false light")

    @property
    def mends(self) -> tuple[PixelTrial, ...]:
        """The trials that make the pixel right."""
        return tuple(trial for trial in self.trials if trial.is_right)

    def figure(self) -> Figure:
        """A matplotlib figure: the pixel in the eye view, its texel in the map, and both along the light's ray."""
        from .. import plot

        return plot.pixel_figure(self)

    def __str__(self) -> str:
        from ..reports.pixel_words import explanation_text

        return explanation_text(self)

    def __repr__(self) -> str:
        what = self.verdict if self.cause is None else f"{self.verdict}: {self.cause}"
        return f"PixelExplanation({self.technique} at {self.run.resolution}², pixel ({self.x}, {self.y}), {what})"

    def _repr_html_(self) -> str:
        figure, file = self.figure(), BytesIO()
        figure.savefig(file, format="png", dpi=HTML_DPI)
        picture = f'<img alt="{escape(repr(self))}" src="data:image/png;base64,{b64encode(file.getvalue()).decode()}">'
        return f"<pre>{escape(str(self))}</pre>{picture}"
