"""What the small numbers in images of codes mean."""

from __future__ import annotations

from enum import IntEnum

# Light from which on a pixel counts as lit: as of `misclassified`.
LIT_FROM = 0.5


class NoTexel(IntEnum):
    """Why a pixel has no map, in `Footprint.map`; maps count from 0."""

    NO_MAP = -1  # it faces the light and no map holds it: it is lit
    AVERTED = -2  # it faces away from the light, or is beyond its cone or range
    NOTHING = -3  # it shows no surface


class Difference(IntEnum):
    """What a mask and the truth say of a pixel, in `Misclassified.image`."""

    NOT_COMPARED = -1
    AGREE = 0
    FALSE_SHADOW = 1
    FALSE_LIGHT = 2


class Cause(IntEnum):
    """Why a pixel is wrong, in `Causes.image`."""

    NOT_COMPARED = -1
    RIGHT = 0
    ACNE = 1
    EDGE = 2
    LEAK = 3
    MISSING = 4
    OTHER = 5
