"""Closed forms of storage and of depth splits, under a light overhead.

Source: Lloyd, Tuft, Yoon, Manocha 2006 [lloyd2006] (storage factor); Zhang, Sun, Xu, Lun 2006 [zhang2006] (splits);
theory.md 12.1, 18.1 and E.1. A
warp within a split is that of a camera with the split's planes; the image, and with it the errors' unit, is the whole
one.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ...errors import ArgumentError
from .arguments import (
    END_SLACK,
    LARGEST_RATIO,
    Numbers,
    check_depths,
    check_fov,
    check_name,
    check_whole,
    refuse,
    returned,
    together,
)
from .overhead import IDEAL, dp_ds

SCHEMES = ("uniform", "logarithmic", "practical")
# Depths of more splits would not be told apart in single precision.
MOST_SPLITS = 1_000_000


def storage_factor(*, ratio: npt.ArrayLike, fov_y: npt.ArrayLike, technique: str, splits: npt.ArrayLike = 1) -> Numbers:
    """Texels per pixel that the maps need so that nowhere a texel is larger than a pixel, under a light overhead.

    Lloyd, Tuft, Yoon, Manocha 2006 [lloyd2006]; theory.md E.1, E.2 and 18.1. The largest error along the view times the
    largest across it, in pixels, for one texel per pixel and receivers that fill the view frustum; the sum over all
    maps. It is the same for every n of LiSPSM from near to n_opt, "psm" and "lispsm" among them.

    Parameters
    ----------
    ratio : array_like of float
        Far over near, above 1.
    fov_y : array_like of float
        Full vertical field of view, radians, of a square image.
    technique : {"uniform", "psm", "perspective", "lispsm", "log"}
        The map of each split.
    splits : array_like of int
        How many logarithmic depth splits, each with a map of its own.

    Returns
    -------
    float or ndarray
        Texels per pixel, in the broadcast shape.

    Raises
    ------
    ArgumentError
        For a number outside its range, and for shapes that do not broadcast.
    UnknownNameError
        For another technique.

    Examples
    --------
    >>> round(storage_factor(ratio=100, fov_y=np.radians(60), technique="uniform"))
    8574
    >>> round(storage_factor(ratio=100, fov_y=np.radians(60), technique="lispsm", splits=4), 2)
    7.49
    """
    check_name("technique", technique, IDEAL)
    r, fov, k = together(ratio=ratio, fov_y=fov_y, splits=splits)
    advice = "it is far over near, such as 100"
    refuse("ratio", r, ~((r > 1) & (r <= LARGEST_RATIO)), f"above 1 and at most {LARGEST_RATIO:.1e}", advice)
    check_fov(fov)
    check_whole("splits", k)
    height = 2 * np.tan(0.5 * fov)
    if technique == "log":
        return returned(np.log(r) / height)
    of_one = np.log(r) / k
    across = np.exp(of_one) if technique == "uniform" else 1.0
    return returned(k * across * np.expm1(of_one) / height)


def splits(
    *,
    near: npt.ArrayLike,
    far: npt.ArrayLike,
    count: int,
    scheme: str = "logarithmic",
    blend: npt.ArrayLike = 0.5,
) -> npt.NDArray[np.float64]:
    """The depths between which a view is split, both ends included.

    Zhang, Sun, Xu, Lun 2006 [zhang2006] (parallel-split shadow maps); theory.md (12.1).

    Parameters
    ----------
    near, far : array_like of float
        Depths of the near and far plane, world units, 0 < near < far.
    count : int
        How many splits.
    scheme : {"uniform", "logarithmic", "practical"}
        All equally long; all equally long in ratio; a blend of both.
    blend : array_like of float
        Share of the logarithmic scheme in the practical one, 0 to 1; the other schemes have none.

    Returns
    -------
    (count + 1,) ndarray
        Ascending depths, world units; (..., count + 1) where near, far or blend are arrays.

    Raises
    ------
    ArgumentError
        For a number outside its range, and for shapes that do not broadcast.
    UnknownNameError
        For another scheme.

    Examples
    --------
    >>> splits(near=1, far=10000, count=4)
    array([1.e+00, 1.e+01, 1.e+02, 1.e+03, 1.e+04])
    >>> splits(near=1, far=100, count=4, scheme="uniform")
    array([  1.  ,  25.75,  50.5 ,  75.25, 100.  ])
    """
    check_name("scheme", scheme, SCHEMES)
    zn, zf, share = together(near=near, far=far, blend=blend)
    check_depths(zn, zf)
    refuse("blend", share, ~((share >= 0) & (share <= 1)), "a share in [0, 1]", "1 is all logarithmic")
    (how_many,) = together(count=count)
    if how_many.ndim > 0:
        raise ArgumentError(f"count: expected one number, got shape {how_many.shape}; call once for each")
    check_whole("count", how_many)
    refuse("count", how_many, how_many > MOST_SPLITS, f"at most {MOST_SPLITS}", "4 is a common number of splits")
    if scheme != "practical":
        share = np.full_like(share, 1.0 if scheme == "logarithmic" else 0.0)
    at = np.arange(int(how_many) + 1) / float(how_many)
    zn, zf, share = zn[..., None], zf[..., None], share[..., None]
    depths = share * (zn * (zf / zn) ** at) + (1 - share) * (zn + (zf - zn) * at)
    depths[..., :1], depths[..., -1:] = zn, zf
    return np.clip(depths, zn, zf)


def dp_ds_in_split(
    z: npt.ArrayLike,
    *,
    near: npt.ArrayLike,
    far: npt.ArrayLike,
    split_near: npt.ArrayLike,
    split_far: npt.ArrayLike,
    technique: str,
    n: npt.ArrayLike | None = None,
) -> Numbers:
    """The error along the view, dp/ds, of the map of one depth split in the ideal case.

    theory.md (12.2): `dp_ds` of a camera with the split's planes, times near / split_near, since the image is that of
    the whole view.

    Parameters
    ----------
    z : array_like of float
        Depths of receivers, world units, in [split_near, split_far].
    near, far : array_like of float
        Depths of the view's near and far plane, world units, 0 < near < far.
    split_near, split_far : array_like of float
        Where the split begins and ends, world units, near <= split_near < split_far <= far.
    technique : {"uniform", "psm", "perspective", "lispsm", "log"}
        The split's map, as for `dp_ds`.
    n : array_like of float, optional
        Of "lispsm": distance from the reference point to the split's near plane, world units, split_near or more;
        `n_opt(split_near, split_far)` where none is given.

    Returns
    -------
    float or ndarray
        Lengths on the view's near plane per map, world units, in the broadcast shape.

    Raises
    ------
    ArgumentError
        For a number outside its range, shapes that do not broadcast, and `n` beside a technique that has none.
    UnknownNameError
        For another technique.

    Examples
    --------
    >>> round(dp_ds_in_split(10, near=1, far=100, split_near=10, split_far=100, technique="uniform"), 12)
    9.0
    """
    check_name("technique", technique, IDEAL)
    given = {} if n is None else {"n": n}
    z, zn, zf, begin, end, *distance = together(
        z=z, near=near, far=far, split_near=split_near, split_far=split_far, **given
    )
    check_depths(zn, zf)
    advice = "splits(near=near, far=far, count=4) has pairs of them"
    outside = ~((begin >= zn * (1 - END_SLACK)) & (begin < math.inf))
    refuse("split_near", begin, outside, "a depth from near = {near}", advice, near=zn)
    check_depths(begin, end, ("split_near", "split_far"))
    refuse("split_far", end, ~(end * (1 - END_SLACK) <= zf), "a depth up to far = {far}", advice, far=zf)
    of_split = dp_ds(z, near=begin, far=end, technique=technique, n=distance[0] if distance else None)
    return returned(zn / begin * of_split)


def max_dp_ds_of_splits(*, near: npt.ArrayLike, far: npt.ArrayLike, count: npt.ArrayLike, technique: str) -> Numbers:
    """The largest error along the view, dp/ds, of logarithmic depth splits in the ideal case; the same in every split.

    theory.md 12.1, with R = (far / near)^(1 / count): near (R - 1) for "uniform" and "psm", near (R - 1) / √R for
    "lispsm" with n_opt, near ln R for "log".

    Parameters
    ----------
    near, far : array_like of float
        Depths of the near and far plane, world units, 0 < near < far.
    count : array_like of int
        How many splits.
    technique : {"uniform", "psm", "perspective", "lispsm", "log"}
        The map of each split.

    Returns
    -------
    float or ndarray
        Lengths on the near plane per map, world units, in the broadcast shape.

    Raises
    ------
    ArgumentError
        For a number outside its range, and for shapes that do not broadcast.
    UnknownNameError
        For another technique.

    Examples
    --------
    >>> round(max_dp_ds_of_splits(near=1, far=10000, count=4, technique="uniform"), 12)
    9.0
    """
    check_name("technique", technique, IDEAL)
    zn, zf, k = together(near=near, far=far, count=count)
    check_depths(zn, zf)
    check_whole("count", k)
    of_one = np.log1p((zf - zn) / zn) / k
    if technique == "log":
        return returned(zn * of_one)
    # (R - 1) / √R = 2 sinh(ln(R) / 2).
    return returned(zn * (2 * np.sinh(0.5 * of_one) if technique == "lispsm" else np.expm1(of_one)))
