//! Depth as a quotient of two functionals of a point: z / w of a matrix, or an affine function along the light.

use glam::{DMat4, DVec3, DVec4};

use super::kind::Spacing;
use super::texel_rays::TexelRays;
use crate::error::Result;
use crate::geometry::Rows;
use crate::parameterization::PostWarp;

/// What a map's numbers measure: `numerator . (p, 1) / denominator . (p, 1)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DepthMeasure {
    pub numerator: DVec4,
    pub denominator: DVec4,
}

/// The two rows of what a map's numbers measure of points that a matrix takes to clip space: the products with a point, (p, 1),
/// are divided by each other.
///
/// # Errors
/// As [`TexelRays::linear_row`], where depth is linear.
pub fn depth_measure(clip_from_local: &DMat4, post_warp: &PostWarp, spacing: Spacing) -> Result<[DVec4; 2]> {
    DepthMeasure::new(clip_from_local, post_warp, spacing).map(|depth| [depth.numerator, depth.denominator])
}

impl DepthMeasure {
    /// Of points that a matrix takes to clip space.
    ///
    /// # Errors
    /// As [`TexelRays::linear_row`], where depth is linear.
    pub fn new(clip_from_local: &DMat4, post_warp: &PostWarp, spacing: Spacing) -> Result<Self> {
        let rows = Rows::of(clip_from_local);
        Ok(match spacing {
            Spacing::Projective => Self { numerator: rows.z, denominator: rows.w },
            Spacing::Linear => {
                let rays = TexelRays::new(clip_from_local, post_warp, [1, 1])?;
                Self { numerator: rays.linear_row()?, denominator: DVec4::W }
            }
        })
    }
    /// The depth of a point, (p, 1).
    #[inline(always)]
    pub fn at(&self, p4: DVec4) -> f64 {
        self.numerator.dot(p4) / self.denominator.dot(p4)
    }
    /// How depth changes about a point, (p, 1), at which it is `value`.
    #[inline(always)]
    pub fn gradient(&self, p4: DVec4, value: f64) -> DVec3 {
        (self.numerator.truncate() - value * self.denominator.truncate()) / self.denominator.dot(p4)
    }
    /// How far along a vector from a point depth becomes a value; not finite where it never changes.
    pub fn way(&self, p: DVec3, along: DVec3, value: f64) -> f64 {
        let (p4, d) = (p.extend(1.0), along.extend(0.0));
        let (n, m) = (self.numerator, self.denominator);
        (value * m.dot(p4) - n.dot(p4)) / (n.dot(d) - value * m.dot(d))
    }
}
