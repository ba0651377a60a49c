"""Maps that are an affine map of ours: a tile of an atlas, another crop, a turn, a bias matrix applied twice.

With m the place of a point in our NDC and q that in theirs, q = L m + o.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from .convention import NDC_RANGE, TEXTURE_RANGE, Convention
from .fields import Tiles
from .pair import SAME_TEXELS, Explanation, Pair, Seen, affine_fit, undone, with_texture_range, words_of

# An atlas of shadow maps has at most this many tiles along a side, and tiles at most this border, in whole texels:
# of the crops that fit into a map only these places are more likely a tile than another map.
TILES_ALONG = 8
LARGEST_BORDER = 8
# Mistakes that are crops.
BIAS_TWICE = "a bias matrix applied twice to x and y"
TWICE_EXTENT = "twice the extent, a radius taken for a diameter?"
HALF_EXTENT = "half the extent, a diameter taken for a radius?"


def affine_of(pair: Pair, seen: Seen) -> tuple[np.ndarray, np.ndarray] | None:
    """(K, 2, 2) and (K, 2) with q = L m + o in every map, where that holds to the tolerance."""
    maps, offsets = [], []
    for k in range(len(pair.ours)):
        here = pair.map_of == k
        solution, left, rank = affine_fit(pair.ndc[here, :2], seen.q[here, :2])
        # Our texels are as large in theirs as the least stretch of the map makes them.
        stretch = np.linalg.svd(solution[:2], compute_uv=False).min()
        if rank < 3 or not left * pair.half <= SAME_TEXELS * stretch:
            return None
        maps.append(solution[:2].T)
        offsets.append(solution[2])
    return np.array(maps), np.array(offsets)


def tiles(pair: Pair, seen: Seen, maps: np.ndarray, offsets: np.ndarray) -> Iterator[Explanation]:
    """A tile for each map: the one that was named, or tiles of a regular atlas of textures."""
    scales = maps[:, [0, 1], [0, 1]]
    if not (np.all(scales[:, 0] * scales[0, 0] > 0) and np.all(scales[:, 1] * scales[0, 1] > 0)):
        return
    x, y = "right" if scales[0, 0] > 0 else "left", "up" if scales[0, 1] > 0 else "down"
    ranges = (TEXTURE_RANGE,) if pair.tile is None else (TEXTURE_RANGE, NDC_RANGE)
    for low, high in ranges:
        start = (offsets - np.abs(scales) - low) / (high - low)
        size = 2.0 * np.abs(scales) / (high - low)
        # As near as a texel's part of the atlas is known.
        known = SAME_TEXELS / (2.0 * pair.half) * size.max()
        tile: Tiles | None = pair.tile
        if tile is None:
            tile = regular_tiles(start, size, round(2.0 * pair.half), float(known))
            if tile is None or twice_biased(scales, offsets, pair.half):
                continue
        convention = seen.convention.changed(xy_range=(low, high), x=x, y=y, tile=tile)
        left = float(np.abs(undone(convention, seen.q, pair.map_of) - pair.ndc[:, :2]).max()) * pair.half
        if left > SAME_TEXELS:
            continue
        # A bias matrix comes with most tiles.
        cost = seen.cost + (3 if low == 0.0 else 4) + 2 * (x == "left") + (y == "down")
        yield Explanation(convention, words_of(convention), left, 0.0, True, cost=cost)


def regular_tiles(start: np.ndarray, size: np.ndarray, texels: int, known: float) -> Tiles | None:
    """The tile or tiles of an atlas of equal tiles; None where some map is nowhere in one, or fills it."""
    found = []
    for (u, v), (width, height) in zip(start, size, strict=True):
        across, up = tile_along(u, width, texels, known), tile_along(v, height, texels, known)
        if across is None or up is None:
            return None
        found.append((across[0], up[0], across[1], up[1]))
    if all(width == 1.0 and height == 1.0 for _, _, width, height in found):
        return None
    return found[0] if len(set(found)) == 1 else tuple(found)


def tile_along(start: float, size: float, texels: int, known: float) -> tuple[float, float] | None:
    """Start and size of a tile along one axis, with a border of whole texels around the map."""
    for count, border in itertools.product(range(1, TILES_ALONG + 1), range(LARGEST_BORDER + 1)):
        whole = texels + 2 * border
        own = texels / (count * whole)
        index = round(start * count - border / whole)
        place = (index + border / whole) / count
        if abs(own - size) <= known and abs(place - start) <= known and 0 <= index < count:
            return place, own
    return None


def twice_biased(scales: np.ndarray, offsets: np.ndarray, half: float) -> bool:
    """Whether x and y went through a bias matrix twice: .5 (.5 m + .5) + .5, or with y turned down each time."""
    twice = [(0.25, 0.75), (0.25, 0.25)]
    across = np.abs(np.concatenate([scales[:, 0] - 0.25, offsets[:, 0] - 0.75])).max()
    up = min(np.abs(np.concatenate([scales[:, 1] - a, offsets[:, 1] - b])).max() for a, b in twice)
    return bool(max(across, up) * half <= SAME_TEXELS)


def crop(pair: Pair, seen: Seen, maps: np.ndarray, offsets: np.ndarray) -> Explanation:
    """Another crop of the same map: its size, and its shift in texels, once flips are undone."""
    scales = maps[:, [0, 1], [0, 1]]
    flips = {"x": "right" if scales[0, 0] > 0 else "left", "y": "up" if scales[0, 1] > 0 else "down"}
    convention: Convention = seen.convention.changed(**flips)
    convention = with_texture_range(convention, np.abs(scales), offsets, pair.half)
    place = undone(convention, seen.q)
    left = float(np.abs(place - pair.ndc[:, :2]).max()) * pair.half
    words = [crop_words(pair, place, k) for k in range(len(pair.ours))]
    if len(set(words)) == 1:
        words = [f"another crop: {words[0]}"] if words[0] else []
    else:
        words = [f"map {k}: {text}" for k, text in enumerate(words) if text]
    if twice_biased(scales, offsets, pair.half):
        u, v = ((offsets - np.abs(scales))[0]).round(2) + 0.0  # no negative zero
        words = [
            f"{BIAS_TWICE}, or a tile of an atlas: "
            f"{u:g}, {v:g}, 0.5, 0.5 (u, v, width, height); name the tile if it is one"
        ]
    mistaken = any(name in text for text in words for name in (BIAS_TWICE, TWICE_EXTENT, HALF_EXTENT))
    words = [*words_of(convention), *words]
    cost = seen.cost + len(words_of(convention)) - len(words_of(seen.convention)) + 4
    return Explanation(convention, tuple(words), left, 0.0, left <= SAME_TEXELS, cost=cost, mistaken=mistaken)


def crop_words(pair: Pair, place: np.ndarray, k: int) -> str:
    """What map k is scaled and shifted by."""
    here = pair.map_of == k
    scales, shifts = np.array([np.polyfit(pair.ndc[here, axis], place[here, axis], 1) for axis in (0, 1)]).T
    parts = []
    for name, scale, shift in zip("xy", scales, shifts, strict=True):
        moved = f"shifted by {shift * pair.half:.3g} texels" if abs(shift) * pair.half > SAME_TEXELS else ""
        grown = f"scaled by {scale:.6g}" if abs(scale - 1.0) * pair.half > SAME_TEXELS else ""
        if moved or grown:
            parts.append(f"{name} {' and '.join(filter(None, (grown, moved)))}")
    text = ", ".join(parts)
    if np.abs(shifts).max() * pair.half <= SAME_TEXELS:
        if np.abs(scales - 0.5).max() * pair.half <= SAME_TEXELS:
            text += f": {TWICE_EXTENT}, or in {pair.whose} {HALF_EXTENT}"
        elif np.abs(scales - 2.0).max() * pair.half <= SAME_TEXELS:
            text += f": {HALF_EXTENT}, or in {pair.whose} {TWICE_EXTENT}"
    return text


def turned_map(pair: Pair, seen: Seen, maps: np.ndarray, offsets: np.ndarray) -> Explanation:
    """The same map, turned in its plane, or stretched askew."""
    mirrored = bool(np.linalg.det(maps[0]) < 0)
    convention: Convention = seen.convention.changed(y="down" if mirrored else "up")
    stretches = np.array([np.linalg.svd(m, compute_uv=False) for m in maps])
    convention = with_texture_range(convention, stretches, offsets, pair.half)
    left = float(np.abs(undone(convention, seen.q) - pair.ndc[:, :2]).max()) * pair.half
    words = []
    for m, (most, least) in zip(maps, stretches, strict=True):
        upright = np.diag([1.0, -1.0]) @ m if mirrored else m
        if (most - least) * pair.half > SAME_TEXELS * most:
            words.append("turned or sheared in its plane")
        else:
            angle = np.degrees(np.arctan2(upright[1, 0], upright[0, 0]))
            words.append(f"turned by {angle:.4g}° in its plane: another up for the light")
    own = words_of(convention)
    cost = seen.cost + len(own) - len(words_of(seen.convention)) + 5
    return Explanation(convention, (*own, *dict.fromkeys(words)), left, 0.0, False, cost=cost)
