"""Pictures as numpy arrays: the shaded eye view, differences from the truth, maps as the light sees them.

No plotting library here; `plot` puts these on axes and `report_html` into a page. All return (H, W, 3) uint8.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

# Two colours of [okabe2008] that all common kinds of colour vision tell apart, from each other and from grey.
FALSE_SHADOW_RGB = (213, 94, 0)
FALSE_LIGHT_RGB = (0, 114, 178)
FRUSTUM_RGB = (255, 149, 0)

# Linear-light colours, chosen so that a lit, a shadowed and an averted face of one neutral material stay apart.
ALBEDO = np.array([0.60, 0.59, 0.57])
SUN = np.array([1.32, 1.22, 1.05])
SKY = np.array([0.30, 0.37, 0.50])
BOUNCE = np.array([0.17, 0.145, 0.12])
# Background in sRGB bytes, from the top row to the bottom row.
BACKGROUND_TOP = np.array([176.0, 196.0, 216.0])
BACKGROUND_BOTTOM = np.array([233.0, 236.0, 238.0])


def shade(gbuffer: Any, light: Any, mask: np.ndarray) -> np.ndarray:
    """The eye view (H, W, 3) uint8 of a neutral material under this light and a hemisphere of sky.

    Parameters
    ----------
    gbuffer : GBuffer
        What the camera sees.
    light : DirectionalLight, SpotLight or PointLight
        Where Lambert's cosine comes from.
    mask : (H, W) float
        Share of the light that arrives. Not read where nothing is seen.
    """
    normal = np.asarray(gbuffer.normal, dtype=np.float32)
    seen = np.asarray(gbuffer.triangle) >= 0
    cosine = np.clip(-np.einsum("hwc,hwc->hw", normal, light_directions(gbuffer, light)), 0.0, 1.0)
    arrives = cosine * np.nan_to_num(np.asarray(mask, dtype=np.float32), nan=0.0)
    upward = 0.5 + 0.5 * normal[..., 1]
    picture = np.empty((*seen.shape, 3), np.uint8)
    # One channel at a time, in single precision: bytes come of it, and single planes are several times faster.
    for i, (flat, rise, sun) in enumerate((ALBEDO * (BOUNCE, SKY - BOUNCE, SUN)).T.astype(np.float32)):
        picture[..., i] = srgb_bytes(flat + rise * upward + sun * arrives)
    np.copyto(picture, background(seen.shape), where=~seen[..., None])
    return picture


def light_directions(gbuffer: Any, light: Any) -> np.ndarray:
    """The unit way the light travels at each pixel, broadcastable to (H, W, 3)."""
    if light.kind == "directional":
        return np.asarray(light.direction, dtype=np.float32)[None, None, :]
    away = np.asarray(gbuffer.position, dtype=np.float64) - np.asarray(light.position, dtype=np.float64)
    length = np.linalg.norm(away, axis=-1, keepdims=True)
    return (away / np.where(length > 0, length, 1.0)).astype(np.float32)


def background(shape: tuple[int, int]) -> np.ndarray:
    """A soft vertical gradient (H, W, 3) uint8 for pixels that see nothing."""
    t = ((np.arange(shape[0]) + 0.5) / shape[0])[:, None, None]
    rows = BACKGROUND_TOP * (1.0 - t) + BACKGROUND_BOTTOM * t
    return np.broadcast_to(np.rint(rows).astype(np.uint8), (*shape, 3))


def srgb_bytes(linear: np.ndarray) -> np.ndarray:
    """Linear light in [0, 1] (clipped) as sRGB bytes, IEC 61966-2-1."""
    steps = SRGB.size - 1
    coded: np.ndarray = SRGB[(np.clip(linear, 0.0, 1.0) * steps + 0.5).astype(np.uint16)]
    return coded


def srgb_table() -> np.ndarray:
    """The bytes of 65536 shades from 0 to 1: a step is a twentieth of a byte where they rise fastest."""
    x = np.linspace(0.0, 1.0, 1 << 16)
    encoded = np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.power(np.maximum(x, 0.0031308), 1 / 2.4) - 0.055)
    coded: np.ndarray = np.rint(255.0 * encoded).astype(np.uint8)
    return coded


SRGB = srgb_table()


def truth_mask(truth: np.ndarray) -> np.ndarray:
    """The traced truth (H, W) int8 as light that arrives: undecided is half, nothing is NaN."""
    table = np.array([np.nan, 0.5, 0.0, 1.0], dtype=np.float32)
    return table[np.asarray(truth, dtype=np.int8) + 2]


def difference(gbuffer: Any, light: Any, truth: np.ndarray, image: np.ndarray, *, width: int = 1) -> np.ndarray:
    """The wrong pixels over a pale grey eye view.

    `FALSE_SHADOW_RGB` where the map shades what is lit, `FALSE_LIGHT_RGB` where it lights what is in shadow.

    Parameters
    ----------
    truth : (H, W) int8
        From `sl.trace.shadow_mask`; it shades the grey view.
    image : (H, W) int8
        From `sl.aliasing.misclassified`: 1 false shadow, 2 false light, everything else is left grey.
    width : int
        Pixels that each wrong pixel is drawn wide, so that a picture shown smaller than it is still shows them.
    """
    grey = shade(gbuffer, light, truth_mask(truth)).astype(np.float32) @ np.array([0.2126, 0.7152, 0.0722], np.float32)
    # Lifted into the upper third, so that both colours are darker than anything beside them.
    picture = np.repeat(np.rint(158.0 + 0.36 * grey)[..., None], 3, axis=-1).astype(np.uint8)
    kinds = ((1, FALSE_SHADOW_RGB), (2, FALSE_LIGHT_RGB))
    for kind, colour in kinds if width > 1 else ():
        picture[widened(np.asarray(image) == kind, width)] = colour
    for kind, colour in kinds:  # the pixels themselves last, so that none is hidden by its neighbour
        picture[np.asarray(image) == kind] = colour
    return picture


def widened(marked: np.ndarray, width: int) -> np.ndarray:
    """The marks (H, W), each grown to a square of `width` pixels to the right and down."""
    grown = marked.copy()
    for shift in range(1, width):
        grown[:, shift:] |= marked[:, : marked.shape[1] - shift]
    rows = grown.copy()
    for shift in range(1, width):
        grown[shift:] |= rows[: rows.shape[0] - shift]
    return grown


def relief(depth: np.ndarray) -> np.ndarray:
    """A shadow map (H, W) as the light sees it: near is light, slopes are modelled, empty is flat and dark."""
    depth = np.asarray(depth, dtype=np.float32)
    covered = depth < 1.0
    picture = np.empty((*depth.shape, 3), np.uint8)
    picture[...] = (30, 33, 38)
    if not covered.any():
        return picture
    values = depth[covered]
    low, high = np.percentile(values[:: max(1, values.size // 200_000)], (0.5, 99.5))
    span = float(high - low) or 1.0
    tone = 0.86 - 0.52 * np.clip((depth - low) / span, 0.0, 1.0)
    # A lamp from the upper left over the height field. The commonest slope, mostly the ground's, is taken as level, and
    # the slopes that stand out from it say how steep is steep, so no unit is assumed.
    gy, gx = np.gradient(np.where(covered, depth, high)) if min(depth.shape) > 1 else (np.zeros_like(depth),) * 2
    slope = gx + gy
    slope = slope - np.median(slope[covered])
    # Where all is one plane only rounding stands out; a slope through a fourth of the depths over the map is not less.
    steep = max(float(np.percentile(np.abs(slope[covered]), 85.0)), 0.25 * span / max(depth.shape))
    tone = np.clip(tone + 0.16 * np.tanh(slope / (2.0 * steep)), 0.0, 1.0)
    picture[covered] = np.rint(255.0 * tone[covered, None] * np.array([0.97, 0.985, 1.0])).astype(np.uint8)
    return picture


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


def frustum_segments(shadow_clip_from_world: np.ndarray, camera: Any, depths: Any = None) -> np.ndarray:
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


def frustum_edges(camera: Any, depths: Any = None) -> list[tuple[np.ndarray, np.ndarray]]:
    """Both ends of each edge of a camera's frustum as homogeneous world points, with cross-sections at some depths."""
    depths = (camera.near, camera.far) if depths is None else tuple(depths)
    tan_y = np.tan(0.5 * camera.fov_y)
    rays = [
        np.asarray(camera.forward)
        + sx * tan_y * camera.aspect * np.asarray(camera.right)
        + sy * tan_y * np.asarray(camera.up)
        for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    eye = np.asarray(camera.eye, dtype=np.float64)
    rings = [[np.append(eye + z * ray, 1.0) for ray in rays] for z in depths]
    edges = [(ring[i], ring[(i + 1) % 4]) for ring in rings for i in range(4)]
    return edges + [(a[i], b[i]) for a, b in itertools.pairwise(rings) for i in range(4)]


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


def with_frustum(picture: np.ndarray, segments: np.ndarray) -> np.ndarray:
    """The picture with NDC segments drawn into it, dark casing under an orange line."""
    from PIL import Image, ImageDraw

    # Twice the size and back: a line without stairs.
    image = Image.fromarray(picture).resize((2 * picture.shape[1], 2 * picture.shape[0]), Image.Resampling.NEAREST)
    pixels = (np.asarray(segments) * [1.0, -1.0] * 0.5 + 0.5) * [image.width - 1, image.height - 1]
    draw = ImageDraw.Draw(image)
    unit = max(1.0, max(picture.shape[:2]) / 512)
    for width, colour in ((7 * unit, (20, 20, 20)), (3.4 * unit, FRUSTUM_RGB)):
        for (x0, y0), (x1, y1) in pixels:
            draw.line((x0, y0, x1, y1), fill=colour, width=round(width))
    return np.asarray(image.resize((picture.shape[1], picture.shape[0]), Image.Resampling.BOX))


def densest_window(images: list[np.ndarray], side: int) -> tuple[int, int]:
    """Row and column of the window of `side` pixels with the most wrong pixels, all difference images together."""
    wrong = np.sum([np.asarray(image) > 0 for image in images], axis=0, dtype=np.int64)
    height, width = wrong.shape
    rows, columns = min(side, height), min(side, width)
    total = np.zeros((height + 1, width + 1), np.int64)
    total[1:, 1:] = wrong.cumsum(0).cumsum(1)
    sums = total[rows:, columns:] - total[:-rows, columns:] - total[rows:, :-columns] + total[:-rows, :-columns]
    row, column = np.unravel_index(int(sums.argmax()), sums.shape)
    return int(row), int(column)


def png(picture: np.ndarray) -> bytes:
    """The picture as the bytes of a PNG file; a higher level takes twice as long and saves little."""
    import io

    from PIL import Image

    stream = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(picture)).save(stream, format="PNG", compress_level=3)
    return stream.getvalue()
