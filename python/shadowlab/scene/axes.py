"""The axis that points up in files and scenes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ..errors import ArgumentError
from ..text import shown
from ..text.arrays import checked_array
from ..text.checks import UP_AXES

if TYPE_CHECKING:
    from ..types import Up

#: Turns z-up coordinates (x, y, z) into y-up ones (x, z, -y): a rotation, so handedness stays.
Y_UP_FROM_Z_UP = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])

#: The same for x-up coordinates of COLLADA, whose right is -y and whose front is z: (x, y, z) becomes (-y, x, z).
Y_UP_FROM_X_UP = np.array([[0.0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])


def up_axis(up: str) -> int:
    """Index of the axis that points up.

    Raises
    ------
    ArgumentError
        For another word.
    """
    if not isinstance(up, str) or up not in UP_AXES:
        raise ArgumentError(f"up: expected 'y' or 'z', got {shown(up)}; name the axis that points up")
    return 1 if up == "y" else 2


def up_keyword(up: Up) -> str:
    """What a recipe says of an axis that is not the usual one."""
    return f", up={up!r}" if up != "y" else ""


def turned(vectors: npt.ArrayLike, *, up: Up) -> npt.NDArray[np.float64]:
    """Points or directions of a file with this up axis, in the y-up coordinates of the loaded scene.

    Parameters
    ----------
    vectors : (..., 3) array_like
    up : {"y", "z"}
        The file's up axis, as given to `load_scene`.
    """
    v: npt.NDArray[np.float64] = checked_array("vectors", vectors)
    if v.ndim < 1 or v.shape[-1] != 3:
        raise ArgumentError(f"vectors: expected shape (..., 3), got {v.shape}; give x, y and z of each")
    v = v.copy()
    return np.einsum("ij,...j->...i", Y_UP_FROM_Z_UP[:3, :3], v) if up_axis(up) == 2 else v
