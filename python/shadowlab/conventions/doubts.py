"""Whether a matrix from elsewhere can be a shadow map of a light: what `compare` says about matrices it did not make.

A shadow_clip_from_world here acts on column vectors, has x, y in [-1, 1] and z in [0, 1], and its depth grows away from
the light. All points of one ray of the light have one place in the map, so x / w and y / w do not change along it: the
rows x, y and w vanish on the light's homogeneous point. Other conventions break one of these, each in its own way.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from .._core import Note

if TYPE_CHECKING:
    import numpy.typing as npt

    from .._core import GBuffer, Partition
    from ..types import Light

# The kind of note that such doubts are.
DOUBT: Final = "check_matrix"
# How far the rows may miss the light, relative to their norms on the visible scene: a tenth of a texel of the largest
# map (16384 texels over 2 units), and above what products of single-precision matrices leave (a few 2^-24).
LARGEST_RESIDUAL = 1e-5


def doubt_about(
    matrices: npt.ArrayLike, light: Light, gbuffer: GBuffer, partitions: Sequence[Partition] = ()
) -> Note | None:
    """What speaks against these matrices as maps of this light on what the camera sees; None where all is well.

    Parameters
    ----------
    matrices : (4, 4) or (K, 4, 4) array_like
        shadow_clip_from_world of the one or the several maps.
    light : DirectionalLight, SpotLight or PointLight
    gbuffer : GBuffer
        The eye view: its surfaces are the receivers.
    partitions : sequence of Partition
        The maps of the matrices, where something may follow these.

    Returns
    -------
    Note or None
        Of the kind "check_matrix".
    """
    stack = np.asarray(matrices, dtype=np.float64).reshape(-1, 4, 4)
    seen = np.asarray(gbuffer.triangle) >= 0
    if not seen.any():
        return None  # without receivers there is nothing that a map could miss
    points = np.asarray(gbuffer.position, dtype=np.float64)[seen]
    center = points.mean(axis=0)
    radius = float(np.linalg.norm(points - center, axis=1).max()) or 1.0
    # world_from_local puts the receivers into the unit ball, so that the norms of rows mean something there.
    world_from_local = np.diag([radius, radius, radius, 1.0])
    world_from_local[:3, 3] = center
    local = np.column_stack([(points - center) / radius, np.ones(len(points))])
    source = np.linalg.solve(world_from_local, np.asarray(light.point, dtype=np.float64))
    source /= np.linalg.norm(source)
    maps = stack @ world_from_local
    details: list[str] = []
    values: dict[str, float] = {}
    missed = max(residual(m, source) for m in maps)
    if not missed <= LARGEST_RESIDUAL:
        details.append("misses_light")
        values["miss"] = missed
        turned = stack.transpose(0, 2, 1) @ world_from_local
        if max(residual(m, source) for m in turned) <= LARGEST_RESIDUAL:
            details.append("transposed")
    elif falls_away(maps, source, local):
        details.append("depth_falls_away")
    clips = [local @ m.T for m in maps]
    for clip, part in zip(clips, partitions, strict=False):
        if part.post_warp != "none":
            ahead = clip[:, 3] > 0
            clip[ahead, :2] = clip[ahead, 3:] * part.project(points[ahead])[0][:, :2]
    inside = np.any([covered(clip) for clip in clips], axis=0)
    below = np.any([covered(clip, lowest=-1.0) for clip in clips], axis=0) & ~inside
    if below.any():
        details.append("depth_below_zero")
        values["share"] = 100.0 * float(below.mean())
    if not inside.any():
        details.append("nothing_in_map")
    return Note(DOUBT, details, values) if details else None


def doubts_in(notes: Iterable[Note]) -> list[str]:
    """What the notes of a map say against its matrices; empty where nothing does."""
    return [reason for note in notes if note.kind == DOUBT for reason in note.reasons]


def residual(shadow_clip_from_local: np.ndarray, source: np.ndarray) -> float:
    """The largest sine of the angle between a row x, y, w and the plane of rows that vanish on the light's point."""
    rows = shadow_clip_from_local[[0, 1, 3]]
    norms = np.linalg.norm(rows, axis=1)
    return float(np.abs(rows[norms > 0] @ source / norms[norms > 0]).max(initial=0.0))


def falls_away(maps: np.ndarray, source: np.ndarray, local: np.ndarray) -> bool:
    """Whether z / w of most receivers falls along the way the light travels.

    With p = (p, 1) and the light's point L = (l, l_w), a receiver moves away from the light along (l_w p - l, 0).
    """
    away = np.column_stack([source[3] * local[:, :3] - source[:3], np.zeros(len(local))])
    falling = growing = 0
    for m in maps:
        z, w = local @ m[2], local @ m[3]
        slope = (away @ m[2]) * w - z * (away @ m[3])  # the derivative of z / w, times w squared
        falling += int(np.count_nonzero((w > 0) & (slope < 0)))
        growing += int(np.count_nonzero((w > 0) & (slope > 0)))
    return falling > growing


def covered(clip: np.ndarray, lowest: float = 0.0) -> np.ndarray:
    """Which points (N, 4) in shadow clip space lie in the map, with depths from `lowest` to 1."""
    x, y, z, w = clip.T
    result: np.ndarray = (w > 0) & (np.abs(x) <= w) & (np.abs(y) <= w) & (lowest * w <= z) & (z <= w)
    return result
