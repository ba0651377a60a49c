"""How far before what each pixel shows what shades it lies: by the light's own rays."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .. import _core

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..types import Light, TruthImage


def traced_gaps(scene: _core.Scene, light: Light, gbuffer: _core.GBuffer, truth: TruthImage) -> NDArray[np.float32]:
    """Distances (H, W) float32, world units, from what the light meets first to each point in shadow; 0 elsewhere.

    Elsewhere is what faces away from the light, too. What the light meets first is what a map holds on the ray; rays
    from the point towards the light would meet what is nearest to the point.
    """
    gaps = np.zeros(truth.shape, np.float32)
    # As `trace.Truth` has it: 0 in shadow.
    dark = (np.asarray(truth) == 0) & (np.asarray(gbuffer.triangle) >= 0)
    points = np.asarray(gbuffer.position, np.float64)[dark]
    if isinstance(light, _core.DirectionalLight):
        way = np.broadcast_to(np.asarray(light.direction, np.float64), points.shape)
        # From before the whole scene.
        low, high = np.asarray(scene.bounds, np.float64)
        far = np.full(len(points), 1.01 * float(np.linalg.norm(high - low)))
    else:
        way = points - np.asarray(light.position, np.float64)
        far = np.linalg.norm(way, axis=1)
        way = way / np.maximum(far, np.finfo(np.float64).tiny)[:, None]
    facing = np.einsum("ij,ij->i", np.asarray(gbuffer.normal, np.float64)[dark], way) < 0
    first, _, _ = _core.first_hit(scene, points - far[:, None] * way, way)
    gaps[dark] = np.where(facing, np.maximum(far - np.minimum(first, far), 0.0), 0.0)
    return gaps
