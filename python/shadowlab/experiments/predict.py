"""Wrong pixels of a technique foretold from the samples of a view, without drawing its maps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, cast

from .. import _core
from ..errors import ArgumentError
from ..scene.view import View, checked_view
from ..techniques.labels import resolved
from ..text import shown
from ..text.checked import a_number
from ..text.checks import renderer_of, whole
from ..travel import Value
from .evaluate import fitted

if TYPE_CHECKING:
    from ..types import Item, RendererArgument

# Drawn counts of nine views in ten lie between these times the predicted ones, with so many pixels more. Chosen by
# leaving scenes out (docs/predict.md).
LEAST, MOST, PIXELS = 0.75, 1.85, 20.0


@dataclass(frozen=True, order=True, repr=False)
class Prediction(Value):
    """Wrong pixels that are foretold, and how far off that may be; compared and sorted by `wrong`.

    What most of the doubt is about, such as casters thinner than a pixel, does the same to all maps of a view: of two
    techniques in one view the order is far better known than either number.

    Attributes
    ----------
    wrong : float
        Pixels.
    low, high : float
        Between which the drawn count was in nine of ten views (docs/predict.md).
    """

    wrong: float
    low: float
    high: float

    @staticmethod
    def of(wrong: float) -> Prediction:
        """With the doubt that was measured."""
        wrong = a_number("wrong", wrong)
        return Prediction(wrong, max(LEAST * wrong - PIXELS, 0.0), MOST * wrong + PIXELS)

    def __float__(self) -> float:
        return self.wrong

    def __repr__(self) -> str:
        return f"Prediction({self.wrong:,.0f} wrong pixels, {self.low:,.0f} to {self.high:,.0f} in nine of ten views)"


def predict(
    view: View,
    technique: Item | str,
    resolution: int = 1024,
    *,
    shadows: Literal["mapped", "traced"] = "mapped",
    bias: _core.Bias | None = None,
    renderer: RendererArgument = None,
) -> Prediction:
    """Wrong pixels of a technique in a view, foretold without drawing a map.

    A pixel gets the state of some point of its texel. Pixels whose rays fall into the same texel know what the map has
    there: their own surfaces, or what shades them. Where that lies above the receiver's plane by more than the bias,
    the point is dark. The share of points whose state is not the pixel's own is the chance that the pixel is wrong.
    Receivers in shadow outside all maps are wrong. Filters, what maps store and casters thinner than a pixel are not
    in it, so the level can be off by a factor of two; the order of techniques mostly is right.

    Parameters
    ----------
    view : View
    technique : str, Technique, Preset or Parameterization
        As `sl.technique` takes it; with several maps each receiver asks the one that serves it.
    resolution : int
        Texels along each side of each map.
    shadows : "mapped" or "traced"
        Whence it is known what is in shadow, and how far before it what shades it lies: one uniform map of 1024 x 1024
        texels, or rays.
    bias : Bias, optional
        With which the maps would be looked up; the default where none is given.
    renderer : Renderer or str, optional
        What draws the view's G-buffer.

    Returns
    -------
    Prediction
        Pixels of the view; the sum over its lights. `float` of it is `wrong`.

    Raises
    ------
    ArgumentError
        For arguments of another type.
    UnsupportedError
        What the technique cannot do with this view or light.

    References
    ----------
    docs/theory.md, (10.9).

    Examples
    --------
    >>> import shadowlab as sl
    >>> scene = sl.library.scene("robots")
    >>> view = sl.View(scene, scene.camera, scene.light, size=(160, 90))
    >>> sl.predict(view, "lispsm", 256) < sl.predict(view, "uniform", 256)
    True
    """
    checked_view(view)
    if not isinstance(shadows, str) or shadows not in ("mapped", "traced"):
        raise ArgumentError(f'shadows: expected "mapped" or "traced", got {shown(shadows)}')
    item, side, draw = resolved(technique, "technique"), whole("resolution", resolution), renderer_of(renderer)
    wrong = 0.0
    for one in view.views:
        p = fitted(item, one, side, draw)
        samples = cast("_core.Samples", one.samples(shadows=shadows, renderer=draw))
        gaps = one.gaps(shadows, renderer=draw)
        wrong += _core.predict_wrong(samples, p, gaps, resolution=side, bias=bias)
    return Prediction.of(wrong)
