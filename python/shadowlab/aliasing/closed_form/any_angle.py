"""Closed forms of the family of perspective warps at any angle between light and view, on the view's centre ray.

Source: Zhang, Sun, Zhao, Wang 2007 [zhang2007] (GMNPR), equations 2 and 3; Zhang, Xu, Tao, Sun 2006 [zhang2006glpr]
(GLPR); Lloyd, Govindaraju, Quammen, Molnar, Manocha 2008 [lloyd2008] (LogPSM); theory.md 6, 7, 11 and E.1, with the
errata of theory.md 15.1. As there, the
light is directional and in the plane of the view direction and the image's vertical, receivers fill the view frustum,
and phi is half the vertical field of view; here that is asked for as `fov_y`, the full angle, as a camera has it.

    reference point        eye              near end (Ymin)                far end (Ymax)      light: ⊗   warp axis: ->
          x <- phi_offset sin θ ->|<- Ymin -> |<------------ D --------------> |
          x <----------- lam D -------------> |  s = 0                         |  s = 1

Departures: the papers' ψ and ϕ are put together so that nothing large cancels and an infinite `lam` is the uniform map;
with A as in (6.1) and the share β = (ϕ + z) / A - λ of the body that lies before depth z, between 0 and 1,

    F = A (λ + β)² / (tan φ λ (λ + 1) z).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .arguments import Numbers, check_within, refuse, returned, together
from .view import AngledView, bent, check_lambda, check_theta, sine_of


class Ends(NamedTuple):
    """An error at both ends of the centre ray."""

    near: Numbers
    far: Numbers


class Least(NamedTuple):
    """The least error on the centre ray, and at which depth."""

    z: Numbers
    value: Numbers


def F(
    z: npt.ArrayLike,
    *,
    theta: npt.ArrayLike,
    lam: npt.ArrayLike,
    near: npt.ArrayLike,
    far: npt.ArrayLike,
    fov_y: npt.ArrayLike,
) -> Numbers:
    """The error along the warp axis on the centre ray, `1 / (z tan φ) dz/ds`, of a perspective warp.

    Zhang, Sun, Zhao, Wang 2007 [zhang2007], equation 2; theory.md (6.2).

    Parameters
    ----------
    z : array_like of float
        Depths on the centre ray, world units, in [near, far].
    theta : array_like of float
        Angle between view direction and light, radians; obtuse ones are as their supplements. Its sine is at least
        1e-6: along the view F is infinite, while F sin(theta), as in `dp_ds_on_surface`, has a limit.
    lam : array_like of float
        Warp distance over the view's extent along the warp axis, as `warp_lambda` returns it, above 0; inf is the
        uniform map.
    near, far : array_like of float
        Depths of the near and far plane, world units, 0 < near < far.
    fov_y : array_like of float
        Full vertical field of view, radians.

    Returns
    -------
    float or ndarray
        NDC of the image, which is two high, per map, in the broadcast shape; half of it is heights of the image per
        map.

    Raises
    ------
    ArgumentError
        For a number outside its range, and shapes that do not broadcast.

    Examples
    --------
    >>> lam = warp_lambda(np.pi / 2, near=1, far=100, fov_y=np.radians(60))
    >>> F([1, 10, 100], theta=np.pi / 2, lam=lam, near=1, far=100, fov_y=np.radians(60)).round(4)
    array([17.1473,  5.6685, 17.1473])
    """
    z, theta, lam, zn, zf, fov = together(z=z, theta=theta, lam=lam, near=near, far=far, fov_y=fov_y)
    view = AngledView.of(theta, zn, zf, fov)
    check_lambda(lam)
    check_within("z", z, zn, zf)
    return returned(view.error(z, lam))


def F_ends(
    theta: npt.ArrayLike, *, lam: npt.ArrayLike, near: npt.ArrayLike, far: npt.ArrayLike, fov_y: npt.ArrayLike
) -> Ends:
    """F at the near and at the far end of the centre ray, by the equations that the paper prints for them.

    Zhang, Sun, Zhao, Wang 2007 [zhang2007], after equation 3, with its μ and ν; theory.md 6. Equal for GMNPR at theta
    of half the field of view or more.

    Parameters
    ----------
    theta, lam, near, far, fov_y : array_like of float
        As for `F`.

    Returns
    -------
    Ends
        Two floats or arrays, near and far, in units of `F`.

    Raises
    ------
    ArgumentError
        As `F`.

    Examples
    --------
    >>> ends = F_ends(np.pi / 2, lam=1 / 9, near=1, far=100, fov_y=np.radians(60))
    >>> round(ends.near, 4), round(ends.far, 4)
    (17.1473, 17.1473)
    """
    theta, lam, zn, zf, fov = together(theta=theta, lam=lam, near=near, far=far, fov_y=fov_y)
    view = AngledView.of(theta, zn, zf, fov)
    check_lambda(lam)
    ratio, t, a = zf / zn, view.tangents, view.extent
    # μ = nT / A, ν = 1 - fT / A;  below phi, A = 2fT: μ = 1/2 - (f - n) / (2fT), ν = 1/2.
    mu = np.where(view.clear, t / a, 0.5 - (ratio - 1) / (2 * ratio * t))
    nu = np.where(view.clear, 1 - ratio * t / a, 0.5)
    scale = a / np.tan(view.phi)
    return Ends(*(returned(scale * bent(share, lam) / depth) for share, depth in ((mu, 1.0), (nu, ratio))))


def F_least(
    theta: npt.ArrayLike, *, lam: npt.ArrayLike, near: npt.ArrayLike, far: npt.ArrayLike, fov_y: npt.ArrayLike
) -> Least:
    """The least F on the centre ray and its depth: at `phi_offset`, or at the end that is closer to it.

    theory.md 6, with erratum 1 of theory.md 15.1: the paper prints another depth. The value is 4 ψ ϕ inside of the ray.

    Parameters
    ----------
    theta, lam, near, far, fov_y : array_like of float
        As for `F`.

    Returns
    -------
    Least
        Depth z in world units, and value in units of `F`.

    Raises
    ------
    ArgumentError
        As `F`.

    Examples
    --------
    >>> least = F_least(np.pi / 2, lam=1 / 9, near=1, far=100, fov_y=np.radians(60))
    >>> round(least.z, 6), round(least.value, 4)
    (10.0, 5.6685)
    """
    theta, lam, zn, zf, fov = together(theta=theta, lam=lam, near=near, far=far, fov_y=fov_y)
    view = AngledView.of(theta, zn, zf, fov)
    check_lambda(lam)
    z = np.clip(view.offset(lam), zn, zf)
    return Least(returned(z), returned(view.error(z, lam)))


def F_log(
    z: npt.ArrayLike,
    *,
    theta: npt.ArrayLike,
    lam: npt.ArrayLike,
    near: npt.ArrayLike,
    far: npt.ArrayLike,
    fov_y: npt.ArrayLike,
) -> Numbers:
    """F of a logarithmic perspective map: the warp of `lam`, and after it the logarithm of its w.

    Lloyd, Govindaraju, Quammen, Molnar, Manocha 2008 [lloyd2008]; theory.md (11.2). Constant where `phi_offset` is 0:
    for GLPR's λ.

    Parameters
    ----------
    z, theta, lam, near, far, fov_y : array_like of float
        As for `F`.

    Returns
    -------
    float or ndarray
        NDC of the image, which is two high, per map, in the broadcast shape.

    Raises
    ------
    ArgumentError
        As `F`.

    Examples
    --------
    >>> lam = warp_lambda(np.pi / 2, near=1, far=100, fov_y=np.radians(60), technique="glpr")
    >>> F_log([1, 100], theta=np.pi / 2, lam=lam, near=1, far=100, fov_y=np.radians(60)).round(4)
    array([7.9764, 7.9764])
    """
    z, theta, lam, zn, zf, fov = together(z=z, theta=theta, lam=lam, near=near, far=far, fov_y=fov_y)
    view = AngledView.of(theta, zn, zf, fov)
    check_lambda(lam)
    check_within("z", z, zn, zf)
    # (11.2): (ϕ + z) ln((λ + 1) / λ) = A (1 + β/λ) · λ ln(1 + 1/λ), whose last factor goes to 1.
    inverse = 1 / lam
    last = np.divide(np.log1p(inverse), inverse, out=np.ones_like(inverse), where=inverse > 0)
    return returned(view.extent * (1 + view.share(z) * inverse) * last / (np.tan(view.phi) * (z / zn)))


def G(
    z: npt.ArrayLike,
    *,
    theta: npt.ArrayLike,
    lam: npt.ArrayLike,
    near: npt.ArrayLike,
    far: npt.ArrayLike,
    fov_y: npt.ArrayLike,
) -> Numbers:
    """The error across the warp axis on the centre ray, `1 / (z tan φx) dx/dt`, of a perspective warp.

    theory.md E.1, last paragraph: the map is as wide as the frustum's corner that is widest after the warp. `2 far / z`
    for the uniform map. The same with the logarithm of `F_log`, which leaves x alone.

    Parameters
    ----------
    z, theta, lam, near, far, fov_y : array_like of float
        As for `F`.

    Returns
    -------
    float or ndarray
        NDC of the image, which is two wide, per map, in the broadcast shape; half of it is widths of the image per map.

    Raises
    ------
    ArgumentError
        As `F`.

    Examples
    --------
    >>> G([1, 100], theta=np.pi / 2, lam=np.inf, near=1, far=100, fov_y=np.radians(60))
    array([200.,   2.])
    """
    z, theta, lam, zn, zf, fov = together(z=z, theta=theta, lam=lam, near=near, far=far, fov_y=fov_y)
    view = AngledView.of(theta, zn, zf, fov)
    check_lambda(lam)
    check_within("z", z, zn, zf)
    # (λ + β) over 1 + λ, for which an infinite λ is none.
    warped, rest = 1 / (1 + 1 / lam), 1 / (1 + lam)
    at = [zc / zn / (warped + view.corner_share(zc) * rest) for zc in (zn, zf)]
    return returned(2 / (z / zn) * (warped + view.share(z) * rest) * np.maximum(*at))


def dp_ds_on_surface(
    F: npt.ArrayLike, theta: npt.ArrayLike, *, cos_alpha: npt.ArrayLike, cos_beta: npt.ArrayLike
) -> Numbers:
    """The error dp/ds on a surface that the centre ray meets: `F sin(theta) cos(alpha) / cos(beta)`.

    theory.md 6, "On a surface"; LiSPSM's and GMNPR's dp/ds with the factor sin(theta) that erratum 3 of theory.md 15.1
    adds. The surface's normal lies in the plane of light and view.

    Parameters
    ----------
    F : array_like of float
        Error on the centre ray, as `F` or `F_log` returns it.
    theta : array_like of float
        Angle between view direction and light, radians, with a sine of 1e-6 or more.
    cos_alpha : array_like of float
        Cosine between the normal and the direction to the eye, 0 to 1.
    cos_beta : array_like of float
        Cosine between the normal and the direction to the light, above 0 and up to 1.

    Returns
    -------
    float or ndarray
        In the unit of `F`, in the broadcast shape.

    Raises
    ------
    ArgumentError
        For a number outside its range, and shapes that do not broadcast.

    Examples
    --------
    >>> dp_ds_on_surface(8.0, np.pi / 2, cos_alpha=0.5, cos_beta=1.0)
    4.0
    """
    error, theta, eye, light = together(F=F, theta=theta, cos_alpha=cos_alpha, cos_beta=cos_beta)
    refuse("F", error, ~((error > 0) & (error < math.inf)), "a finite error above 0", "closed_form.F returns it")
    check_theta(theta)
    refuse(
        "cos_alpha", eye, ~((eye >= 0) & (eye <= 1)), "a cosine in [0, 1]", "from the eye behind a surface none is seen"
    )
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        found = error * sine_of(theta) * eye / light
    possible = (light > 0) & (light <= 1) & np.isfinite(found)
    refuse("cos_beta", light, ~possible, "a cosine in (0, 1]", "light along a surface has no finite error there")
    return returned(found)
