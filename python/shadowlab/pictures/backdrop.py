"""An eye view with its truth, made once for all pictures that are drawn over it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, cast

import numpy as np

from .causes import causes_over
from .errors import errors_over, image_codes, tones
from .eye import difference_over, luminance, shade, truth_mask

if TYPE_CHECKING:
    from .._core import GBuffer
    from ..aliasing.footprint import Footprint
    from ..types import Light


class Once:
    """An array that is made when it is first asked for, once for all threads."""

    def __init__(self, make: Callable[[], np.ndarray]):
        self._make, self._lock = make, threading.Lock()
        self._made: np.ndarray | None = None

    def __call__(self) -> np.ndarray:
        """The array."""
        with self._lock:
            if self._made is None:
                self._made = self._make()
            return self._made


class Backdrop:
    """What the pictures of one view share.

    Parameters
    ----------
    gbuffer : GBuffer
    light : DirectionalLight, SpotLight or PointLight
    truth : (H, W) int8, optional
        Needed for `lit` and what is drawn over it.
    """

    def __init__(self, gbuffer: GBuffer, light: Light, truth: np.ndarray | None = None):
        self._gbuffer, self._light = gbuffer, light
        self._lit = Once(lambda: shade(gbuffer, light, truth_mask(cast("np.ndarray", truth))))
        self._grey = Once(lambda: luminance(self._lit()))
        self._tone = Once(lambda: tones(np.shape(gbuffer.triangle), gbuffer, light))

    @property
    def lit(self) -> np.ndarray:
        """The eye view with its true shadows (H, W, 3) uint8."""
        return self._lit()

    @property
    def grey(self) -> np.ndarray:
        """The luminance (H, W) float32 of `lit`, 0 to 255."""
        return self._grey()

    def shaded(self, mask: np.ndarray) -> np.ndarray:
        """The eye view with the shadows of a mask; see `shade`."""
        return shade(self._gbuffer, self._light, mask)

    def difference(self, image: np.ndarray, width: int = 1) -> np.ndarray:
        """The wrong pixels; see `difference`."""
        return difference_over(self.grey, image, width)

    def causes(self, image: np.ndarray, width: int = 1) -> np.ndarray:
        """The causes of wrong pixels; see `cause_picture`."""
        return causes_over(self.grey, image, width)

    def texels(self, footprint: Footprint) -> np.ndarray:
        """The size of texels; see `error_picture`."""
        return errors_over(self._tone(), image_codes(footprint), np.asarray(footprint.major))
