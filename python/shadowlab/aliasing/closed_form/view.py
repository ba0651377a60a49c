"""The view frustum as a directional light at an angle sees it: what the closed forms of `any_angle` stand on.

Source: Zhang, Sun, Zhao, Wang 2007 [zhang2007], section 3; theory.md (6.1) and (6.2). Lengths are in units of near, so
that no product leaves float64's range.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .arguments import SMALLEST, Array, check_depths, check_fov, refuse

# Below this sine of the angle between light and view there is no warp: LEAST_KAPPA of src/focus/warp.rs.
LEAST_SINE = 1e-6


@dataclass(frozen=True, eq=False)
class AngledView:
    """What theory.md 6 derives from an angle and a frustum; lengths in units of near."""

    near: Array
    #: At most a right angle.
    theta: Array
    #: Half the vertical field of view.
    phi: Array
    #: T = tan φ / tan θ.
    tangents: Array
    #: Where θ ≥ φ: the whole frustum lies before the eye as the light sees it.
    clear: npt.NDArray[np.bool_]
    #: A of (6.1).
    extent: Array
    #: The depth of the corner that is the near end, along the warp axis: n where clear, else f.
    first: Array

    @classmethod
    def of(cls, theta: Array, near: Array, far: Array, fov_y: Array) -> AngledView:
        """The view, checked."""
        check_theta(theta)
        check_depths(near, far)
        check_fov(fov_y)
        acute, phi = acute_of(theta), 0.5 * fov_y
        tangents = np.tan(phi) * np.cos(acute) / np.sin(acute)
        clear = acute >= phi
        ratio = far / near
        # (6.1)
        extent = np.where(clear, (far - near) / near + (ratio + 1) * tangents, 2 * ratio * tangents)
        return cls(near, acute, phi, tangents, clear, extent, np.where(clear, near, far))

    def share(self, z: Array) -> Array:
        """β: how much of the body lies before the centre ray's point at depth z, along the warp axis; 0 to 1."""
        share: Array = ((z - self.first) / self.near + self.first / self.near * self.tangents) / self.extent
        return share

    def corner_share(self, z: Array) -> Array:
        """β of the corners at depth z that are nearest along the warp axis."""
        share: Array = (z - self.first) / self.near * (1 - self.tangents) / self.extent
        return share

    def offset(self, lam: Array) -> Array:
        """ϕ of (6.2), in world units."""
        with np.errstate(over="ignore"):
            offset: Array = self.near * (self.extent * lam) - self.first * (1 - self.tangents)
        return offset

    def error(self, z: Array, lam: Array) -> Array:
        """F of (6.2)."""
        error: Array = self.extent * bent(self.share(z), lam) / (np.tan(self.phi) * (z / self.near))
        return error


def bent(share: Array, lam: Array) -> Array:
    """(λ + β)² / (λ (λ + 1)), 1 for an infinite λ."""
    inverse = 1 / lam
    bent: Array = (1 + share * inverse) ** 2 / (1 + inverse)
    return bent


def sine_of(theta: Array) -> Array:
    """The sine of an angle, of its supplement for obtuse ones, so that that of pi is 0."""
    sine: Array = np.sin(acute_of(theta))
    return sine


def acute_of(theta: Array) -> Array:
    """The angle or its supplement, whichever is at most a right one."""
    return np.where(theta > 0.5 * np.pi, np.pi - theta, theta)


def check_angle(theta: Array) -> None:
    """Raises unless theta is an angle between two directions."""
    wrong = ~((theta >= 0) & (theta <= np.pi))
    refuse("theta", theta, wrong, "an angle in [0, pi] radians", "np.radians makes one of degrees")


def check_theta(theta: Array) -> None:
    """Raises unless theta is an angle between two directions that a warp can act between."""
    check_angle(theta)
    # An angle of just LEAST_SINE has a sine that is a little less.
    along = sine_of(theta) < LEAST_SINE * (1 - LEAST_SINE)
    expected = f"an angle in [{LEAST_SINE:g}, pi - {LEAST_SINE:g}] radians"
    refuse("theta", theta, along, expected, "light along the view has no warp axis; F grows beyond all bounds there")


def check_lambda(lam: Array) -> None:
    """Raises unless lam is a warp distance over an extent."""
    advice = "warp_lambda returns one, inf is the uniform map"
    refuse("lam", lam, ~(lam >= SMALLEST), "a number above 0", advice)
