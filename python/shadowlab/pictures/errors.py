"""The error of every pixel as a picture: how long a texel of the map is in the image, and the scale that says so.

Source: Lloyd, Govindaraju, Quammen, Molnar, Manocha 2008 [lloyd2008]: 1 pixel a texel is green, 10 and more are dark
red, on a logarithmic scale. Departures: lightness falls all the way, so that every kind of colour vision and a grey
print read it; below 1 is blue and clearly lighter, since such pixels have texels to spare. Pixels without a texel are
grey.

    0.1          1          10 pixels a texel
    | pale blue  | green, mustard, orange, red, dark red
    lightness 95 to 89 | 79 to 21

No plotting library here; `plot.error_map` puts the picture on axes.
"""

from __future__ import annotations

import math
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..aliasing.footprint import AVERTED, NO_MAP, NOTHING, Footprint
from ..errors import ArgumentError
from ..text import shown
from ..text.arrays import checked_array
from ..text.checked import a_gbuffer, a_light, checked, optional
from .bands import packed, put_colours, row_bands
from .eye import luminance, shade

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    import numpy.typing as npt

    from .._core import GBuffer
    from ..types import Floats, Light

# Ends of the scale, pixels per texel. The upper one is published; the lower one mirrors it.
BEST_PX, WORST_PX = 0.1, 10.0
# sRGB, each list even in the logarithm of the error. Chosen in CIELCh as lightness, chroma, hue: 95 9 250, 93 12 250,
# 89 18 250; and 79 52 140, 70 62 95, 58 68 62, 42 66 38, 21 46 28, where gaps of lightness outlast red-green blindness.
OVERSAMPLED_RGB = ((227, 243, 255), (217, 238, 254), (194, 228, 254))
UNDERSAMPLED_RGB = ((137, 214, 131), (193, 171, 49), (210, 115, 25), (183, 51, 34), (105, 7, 21))
# Colours on either side of 1: finer than a byte of lightness.
STEPS = 128

# Darkest and lightest grey where no texel is looked up, and how much darker its hatching is. The ranges are apart, and
# so are the directions, since one grey or another is as dark as some colour of the scale.
GREYS: dict[int, tuple[int, int, int]] = {NO_MAP: (224, 242, 26), AVERTED: (160, 194, 26), NOTHING: (255, 255, 0)}
WORDS: dict[int, str] = {
    NO_MAP: "in no map", AVERTED: "averted from the light or out of its reach", NOTHING: "nothing seen",
}  # fmt: skip
# Pixels from one line of the hatching to the next: wide enough to survive at half the size.
HATCH_PX = 8


def _table() -> NDArray[np.uint8]:
    """The colours (2 STEPS, 3) of the scale, the best first."""
    halves = []
    for colours in (OVERSAMPLED_RGB, UNDERSAMPLED_RGB):
        at, anchors = np.linspace(0, 1, STEPS), np.linspace(0, 1, len(colours))
        halves.append(np.stack([np.interp(at, anchors, channel) for channel in zip(*colours, strict=True)], axis=-1))
    table: NDArray[np.uint8] = np.rint(np.concatenate(halves)).astype(np.uint8)
    return table


SCALE = _table()
# The scale, and after it all greys.
SCALE_AND_GREYS = packed(np.concatenate([SCALE, np.repeat(np.arange(256, dtype=np.uint8)[:, None], 3, axis=1)]))


def error_colours(values: npt.ArrayLike) -> NDArray[np.uint8]:
    """The colours (..., 3) uint8 of errors (...) in pixels per texel; those beyond the ends take the ends' colours.

    Parameters
    ----------
    values : (...) array_like of float
        0 or more; infinity is the worst.

    Raises
    ------
    ArgumentError
        For NaN and negative numbers.
    """
    colours: NDArray[np.uint8] = SCALE[scale_places(np.asarray(values))]
    return colours


def scale_places(v: NDArray[Any]) -> NDArray[np.intp]:
    """The places of errors in the scale; errors as of `error_colours`."""
    if not (v >= 0).all():
        raise ArgumentError(
            "values: expected errors of 0 or more pixels wherever a texel is looked up, got NaN or a negative one; "
            "mark such pixels in the footprint's map"
        )
    place = np.floor(STEPS * np.log10(np.clip(v, BEST_PX, WORST_PX))).astype(np.intp) + STEPS
    # 1 itself begins the upper half, whatever the rounding of its neighbours.
    found: NDArray[np.intp] = np.where(v < 1, np.clip(place, 0, STEPS - 1), np.clip(place, STEPS, 2 * STEPS - 1))
    return found


