"""Pictures of shadow maps, one or several: as the light sees them, side by side, and which of them each pixel asks.

All return (H, W, 3) uint8.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ..text.checked import a_count, checked, numbers_in
from .bands import packed, put_colours, row_bands
from .eye import same_size, shade
from .frustum import frustum_edges, frustum_segments, with_frustum

if TYPE_CHECKING:
    from collections.abc import Iterable

    from .._core import Camera, GBuffer, Parameterization, Partition
    from ..types import Light, ShadowMaps

# The colours of [okabe2008] in an order in which neighbours differ most, for the first eight maps and again.
MAP_RGB = (
    (86, 180, 233), (230, 159, 0), (0, 158, 115), (204, 121, 167), (240, 228, 66), (0, 114, 178), (213, 94, 0),
    (120, 120, 120),
)  # fmt: skip
# A texel without a caster.
EMPTY_RGB = (30, 33, 38)
# The colours of tones from 0 to 1, a little bluish, in steps of a sixteenth of a byte; the last is that of no caster.
RELIEF = packed(np.rint(
    np.vstack([np.linspace(0.0, 255.0, 1 << 12)[:, None] * (0.97, 0.985, 1.0), EMPTY_RGB])
).astype(np.uint8))  # fmt: skip
# Covered texels, evenly spaced, whose depths and slopes say what is common: percentiles of so many move by less than a
# byte of tone.
SAMPLED_TEXELS = 200_000
# Share of a picture's side that is the frame around it, in the map's colour.
FRAME = 0.015
# Pieces of an edge that a post-warp bends: short enough to look smooth, and longer than the line is wide.
PIECES = 48


def map_colour(index: int) -> tuple[int, int, int]:
    """The colour of a map."""
    return MAP_RGB[index % len(MAP_RGB)]


@checked(depth=numbers_in(np.float32, None, None))
def relief(depth: np.ndarray) -> np.ndarray:
    """A shadow map (H, W) as the light sees it: near is light, slopes are modelled, empty is flat and dark."""
    depth = np.asarray(depth, dtype=np.float32)
    picture = np.empty((*depth.shape, 3), np.uint8)
    places = np.flatnonzero(depth < 1.0)
    if not len(places):
        picture[...] = EMPTY_RGB
        return picture
    places = places[:: max(1, len(places) // SAMPLED_TEXELS)]
    values = depth.reshape(-1)[places]
    low, high = values_at(values, 0.005, 0.995)
    span = high - low or 1.0
    # A lamp from the upper left over the height field. The commonest slope, mostly the ground's, is taken as level, and
    # the slopes that stand out from it say how steep is steep, so no unit is assumed.
    slope = slopes(np.where(depth < 1.0, depth, np.float32(high)))
    some = slope.reshape(-1)[places]
    (level,) = values_at(some, 0.5)
    # Where all is one plane only rounding stands out; a slope through a fourth of the depths over the map is not less.
    steep = max(*values_at(np.abs(some - level), 0.85), 0.25 * span / max(depth.shape))
    for rows in row_bands(depth.shape):
        tone = 0.86 - 0.52 * ((np.clip(depth[rows], low, low + span) - low) / span)
        tone = np.clip(tone + 0.16 * np.tanh((slope[rows] - level) / (2.0 * steep)), 0.0, 1.0)
        place = np.where(depth[rows] < 1.0, tone * (len(RELIEF) - 2) + 0.5, len(RELIEF) - 1)
        put_colours(picture[rows], RELIEF, place.astype(np.int32))
    return picture


def values_at(values: np.ndarray, *shares: float) -> list[float]:
    """The values (N,) that so many of all do not exceed. `np.percentile` loads masked arrays, which takes longer."""
    places = [round(share * (len(values) - 1)) for share in shares]
    ordered = np.partition(values, places)
    return [float(ordered[place]) for place in places]


def slopes(height: np.ndarray) -> np.ndarray:
    """The slope (H, W) towards the lower right, per texel: central differences, one-sided ones at the edges."""
    slope = np.empty_like(height)
    for rows in row_bands(height.shape):
        # With the rows beside the band.
        first, last = max(0, rows.start - 1), min(height.shape[0], rows.stop + 1)
        inner = slice(rows.start - first, rows.stop - first)
        gy, gx = np.gradient(height[first:last]) if min(height.shape) > 1 else (np.zeros_like(height[first:last]),) * 2
        slope[rows] = (gx + gy)[inner]
    return slope


@checked(depth=numbers_in(np.float32, None, None), side=a_count(1, 1 << 30))
def reduced(depth: np.ndarray, side: int) -> np.ndarray:
    """The map with at most `side` texels along each edge: the nearest depth of each block, so thin casters stay."""
    height, width = depth.shape
    step = max(1, -(-max(height, width) // side))
    if step == 1:
        return depth
    padded = np.pad(depth, ((0, -height % step), (0, -width % step)), constant_values=1.0)
    blocks = padded.reshape(padded.shape[0] // step, step, padded.shape[1] // step, step)
    nearest: np.ndarray = blocks.min(axis=(1, 3))
    return nearest


def served_depths(partition: Partition, camera: Camera) -> tuple[float, float] | None:
    """The camera depths that a map serves; None where it serves all that the camera sees."""
    begin, end = partition.eye_depth
    if begin <= 0 and math.isinf(end):
        return camera.near, camera.far  # of a matrix that is not known to be a part of several
    near, far = (min(max(depth, camera.near), camera.far) for depth in (begin, end))
    return (near, far) if near < far else None


def map_picture(
    depth: np.ndarray, partition: Partition, camera: Camera, side: int = 1024, *, depths: Iterable[float] | None = None
) -> np.ndarray:
    """A shadow map as the light sees it, with the camera frustum, at most `side` pixels along each edge.

    `depths` are the camera depths that the frustum is drawn for; its near and far planes where none are given.
    """
    small = reduced(np.asarray(depth), side)
    return with_frustum(relief(small), frustum_in(partition, camera, depths))


def frustum_in(partition: Partition, camera: Camera, depths: Iterable[float] | None = None) -> np.ndarray:
    """The camera frustum's edges inside a map: (N, 2, 2) x, y of both ends; in pieces where a post-warp bends them."""
    matrix = np.asarray(partition.matrix, dtype=np.float64)
    if partition.post_warp == "none":
        return frustum_segments(matrix, camera, depths)
    segments = []
    if depths is None and math.isinf(camera.far):
        depths = (camera.near, partition.eye_depth[1])
    for a, b in frustum_edges(camera, depths):
        share = even_in_log(float(matrix[3] @ a), float(matrix[3] @ b))[:, None]
        ndc, w = partition.project(((1.0 - share) * a + share * b)[:, :3])
        ahead = w > 0
        places = np.where(ahead[:, None], ndc[:, :2], 0.0)
        # The ends of a fitted map lie on its edge, but for rounding.
        inside = ahead & (np.abs(places) <= 1.0 + 16.0 * np.finfo(np.float64).eps).all(axis=1)
        places = np.clip(places, -1.0, 1.0)
        both = inside[:-1] & inside[1:]
        segments.append(np.stack([places[:-1][both], places[1:][both]], axis=1))
    return np.concatenate(segments).reshape(-1, 2, 2)


