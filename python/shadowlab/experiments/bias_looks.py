"""The wrong pixels of a view over one part of a bias, by look-ups in maps that are drawn once.

A larger value of a `BiasPart` moves every receiver nearer to the light, so a pixel that is lit stays lit: with a value,
false shadow only shrinks and false light only grows. All counts here rest on that.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..aliasing.bias_parts import with_part
from ..aliasing.codes import Cause, Difference
from ..aliasing.plane_bias import plane_bias
from ..scene.view import light_of
from .drawing import drawn_as
from .evaluate import fitted

if TYPE_CHECKING:
    from ..scene.view import View
    from ..types import BiasPart, Filter, Item, RendererLike

# More than any scene needs of any part, and far from the ends of f64.
UNLIMITED = 1e30


class BiasCounts(NamedTuple):
    """Pixels with one value of a part: acne, all false shadow, and false light."""

    acne: int
    false_shadow: int
    leaks: int

    @property
    def wrong(self) -> int:
        """All wrong pixels."""
        return self.false_shadow + self.leaks

    def __add__(self, other: object) -> BiasCounts:
        if not isinstance(other, BiasCounts):
            return NotImplemented
        return BiasCounts(*(a + b for a, b in zip(self, other, strict=True)))


class BiasLooks:
    """The maps of a technique in a view with one light, and what look-ups in them find.

    Parameters
    ----------
    view : View
        With one light.
    item : Technique, Preset or Parameterization
    resolution : int
    renderer : Renderer
    part : str
    bias : Bias
        The other parts; its own `part` is 0.
    filter : str
    stored : Stored
    """

    def __init__(
        self, view: View, item: Item, resolution: int, renderer: RendererLike, part: BiasPart, bias: _core.Bias,
        filter: Filter, stored: _core.Stored,
    ):  # fmt: skip
        self.view, self.part, self.bias, self.filter = view, part, bias, filter
        self.stored = stored
        light = light_of(view)
        self.parameterization = fitted(item, view, resolution, renderer)
        self.gbuffer, self.truth = view.gbuffer(renderer), view.truth()
        self.maps = renderer.shadow_map(view.scene, self.parameterization, resolution=resolution, **drawn_as(stored))
        self._looks = (self.gbuffer, view.camera, light, self.parameterization)
        mask, self.chosen = _core.look_up(self.maps, *self._looks, bias=bias, filter=filter, stored=self.stored)
        errors = _core.misclassified(mask, self.truth)
        causes, _ = _core.causes(
            view.scene, view.camera, light, self.parameterization, errors.image,
            gbuffer=self.gbuffer, maps=self.maps, bias=bias, filter=filter, stored=self.stored,
        )  # fmt: skip
        self._can_be_acne = causes == Cause.ACNE
        #: Pixels that are compared and lit in truth, (H, W).
        self.lit = (self.truth == 1) & (errors.image != Difference.NOT_COMPARED)

    def counts(self, value: float) -> BiasCounts:
        """The wrong pixels with a value of the part."""
        bias = with_part(self.bias, self.part, value)
        mask, _ = _core.look_up(self.maps, *self._looks, bias=bias, filter=self.filter, stored=self.stored)
        errors = _core.misclassified(mask, self.truth)
        dark = errors.image == Difference.FALSE_SHADOW
        return BiasCounts(
            int(np.count_nonzero(dark & self._can_be_acne)), int(errors.false_shadow), int(errors.false_light)
        )

    def of_planes(self) -> NDArray[np.float64]:
        """What the plane of each lit pixel needs of the part, (N,), of maps that store the front; see `plane_bias`."""
        height, width = self.maps.shape[-2:]
        return plane_bias(
            *self._looks, self.chosen, self.lit, self.part, self.bias, (width, height), self.filter, self.stored
        )  # fmt: skip
