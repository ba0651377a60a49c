"""The difference between two shadow matrices by its name: a convention, another crop, another warp, another light.

Both are taken to map coordinates at the same points of the world. A convention is tried by what it does to coordinates;
of all that leave nothing over, the simplest is told. What no convention explains is told with its size in texels.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ..errors import ArgumentError
from ..text import shown
from ..text.arrays import checked_array, checked_items
from ..text.checked import has_all
from ..text.checks import whole
from ..travel import Value
from .account import account_of, better_of, is_same, texels_text
from .convention import Convention
from .fields import Tile, matrices_of, tiles_of
from .mistakes import mistake
from .pair import Pair, Side
from .points import points_of_map
from .search import explain

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .._core import Camera, Scene
    from ..types import Maps


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis(Value):
    """What sets a shadow matrix apart from another.

    Attributes
    ----------
    same : bool
        Whether both are one map, once they are written in one convention.
    convention : Convention
        How the matrix of `side` is written, as far as one can tell: what `convention.to_ours` makes of it is to be held
        against the other.
    differences : tuple of str
        What sets them apart, in words; nothing where the matrices are equal. Those without a name are about theirs.
    texels : float
        How far apart one point lands in both maps at the most, in texels of the other matrix, once the convention is
        undone.
    depth : float
        The same for depths, which span 0 to 1.
    side : "theirs" or "mine"
        The matrix that is written otherwise or has the mistake, as far as one can tell.
    """

    STATE_VERSION: ClassVar[int] = 2

    same: bool
    convention: Convention
    differences: tuple[str, ...]
    texels: float
    depth: float
    side: Side = "theirs"

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

    Either of the two can be ours. A convention of theirs is looked for first, then one of mine; a mistake in either has
    the same name, with the matrix that has it as far as anything says which. The `Parameterization` of a technique is
    known to be a map of the world in our convention; of an array nothing is known.

    Parameters
    ----------
    mine, theirs : Parameterization, or (4, 4) or (K, 4, 4) array_like
        As many matrices each: shadow_clip_from_world in our convention, and anybody's in any convention.
    camera : Camera, optional
        Differences are measured at the corners of its frustum, as far as the map has them; at the corners of the map's
        unit cube where these are too few. Mistakes with its matrices are named only where it is given.
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
    sides = {"mine": stack_of("mine", mine), "theirs": stack_of("theirs", theirs)}
    count, others = (len(stack) for stack, _ in sides.values())
    if count != others:
        raise ArgumentError(f"theirs: expected as many matrices as mine ({count}), got {others}; compare one by one")

    def pair(names: tuple[Side, Side], tile: Tile | Sequence[Tile] | None) -> Pair:
        (one, ranges), (other, _) = (sides[name] for name in reversed(names))
        points = [points_of_map(m, 2.0 / resolution, d, camera, scene) for m, d in zip(one, ranges, strict=True)]
        return Pair(one, other, points, resolution, None if tile is None else tiles_of(tile), names)

    theirs_first, mine_first = pair(("theirs", "mine"), tile), pair(("mine", "theirs"), None)
    # A map of the world in our convention for certain is the one that the other is held against.
    pairs = [mine_first] if is_made_here(theirs) and not is_made_here(mine) else [theirs_first]
    pairs += [mine_first] * (not is_made_here(mine) and not is_made_here(theirs))
    accounts = [account_of(pairs[0], explain(pairs[0]))]
    if not is_same(accounts[0].found):
        accounts += [account_of(each, explain(each)) for each in pairs[1:]]
    best = accounts[0] if len(accounts) == 1 else better_of(*accounts)
    if not is_same(best.found):
        named = mistake(pairs, [account.found for account in accounts], camera, scene)
        best = best if named is None else account_of(*named)
    found = best.found
    return Diagnosis(is_same(found), found.convention, best.differences, found.texels, found.depth, best.pair.who)


def is_made_here(value: object) -> bool:
    """Whether maps come from a technique, and so are maps of the world in our convention."""
    of: Any = value
    return has_all(value, "partitions") and all(part.lift is not None for part in of.partitions)


def stack_of(name: str, value: Maps) -> tuple[np.ndarray, list[tuple[float, float]]]:
    """(K, 4, 4) matrices and the camera depths of each."""
    if has_all(value, "matrices", "partitions"):
        of: Any = value
        parts = checked_items(f"{name}.partitions", of.partitions, "a list of maps", "technique.parameterize makes one")
        if not all(has_all(part, "post_warp", "eye_depth", "lift") for part in parts):
            raise ArgumentError(
                f"{name}: expected a Parameterization or matrices, got {shown(value)}; technique.parameterize makes one"
            )
        if any(part.post_warp != "none" for part in parts):
            raise ArgumentError(
                f"{name}: expected maps that are matrices alone, got one with a post-warp; "
                "hold its .matrices and what follows them against theirs"
            )
        return checked_array(f"{name}.matrices", of.matrices, shape=(len(parts), 4, 4)), [p.eye_depth for p in parts]
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
