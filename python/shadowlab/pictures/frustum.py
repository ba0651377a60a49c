"""The camera's frustum in the picture of a map."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

import numpy as np

from ..text.checked import A_CAMERA, a_number, a_picture, any_numbers, checked, finite_numbers, items_of, optional

if TYPE_CHECKING:
    from collections.abc import Iterable

    from .._core import Camera

FRUSTUM_RGB, CASING_RGB = (255, 149, 0), (20, 20, 20)
# Ends of lines; there may be none.
SEGMENTS = any_numbers(None, 2, 2)
DEPTHS = optional(items_of(a_number, "camera depths", "give a list of numbers"))


@checked(shadow_clip_from_world=finite_numbers(4, 4), camera=A_CAMERA, depths=DEPTHS)
def frustum_segments(
    shadow_clip_from_world: np.ndarray, camera: Camera, depths: Iterable[float] | None = None
) -> np.ndarray:
    """The camera frustum's edges inside a map: (N, 2, 2) NDC x, y of both ends, each within [-1, 1].

    Edges are clipped as homogeneous points against -w <= x <= w and -w <= y <= w. Together these hold only where
    w >= 0, so an edge that passes behind the projection's centre is cut there and never returns from the other side.

    Parameters
    ----------
    shadow_clip_from_world : (4, 4) float
    camera : Camera
    depths : sequence of float, optional
        Camera depths at which a cross-section is drawn; the near and far planes where none is given.
    """
    matrix = np.asarray(shadow_clip_from_world, dtype=np.float64)
    clipped = [clip_segment(matrix @ a, matrix @ b) for a, b in frustum_edges(camera, depths)]
    return np.array([s for s in clipped if s is not None]).reshape(-1, 2, 2)


@checked(camera=A_CAMERA, depths=DEPTHS)
def frustum_edges(camera: Camera, depths: Iterable[float] | None = None) -> list[tuple[np.ndarray, np.ndarray]]:
    """Both ends of each edge of a camera's frustum as homogeneous world points, with cross-sections at some depths."""
    rings = [cross_section(camera, z) for z in ((camera.near, camera.far) if depths is None else depths)]
    edges = [(ring[i], ring[(i + 1) % 4]) for ring in rings for i in range(4)]
    return edges + [(a[i], b[i]) for a, b in itertools.pairwise(rings) for i in range(4)]


def cross_section(camera: Camera, depth: float) -> np.ndarray:
    """The corners (4, 4) of a camera's picture at a depth, in turn around it, as homogeneous world points."""
    around = [0, 1, 3, 2]
    if math.isinf(depth):
        # Where the four rays end: points at infinity.
        return np.pad(camera.corners(1.0)[around] - camera.eye, ((0, 0), (0, 1)))
    return np.pad(camera.corners(depth)[around], ((0, 0), (0, 1)), constant_values=1.0)


def clip_segment(a: np.ndarray, b: np.ndarray) -> np.ndarray | None:
    """NDC x, y (2, 2) of the part of a homogeneous segment inside |x| <= w, |y| <= w; None where there is none."""
    start, end = 0.0, 1.0
    for axis, sign in itertools.product((0, 1), (1.0, -1.0)):
        da, db = a[3] - sign * a[axis], b[3] - sign * b[axis]
        if da < 0 and db < 0:
            return None
        if da < 0:
            start = max(start, da / (da - db))
        elif db < 0:
            end = min(end, da / (da - db))
    if not start <= end:
        return None
    ends = [a + t * (b - a) for t in (start, end)]
    if any(not p[3] > 0 for p in ends):
        return None  # touches the square only at the projection's centre, which has no place in the image
    # Rounding may leave an end a step outside of the edge it was cut at.
    inside: np.ndarray = np.clip([p[:2] / p[3] for p in ends], -1.0, 1.0)
    return inside


@checked(picture=a_picture, segments=SEGMENTS)
def with_frustum(picture: np.ndarray, segments: np.ndarray) -> np.ndarray:
    """The picture with NDC segments drawn into it, dark casing under an orange line."""
    from PIL import Image, ImageDraw

    # Lines without stairs: what covers a quarter of a pixel, drawn at twice the size.
    height, width = picture.shape[:2]
    drawn = Image.new("L", (2 * width, 2 * height))
    pixels = (np.asarray(segments) * [1.0, -1.0] * 0.5 + 0.5) * [drawn.width - 1, drawn.height - 1]
    draw = ImageDraw.Draw(drawn)
    unit = max(1.0, max(height, width) / 512)
    for code, thick in enumerate((7 * unit, 3.4 * unit), start=1):
        for (x0, y0), (x1, y1) in pixels:
            draw.line((x0, y0, x1, y1), fill=code, width=round(thick))
    # The quarters of a pixel, a byte each: of the upper two and of the lower two.
    pairs = np.asarray(drawn).view(np.uint16)
    upper, lower = pairs[0::2], pairs[1::2]
    rows, columns = np.divmod(np.flatnonzero((upper | lower) != 0), width)
    quarters = upper[rows, columns] | lower[rows, columns].astype(np.uint32) << 16
    made = picture.copy()
    beneath = made[rows, columns]
    # How many of them are casing, and how many the line itself: the sum of the bytes comes into the uppermost one.
    ones = np.uint32(0x01010101)
    casing, line = (((quarters >> bit & ones) * ones >> 24).astype(np.float32)[:, None] for bit in (0, 1))
    drawn_over = casing * np.array(CASING_RGB, np.float32) + line * np.array(FRUSTUM_RGB, np.float32)
    made[rows, columns] = np.rint(((4 - casing - line) * beneath + drawn_over) / 4)
    return made
