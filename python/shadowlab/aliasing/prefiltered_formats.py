"""What a prefiltered shadow map stores in a texel, in which numbers, and the light that is read from it.

Sources: variance maps and their least variance [donnelly2006], the trouble of half floats [lauritzen2008], exponential
maps [annen2008], four moments with their quantisation [peters2015], section 4.3.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..types import Vector
from .light_bounds import chebyshev_light, exponential_light, moment_light, without_bleeding

StoredQuantity = Literal["variance", "exponential", "moment"]
Number = Literal["f16", "f32", "unorm16"]

# Numbers of a texel of each quantity.
CHANNELS: dict[StoredQuantity, int] = {"variance": 2, "exponential": 1, "moment": 4}
BYTES: dict[Number, int] = {"f16": 2, "f32": 4, "unorm16": 2}
DTYPES: dict[Number, type[np.generic]] = {"f16": np.float16, "f32": np.float32, "unorm16": np.uint16}
UNORM16_STEPS = 65535
# The largest difference of a number from what is stored: of floats as a share of it, of unorm16 half a step.
NUMBER_ROUNDING: dict[Number, float] = {"f16": 2.0**-11, "f32": 2.0**-24, "unorm16": 0.5 / UNORM16_STEPS}
# A map is rounded when it is drawn and again when it is filtered.
ROUNDINGS = 2
# The affine map of four moments to [0, 1]^4 that keeps the most volume, [peters2015] section 4.3: rows are moments.
MOMENT_TRANSFORM = np.array([
    [-2.07224649, 13.7948857237, 0.105877704, 9.7924062118],
    [32.23703778, -59.4683975703, -1.9077466311, -33.7652110555],
    [-68.571074599, 82.0359750338, 9.3496555107, 47.9456096605],
    [39.3703274134, -35.364903257, -6.6543490743, -23.9728048165],
])  # fmt: skip
MOMENT_OFFSET = np.array([0.035955884801, 0.0, 0.0, 0.0])
MOMENT_INVERSE = np.linalg.inv(MOMENT_TRANSFORM)
# Shares by which moments are moved to those of a valid distribution: that of unorm16 as published in [peters2015], of
# f32 the least of 1, 3 and 6 in each decade that keeps a map of one depth lit with the bias below; the published 3e-7
# leaves 15 of a million depths dark, for it does not count that maps are rounded twice.
MOMENT_BIAS: dict[Number, float] = {"unorm16": 3e-5, "f32": 1e-6}
# How far receivers of moment maps are moved towards the light, as a share of the range: a distribution of one depth has
# no room for rounding. Without it 5 % of the depths of a map of one depth are dark in unorm16, with it none is.
MOMENT_DEPTH_BIAS = 1e-4
# The largest exponent of single precision that is published, [annen2008] section 4; of half floats the one whose
# exponentials fill the normal numbers, from 2^-14 to 65504.
LEAST_HALF, LARGEST_HALF = 2.0**-14, 65504.0
EXPONENT: dict[Number, float] = {"f32": 80.0, "f16": float(np.log(LARGEST_HALF / LEAST_HALF))}


@dataclass(frozen=True)
class PrefilteredFormat:
    """What a texel stores.

    Attributes
    ----------
    name : str
        "variance:f16" for example.
    quantity : "variance", "exponential" or "moment"
    number : "f16", "f32" or "unorm16"
    """

    name: str
    quantity: StoredQuantity
    number: Number

    @property
    def bytes(self) -> int:
        """Of a texel."""
        return CHANNELS[self.quantity] * BYTES[self.number]

    @property
    def exponent(self) -> float | None:
        """Factor c of exp(c z); None of the other quantities."""
        return EXPONENT[self.number] if self.quantity == "exponential" else None

    def least_variance(self, mean: Vector, square: Vector) -> Vector:
        """What rounding can take off variances, in the squares of the stored depths: (19.5)."""
        # Of unorm16 the errors are steps, whatever the number, and 1 + 2 z is 3 at most.
        sizes = square + 2.0 * mean * mean if self.number != "unorm16" else np.full_like(mean, 3.0)
        least: Vector = ROUNDINGS * NUMBER_ROUNDING[self.number] * sizes
        return least

    @property
    def is_centred(self) -> bool:
        """Whether depths are stored from -1 to 1: floats then use their sign, and are finest in the middle."""
        return self.quantity == "variance" and self.number != "unorm16"

    def stored(self, depth: Vector) -> NDArray[Any]:
        """What texels of depths (...,) in [0, 1] store, (..., C), in the format's own numbers."""
        if self.quantity == "exponential":
            return self._rounded(self._exponential(depth)[..., None])
        depth = self._own(depth)
        powers = [depth ** (k + 1) for k in range(CHANNELS[self.quantity])]
        return self.restored(np.stack(powers, axis=-1))

    def restored(self, averages: Vector) -> NDArray[Any]:
        """Averages of what `read` returns (..., C) as texels store them."""
        if self.quantity == "moment" and self.number == "unorm16":
            averages = averages @ MOMENT_TRANSFORM + MOMENT_OFFSET
        return self._rounded(averages)

    def read(self, texels: NDArray[Any]) -> Vector:
        """What is averaged of texels (..., C): moments, or exponentials with the format's factor."""
        values: Vector = texels.astype(np.float64)
        if self.number == "unorm16":
            values /= UNORM16_STEPS
        if self.quantity == "moment" and self.number == "unorm16":
            values = (values - MOMENT_OFFSET) @ MOMENT_INVERSE
        return values

    def light(self, averages: Vector, depth: Vector, reduction: float) -> Vector:
        """The light that reaches receivers at depths (N,) through averages (N, C)."""
        if self.quantity == "variance":
            mean, square = averages.T
            return chebyshev_light(mean, square, self._own(depth), self.least_variance(mean, square), reduction)
        if self.quantity == "moment":
            light = moment_light(averages, depth - MOMENT_DEPTH_BIAS, MOMENT_BIAS[self.number])
            return without_bleeding(light, reduction)
        # Rounding in half floats leaves no exponential below the least of the range.
        logarithm = np.log(averages[:, 0]) - self._shift
        return exponential_light(logarithm, depth, EXPONENT[self.number])

    def _own(self, depth: Vector) -> Vector:
        """Depths as the format stores them."""
        return 2.0 * depth - 1.0 if self.is_centred else depth

    @property
    def _shift(self) -> float:
        """Half floats use their whole range: exp(c z + shift) is from the least to the largest normal number."""
        return float(np.log(LEAST_HALF)) if self.number == "f16" else 0.0

    def _exponential(self, depth: Vector) -> Vector:
        # The largest exponential is the largest number exactly, up to the rounding of logarithms.
        largest = LARGEST_HALF if self.number == "f16" else np.inf
        values: Vector = np.minimum(np.exp(EXPONENT[self.number] * depth + self._shift), largest)
        return values

    def _rounded(self, values: Vector) -> NDArray[Any]:
        if self.number == "unorm16":
            return np.rint(np.clip(values, 0.0, 1.0) * UNORM16_STEPS).astype(np.uint16)
        return values.astype(DTYPES[self.number])


#: Depths in f32 and the comparisons that the others are held against: with the nearest texel, with the whole kernel.
DEPTH_FORMATS = ("depth:nearest", "depth:pcf")
DEPTH_BYTES = 4
#: Every format that is filtered before it is read, by name.
PREFILTERED_FORMATS: dict[str, PrefilteredFormat] = {
    one.name: one
    for one in (
        PrefilteredFormat("variance:f16", "variance", "f16"),
        PrefilteredFormat("variance:unorm16", "variance", "unorm16"),
        PrefilteredFormat("variance:f32", "variance", "f32"),
        PrefilteredFormat("exponential:f16", "exponential", "f16"),
        PrefilteredFormat("exponential:f32", "exponential", "f32"),
        PrefilteredFormat("moment:unorm16", "moment", "unorm16"),
        PrefilteredFormat("moment:f32", "moment", "f32"),
    )
}