def even_in_log(start: float, end: float) -> np.ndarray:
    """(PIECES + 1,) places from 0 to 1 between two values of w, even in its logarithm, and so in the map."""
    even = np.linspace(0.0, 1.0, PIECES + 1)
    if not (start > 0 and end > 0) or np.isclose(start, end):
        return even
    return np.asarray(np.expm1(even * np.log(end / start)) / (end / start - 1.0))


def pictures_of(maps: ShadowMaps, p: Parameterization, camera: Camera, side: int) -> list[np.ndarray]:
    """Maps, each with the part of the camera frustum that it serves, framed in its colour if several."""
    return [layer_picture(maps, p, camera, side, i) for i in range(len(p.partitions))]


def layer_picture(maps: ShadowMaps, p: Parameterization, camera: Camera, side: int, index: int) -> np.ndarray:
    """The picture of one of the maps."""
    several, part = len(p.partitions) > 1, p.partitions[index]
    layer = maps[index] if maps.ndim == 3 else maps
    picture = map_picture(layer, part, camera, side, depths=served_depths(part, camera) if several else None)
    return framed(picture, map_colour(index)) if several else picture


def framed(picture: np.ndarray, colour: tuple[int, int, int]) -> np.ndarray:
    """The picture with a frame of this colour over its edge."""
    width = max(1, round(FRAME * max(picture.shape[:2])))
    made = picture.copy()
    for edge in (made[:width], made[-width:], made[:, :width], made[:, -width:]):
        edge[...] = colour
    return made


def mosaic(pictures: list[np.ndarray]) -> np.ndarray:
    """Pictures of one size in as many columns as rows or one more, row after row, on white."""
    columns = math.ceil(math.sqrt(len(pictures)))
    height, width = pictures[0].shape[:2]
    gap = 0 if len(pictures) == 1 else max(1, round(FRAME * max(height, width)))
    rows = -(-len(pictures) // columns)
    made = np.full((rows * (height + gap) - gap, columns * (width + gap) - gap, 3), 255, np.uint8)
    for i, picture in enumerate(pictures):
        row, column = divmod(i, columns)
        made[row * (height + gap) :, column * (width + gap) :][:height, :width] = picture
    return made


def chosen_picture(gbuffer: GBuffer, light: Light, mask: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """The eye view in the colours of the maps that its pixels ask; grey where they ask none.

    Parameters
    ----------
    mask : (H, W) float
        Share of the light that arrives.
    chosen : (H, W) int
        From `Renderer.chosen_map`; -1 for none.
    """
    chosen = np.asarray(chosen)
    same_size(gbuffer, chosen=chosen)
    picture = shade(gbuffer, light, mask)
    grey = picture.astype(np.float32) @ np.array([0.2126, 0.7152, 0.0722], np.float32)
    colours = np.array([*MAP_RGB, (200, 200, 200)], np.float32)
    index = np.where(chosen >= 0, chosen % len(MAP_RGB), len(MAP_RGB))
    # Shadows stay readable, and the colour of a dark pixel too.
    tinted = colours[index] * (0.35 + 0.65 * grey / 255.0)[..., None]
    seen = np.asarray(gbuffer.triangle) >= 0
    result: np.ndarray = np.where(seen[..., None], np.rint(tinted).astype(np.uint8), picture)
    return result
