"""Why two tracers may answer differently for one ray: decided against all triangles in double precision.

Embree computes in single precision, so its vertices and intersections are off by a few units of 2^-24 of the
coordinates that take part. A ray that passes within that reach of an edge of a triangle may hit or miss it; one that
starts or ends within that reach of a triangle may be blocked by it or not. Nothing else excuses a difference.
"""

from __future__ import annotations

import numpy as np

DIFFERING_SHARE = 2e-4
"""Rays of an image that may differ: 0.02 %."""

# Rounding of a vertex and of a ray's origin, and the operations of Embree's robust test ([woop2013]: products and
# differences of translated coordinates), each half a unit of 2^-23 of the scene's size at most.
_SINGLE_PRECISION_ERROR = 16 * 2.0**-24

# Coordinates of magnitude d / 2 round by 2^-25 d each, those of a ray's origin and those of the triangle it starts on:
# sqrt(3) times two of that is how far the origin may come to lie on the wrong side.
_ORIGIN_ERROR = 2 * 2.0**-24


def single_precision_reach(vertices, origins) -> float:
    """Distance below which single precision cannot tell apart positions in a scene seen from these origins."""
    vertices, origins = np.asarray(vertices), np.asarray(origins)
    low = np.minimum(vertices.min(axis=0), origins.min(axis=0))
    high = np.maximum(vertices.max(axis=0), origins.max(axis=0))
    return _SINGLE_PRECISION_ERROR * float(np.linalg.norm(high - low))


def single_precision_lift(vertices) -> float:
    """Distance to move a point off its triangle so that rounding point and triangle leaves it on that side."""
    return _ORIGIN_ERROR * float(np.linalg.norm(np.ptp(vertices, axis=0)))


def pixel_rays(camera, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """(H * W, 3) origins and unit directions through the centres of an image's pixels, rows from the top."""
    width, height = size
    x = 2 * (np.arange(width) + 0.5) / width - 1
    y = 1 - 2 * (np.arange(height) + 0.5) / height
    projection, view = np.asarray(camera.projection), np.asarray(camera.view)
    rays_view = np.empty((height, width, 3))
    rays_view[..., 0] = x / projection[0, 0]
    rays_view[..., 1] = y[:, None] / projection[1, 1]
    rays_view[..., 2] = -1
    rays_view /= np.linalg.norm(rays_view, axis=2, keepdims=True)
    directions = rays_view.reshape(-1, 3) @ view[:3, :3]
    eye = -view[:3, :3].T @ view[:3, 3]
    return np.broadcast_to(eye, directions.shape).copy(), directions


def ray_meets(origin, direction, triangles, reach: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Triangles that one ray's line meets when each is taken `reach` larger: (low, high, on_edge).

    The meeting lies between `low` and `high` lengths of the direction; `on_edge` says that the line passes within
    `reach` of the triangle's outline, inside or outside, so that the triangle may be hit or missed.
    """
    corner = triangles - origin
    # Only triangles whose box the line comes near, seen along the axis of the ray's largest component.
    axis = int(np.argmax(np.abs(direction)))
    across = [k for k in range(3) if k != axis]
    flat = corner[..., across] - corner[..., axis, None] * (direction[across] / direction[axis])
    length = np.linalg.norm(direction)
    # The shear stretches distances across the ray by no more than this.
    margin = reach * length / abs(direction[axis])
    near = (flat.min(axis=1) <= margin).all(axis=1) & (flat.max(axis=1) >= -margin).all(axis=1)
    corner, unit = corner[near], direction / length
    side = np.roll(corner, -1, axis=1) - corner
    on_edge = np.min([_line_to_segment(unit, corner[:, k], side[:, k]) for k in range(3)], axis=0) <= reach
    turn = np.stack([np.cross(corner[:, k], corner[:, (k + 1) % 3]) @ unit for k in range(3)], axis=1)
    inside = (turn >= 0).all(axis=1) | (turn <= 0).all(axis=1)
    normal = np.cross(side[:, 0], side[:, 1])
    facing, height = normal @ unit, np.einsum("ij,ij->i", normal, corner[:, 0])
    first, last = (corner @ unit).min(axis=1), (corner @ unit).max(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        middle = np.clip(np.where(facing != 0, height / facing, 0.5 * (first + last)), first, last)
        # A shift of the plane by `reach` moves the meeting by this much; seen edge-on, anywhere along the triangle.
        spread = np.where(facing != 0, reach * np.linalg.norm(normal, axis=1) / np.abs(facing), np.inf)
    low, high = np.maximum(middle - spread, first - reach), np.minimum(middle + spread, last + reach)
    met = inside | on_edge
    return low[met] / length, high[met] / length, on_edge[met]


def _line_to_segment(unit, start, side) -> np.ndarray:
    """(N,) distance between the line through the origin along `unit` and the segments start + s side, 0 <= s <= 1."""
    # Seen along the line, each segment lies in a plane; the nearest point to the origin there.
    a = start - np.outer(start @ unit, unit)
    d = side - np.outer(side @ unit, unit)
    squared = np.einsum("ij,ij->i", d, d)
    s = np.clip(-np.einsum("ij,ij->i", a, d) / np.where(squared > 0, squared, 1), 0, 1)
    return np.linalg.norm(a + s[:, None] * d, axis=1)


def unexplained_hits(origins, directions, ours, theirs, triangles, reach: float) -> list[str]:
    """What is wrong with the first hits `ours` or `theirs`, distances in lengths of the direction, infinite for
    none."""
    found = []
    for origin, direction, a, b in zip(origins, directions, ours, theirs, strict=True):
        low, high, on_edge = ray_meets(origin, direction, triangles, reach)
        # Nothing behind a hit that cannot be missed can be the first.
        last = high[~on_edge & (low > 0)].min(initial=np.inf)
        for name, t in (("ours", a), ("theirs", b)):
            possible = np.isinf(last) if np.isinf(t) else t <= last and ((low <= t) & (t <= high)).any()
            if not possible:
                found.append(f"{name} {t:.9g} where {np.column_stack([low, high])[:4]} is met, edges {on_edge[:4]}")
    return found


def unexplained_occlusions(origins, directions, t_max, triangles, reach) -> list[str]:
    """Rays whose occlusion between 0 and `t_max` is certain, so that two tracers have to agree on it.

    `reach` is one number or one a ray.
    """
    found = []
    reach = np.broadcast_to(reach, len(origins))
    for origin, direction, end, near in zip(origins, directions, t_max, reach, strict=True):
        low, high, on_edge = ray_meets(origin, direction, triangles, near)
        slack = near / np.linalg.norm(direction)
        blocked = (~on_edge & (low > slack) & (high < end - slack)).any()
        free = not ((high >= -slack) & (low <= end + slack)).any()
        if blocked or free:
            answer = "blocked" if blocked else "free"
            found.append(f"{answer} for certain, end {end:.9g}: met at {np.column_stack([low, high])[:4]}")
    return found
