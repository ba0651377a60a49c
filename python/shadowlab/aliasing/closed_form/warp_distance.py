"""Closed forms of warp distances at any angle between light and view: λ of each technique.

Source: Zhang, Sun, Zhao, Wang 2007 [zhang2007] (GMNPR), equations 4, 7 and 8, and of LiSPSM 9; Wimmer, Scherzer,
Purgathofer 2004 [wimmer2004], section 4.4; Zhang, Xu, Tao, Sun 2006 [zhang2006glpr] (GLPR); theory.md (5.2), (6.3) and
(7.1). GLPR's floor and what it does below are ours,
as in src/techniques/glpr.rs.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ...errors import ArgumentError
from ...text import shown
from .arguments import SMALLEST, Numbers, check_name, refuse, returned, together
from .view import LEAST_SINE, AngledView, check_angle, check_lambda, sine_of

WARPS = ("gmnpr", "lispsm", "lispsm-delta-z", "glpr", "uniform")
# The default of `lambda_floor`: LEAST_SHARE of src/techniques/glpr.rs.
LAMBDA_FLOOR = 0.1


def warp_lambda(
    theta: npt.ArrayLike,
    *,
    near: npt.ArrayLike,
    far: npt.ArrayLike,
    fov_y: npt.ArrayLike,
    technique: str = "gmnpr",
    lambda_floor: npt.ArrayLike | None = None,
) -> Numbers:
    """The warp distance of a technique over the extent of the view along the warp axis, λ = Pn / D.

    Zhang, Sun, Zhao, Wang 2007 [zhang2007], equations 4, 7, 8 and 9; theory.md (5.2), (6.3) and (7.1). Infinite where
    the map is uniform: at an angle whose sine is below 1e-6, and for "uniform".

    Parameters
    ----------
    theta : array_like of float
        Angle between view direction and light, radians, 0 to pi; obtuse ones are as their supplements.
    near, far : array_like of float
        Depths of the near and far plane, world units, 0 < near < far.
    fov_y : array_like of float
        Full vertical field of view, radians.
    technique : {"gmnpr", "lispsm", "lispsm-delta-z", "glpr", "uniform"}
        Equal errors at both ends of the centre ray (the least largest error as well, but for views narrow in depth
        under a light near half the field of view, where weaker warps have less); LiSPSM's n_opt over sin(theta), which
        is `near=basic` of the technique lispsm; LiSPSM's over the depth that the body spans, the default of the
        technique; an error that grows as depth does.
    lambda_floor : array_like of float, optional
        Of "glpr": the least λ in units of near / far; 0.1 where none is given. Between half the field of view and it
        GLPR's λ falls to 0, below it is negative: there it is raised to the floor and, for smaller angles, made weaker
        as GMNPR's is. 0 raises nothing, and is an error for angles up to half the field of view.

    Returns
    -------
    float or ndarray
        Above 0, in the broadcast shape.

    Raises
    ------
    ArgumentError
        For a number outside its range, shapes that do not broadcast, and `lambda_floor` beside another technique.
    UnknownNameError
        For another technique.

    Examples
    --------
    >>> round(warp_lambda(np.pi / 2, near=1, far=100, fov_y=np.radians(60)), 6)
    0.111111
    >>> warp_lambda(0.0, near=1, far=100, fov_y=np.radians(60))
    inf
    """
    check_name("technique", technique, WARPS)
    if lambda_floor is not None and technique != "glpr":
        raise ArgumentError(
            f'lambda_floor: expected none beside technique {technique!r}, got {shown(lambda_floor)}; "glpr" takes it'
        )
    theta, zn, zf, fov, floor = together(
        theta=theta,
        near=near,
        far=far,
        fov_y=fov_y,
        lambda_floor=LAMBDA_FLOOR if lambda_floor is None else lambda_floor,
    )
    advice = "0.1 is the default of the technique"
    refuse("lambda_floor", floor, ~((floor >= 0) & (floor < 1 / SMALLEST)), "a finite number of 0 or more", advice)
    check_angle(theta)
    uniform = sine_of(theta) < LEAST_SINE
    view = AngledView.of(np.where(uniform, LEAST_SINE, theta), zn, zf, fov)
    ratio, t, sine = zf / zn, view.tangents, np.sin(view.theta)
    # (6.3) and (7.1): below phi, over the tangent of an angle that grows from 0 to 45 degrees.
    weaker = np.tan(0.25 * np.pi * np.minimum(view.theta / view.phi, 1.0))
    if technique == "uniform":
        found = np.full_like(theta, math.inf)
    elif technique == "gmnpr":
        found = np.where(view.clear, (1 + np.sqrt(ratio) - t) / view.extent, 0.5 / np.sqrt(ratio) / weaker)
    elif technique == "glpr":
        found = np.where(view.clear, np.maximum((1 - t) / view.extent, floor / ratio), floor / ratio / weaker)
    else:
        # (5.2), over D = A sin θ: the far end of the line that has equal errors at both ends.
        end = ratio if technique == "lispsm" else 1 + view.extent * sine**2
        found = (1 + np.sqrt(end)) / (view.extent * sine**2)
    found = np.where(uniform, math.inf, found)
    degrees = "an angle above half the field of view where lambda_floor is 0"
    refuse("theta", theta, ~(found >= SMALLEST), degrees, "no warp has linear errors there; lambda_floor=0.1 goes on")
    return returned(found)


def phi_offset(
    theta: npt.ArrayLike, *, lam: npt.ArrayLike, near: npt.ArrayLike, far: npt.ArrayLike, fov_y: npt.ArrayLike
) -> Numbers:
    """How far the reference point of a warp lies behind the eye, in eye depth along the centre ray: ϕ(λ, θ).

    Zhang, Sun, Zhao, Wang 2007 [zhang2007], as printed; theory.md (6.2). F is least at this depth. √(near far) for
    GMNPR at theta of half the field of view or more, 0 for GLPR where its floor does nothing.

    Parameters
    ----------
    theta, lam, near, far, fov_y : array_like of float
        As for `F`.

    Returns
    -------
    float or ndarray
        World units, in the broadcast shape; negative before the eye, infinite for an infinite `lam`.

    Raises
    ------
    ArgumentError
        As `F`.

    Examples
    --------
    >>> round(phi_offset(np.pi / 2, lam=1 / 9, near=1, far=100, fov_y=np.radians(60)), 12)
    10.0
    """
    theta, lam, zn, zf, fov = together(theta=theta, lam=lam, near=near, far=far, fov_y=fov_y)
    view = AngledView.of(theta, zn, zf, fov)
    check_lambda(lam)
    return returned(view.offset(lam))
