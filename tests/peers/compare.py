"""Comparison of two depth maps with a reason for every texel that differs.

Source: the fill rule of OpenGL 4.5 section 14.6.1 and of WebGPU; both leave a renderer free to snap vertices to its
sub-pixel grid, and that is the only freedom granted here.

A texel differs where the depths are more than a tolerance apart. Such a texel is explained when *each* of the two
depths could have come from the scene: some triangle with that depth covers the texel's centre, or misses it by no
more than the snapping of its vertices, and nothing that covers the centre for certain lies in front. Everything is
decided in double precision from vertices and matrix, not from the images. The reasons, in the order they are looked
for:

- `edge`: the centre lies within the snapping distance of an outline that one depth needs and the other does not;
- `thin`: a triangle narrower than a texel, whose depth at the centre moves with the snapping;
- `theirs`: ours is the triangle's exact depth, theirs is off by what single precision loses in the plane of a triangle
  that is long and narrow (llvmpipe forms the plane from differences of products);
- `cut`: ours is off by that much, in a narrow triangle that the driver cut from a larger one when it clipped it. Mesa's
  Vulkan on the processor clips at all six planes and does this; its OpenGL keeps what lies beside the map whole;
- `steep`: a wide triangle seen nearly edge-on, whose depth moves with the snapping;
- `unexplained`: none of these, a fault.
"""

from __future__ import annotations

import functools
import itertools
from dataclasses import dataclass

import numpy as np

DEPTH_TOLERANCE = 1e-5
"""Depths closer than this agree; 84 units of the last place of a float32 near 1."""

SUBPIXEL_BITS = 8
"""Bits of the sub-pixel grid: ours, llvmpipe's and every desktop GPU's."""

DIFFERING_SHARE = 1e-4
"""Texels of a map that may differ: 0.01 %."""

REASONS = ("edge", "thin", "theirs", "cut", "steep", "unexplained")

# A product of four float32 terms with rounded factors errs by at most 6 units of 2^-24 of the sum of magnitudes
# (Higham, Accuracy and Stability, 3.1: (n + 2) u); as much again for a second, different order of operations.
_DOT_PRODUCT_ERROR = 12 * 2.0**-24
# The viewport transform adds half a unit in the last place of a coordinate as large as the map.
_VIEWPORT_ERROR = 2.0**-23
# A plane's slope is a difference of two products over the area: three roundings each of the two products, one each of
# the difference and the quotient.
_PLANE_ERROR = 8 * 2.0**-24
# The share of the tolerance within which a depth counts as the exact one.
_EXACT = 0.25


@dataclass(frozen=True)
class Difference:
    """Where two maps differ and why; every array has one entry a differing texel."""

    texel_count: int
    rows: np.ndarray
    columns: np.ndarray
    ours: np.ndarray
    theirs: np.ndarray
    reason: np.ndarray

    @property
    def count(self) -> int:
        """Number of texels that differ."""
        return len(self.rows)

    @property
    def share(self) -> float:
        """Share of all texels that differ."""
        return self.count / self.texel_count

    def of(self, reason: str) -> int:
        """Number of differing texels with this reason."""
        return int((self.reason == reason).sum())

    def __str__(self) -> str:
        reasons = ", ".join(f"{self.of(r)} {r}" for r in REASONS)
        text = f"{self.count} of {self.texel_count} texels differ ({100 * self.share:.5f} %): {reasons}"
        for i in np.flatnonzero(self.reason == "unexplained")[:4]:
            text += (
                f"; row {self.rows[i]} column {self.columns[i]}: ours {self.ours[i]:.8f}, theirs {self.theirs[i]:.8f}"
            )
        return text


