//! What a search over warp distances makes small, and what all measures of it share: the scale of a warp's map.
//!
//! With eta in [0, 1] along the body's extent D and mu = D / Pn, q = (1 + mu eta) / (1 + mu) is w over its largest value
//! ([`BodyError`](super::BodyError)).

use glam::DVec2;

/// What a search makes small: an error for each strength of a warp and extent of its map.
pub trait Measure {
    /// The error of a map in which receivers span `ndc`: of [`WarpSpace::warped`] at distance D / mu, or of the space itself
    /// for mu = 0.
    fn error(&self, mu: f64, ndc: DVec2) -> f64;
    /// Nearly the same, for less.
    fn rough(&self, mu: f64, ndc: DVec2) -> f64 {
        self.error(mu, ndc)
    }
    /// Whether one map's error is known to be less than another's.
    fn is_less(&self, error: f64, other: f64) -> bool;
}

/// q at a place along the axis.
pub(super) fn q_at(mu: f64, eta: f64) -> f64 {
    (1.0 + mu * eta) / (1.0 + mu)
}

/// Extents Ex and Ey in a map in which receivers span 1 of NDC x and y.
pub(super) fn across_along_per_ndc(mu: f64) -> DVec2 {
    // warped() has w = 1 at Pn + D / 2, q is 1 at Pn + D.
    let (far, middle) = (1.0 + mu, 1.0 + 0.5 * mu);
    DVec2::new(far / middle, far * far / middle)
}