@checked(gbuffer=optional(a_gbuffer), light=optional(a_light))
def error_picture(
    footprint: Footprint,
    *,
    values: npt.ArrayLike | None = None,
    gbuffer: GBuffer | None = None,
    light: Light | None = None,
) -> NDArray[np.uint8]:
    """The error of each pixel in the colours of the scale: (H, W, 3) uint8.

    Parameters
    ----------
    footprint : Footprint
        Of an image.
    values : (H, W) array_like of float, optional
        Errors to draw, pixels per texel; ``footprint.major`` where none are given.
    gbuffer, light : GBuffer and light, optional
        Both: pixels without a texel show a pale eye view in the greys that say why.

    Returns
    -------
    (H, W, 3) uint8
        Colours where a texel is looked up. Elsewhere grey, hatched: light where no map holds the pixel, darker where it
        faces away from the light; white where nothing is seen.

    Raises
    ------
    ArgumentError
        For a footprint of points, values of another shape or that are no errors, and a G-buffer without a light.
    """
    codes = image_codes(footprint)
    errors = footprint.major if values is None else values_of(values, codes.shape)
    return errors_over(tones(codes.shape, gbuffer, light), codes, np.asarray(errors))


def errors_over(tone: Floats, codes: NDArray[np.int16], errors: Floats) -> NDArray[np.uint8]:
    """The errors over a grey eye view (H, W) in [0, 1]; see `error_picture`."""
    picture, lines = np.empty((*codes.shape, 3), np.uint8), hatching(codes.shape[1])
    for rows in row_bands(codes.shape):
        measured = codes[rows] >= 0
        turn = np.arange(rows.start, rows.stop) % HATCH_PX
        places = greys(codes[rows], tone[rows], {code: of[turn] for code, of in lines.items()})
        places += len(SCALE)
        # A logarithm is what takes longest.
        places[measured] = scale_places(errors[rows][measured])
        put_colours(picture[rows], SCALE_AND_GREYS, places)
    return picture


def image_codes(footprint: object) -> NDArray[np.int16]:
    """The map codes (H, W) of the footprint of an image."""
    if not isinstance(footprint, Footprint):
        raise ArgumentError(
            f"footprint: expected a Footprint, got {shown(footprint)}; sl.aliasing.footprint(...) makes one"
        )
    if np.ndim(footprint.map) != 2 or 0 in np.shape(footprint.map):
        raise ArgumentError(
            f"footprint: expected one of an image (H, W), got shape {np.shape(footprint.map)}; "
            "sl.aliasing.footprint(...) makes one of a G-buffer"
        )
    return np.asarray(footprint.map)