@dataclass(frozen=True)
class _Piece:
    """A triangle clipped to the map's volume, in texels."""

    outline: np.ndarray
    plane: np.ndarray
    snap: float
    rounding: float
    depth_error: float
    width: float
    span: float
    was_cut: bool

    @functools.cached_property
    def cuts(self) -> list[tuple[np.ndarray, float]]:
        """Narrow triangles that a driver may draw instead of the whole, each with the depth its plane loses.

        Drivers draw what is left after clipping as a fan. Where two of its corners are close together, one of the fan's
        triangles is narrower than anything in the scene.
        """
        if not self.was_cut:
            return []
        outlines = [self.outline[list(k)] for k in itertools.combinations(range(len(self.outline)), 3)]
        narrow = [(o, _width(o)) for o in outlines]
        return [(o, _plane_error(self.span, _length(o), w)) for o, w in narrow if w < self.width]

    def cut_error(self, x: float, y: float) -> float:
        """The largest depth that one of the narrow triangles may lose at a point."""
        return max((lost for o, lost in self.cuts if _distance_inside(o, x, y) >= -self.snap), default=0.0)


def compare(
    ours, theirs, vertices, faces, clip_from_world, tolerance: float = DEPTH_TOLERANCE, by_driver: bool = False
) -> Difference:
    """Where two (H, W) depth maps of the same world triangles differ, with the reason for each texel.

    Raises AssertionError where more than ten times :data:`DIFFERING_SHARE` differ: then the maps show different
    things, and a reason per texel would take long and say nothing.
    """
    ours, theirs = np.asarray(ours, np.float64), np.asarray(theirs, np.float64)
    assert ours.shape == theirs.shape, f"maps of {ours.shape} and {theirs.shape} texels"
    for name, depth in (("ours", ours), ("theirs", theirs)):
        # A comparison with NaN is false, so this refuses it too.
        assert ((depth >= 0) & (depth <= 1)).all(), f"{name}: depths outside [0, 1]"
    differs = np.abs(ours - theirs) > tolerance
    rows, columns = np.nonzero(differs)
    limit = max(16, 10 * DIFFERING_SHARE * differs.size)
    worst = np.abs(ours - theirs).max()
    assert len(rows) <= limit, f"{len(rows)} of {differs.size} texels differ, by up to {worst:.3g}"
    pieces_of = _pieces_near(differs, vertices, faces, clip_from_world)
    reason = []
    for row, column in zip(rows, columns, strict=True):
        near = pieces_of.get((row, column), [])
        reason.append(
            _reason(near, column + 0.5, row + 0.5, ours[row, column], theirs[row, column], tolerance, by_driver)
        )
    return Difference(differs.size, rows, columns, ours[rows, columns], theirs[rows, columns], np.array(reason, "U12"))


def assert_agree(
    ours, theirs, vertices, faces, clip_from_world, share: float = DIFFERING_SHARE, by_driver: bool = False, **options
) -> Difference:
    """The difference of two maps, which is small and explained texel by texel; AssertionError otherwise.

    `by_driver`: ours is drawn by a driver too, whose clipping and planes are not ours to mend. It allows `cut`.
    """
    difference = compare(ours, theirs, vertices, faces, clip_from_world, by_driver=by_driver, **options)
    # What the other program's or the driver's arithmetic lost is told, but does not count as a difference of ours.
    wrong = difference.count - difference.of("theirs") - (difference.of("cut") if by_driver else 0)
    assert wrong <= share * difference.texel_count, f"more than {100 * share} %: {difference}"
    assert difference.of("unexplained") == 0, str(difference)
    assert difference.of("steep") == 0, str(difference)
    return difference


def homogeneous(vertices) -> np.ndarray:
    """(V, 4) float64 points from (V, 3)."""
    vertices = np.asarray(vertices, np.float64)
    return np.concatenate([vertices, np.ones((len(vertices), 1))], axis=1)


