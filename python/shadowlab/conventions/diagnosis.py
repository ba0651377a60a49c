"""The difference between two shadow matrices by its name: a convention, another crop, another warp, another light.

Both are taken to map coordinates at the same points of the world. A convention is tried by what it does to coordinates;
of all that leave nothing over, the simplest is told. What no convention explains is told with its size in texels.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .. import _core
from ..errors import ArgumentError
from ..text.checks import whole
from ..travel import Value
from .convention import Convention
from .fields import Tile, matrices_of, tiles_of
from .lights import angle_between, same_light
from .mistakes import mistake
from .pair import SAME_DEPTH, Explanation, Pair
from .points import points_of_map
from .search import NO_PLACES, OPPOSITE, explain

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .._core import Camera, Scene
    from ..types import Maps

# Entries of single precision, multiplied a few times, stand a few 2^-24 apart.
SAME_SCALE = 1e-6
# Depths of theirs by slope and start of ours, where a change of the range was made once too often.
DEPTH_MISTAKES = {
    (0.5, 0.5): "depths biased by 0.5 z + 0.5 though they are in [0, 1] without: OpenGL's bias on another range",
    (0.25, 0.75): "depths biased by 0.5 z + 0.5 twice",
    (4.0, -3.0): "depths turned into [-1, 1] by 2 z - 1 twice",
}


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis(Value):
    """What sets a shadow matrix apart from another.

    Attributes
    ----------
    same : bool
        Whether both are one map, once they are written in one convention.
    convention : Convention
        How theirs is written, as far as one can tell: `convention.to_ours(theirs)` is to be held against mine.
    differences : tuple of str
        What sets them apart, in words; nothing where the matrices are equal.
    texels : float
        How far apart one point lands in both maps at the most, in texels of mine, once the convention is undone.
    depth : float
        The same for depths, which span 0 to 1.
    """

    same: bool
    convention: Convention
    differences: tuple[str, ...]
    texels: float
    depth: float

    def __str__(self) -> str:
        """One sentence."""
        if not self.differences:
            return "the matrices are equal"
        what = "the same map, written otherwise" if self.same else "not the same map"
        return f"{what}: {'; '.join(self.differences)}"

    def __repr__(self) -> str:
        return f"Diagnosis({self}; {texels_text(self.texels)} apart)"


def diagnose(
    mine: Maps,
    theirs: Maps,
    *,
    camera: Camera | None = None,
    scene: Scene | None = None,
    resolution: int = 1024,
    tile: Tile | Sequence[Tile] | None = None,
) -> Diagnosis:
    """What sets somebody's shadow matrix apart from one of ours: its convention, or a difference of so many texels.

    Parameters
    ----------
    mine : Parameterization, or (4, 4) or (K, 4, 4) array_like
        shadow_clip_from_world in our convention.
    theirs : Parameterization, or (4, 4) or (K, 4, 4) array_like
        As many matrices in any convention.
    camera : Camera, optional
        Differences are measured at the corners of its frustum, as far as mine has them in its map; at the corners of
        mine's unit cube where there is none.
    scene : Scene, optional
        Leaves away what of the frustum lies outside of the scene's bounds.
    resolution : int
        Texels along a side of the map.
    tile : (u, v, width, height), or several; optional
        Where in an atlas theirs has the map or the maps. Tiles of a regular atlas of textures are found without it; any
        other part of a map is another crop of it until it is named.

    Returns
    -------
    Diagnosis

    Raises
    ------
    ArgumentError
        For something else than matrices, another number of them, singular ones, or maps with a post-warp.

    Examples
    --------
    >>> import numpy as np, shadowlab as sl
    >>> print(sl.diagnose(np.eye(4), sl.Convention.vulkan().from_ours(np.eye(4))))
    the same map, written otherwise: y points down
    """
    resolution = whole("resolution", resolution)
    check_view(camera, scene)
    ours, depths = stack_of("mine", mine)
    others, _ = stack_of("theirs", theirs)
    if len(ours) != len(others):
        raise ArgumentError(
            f"theirs: expected as many matrices as mine ({len(ours)}), got {len(others)}; compare one by one"
        )
    points = [points_of_map(m, 2.0 / resolution, d, camera, scene) for m, d in zip(ours, depths, strict=True)]
    pair = Pair(ours, others, points, resolution, None if tile is None else tiles_of(tile))
    found = explain(pair)
    if not is_same(found):
        found = mistake(pair, found, camera) or found
    differences = (*found.differences, *scale_of(found, pair), *depth_of(found, pair))
    if not is_same(found) and not found.named:
        differences += (real_difference(found, pair),)
    return Diagnosis(is_same(found), found.convention, differences, found.texels, found.depth)


def is_same(found: Explanation) -> bool:
    """Whether an explanation leaves nothing over."""
    return found.whole and found.depth <= SAME_DEPTH


def scale_of(found: Explanation, pair: Pair) -> tuple[str, ...]:
    """A constant factor of the whole matrix, which no map shows."""
    if not found.whole:
        return ()
    # Rows of places alone: depths may have a range of their own.
    mine = pair.ours[:, [0, 1, 3]]
    other = found.convention.to_ours(pair.theirs)[:, [0, 1, 3]]
    factors = np.sum(mine * other, axis=(1, 2)) / np.sum(mine * mine, axis=(1, 2))
    if np.all(np.abs(factors - 1.0) <= SAME_SCALE):
        return ()
    texts = " and ".join(dict.fromkeys(f"{factor:.6g}" for factor in factors))
    if factors.min() < 0:
        return (f"scaled by {texts}: the same map, but w is negative, so that hardware clips all of it",)
    return (f"scaled by {texts}, which no map shows",)


def depth_of(found: Explanation, pair: Pair) -> tuple[str, ...]:
    """Depths that differ where places do not, by more than their direction."""
    if found.depth <= SAME_DEPTH or not found.crop or OPPOSITE in found.differences:
        return ()
    q = pair.project(found.convention.changed(**NO_PLACES).to_ours(pair.theirs))
    for (slope, start), words in DEPTH_MISTAKES.items():
        mine = 1.0 - pair.ndc[:, 2] if found.convention.reversed_z else pair.ndc[:, 2]
        # The check fails for infinite q too.
        if np.abs(q[:, 2] - (slope * mine + start)).max() <= SAME_DEPTH:
            return (words,)
    return (f"depths differ by up to {found.depth:.3g} of the range: other near and far planes",)


def real_difference(found: Explanation, pair: Pair) -> str:
    """A difference that no convention explains."""
    finite = np.isfinite(found.texels)
    apart = f"up to {texels_text(found.texels)} apart" if finite else "some points of mine lie behind its centre"
    if same_light(pair, found.convention):
        return f"another warp or crop of the same light: {apart}"
    angle = angle_between(pair)
    turned = "" if angle is None else f"; the directions are {angle:.3g}° apart"
    return f"another light: {apart}{turned}"


def texels_text(texels: float) -> str:
    """A number of texels, three digits where it has fewer than four before the point."""
    return f"{texels:,.0f} texels" if texels >= 100 else f"{texels:.3g} texels"


def stack_of(name: str, value: Maps) -> tuple[np.ndarray, list[tuple[float, float]]]:
    """(K, 4, 4) matrices and the camera depths of each."""
    if isinstance(value, _core.Parameterization):
        if any(part.post_warp != "none" for part in value.partitions):
            raise ArgumentError(
                f"{name}: expected maps that are matrices alone, got one with a post-warp; "
                "hold its .matrices and what follows them against theirs"
            )
        return np.asarray(value.matrices), [part.eye_depth for part in value.partitions]
    stack = matrices_of(name, value).reshape(-1, 4, 4)
    for m in stack:
        largest = np.abs(m).max(axis=1, keepdims=True)
        if np.any(largest == 0) or np.linalg.matrix_rank(m / largest) < 4:
            raise ArgumentError(
                f"{name}: expected matrices that have an inverse, got a singular one; check where it comes from"
            )
    return stack, [(0.0, np.inf)] * len(stack)


def check_view(camera: object, scene: object) -> None:
    """Raises for a camera or scene that is none."""
    from .. import _core

    if camera is not None and not isinstance(camera, _core.Camera):
        raise ArgumentError(f"camera: expected a Camera, got {type(camera).__name__}; sl.Camera.look_at makes one")
    if scene is not None and not isinstance(scene, _core.Scene):
        raise ArgumentError(f"scene: expected a Scene, got {type(scene).__name__}; sl.load_scene reads one")
