"""Alpha tests: which points of a mesh's triangles exist, by the alpha of a texture. Leaves and fences are made so."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, TypeVar, get_args

import numpy as np
import numpy.typing as npt

from ..errors import ArgumentError
from ..text.arrays import bounded, checked_array, checked_number
from ..text.words import shown
from ..travel import Value

#: How texture coordinates outside [0, 1] are read: the image again, mirrored every second time, or its edge.
Wrap: TypeAlias = Literal["repeat", "mirror", "clamp"]
WRAPS: tuple[Wrap, ...] = get_args(Wrap)

# Wrapping modes as OpenGL and glTF number them.
WRAP_OF: dict[int, Wrap] = {10497: "repeat", 33648: "mirror", 33071: "clamp"}
# Of a material that names none, as in glTF.
CUTOFF = 0.5

S = TypeVar("S", bound=np.generic)

# Texels along a side: what fits into 32 bits.
LONGEST_SIDE = 2**31 - 1


@dataclass(frozen=True, eq=False)
class AlphaTest(Value):
    """Which points of a mesh's triangles exist: those whose alpha is at least a cutoff.

    The alpha of a point is `factor` times the texture's, which is weighted bilinearly between the centres of its
    texels, at full size: glTF's ``alphaMode`` ``"MASK"`` as a viewer without mipmaps draws it. What does not exist
    casts no shadow and is not seen, in maps, G-buffers and truth alike.

    Parameters
    ----------
    texture : (H, W) uint8, optional
        Alpha by texel, 255 opaque; row 0 is the top of the image. None: 1 all over.
    uv : (V, 2) array_like of float
        Texture coordinates of each vertex of the mesh, kept as float32. (0, 0) is the upper left corner of the image,
        as in glTF; v grows downwards.
    cutoff : float
        Least alpha that exists, at least 0. Above 1 nothing does, unless `factor` is above 1.
    wrap : pair of {"repeat", "mirror", "clamp"}
        How coordinates outside [0, 1] are read, along u and v.
    factor : float
        What the texture's alpha is multiplied with, at least 0.

    Raises
    ------
    ArgumentError
        For a texture that is not of uint8 or has no texel, coordinates that are not finite, and numbers and names
        outside of the above.

    References
    ----------
    glTF 2.0 specification, sections 3.9.4 (alpha coverage) and 3.8.4 (samplers).

    Examples
    --------
    A square that exists only where its texture is opaque, on the left:

    >>> import numpy as np
    >>> import shadowlab as sl
    >>> corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> half = sl.AlphaTest(np.array([[255, 0]], np.uint8), uv=[[0, 1], [1, 1], [1, 0], [0, 0]])
    >>> scene = sl.Scene.from_arrays(corners, [[0, 1, 2], [0, 2, 3]], alpha=half)
    >>> sl.trace.occluded(scene, [[0.3, 0.5, 1], [0.7, 0.5, 1]], [[0, 0, -1], [0, 0, -1]])
    array([ True, False])
    """

    texture: npt.NDArray[np.uint8] | None
    uv: npt.NDArray[np.float32]
    cutoff: float = CUTOFF
    wrap: tuple[Wrap, Wrap] = ("repeat", "repeat")
    factor: float = 1.0

    def __post_init__(self) -> None:
        checked: dict[str, Any] = {
            "texture": None if self.texture is None else _levels(self.texture),
            "uv": _coordinates(self.uv),
            "cutoff": _level("cutoff", self.cutoff),
            "wrap": _wrap(self.wrap),
            "factor": _level("factor", self.factor),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        size = "None" if self.texture is None else "x".join(map(str, reversed(self.texture.shape)))
        return (
            f"AlphaTest(texture={size}, uv of {len(self.uv)} vertices, cutoff={self.cutoff:g}, wrap={self.wrap}, "
            f"factor={self.factor:g})"
        )


def alpha_of_image(image: Any) -> npt.NDArray[np.uint8] | None:
    """The alpha (H, W) of an image of Pillow; None where it has none. Palettes and the like may hold alpha, too."""
    if not ({"A", "a"} & set(image.getbands()) or "transparency" in getattr(image, "info", {})):
        return None
    return np.asarray(image.convert("RGBA").getchannel("A"), np.uint8)


def _levels(value: object) -> npt.NDArray[np.uint8]:
    try:
        found = np.asarray(bounded(value))
    except Exception:  # noqa: BLE001 - what callers give may raise whatever it likes
        found = np.empty(0)
    if found.dtype != np.uint8 or found.ndim != 2 or found.size == 0 or max(found.shape) > LONGEST_SIDE:
        raise ArgumentError(
            f"texture: expected an array (H, W) of uint8 with at least one texel, got {shown(value)} (shape "
            f"{list(found.shape)} of {found.dtype}); give the alpha channel alone, 255 for opaque"
        )
    return _kept(found)


def _coordinates(value: Any) -> npt.NDArray[np.float32]:
    found = checked_array("uv", value, np.float64, (None, 2))
    with np.errstate(over="ignore"):
        single = found.astype(np.float32)
    bad = np.flatnonzero(~np.isfinite(single).all(axis=1))
    if len(bad):
        raise ArgumentError(
            f"uv[{bad[0]}]: expected two finite numbers of single precision, got {found[bad[0]].tolist()}; give each "
            "vertex its texture coordinates"
        )
    return _kept(single)


def _kept(array: npt.NDArray[S]) -> npt.NDArray[S]:
    """A copy that nobody writes into: values are keys."""
    made = np.array(array, order="C")
    made.flags.writeable = False
    return made


def _level(name: str, value: Any) -> float:
    number = checked_number(name, value, "1 is fully opaque", "a finite number of at least 0")
    if not 0 <= number < float("inf"):
        raise ArgumentError(f"{name}: expected a finite number of at least 0, got {shown(value)}; 1 is fully opaque")
    return number


def _wrap(value: Any) -> tuple[Wrap, Wrap]:
    names = tuple(value) if type(value) in (tuple, list) else ()
    if len(names) != 2 or not all(isinstance(name, str) and name in WRAPS for name in names):
        known = ", ".join(map(repr, WRAPS))
        raise ArgumentError(f"wrap: expected two of {known}, got {shown(value)}; name one for u and one for v")
    return names