def _pieces_near(differs, vertices, faces, clip_from_world):
    """The clipped triangles near each differing texel, by its row and column."""
    height, width = differs.shape
    matrix = np.asarray(clip_from_world, np.float64)
    points = homogeneous(vertices)
    clip = points @ matrix.T
    size = np.array([width, height], np.float64)
    # Error of float32 clip coordinates: of the numbers that are summed, not of the sum.
    magnitude = np.abs(points - _middle(points)) @ np.abs(matrix).T
    error = _DOT_PRODUCT_ERROR * magnitude
    faces = np.asarray(faces)
    corner = clip[faces]
    distance = _plane_distances(corner)
    inside_any = (distance >= 0).any(axis=1).all(axis=1)
    # Box in texels; triangles that reach behind the projection's centre have none and are always candidates.
    keep = inside_any.copy()
    whole = np.flatnonzero(inside_any & (corner[..., 3] > 0).all(axis=1))
    if len(whole):
        xy = _texels(corner[whole], size)
        summed = np.zeros((height + 1, width + 1), np.int64)
        summed[1:, 1:] = differs.cumsum(0).cumsum(1)
        low = np.clip(np.floor(xy.min(axis=1)) - 1, 0, size).astype(int)
        high = np.clip(np.floor(xy.max(axis=1)) + 2, 0, size).astype(int)
        count = (
            summed[high[:, 1], high[:, 0]]
            - summed[low[:, 1], high[:, 0]]
            - summed[high[:, 1], low[:, 0]]
            + summed[low[:, 1], low[:, 0]]
        )
        keep[whole] = count > 0
    rows, columns = np.nonzero(differs)
    centre = np.column_stack([columns, rows]) + 0.5
    pieces_of = {}
    for face in np.flatnonzero(keep):
        piece = _piece(corner[face], error[faces[face]], size)
        if piece is None:
            continue
        low, high = piece.outline.min(axis=0) - piece.snap, piece.outline.max(axis=0) + piece.snap
        for k in np.flatnonzero(((centre >= low) & (centre <= high)).all(axis=1)):
            pieces_of.setdefault((rows[k], columns[k]), []).append(piece)
    return pieces_of


def _middle(points: np.ndarray) -> np.ndarray:
    """The scene's middle as a homogeneous point with w = 0: renderers keep coordinates relative to it."""
    return np.append(0.5 * (points[:, :3].min(axis=0) + points[:, :3].max(axis=0)), 0.0)


def _plane_distances(corner: np.ndarray) -> np.ndarray:
    """(..., 3, 6) signed values of the clip volume's planes: w - x, w + x, w - y, w + y, z, w - z."""
    x, y, z, w = np.moveaxis(corner, -1, 0)
    return np.stack([w - x, w + x, w - y, w + y, z, w - z], axis=-1)


