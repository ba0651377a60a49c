//! The published search: the last row of the homography turned against the gradient, everything else by the smallest rectangle.
//!
//! Source: Chong, Gortler 2007 `[chong2007]`, algorithm 1 with its angles and three iterations; theory.md 10, with (10.5), the
//! gradient that the paper leaves out. It holds the affine part fixed while what is accepted has it fitted anew, so it mostly
//! stalls after a step (theory.md 10.1). Departure: under a placed light the first row is the mean of the samples' directions,
//! not of their places.
//!
//! ```text
//!      u_i = p_i·Y / p4·Y            Y = (y, 1)
//!      ∂J_ij / ∂p4 = ((2 u_i p4_j - p_ij) Y / W - u_i e_j) / W,   W = p4·Y
//!      ∂h / ∂p4 = -2 Σ (GᵀG J⁻ᵀ)_ij ∂J_ij / ∂p4,   G = D J⁻¹,   h = Σ |G|²
//! ```

use glam::{DMat2, DMat3, DQuat, DVec2, DVec3};

use super::kernel::Sample;
use crate::geometry::{convex_hull, planar_image};

/// Turns that are tried, degrees.
const ANGLES: [f64; 8] = [3.0, 5.0, 8.0, 15.0, 23.0, 30.0, 40.0, 50.0];
/// Iterations.
pub const ITERATIONS: usize = 3;

/// The parallelogram of least area around a polygon among the rectangles flush with its sides, sheared along them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Enclosing {
    /// From the plane to [-1, 1]²: x and y of (u, 1).
    pub rows: [DVec3; 2],
    /// Its area.
    pub area: f64,
}

/// The smallest rectangle around a convex polygon's corners with a shear along its flush side; nothing without area. The best
/// shear brings the other sides flush with one of the polygon's, too, so pairs of its sides are all there is to try.
pub fn enclosing(corners: &[DVec2]) -> Option<Enclosing> {
    let sides = (0..corners.len()).map(|i| corners[(i + 1) % corners.len()] - corners[i]);
    // Across each side, the extent of the polygon.
    let flush: Vec<(DVec2, f64, f64)> = sides
        .filter_map(|side| {
            let across = side.try_normalize()?.perp();
            let at = corners.iter().map(|p| across.dot(*p));
            let (low, high) = at.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
            Some((across, low, high))
        })
        .collect();
    let mut best: Option<(f64, usize, usize)> = None;
    for (i, (a, low, high)) in flush.iter().enumerate() {
        for (j, (b, b_low, b_high)) in flush.iter().enumerate().skip(i + 1) {
            let area = (high - low) * (b_high - b_low) / a.perp_dot(*b).abs();
            if area > 0.0 && area.is_finite() && best.is_none_or(|(least, ..)| area < least) {
                best = Some((area, i, j));
            }
        }
    }
    let (area, i, j) = best?;
    let row = |(axis, low, high): (DVec2, f64, f64)| (axis * 2.0).extend(-(low + high)) / (high - low);
    let (y, x) = (flush[i], flush[j]);
    // To the right of y.
    let x = if x.0.perp_dot(y.0) > 0.0 { x } else { (-x.0, -x.2, -x.1) };
    Some(Enclosing { rows: [row(x), row(y)], area })
}

/// A homography that the search accepted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Of rays.
    pub homography: DMat3,
    /// h, the sum of (10.4).
    pub sum: f64,
}

/// Samples, told in the coordinates of Y, and the hull that a map must hold.
#[derive(Debug, Clone)]
pub struct Published {
    /// Corners.
    pub hull: Vec<DVec2>,
    /// Samples with both rows of d(pixel) / dy.
    pub samples: Vec<Sample>,
}

impl Published {
    /// The homography of a last row: the smallest sheared rectangle in the plane across it. Nothing where w is not positive on
    /// the hull.
    pub fn affine(&self, p4: DVec3) -> Option<DMat3> {
        let (r1, r2) = p4.normalize().any_orthonormal_pair();
        let mut corners = Vec::with_capacity(self.hull.len());
        for y in &self.hull {
            let y = y.extend(1.0);
            let w = p4.dot(y);
            if w <= 0.0 {
                return None;
            }
            corners.push(DVec2::new(r1.dot(y), r2.dot(y)) / w);
        }
        convex_hull(&mut corners, &mut Vec::new());
        let rows = enclosing(&corners)?.rows.map(|row| r1 * row.x + r2 * row.y + p4 * row.z);
        Some(DMat3::from_cols(rows[0], rows[1], p4).transpose())
    }
    /// h, the sum of (10.4), of a homography.
    pub fn sum(&self, homography: &DMat3) -> f64 {
        self.samples.iter().map(|s| s.weight * squares(&looked(homography, s).2)).sum()
    }
    /// Its derivative by the last row, the others as they are (10.5).
    pub fn slope(&self, homography: &DMat3) -> DVec3 {
        let p4 = homography.row(2);
        let mut slope = DVec3::ZERO;
        for s in &self.samples {
            let (y, w) = (s.y.extend(1.0), p4.dot(s.y.extend(1.0)));
            let (u, inverse, g) = looked(homography, s);
            let by_j = g.transpose() * g * inverse.transpose();
            for i in 0..2 {
                let row = homography.row(i);
                for j in 0..2 {
                    let by = (y * ((2.0 * u[i] * p4[j] - row[j]) / w) - DVec3::AXES[j] * u[i]) / w;
                    slope -= by * (2.0 * s.weight * by_j.col(j)[i]);
                }
            }
        }
        slope
    }
    /// Every homography that the search accepts, from the first to the one that it ends with. Nothing where the first has none.
    pub fn search(&self, first: DVec3) -> Option<Vec<Step>> {
        let step = |homography: DMat3| Step { homography, sum: self.sum(&homography) };
        let mut best = step(self.affine(first.try_normalize()?)?);
        let mut steps = vec![best];
        for _ in 0..ITERATIONS {
            let p4 = best.homography.row(2);
            let Some(axis) = p4.cross(-self.slope(&best.homography)).try_normalize() else { break };
            let turned = ANGLES
                .iter()
                .filter_map(|angle| self.affine(DQuat::from_axis_angle(axis, angle.to_radians()) * p4).map(step));
            match turned.min_by(|a, b| a.sum.total_cmp(&b.sum)) {
                Some(least) if least.sum < best.sum => best = least,
                _ => break,
            }
            steps.push(best);
        }
        Some(steps)
    }
}

/// u, J⁻¹ and G of a sample.
fn looked(homography: &DMat3, s: &Sample) -> (DVec2, DMat2, DMat2) {
    let (u, _, jacobian) = planar_image(homography, s.y);
    let inverse = jacobian.inverse();
    (u, inverse, DMat2::from_cols(s.rows[0], s.rows[1]).transpose() * inverse)
}

fn squares(g: &DMat2) -> f64 {
    g.x_axis.length_squared() + g.y_axis.length_squared()
}
