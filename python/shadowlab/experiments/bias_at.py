"""How far a bias carries the receivers of a view towards the light."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from .. import _core
from ..scene.view import checked_view, light_of
from ..techniques.labels import resolved
from ..techniques.variant import reading
from ..text.checks import check_filter, renderer_of, whole
from .evaluate import fitted

if TYPE_CHECKING:
    from ..scene.view import View
    from ..types import Filter, RendererArgument, TechniqueArgument


def bias_at(
    bias: _core.Bias,
    view: View,
    technique: TechniqueArgument,
    resolution: int,
    renderer: RendererArgument,
    filter: Filter,
) -> npt.NDArray[np.float32]:
    """`Bias.at`."""
    checked_view(view)
    check_filter(filter)
    light = light_of(view)
    side, draw = whole("resolution", resolution), renderer_of(renderer)
    item = resolved(technique, "technique")
    read = reading(item, bias, filter, 0.0, _core.Stored())
    return _core.bias_distance(
        view.gbuffer(draw), view.camera, light, fitted(item, view, side, draw), resolution=side, bias=bias,
        filter=read.filter, stored=read.stored,
    )  # fmt: skip