def _texels(clip: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Texel coordinates, x to the right and y down, of clip coordinates with w > 0."""
    ndc = clip[..., :2] / clip[..., 3:]
    return 0.5 * (np.array([1.0, 1.0]) + ndc * [1.0, -1.0]) * size


def _piece(corner: np.ndarray, error: np.ndarray, size: np.ndarray) -> _Piece | None:
    """One triangle clipped to the volume, or nothing."""
    polygon = corner
    for k in range(6):
        if len(polygon) == 0:
            return None
        distance = _plane_distances(polygon)[:, k]
        if (distance >= 0).all():
            continue
        following, after = np.roll(polygon, -1, axis=0), np.roll(distance, -1)
        out = []
        for p, q, dp, dq in zip(polygon, following, distance, after, strict=True):
            if dp >= 0:
                out.append(p)
            if (dp >= 0) != (dq >= 0):
                out.append(p + (q - p) * (dp / (dp - dq)))
        polygon = np.array(out)
    if len(polygon) < 3 or (polygon[:, 3] <= 0).any():
        return None
    outline = _texels(polygon, size)
    width = _width(outline)
    span = float(np.ptp(polygon[:, 2] / polygon[:, 3]))
    w_min = polygon[:, 3].min()
    # x / w errs by (error of x + |x / w| error of w) / w with |x / w| <= 1.
    ndc_error = (error[:, :3].max(axis=1) + error[:, 3]).max() / w_min
    rounding = 0.5 * size.max() * ndc_error + _VIEWPORT_ERROR * size.max()
    snap = np.sqrt(2) * 2.0 ** -(SUBPIXEL_BITS + 1) + rounding
    # Depth is affine in x and y on the map: z = plane . (x, y, w) with x, y in texels times w.
    clip_to_texels = np.array([[0.5 * size[0], 0, 0.5 * size[0]], [0, -0.5 * size[1], 0.5 * size[1]], [0, 0, 1]])
    xyw = corner[:, [0, 1, 3]] @ clip_to_texels.T
    try:
        plane = np.linalg.solve(xyw, corner[:, 2])
    except np.linalg.LinAlgError:
        plane = np.array([np.inf, np.inf, 0.0])
    depth_error = ndc_error + _plane_error(span, _length(outline), width)
    return _Piece(outline, plane, snap, rounding, depth_error, width, span, was_cut=polygon is not corner)


def _plane_error(span: float, length: float, width: float) -> float:
    """Depth that single precision loses in the plane of a triangle.

    A slope errs by a share of span / width and acts over the length; no area at all leaves the whole span.
    """
    return span * min(1.0, _PLANE_ERROR * length / width) if width > 0 else span


def _length(outline: np.ndarray) -> float:
    """Diagonal of an outline's box."""
    return float(np.linalg.norm(np.ptp(outline, axis=0)))


def _width(outline: np.ndarray) -> float:
    """Smallest width of a convex polygon: over its sides, the farthest corner from the side's line."""
    side = np.roll(outline, -1, axis=0) - outline
    length = np.hypot(*side.T)
    widths = []
    for p, s, n in zip(outline, side, length, strict=True):
        if n > 0:
            widths.append(np.abs((outline - p) @ np.array([-s[1], s[0]]) / n).max())
    return min(widths, default=0.0)


def _distance_inside(outline: np.ndarray, x: float, y: float) -> float:
    """Distance of a point to a convex outline, positive inside."""
    p = np.array([x, y])
    side = np.roll(outline, -1, axis=0) - outline
    squared = (side**2).sum(axis=1)
    t = np.clip(((p - outline) * side).sum(axis=1) / np.where(squared > 0, squared, 1.0), 0, 1)
    distance = np.hypot(*(outline + t[:, None] * side - p).T).min()
    turn = side[:, 0] * (p[1] - outline[:, 1]) - side[:, 1] * (p[0] - outline[:, 0])
    inside = (turn >= 0).all() or (turn <= 0).all()
    return distance if inside else -distance


def _reason(
    pieces: list[_Piece], x: float, y: float, ours: float, theirs: float, tolerance: float, by_driver: bool
) -> str:
    """Why a texel whose centre is (x, y) may hold either depth."""
    inside = np.array([_distance_inside(p.outline, x, y) for p in pieces])
    snap = np.array([p.snap for p in pieces])
    covers, may_cover = inside > snap, inside >= -snap
    depth, slack, cut = np.zeros(len(pieces)), np.zeros(len(pieces)), np.zeros(len(pieces))
    for i in np.flatnonzero(may_cover):
        p, slope = pieces[i], np.hypot(*pieces[i].plane[:2])
        depth[i] = p.plane @ [x, y, 1.0] if np.isfinite(slope) else 0.5
        slack[i] = tolerance + p.depth_error + (slope * p.snap if np.isfinite(slope) else 1.0)
        cut[i] = p.cut_error(x, y)
    # Narrower than the rounding of its corners, a triangle has no plane; a driver draws what its arithmetic makes of
    # it, also beyond the range of the corners' depths.
    planeless = may_cover & np.array([p.width <= 2 * p.rounding for p in pieces], bool)
    nearest_sure = (depth + slack + cut)[covers].min(initial=np.inf)
    sources = []
    for value, drawn_by_driver in ((ours, by_driver), (theirs, True)):
        found = may_cover & (np.abs(depth - value) <= slack + cut) | (planeless & drawn_by_driver)
        empty = value == 1.0 and not covers.any()
        if not (found.any() or empty) or value > nearest_sure:
            return "unexplained"
        sources.append(found)
    involved = sources[0] | sources[1]
    if not covers[involved].all():
        return "edge"
    if any(pieces[i].width < 1 for i in np.flatnonzero(involved)):
        return "thin"
    if np.abs(depth[involved] - ours).min() <= _EXACT * tolerance:
        return "theirs"
    if cut[involved].any():
        return "cut"
    return "steep"
