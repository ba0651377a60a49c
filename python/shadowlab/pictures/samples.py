"""Samples in the eye's view: where they are in the picture, and their colours."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..trace import Truth
from .eye import shade, truth_mask

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._core import Camera, GBuffer
    from ..types import Light

# Two colours of [okabe2008]: by state, name and colour.
SAMPLE_STATES = {Truth.SHADOW: ("in shadow", "#D55E00"), Truth.LIT: ("lit", "#0072B2")}
# Of a pale picture: share of white.
WHITE_SHARE = 0.55


def pale_eye_view(gbuffer: GBuffer, light: Light, truth: np.ndarray) -> NDArray[np.uint8]:
    """The eye view (H, W, 3) under the true shadows, pale enough to draw on."""
    picture = shade(gbuffer, light, truth_mask(truth)).astype(np.float32)
    return np.rint(picture + WHITE_SHARE * (255.0 - picture)).astype(np.uint8)


def pixels_of(camera: Camera, size: tuple[int, int], points: np.ndarray) -> NDArray[np.float64]:
    """Where world points (N, 3) are in a picture of so many pixels (N, 2); the first pixel has its centre at (0, 0)."""
    matrix = np.asarray(camera.clip_from_world)
    clip = points @ matrix[:, :3].T + matrix[:, 3]
    x, y = clip[:, 0] / clip[:, 3], clip[:, 1] / clip[:, 3]
    return np.column_stack([(0.5 + 0.5 * x) * size[0] - 0.5, (0.5 - 0.5 * y) * size[1] - 0.5])
