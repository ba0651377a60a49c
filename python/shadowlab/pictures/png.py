"""Pictures as PNG files. Threads encode side by side: the extension lets go of the interpreter."""

from __future__ import annotations

import numpy as np

from .. import _core
from ..text.checked import a_picture, checked


@checked(picture=a_picture)
def png(picture: np.ndarray) -> bytes:
    """The picture (H, W, 3) uint8 as the bytes of a PNG file."""
    return _core.png(picture)
