"""Wrong pixels of a technique foretold from the samples of a view, without drawing its maps."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

from .. import _core
from ..errors import ArgumentError
from ..scene.view import View
from ..techniques.labels import resolved
from ..text.checks import renderer_of, whole
from .evaluate import fitted

if TYPE_CHECKING:
    from ..types import Item, RendererArgument


def predict(view: View, technique: Item | str, resolution: int = 1024, *, renderer: RendererArgument = None) -> float:
    """Wrong pixels of a technique in a view, foretold without drawing a map.

    At receivers near the edges of shadows, a pixel gets the state of some point of its texel: the share of the texel's
    points in the picture whose state is another than the pixel's is the chance that it is wrong. Receivers in shadow
    outside all maps are wrong. Bias and casters thinner than a pixel are not in it, so the level can be off by a
    factor of two; the order of techniques mostly is right.

    Parameters
    ----------
    view : View
        Its `samples` say what is in shadow, by one uniform map of 1024 x 1024 texels.
    technique : str, Technique, Preset or Parameterization
        As `sl.technique` takes it.
    resolution : int
        Texels along each side of the maps.
    renderer : Renderer or str, optional
        What draws the view's G-buffer.

    Returns
    -------
    float
        Pixels of the view; the sum over its lights.

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
    if not isinstance(view, View):
        raise ArgumentError(
            f"view: expected a View, got {type(view).__name__}; sl.View(scene, camera, light) makes one"
        )
    item, side, draw = resolved(technique), whole("resolution", resolution), renderer_of(renderer)
    wrong = 0.0
    for one in view.views:
        p = fitted(item, one, side, draw)
        wrong += _core.predict_wrong(cast("_core.Samples", one.samples(renderer=draw)), p, resolution=side)
    return wrong
