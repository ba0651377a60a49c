"""Alpha tests of other programs' meshes: materials of trimesh and pyrender whose alpha mode is MASK.

Known by their attributes, as all of their objects. Both have the origin of texture coordinates at the lower left
corner of the image, glTF and we at the upper left.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .alpha_test import CUTOFF, WRAP_OF, AlphaTest, Wrap, alpha_of_image


def alpha_of_trimesh(geometry: Any, notes: list[str], name: str) -> AlphaTest | None:
    """The alpha test of a trimesh mesh; None where its material has none. What was left out is noted."""
    visual = getattr(geometry, "visual", None)
    return _alpha(getattr(visual, "material", None), getattr(visual, "uv", None), geometry.vertices, notes, name)


def alpha_of_primitive(primitive: Any, notes: list[str], name: str) -> AlphaTest | None:
    """The alpha test of a pyrender primitive; None where its material has none. What was left out is noted."""
    uv = getattr(primitive, "texcoord_0", None)
    return _alpha(getattr(primitive, "material", None), uv, primitive.positions, notes, name)


def _alpha(material: Any, uv: Any, vertices: Any, notes: list[str], name: str) -> AlphaTest | None:
    if getattr(material, "alphaMode", None) != "MASK":
        return None
    texture, wrap = _texture(getattr(material, "baseColorTexture", None))
    count = len(vertices)
    if uv is None or np.shape(uv) != (count, 2):
        if texture is not None:
            notes.append(f"{name}: no alpha test, since its vertices have no texture coordinates")
            return None
        uv = np.zeros((count, 2))
    upper_left = (np.asarray(uv, np.float64) * [1, -1] + [0, 1]).astype(np.float32)
    cutoff = getattr(material, "alphaCutoff", None)
    try:
        return AlphaTest(texture, upper_left, CUTOFF if cutoff is None else float(cutoff), wrap, _factor(material))
    except ValueError as e:
        notes.append(f"{name}: no alpha test: {e}")
        return None


def _texture(texture: Any) -> tuple[NDArray[np.uint8] | None, tuple[Wrap, Wrap]]:
    """The alpha channel of an image, of an array or of a texture with a sampler, and how it is wrapped."""
    sampler = getattr(texture, "sampler", None)
    names = [WRAP_OF.get(getattr(sampler, side, None) or 10497, "repeat") for side in ("wrapS", "wrapT")]
    wrap = names[0], names[1]
    source = getattr(texture, "source", texture)
    if source is None:
        return None, wrap
    if hasattr(source, "getchannel"):
        return alpha_of_image(source), wrap
    pixels = np.asarray(source)
    if pixels.ndim != 3 or pixels.shape[2] not in (2, 4):
        return None, wrap
    alpha = pixels[:, :, -1]
    if alpha.dtype.kind == "f":
        alpha = np.rint(255 * np.clip(alpha, 0, 1))
    return alpha.astype(np.uint8), wrap


def _factor(material: Any) -> float:
    """The alpha of a colour of four numbers: of bytes, or of shares of one."""
    colour = getattr(material, "baseColorFactor", None)
    values = np.asarray(1.0 if colour is None else colour)
    if values.shape != (4,):
        return 1.0
    return float(values[3]) / (255 if values.dtype.kind in "iu" and values.max() > 1 else 1)
