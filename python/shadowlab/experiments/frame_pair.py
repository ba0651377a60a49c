"""Two frames, compared at the same points of the surfaces: where these lie in both maps, and which shadows flip.

A point that a pixel of the first frame sees is known by its instance and its place in the frame of the instance's mesh.
In the second frame it is where the instance has taken it.

```
  frame i     | . |   |      a receiver at 0.3 of its texel
  frame i+1   |   |.  |      moved by whole texels and 0.2 more: a drift of 0.2
```
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..aliasing.codes import LIT_FROM
from ..aliasing.footprint import NO_MAP
from ..aliasing.usage import look_up, texel_coordinates
from ..scene.view import View, light_of
from ..trace import Truth
from .run import Run

if TYPE_CHECKING:
    import numpy.typing as npt

    from .._core import Camera, Parameterization
    from ..types import RendererLike, ShadowMaps


# Where receivers lie anywhere in the lattice of the next frame, whatever they did in this one: the mean distance of a
# point of a square of side 1 from its centre, and its root mean square.
RANDOM_DRIFT_MEAN, RANDOM_DRIFT_RMS = 0.3825978582, 0.4082482905


class FramePair:
    """Two frames of a path: receivers of the first, where they are in the second, and what both maps make of them."""

    def __init__(self, before: View, after: View, renderer: RendererLike):
        self.frames = (before, after)
        first = second = before.gbuffer(renderer)
        moves = before.scene is not after.scene and before.scene != after.scene
        self.moving = np.zeros(np.asarray(first.triangle).shape, bool)
        if moves:
            second = _core.moved_gbuffer(first, before.scene, after.scene)
            changed = (before.scene.transforms != after.scene.transforms).any(axis=(1, 2))
            # Where nothing is there is no instance, -1; such pixels are not seen.
            self.moving = changed[first.instance]
        self.gbuffers = (first, second)
        self.seen = (np.asarray(second.triangle) >= 0) & seen_by(after.camera, second.position)
        self.steady = self.seen
        if moves or before.light != after.light:
            truths = [
                _core.shadows_at(view.scene, points, light_of(view))
                for view, points in zip(self.frames, self.gbuffers, strict=True)
            ]
            self.steady = self.seen & (truths[0] == truths[1]) & (truths[0] >= Truth.SHADOW)

    def compared(self, runs: tuple[Run, Run]) -> dict[str, Any]:
        """A row of the table."""
        texels, which, masks = [], [], []
        for view, points, run in zip(self.frames, self.gbuffers, runs, strict=True):
            looks = (points, view.camera, light_of(view), cast("Parameterization", run.parameterization))
            texel, chosen = texel_coordinates(*looks, resolution=run.resolution)
            masks.append(look_up(cast("ShadowMaps", run.maps), *looks, **run.read._asdict()))
            texels.append(texel)
            which.append(chosen)
        facing = self.seen & (which[0] >= NO_MAP) & (which[1] >= NO_MAP)
        held = facing & (which[0] >= 0) & (which[1] >= 0)
        same = held & (which[0] == which[1])
        # Held by no map in either frame a receiver is lit in both: nothing is judged by it.
        judged = self.steady & facing & ((which[0] >= 0) | (which[1] >= 0))
        flips = int(np.count_nonzero(((masks[0] >= LIT_FROM) != (masks[1] >= LIT_FROM)) & judged))
        count = int(np.count_nonzero(facing))
        row: dict[str, Any] = {"receivers": int(np.count_nonzero(same)), "judged": int(np.count_nonzero(judged))}
        row["flips"] = flips
        row["flip_share"] = flips / row["judged"] if row["judged"] else None
        if count:
            row["moving"] = int(np.count_nonzero(facing & self.moving)) / count
            row["switched"] = int(np.count_nonzero(held & ~same)) / count
            row["lost"] = int(np.count_nonzero(facing & ~held)) / count
        if row["receivers"]:
            row |= drift_of(texels[0][same], texels[1][same])
            row["scale"] = scale_change(texels, np.where(same, self.together(which[0]), -1))
        return row

    def together(self, which: NDArray[np.int16]) -> NDArray[np.int64]:
        """A number for each receiver, the same for those of one map whose distances are kept by what moves."""
        instance = np.asarray(self.gbuffers[0].instance, np.int64)
        found: NDArray[np.int64] = which + (1 + int(which.max())) * np.where(self.moving, 1 + instance, 0)
        return found


def drift_of(first: NDArray[np.float64], second: NDArray[np.float64]) -> dict[str, float]:
    """How far receivers have moved in the lattice: the part of their way that is no whole number of texels.

    Parameters
    ----------
    first, second : (N, 2) float64
        Their texel coordinates in two frames.

    Returns
    -------
    dict
        drift_mean, drift_rms, drift_max: lengths, texels; at most the square root of one half.
    """
    way = second - first
    drift = np.linalg.norm(way - np.rint(way), axis=-1)
    rms = float(np.sqrt(np.mean(np.square(drift))))
    return {"drift_mean": float(drift.mean()), "drift_rms": rms, "drift_max": float(drift.max())}


def scale_change(texels: list[NDArray[np.float64]], which: NDArray[np.int64]) -> float | None:
    """By how much the distance of neighbouring receivers of one map, told in texels, changes: a factor of 1 or more.

    Parameters
    ----------
    texels : two (H, W, 2) float64
        Their texel coordinates in two frames.
    which : (H, W) int
        The same for receivers of one map on what moves together, -1 where the frames ask none or not the same map.
    """
    factors = []
    for axis in (0, 1):
        pairs = (which >= 0) & (which == np.roll(which, -1, axis))
        pairs[(-1,) if axis == 0 else (slice(None), -1)] = False
        ways = [np.linalg.norm(np.roll(t, -1, axis)[pairs] - t[pairs], axis=-1) for t in texels]
        apart = (ways[0] > 0) & (ways[1] > 0)
        factors.append(np.abs(np.log(ways[1][apart] / ways[0][apart])))
    logs = np.concatenate(factors)
    return float(np.exp(logs.mean())) if logs.size else None


def seen_by(camera: Camera, points: npt.ArrayLike) -> NDArray[np.bool_]:
    """Which points (..., 3) lie in a camera's frustum."""
    clip = np.asarray(points) @ np.asarray(camera.clip_from_world)[:, :3].T + np.asarray(camera.clip_from_world)[:, 3]
    w = clip[..., 3:]
    depth, w = clip[..., 2], w[..., 0]
    inside: NDArray[np.bool_] = (
        (np.abs(clip[..., :2]) <= w[..., None]).all(axis=-1) & (depth >= 0) & (depth <= w) & (w > 0)
    )
    return inside
