"""How far a shadow mask is from the truth averaged over each pixel: the error beside the count of wrong pixels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..errors import ArgumentError
from ..text.arrays import checked_array
from ..travel import Value

if TYPE_CHECKING:
    import numpy.typing as npt


@dataclass(frozen=True, eq=False, repr=False)
class SoftError(Value):
    """The difference of a shadow mask from the area average of the truth.

    Attributes
    ----------
    image : (H, W) float32
        Mask minus truth, -1 to 1: above 0 where the mask is too light. NaN where they are not compared.
    unmatched : int
        Pixels in which only one of the two has a value: silhouettes whose centre shows the background, and pixels whose
        rays are all undecided.
    """

    image: NDArray[np.float32]
    unmatched: int

    @property
    def compared(self) -> int:
        """Pixels in which both have a value."""
        return int(np.count_nonzero(~np.isnan(self.image)))

    @property
    def mean(self) -> float:
        """Mean absolute error over the compared pixels, 0 to 1; 0 where none is compared."""
        return self._mean_of(np.abs(self.image, dtype=np.float64))

    @property
    def too_dark(self) -> float:
        """What false shadow contributes to `mean`."""
        return self._mean_of(np.maximum(-self.image.astype(np.float64), 0.0))

    @property
    def too_light(self) -> float:
        """What false light contributes to `mean`."""
        return self._mean_of(np.maximum(self.image.astype(np.float64), 0.0))

    def _mean_of(self, values: NDArray[np.float64]) -> float:
        compared = self.compared
        return float(np.nansum(values) / compared) if compared else 0.0

    def __float__(self) -> float:
        return self.mean

    def __repr__(self) -> str:
        return (
            f"SoftError({self.mean:.3g} on average over {self.compared:,} pixels: {self.too_dark:.3g} too dark, "
            f"{self.too_light:.3g} too light; unmatched={self.unmatched:,})"
        )


def soft_error(mask: npt.ArrayLike, soft: npt.ArrayLike) -> SoftError:
    """The mean absolute error of a shadow mask against the truth averaged over each pixel.

    `misclassified` counts pixels that are wrong at one half, and says nothing of a filter that blurs an edge in its
    right place. This counts by how much each pixel is wrong: of an unfiltered mask that is exact at the pixels' centres
    a quarter, on average over the pixels that a straight edge along the pixels' sides crosses.

    Parameters
    ----------
    mask : (H, W) array_like
        From `Renderer.shadow_mask` or `look_up`: 1 lit, 0 in shadow, NaN where nothing is.
    soft : (H, W) array_like
        From `trace.soft_shadow_mask`, of the same view and size.

    Returns
    -------
    SoftError
        `float` of it is the mean. A pixel that is NaN in either is not compared.

    Raises
    ------
    ArgumentError
        For images of other sizes, and values outside [0, 1].

    Examples
    --------
    >>> import shadowlab as sl
    >>> scene = sl.library.scene("robots")
    >>> view = (scene, scene.camera, scene.light)
    >>> soft = sl.trace.soft_shadow_mask(*view, size=(160, 90))
    >>> p = sl.technique("lispsm").parameterize(*view, resolution=1024)
    >>> mask = sl.Renderer("cpu").shadow_mask(*view, p, size=(160, 90))
    >>> 0 < sl.aliasing.soft_error(mask, soft).mean < 0.02
    True
    """
    given, exact = _light("mask", mask), _light("soft", soft)
    if given.shape != exact.shape:
        raise ArgumentError(
            f"mask, soft: expected images of one size, got shapes {list(given.shape)} and {list(exact.shape)}; make "
            "both of one view and size"
        )
    unmatched = np.isnan(given) != np.isnan(exact)
    return SoftError(given - exact, int(np.count_nonzero(unmatched)))


def _light(name: str, value: object) -> NDArray[np.float32]:
    """Light that arrives at pixels, NaN where nothing is.

    Raises
    ------
    ArgumentError
        For another shape, or values outside [0, 1].
    """
    found: NDArray[np.float32] = checked_array(name, value, np.float32, (None, None))
    outside = (found < 0) | (found > 1)
    if outside.any():
        raise ArgumentError(
            f"{name}: expected values in [0, 1], NaN where nothing is, got {found[outside][0]:g}; "
            "sl.aliasing.look_up and sl.trace.soft_shadow_mask make them"
        )
    return found
