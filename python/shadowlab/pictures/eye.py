"""The eye view: shaded, and its differences from the truth."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from .. import _core
from ..aliasing.codes import Difference
from ..errors import ArgumentError
from ..text.checked import a_count, a_gbuffer, a_light, checked, items_of, numbers_in
from ..trace import Truth
from .bands import row_bands

if TYPE_CHECKING:
    from .._core import GBuffer
    from ..types import RGB, Light

# Two colours of [okabe2008] that all common kinds of colour vision tell apart, from each other and from grey.
FALSE_SHADOW_RGB = (213, 94, 0)
FALSE_LIGHT_RGB = (0, 114, 178)

# Pixels that a wrong pixel may be drawn wide: more hides the picture.
WIDEST_MARK_PX = 64
# Linear-light colours, chosen so that a lit, a shadowed and an averted face of one neutral material stay apart.
ALBEDO = np.array([0.60, 0.59, 0.57])
SUN = np.array([1.32, 1.22, 1.05])
SKY = np.array([0.30, 0.37, 0.50])
BOUNCE = np.array([0.17, 0.145, 0.12])
# Shares of red, green and blue in the luminance of sRGB, ITU-R BT.709.
LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)
# Background in sRGB bytes, from the top row to the bottom row.
BACKGROUND_TOP = np.array([176.0, 196.0, 216.0])
BACKGROUND_BOTTOM = np.array([233.0, 236.0, 238.0])


@checked(gbuffer=a_gbuffer, light=a_light, mask=numbers_in(np.float32, None, None))
def shade(gbuffer: GBuffer, light: Light, mask: np.ndarray) -> np.ndarray:
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
    same_size(gbuffer, mask=mask)
    # In single precision, a channel at a time: bytes come of it.
    material = (ALBEDO * (BOUNCE, SKY - BOUNCE, SUN)).astype(np.float32)
    ways, sky = light_directions(gbuffer, light), background(np.shape(mask))[:, 0]
    seen = gbuffer.normal, gbuffer.triangle
    return _core.shade(*seen, mask, ways=ways, material=material, sky=sky, coded=SRGB)


def light_directions(gbuffer: GBuffer, light: Light) -> np.ndarray:
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


def same_size(gbuffer: GBuffer, **images: np.ndarray) -> None:
    """Raises unless images (H, W) are of the G-buffer's size.

    Raises
    ------
    ArgumentError
        For another shape.
    """
    shape = np.shape(gbuffer.triangle)
    for name, image in images.items():
        if np.shape(image) != shape:
            raise ArgumentError(
                f"{name}: expected shape {shape}, the G-buffer's, got {np.shape(image)}; use one size for all"
            )


def srgb_table() -> np.ndarray:
    """The bytes of 65536 shades from 0 to 1: a step is a twentieth of a byte where they rise fastest."""
    x = np.linspace(0.0, 1.0, 1 << 16)
    encoded = np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.power(np.maximum(x, 0.0031308), 1 / 2.4) - 0.055)
    coded: np.ndarray = np.rint(255.0 * encoded).astype(np.uint8)
    return coded


SRGB = srgb_table()


@checked(truth=numbers_in(np.int8, None, None))
def truth_mask(truth: np.ndarray) -> np.ndarray:
    """The traced truth (H, W) int8 as light that arrives: undecided is half, nothing is NaN."""
    arrives = {Truth.NOTHING: np.nan, Truth.UNDECIDED: 0.5, Truth.SHADOW: 0.0, Truth.LIT: 1.0}
    table = np.array([arrives[code] for code in sorted(arrives)], dtype=np.float32)
    if truth.min() < min(arrives) or truth.max() > max(arrives):
        raise ArgumentError(
            f"truth: expected states -2 to 1, as sl.trace.Truth has them, got {truth.min()} to {truth.max()}; "
            "sl.trace.shadow_mask makes them"
        )
    found: np.ndarray = table[truth - min(arrives)]
    return found


@checked(
    gbuffer=a_gbuffer,
    light=a_light,
    truth=numbers_in(np.int8, None, None),
    image=numbers_in(np.int8, None, None),
    width=a_count(1, WIDEST_MARK_PX),
)
def difference(gbuffer: GBuffer, light: Light, truth: np.ndarray, image: np.ndarray, *, width: int = 1) -> np.ndarray:
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
    same_size(gbuffer, truth=truth, image=image)
    return difference_over(luminance(shade(gbuffer, light, truth_mask(truth))), np.asarray(image), width)


def difference_over(grey: np.ndarray, image: np.ndarray, width: int = 1) -> np.ndarray:
    """The wrong pixels over an eye view in grey (H, W), 0 to 255, that is made pale here; see `difference`."""
    # Lifted into the upper third, so that both colours are darker than anything beside them.
    pale = np.empty(grey.shape, np.uint8)
    for rows in row_bands(grey.shape):
        pale[rows] = np.rint(158.0 + 0.36 * grey[rows])
    colours: dict[int, RGB] = {Difference.FALSE_SHADOW: FALSE_SHADOW_RGB, Difference.FALSE_LIGHT: FALSE_LIGHT_RGB}
    return marked(pale, image, colours, width)


def luminance(picture: np.ndarray) -> np.ndarray:
    """The luminance (H, W) float32, 0 to 255, of the bytes of a picture."""
    grey = np.empty(picture.shape[:2], np.float32)
    for rows in row_bands(grey.shape):
        # No product of matrices, whose threads would run against those that draw other pictures.
        grey[rows] = sum(picture[rows, :, channel] * LUMINANCE[channel] for channel in range(3))
    return grey


def marked(grey: np.ndarray, image: np.ndarray, colours: Mapping[int, RGB], width: int) -> np.ndarray:
    """A grey picture (H, W) uint8 in RGB, where the image (H, W) has one of these codes in its colour."""
    picture = in_channels(grey)
    # From 1 on, in the order of the colours; 0 is none of them.
    marks = np.zeros(grey.shape, np.uint8)
    for place, code in enumerate(colours, start=1):
        marks[image == code] = place
    if width > 1:
        # The pixels themselves stay, so that none is hidden by its neighbour.
        marks = np.where(marks > 0, marks, widened(marks, width))
    wrong = np.flatnonzero(marks > 0)
    table = np.array([(0, 0, 0), *colours.values()], np.uint8)
    picture.reshape(-1, 3)[wrong] = table[marks.reshape(-1)[wrong]]
    return picture


def in_channels(grey: np.ndarray) -> np.ndarray:
    """A grey picture (H, W) uint8 as one of three channels."""
    picture = np.empty((*grey.shape, 3), np.uint8)
    for channel in range(3):
        picture[..., channel] = grey
    return picture


def widened(marks: np.ndarray, width: int) -> np.ndarray:
    """The marks (H, W), each grown to a square of `width` pixels to the right and down; larger numbers hide smaller."""
    grown = marks.copy()
    for shift in range(1, width):
        np.maximum(grown[:, shift:], marks[:, : marks.shape[1] - shift], out=grown[:, shift:])
    rows = grown.copy()
    for shift in range(1, width):
        np.maximum(grown[shift:], rows[: rows.shape[0] - shift], out=grown[shift:])
    return grown


@checked(
    images=items_of(numbers_in(np.int8, None, None), "difference images (H, W)", "give a list of them", 1),
    side=a_count(1, 1 << 30),
)
def densest_window(images: list[np.ndarray], side: int) -> tuple[int, int]:
    """Row and column of the window of `side` pixels with the most wrong pixels, all difference images together."""
    if len({image.shape for image in images}) > 1:
        shapes = ", ".join(str(image.shape) for image in images[:4])
        raise ArgumentError(f"images: expected difference images of one shape, got {shapes}; use one size for all")
    height, width = images[0].shape
    # As few bytes as hold the number of all pixels of all images.
    counts = np.int32 if len(images) * height * width < np.iinfo(np.int32).max else np.int64
    total = np.zeros((height + 1, width + 1), counts)
    wrong = total[1:, 1:]
    for image in images:
        wrong += image > Difference.AGREE
    wrong.cumsum(0, out=wrong)
    wrong.cumsum(1, out=wrong)
    rows, columns = min(side, height), min(side, width)
    sums = total[rows:, columns:] - total[:-rows, columns:] - total[rows:, :-columns] + total[:-rows, :-columns]
    row, column = np.unravel_index(int(sums.argmax()), sums.shape)
    return int(row), int(column)
