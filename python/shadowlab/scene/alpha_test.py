"""What alpha-tested materials are made of: where a texture lets light through."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class AlphaTest:
    """Which points of a mesh are there: those whose alpha is at least the cutoff.

    Attributes
    ----------
    texture : (H, W) uint8, optional
        Alpha, row 0 at v = 0, 255 for opaque. None where alpha is `factor` everywhere.
    uv : (V, 2) float32
        Texture coordinates of the vertices, v downwards as in glTF.
    cutoff : float
        In [0, 1].
    wrap : (str, str)
        What lies beyond [0, 1] along u and v: "repeat", "mirror" or "clamp".
    factor : float
        Multiplies the texture.
    """

    texture: NDArray[np.uint8] | None
    uv: NDArray[np.float32]
    cutoff: float
    wrap: tuple[str, str]
    factor: float
