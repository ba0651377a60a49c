"""Wrong pixels in the colours of their causes, as a picture over a pale eye view.

The causes are those of `aliasing.causes`. Colours of [okabe2008]: acne is coloured as false shadow is in other
pictures and leaks as false light, edges a reddish purple that is lighter than both, missing casters black, and what a
wrong map does violet. No two are closer than 25 in CIELAB to an eye without red, green or blue receptors.

No plotting library here; `plot.cause_map` puts the picture on axes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..errors import ArgumentError
from ..text import shown
from ..text.checked import a_count, a_gbuffer, a_light, checked, numbers_in
from ..types import RGB
from .bands import row_bands
from .eye import FALSE_LIGHT_RGB, FALSE_SHADOW_RGB, WIDEST_MARK_PX, luminance, marked, same_size, shade, truth_mask

if TYPE_CHECKING:
    import numpy.typing as npt

    from .._core import GBuffer
    from ..types import Light

# By code of `aliasing.causes.CAUSES`.
CAUSE_RGB: dict[int, RGB] = {
    1: FALSE_SHADOW_RGB,
    2: (219, 143, 186),
    3: FALSE_LIGHT_RGB,
    4: (0, 0, 0),
    5: (120, 0, 225),
}
NOT_COMPARED = -1
# Greys of the eye view beneath: all colours are darker. What is not compared is white, hatched.
DARKEST, LIGHTEST, HATCH = 205, 245, 215
STRIPE_PX = 6


@checked(
    gbuffer=a_gbuffer,
    light=a_light,
    truth=numbers_in(np.int8, None, None),
    cause_image=numbers_in(np.int64, None, None),
    width=a_count(1, WIDEST_MARK_PX),
)
def cause_picture(
    gbuffer: GBuffer, light: Light, truth: npt.ArrayLike, cause_image: npt.ArrayLike, *, width: int = 1
) -> NDArray[np.uint8]:
    """The wrong pixels in the colours of their causes over a pale grey eye view: (H, W, 3) uint8.

    Parameters
    ----------
    gbuffer : GBuffer
        What the camera sees.
    light : DirectionalLight, SpotLight or PointLight
    truth : (H, W) int8
        From `sl.trace.shadow_mask`; it shades the grey view.
    cause_image : (H, W) int
        Of each pixel 0 where it is right, 1 acne, 2 edge, 3 leak, 4 missing, 5 other, -1 where it is not compared.
    width : int
        Pixels that each wrong pixel is drawn wide, so that a picture shown smaller than it is still shows them.

    Raises
    ------
    ArgumentError
        For images of another shape than the G-buffer's, unknown codes, and a width below 1.
    """
    codes = np.asarray(cause_image)
    same_size(gbuffer, truth=np.asarray(truth), cause_image=codes)
    if codes.min() < NOT_COMPARED or codes.max() > max(CAUSE_RGB):
        unknown = np.setdiff1d(codes, [NOT_COMPARED, 0, *CAUSE_RGB])
        raise ArgumentError(f"cause_image: expected codes -1 to 5, got {shown(unknown[:4].tolist())}")
    return causes_over(luminance(shade(gbuffer, light, truth_mask(np.asarray(truth)))), codes, width)


def causes_over(grey: np.ndarray, codes: np.ndarray, width: int = 1) -> NDArray[np.uint8]:
    """The causes over an eye view in grey (H, W), 0 to 255, that is made pale here; see `cause_picture`."""
    pale = np.empty(codes.shape, np.uint8)
    down, along = np.ogrid[:STRIPE_PX, : codes.shape[1]]
    # Rows that come again and again.
    stripes = np.where((down + along) % STRIPE_PX < 1, HATCH, 255).astype(np.uint8)
    for rows in row_bands(codes.shape):
        pale[rows] = np.rint(DARKEST + (LIGHTEST - DARKEST) * grey[rows] / 255.0)
        turn = np.arange(rows.start, rows.stop) % STRIPE_PX
        np.copyto(pale[rows], stripes[turn], where=codes[rows] == NOT_COMPARED)
    return marked(pale, codes, CAUSE_RGB, width)