def values_of(values: npt.ArrayLike, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """The values as numbers of this shape."""
    v: NDArray[np.float64] = checked_array("values", values)
    if v.shape != shape:
        raise ArgumentError(
            f"values: expected numbers of shape {shape}, the footprint's, got {shown(values)}; crop both"
        )
    return v


def tones(shape: tuple[int, ...], gbuffer: GBuffer | None, light: Light | None) -> Floats:
    """The eye view (H, W) without shadows in grey, 0 to 1; middle grey where none is given."""
    if (gbuffer is None) != (light is None):
        raise ArgumentError("gbuffer, light: expected both or neither, got one; the eye view is shaded with both")
    if gbuffer is None or light is None:
        return np.full(shape, 0.5, np.float32)
    if np.shape(gbuffer.triangle) != shape:
        raise ArgumentError(
            f"gbuffer: expected shape {shape}, the footprint's, got {np.shape(gbuffer.triangle)}; "
            "render it at the same size"
        )
    tone: Floats = luminance(shade(gbuffer, light, np.ones(shape, np.float32))) / 255
    return tone


def hatching(width: int) -> dict[int, NDArray[np.float32]]:
    """How much darker the lines of each hatching make `HATCH_PX` rows (HATCH_PX, W), which come again and again."""
    rows, columns = np.ogrid[:HATCH_PX, :width]
    on = {NO_MAP: (columns - rows) % HATCH_PX < 1, AVERTED: (columns + rows) % HATCH_PX < 2}
    return {code: (GREYS[code][2] * lines).astype(np.float32) for code, lines in on.items()}


def greys(codes: NDArray[np.int16], tone: Floats, lines: Mapping[int, Floats]) -> NDArray[np.intp]:
    """The grey (H, W) of what the codes below 0 say, over an eye view in grey, less the lines of the hatching."""
    grey = np.full(codes.shape, 255, np.float32)
    for code, dark in lines.items():
        darkest, lightest, _ = GREYS[code]
        np.copyto(grey, darkest + (lightest - darkest) * tone - dark, where=codes == code)
    return np.rint(grey).astype(np.intp)


def middle_grey(code: int) -> int:
    """The grey of a code without an eye view, between the lines of its hatching."""
    darkest, lightest, _ = GREYS[code]
    return round(0.5 * (darkest + lightest))


# The scale as SVG, in its pixels.
SVG_WIDTH, BAR, SVG_LEFT = 560, 14, 28
TICKS = (0.1, 0.2, 0.5, 1, 2, 5, 10)


def error_scale_svg(
    codes: Iterable[int] = (NO_MAP, AVERTED, NOTHING), *, label: str = "longest extent of a texel, pixels per texel"
) -> str:
    """The scale of `error_picture` as an SVG element; its text takes the page's colour.

    Parameters
    ----------
    codes : iterable of int
        The codes of pixels without a texel to explain, of `Footprint.map`; those of 0 and more are left out.
    label : str
        What is drawn, and its unit.
    """
    inner = SVG_WIDTH - 2 * SVG_LEFT
    # Twelve pieces a decade and more: no seam is seen, and a page stays small.
    pieces = 64

    def x(value: float) -> float:
        return SVG_LEFT + inner * math.log10(value / BEST_PX) / math.log10(WORST_PX / BEST_PX)

    parts = []
    for i in range(pieces):
        colour = rgb(SCALE[round((i + 0.5) * len(SCALE) / pieces)])
        parts.append(
            f'<rect x="{SVG_LEFT + inner * i / pieces:.2f}" y="20" width="{inner / pieces:.2f}" height="{BAR}" '
            f'fill="{colour}" shape-rendering="crispEdges"/>'
        )
    top, middle, bottom = 20, 20 + BAR / 2, 20 + BAR
    for end, tip, colour in ((SVG_LEFT, SVG_LEFT - 12, SCALE[0]), (SVG_LEFT + inner, SVG_LEFT + inner + 12, SCALE[-1])):
        parts.append(f'<path d="M{end} {top}L{tip} {middle:g}L{end} {bottom}z" fill="{rgb(colour)}"/>')
    for value in TICKS:
        parts.append(f'<path d="M{x(value):.1f} {bottom}v4" stroke="currentColor"/>')
        parts.append(f'<text x="{x(value):.1f}" y="{bottom + 17}" text-anchor="middle">{value:g}</text>')
    parts.append(f'<text x="{x(1) - 8:.1f}" y="14" text-anchor="end">oversampled</text>')
    parts.append(f'<text x="{x(1) + 8:.1f}" y="14">undersampled</text>')
    parts.append(f'<text x="{SVG_WIDTH / 2}" y="{bottom + 35}" text-anchor="middle">{escape(label)}</text>')
    at, y = float(SVG_LEFT), bottom + 48
    known = [code for code in GREYS if code in set(codes)]
    for code in known:
        parts.append(grey_swatch(code, at, y))
        parts.append(f'<text x="{at + 26:.0f}" y="{y + 11}">{WORDS[code]}</text>')
        at += 50 + 6.3 * len(WORDS[code])  # the width of a letter of 13 pixels, on average
    height = y + 20 if known else bottom + 42
    text = "Colours of the error: green is one pixel a texel, dark red ten and more, blue less than one"
    return (
        f'<svg class="scale" viewBox="0 0 {SVG_WIDTH} {height}" role="img" aria-label="{text}" fill="currentColor" '
        f'style="display:block;width:100%;max-width:{SVG_WIDTH}px;font:13px system-ui,sans-serif">'
        f"{''.join(parts)}</svg>"
    )


def grey_swatch(code: int, x: float, y: float) -> str:
    """A sample of the grey of a code, hatched as in the picture."""
    hatch = GREYS[code][2]
    dark = middle_grey(code) - hatch
    slope = 14 if code == NO_MAP else -14
    start = y if code == NO_MAP else y + 14
    lines = "".join(f"M{x + shift:.0f} {start}l4 {slope}" for shift in (2, 8, 14)) if hatch else ""
    return (
        f'<rect x="{x:.0f}" y="{y}" width="20" height="14" fill="{rgb((middle_grey(code),) * 3)}" stroke="#888"/>'
        f'<path d="{lines}" stroke="{rgb((dark,) * 3)}" stroke-width="1.5"/>'
    )


def rgb(colour: Iterable[float]) -> str:
    """A colour of bytes as six hexadecimal digits."""
    return "#{:02x}{:02x}{:02x}".format(*(int(c) for c in colour))
