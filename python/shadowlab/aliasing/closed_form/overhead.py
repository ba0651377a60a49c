"""Closed forms of the ideal case: a light overhead, and receivers that fill the view frustum.

Source: Wimmer, Scherzer, Purgathofer 2004 [wimmer2004] (LiSPSM), equations 1 to 3 and sections 4.1 to 4.3; theory.md
E.1, (E.1) to (E.4), with the errata of theory.md 15.2. Departure: all are written with q = near / n, which is 0 for the
uniform map and 1 for the perspective one, so that no n is too large.

    reference point     eye           near                      far       light from above, s along the view
          x--------------x-------------|-------------------------|--> z
          |<---- n - near ------------>|  s = 0                  |  s = 1
          |<------------ n ----------->|

p is a length on the near plane. Heights of the image are p over 2 near tan(fov_y / 2).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...errors import ArgumentError
from ...text import shown
from ...travel import Value
from .arguments import (
    END_SLACK,
    Array,
    Numbers,
    check_depths,
    check_name,
    check_within,
    real,
    refuse,
    returned,
    together,
)

# "perspective" is what the LiSPSM paper calls a perspective shadow map.
IDEAL = ("uniform", "psm", "perspective", "lispsm", "log")
# Two ends whose errors differ by less have equal ones, up to the rounding of a dozen operations.
TIE = 16 * float(np.finfo(np.float64).eps)


def n_opt(near: npt.ArrayLike, far: npt.ArrayLike) -> Numbers:
    """LiSPSM's distance from the reference point to the near plane with the least largest error along the view.

    `n_opt = zn + √(zn zf)`: Wimmer, Scherzer, Purgathofer 2004 [wimmer2004], section 4.3; theory.md E.1. At a light
    angle theta the paper divides it by sin(theta), GMNPR multiplies (`warp_lambda`).

    Parameters
    ----------
    near, far : array_like of float
        Depths of the near and far plane, world units, 0 < near < far.

    Returns
    -------
    float or ndarray
        World units, in the broadcast shape.

    Raises
    ------
    ArgumentError
        For other depths.

    Examples
    --------
    >>> n_opt(1, 100)
    11.0
    """
    zn, zf = together(near=near, far=far)
    check_depths(zn, zf)
    return returned(zn + np.sqrt(zn) * np.sqrt(zf))


def dp_ds(
    z: npt.ArrayLike,
    *,
    near: npt.ArrayLike,
    far: npt.ArrayLike,
    technique: str = "lispsm",
    n: npt.ArrayLike | None = None,
) -> Numbers:
    """The error along the view, dp/ds, of a map in the ideal case: how far the image moves as s runs over the map.

    Wimmer, Scherzer, Purgathofer 2004 [wimmer2004], equations 1 and 3; theory.md (E.2) and (E.3). Its integral over the
    map is the whole view: that of near / (z dp/ds) over [near, far] is 1.

    Parameters
    ----------
    z : array_like of float
        Depths of receivers, world units, in [near, far].
    near, far : array_like of float
        Depths of the near and far plane, world units, 0 < near < far.
    technique : {"uniform", "psm", "perspective", "lispsm", "log"}
        "perspective" is another name of "psm"; "log" is the ideal logarithmic map, and LogPSM.
    n : array_like of float, optional
        Of "lispsm": distance from the reference point to the near plane, world units, near or more; `n_opt` where none
        is given. As large as infinity, where the map is uniform.

    Returns
    -------
    float or ndarray
        Lengths on the near plane per map, world units, in the broadcast shape. Over `2 near tan(fov_y / 2)` they are
        heights of the image per map; these, times the image's height in pixels over the map's in texels, are pixels per
        texel.

    Raises
    ------
    ArgumentError
        For a number outside its range, shapes that do not broadcast, and `n` beside a technique that has none.
    UnknownNameError
        For another technique.

    Examples
    --------
    >>> dp_ds(1, near=1, far=100), dp_ds(100, near=1, far=100)
    (9.9, 9.9)
    >>> dp_ds([1, 10, 100], near=1, far=100, technique="uniform")
    array([99.  ,  9.9 ,  0.99])
    """
    z, zn, zf, q = _ideal(z, near, far, technique, n)
    range_ = (zf - zn) / zn
    if technique == "log":
        # theory.md E.1: s = ln(z / zn) / ln(zf / zn).
        return returned(zn * np.log1p(range_))
    # (E.3) over n², with beyond = z / zn - 1: (z - zn + n)² / z · zn (zf - zn) / (n (n + zf - zn)).
    beyond = (z - zn) / zn
    reach = 1 + beyond * q
    return returned((zf - zn) * (reach / (1 + range_ * q)) * (reach / (1 + beyond)))


def dp_dt(
    z: npt.ArrayLike,
    *,
    near: npt.ArrayLike,
    far: npt.ArrayLike,
    technique: str = "lispsm",
    n: npt.ArrayLike | None = None,
) -> Numbers:
    """The error across the view, dp/dt, of a map in the ideal case: widths of the image per map.

    Wimmer, Scherzer, Purgathofer 2004 [wimmer2004], section 4.3, with erratum 3 of theory.md 15.2; theory.md (E.4). 1
    for "psm" and "log", z for depth far / z for "uniform".

    Parameters
    ----------
    z : array_like of float
        Depths of receivers, world units, in [near, far].
    near, far : array_like of float
        Depths of the near and far plane, world units, 0 < near < far.
    technique : {"uniform", "psm", "perspective", "lispsm", "log"}
        As for `dp_ds`.
    n : array_like of float, optional
        As for `dp_ds`.

    Returns
    -------
    float or ndarray
        Widths of the image per map, in the broadcast shape.

    Raises
    ------
    ArgumentError
        For a number outside its range, shapes that do not broadcast, and `n` beside a technique that has none.
    UnknownNameError
        For another technique.

    Examples
    --------
    >>> dp_dt([1, 10, 100], near=1, far=100, technique="uniform")
    array([100.,  10.,   1.])
    >>> dp_dt(1, near=1, far=100)
    10.0
    """
    z, zn, zf, q = _ideal(z, near, far, technique, n)
    # (E.4) over n: zf (z - zn + n) / (z (zf - zn + n)).
    beyond, range_ = (z - zn) / zn, (zf - zn) / zn
    return returned((1 + range_) * ((1 + beyond * q) / (1 + range_ * q)) / (1 + beyond))


@dataclass(frozen=True, eq=False)
class Worst(Value):
    """The largest and least errors of a map in the ideal case, and where; floats, or arrays of one shape.

    Where an error has one value at several depths, the nearest of them is named.
    """

    #: As it was asked for.
    technique: str
    #: World units.
    near: Numbers
    #: World units.
    far: Numbers
    #: Distance from the reference point to the near plane, world units: infinite for "uniform", near for "psm" and
    #: "log".
    n: Numbers
    #: As `dp_ds` returns it, and at which depth.
    max_dp_ds: Numbers
    max_dp_ds_z: Numbers
    #: As `dp_ds` returns it, and at which depth.
    min_dp_ds: Numbers
    min_dp_ds_z: Numbers
    #: As `dp_dt` returns it, and at which depth.
    max_dp_dt: Numbers
    max_dp_dt_z: Numbers
    #: max dp/ds times max dp/dt; over `2 near tan(fov_y / 2)` it is `storage_factor`.
    storage: Numbers


def worst(*, near: npt.ArrayLike, far: npt.ArrayLike, technique: str, n: npt.ArrayLike | None = None) -> Worst:
    """The largest and least errors of a map in the ideal case, where they are, and what they cost in texels.

    theory.md E.1, its table: dp/ds is convex in z, least at n - near, largest at an end; dp/dt falls with z. For every
    n in [near, n_opt] the product of both largest errors is far - near.

    Parameters
    ----------
    near, far : array_like of float
        Depths of the near and far plane, world units, 0 < near < far.
    technique : {"uniform", "psm", "perspective", "lispsm", "log"}
        As for `dp_ds`.
    n : array_like of float, optional
        As for `dp_ds`.

    Returns
    -------
    Worst

    Raises
    ------
    ArgumentError
        For a number outside its range, shapes that do not broadcast, and `n` beside a technique that has none.
    UnknownNameError
        For another technique.

    Examples
    --------
    >>> w = worst(near=1, far=100, technique="lispsm")
    >>> round(w.max_dp_ds, 4), round(w.min_dp_ds, 4), w.min_dp_ds_z, round(w.max_dp_dt, 4), round(w.storage, 4)
    (9.9, 3.2727, 10.0, 10.0, 99.0)
    """
    real("near", near)  # by its own name before it stands for a depth
    _, zn, zf, q = _ideal(near, near, far, technique, n)

    def along(z: npt.ArrayLike) -> Array:
        return np.asarray(dp_ds(z, near=zn, far=zf, technique=technique, n=n))

    def across(z: npt.ArrayLike) -> Array:
        return np.asarray(dp_dt(z, near=zn, far=zf, technique=technique, n=n))

    with np.errstate(divide="ignore"):
        distance = np.where(q > 0, zn / q, np.inf)
    # The minimum of (z + n - zn)² / z; for the logarithm, which has none, the nearest depth of all.
    least_z = zn if technique == "log" else np.clip(distance - zn, zn, zf)
    largest_z = np.where(along(zf) > along(zn) * (1 + TIE), zf, zn)
    largest, widest = along(largest_z), across(zn)
    return Worst(
        technique=technique,
        near=returned(zn),
        far=returned(zf),
        n=returned(distance),
        max_dp_ds=returned(largest),
        max_dp_ds_z=returned(largest_z),
        min_dp_ds=returned(along(least_z)),
        min_dp_ds_z=returned(least_z),
        max_dp_dt=returned(widest),
        max_dp_dt_z=returned(zn),
        storage=returned(largest * widest),
    )


def _ideal(
    z: npt.ArrayLike, near: npt.ArrayLike, far: npt.ArrayLike, technique: str, n: npt.ArrayLike | None
) -> tuple[Array, Array, Array, Array]:
    """z, near, far and q = near / n, checked and of one shape."""
    check_name("technique", technique, IDEAL)
    if n is not None and technique != "lispsm":
        raise ArgumentError(f'n: expected none beside technique {technique!r}, got {shown(n)}; "lispsm" takes any')
    given = {} if n is None else {"n": n}
    z, zn, zf, *distance = together(z=z, near=near, far=far, **given)
    check_depths(zn, zf)
    check_within("z", z, zn, zf)
    if distance:
        advice = "near is the perspective map, n_opt(near, far) the default, inf the uniform map"
        refuse(
            "n", distance[0], ~(distance[0] >= zn * (1 - END_SLACK)), "{near}, the near depth, or more", advice, near=zn
        )
        return z, zn, zf, zn / distance[0]
    if technique == "lispsm":
        return z, zn, zf, 1 / (1 + np.sqrt(zf / zn))
    return z, zn, zf, np.full_like(zn, 0.0 if technique == "uniform" else 1.0)
