//! The error of a warp at the shadows' edges that are seen: how wide texels are across them, in pixels.
//!
//! Source: theory.md 10.2, (10.7) and (10.8), for the family of warps along one axis (10.10). With x and eta of
//! [`BodyError`](super::BodyError), q = (1 + mu eta) / (1 + mu), k = mu / ((1 + mu) D) and `e` the pixels across the edge per unit
//! of the unwarped x and y,
//!
//! ```text
//! edge = (|e_x| q Ex + |e_x x k + e_y q| q Ey) / N      pixels, two terms for a texel's two sides
//! error = Σ weight c (1 - exp(-edge / c)) / Σ weight      c = 32 px: no single sample can rule the sum
//! ```

use glam::{DMat2, DMat3, DVec2};

use super::measure::{Measure, across_along_per_ndc};
use crate::fit::MapSize;
use crate::focus::{RayEdge, RayFrame};
use crate::geometry::planar_image;
use crate::simd::{dispatch, exp_of_minus};
use crate::techniques::kit::{CAP_PX, WarpSpace};

/// Samples of the first look at a strength.
const FEW: usize = 384;
/// Edges whose widths are counted at once.
const LANES: usize = 8;

/// The measure over the edges of shadows for every warp distance of a warp space.
#[derive(Debug, Clone)]
pub struct SeenError {
    points: Vec<Point>,
    /// 1 over the extent of the body along the axis.
    per_extent: f64,
    /// Texels along the receivers.
    texels: DVec2,
}

/// An edge: x from the reference point's, eta along the axis, pixels across the edge per unit of x and y.
#[derive(Debug, Clone, Copy)]
struct Point {
    x: f64,
    eta: f64,
    across: DVec2,
    weight: f64,
}

/// The coordinates of a warp space of a light's rays.
pub(super) struct Unwarped<'a> {
    space: &'a WarpSpace,
    homography: DMat3,
    /// 1 over the extent of the body along the axis; 0 for none, which has the uniform map alone.
    pub per_extent: f64,
}

impl<'a> Unwarped<'a> {
    pub fn new(space: &'a WarpSpace, rays: &RayFrame) -> Self {
        let per_extent = Some(space.extent().recip()).filter(|x| x.is_finite()).unwrap_or(0.0);
        Self { space, homography: rays.homography(&space.rows), per_extent }
    }
    /// x from the reference point's, eta along the axis and d(ray) / d(x, y); nothing where the space's w is not positive.
    pub fn at(&self, ray: DVec2) -> Option<(f64, f64, DMat2)> {
        let (at, w, per_ray) = planar_image(&self.homography, ray);
        let ray_per_unit = per_ray.inverse();
        let eta = (at.y - self.space.y[0]) * self.per_extent;
        (w > 0.0 && ray_per_unit.is_finite()).then_some((at.x - self.space.x_ref, eta, ray_per_unit))
    }
}

impl SeenError {
    /// The measure of a space's warps at edges told in a light's rays; edges at which the space's own w is not positive are left
    /// out.
    pub fn new(space: &WarpSpace, rays: &RayFrame, edges: &[RayEdge], size: &MapSize) -> Self {
        let unwarped = Unwarped::new(space, rays);
        let point = |edge: &RayEdge| {
            let (x, eta, ray_per_unit) = unwarped.at(edge.ray)?;
            Some(Point { x, eta, across: ray_per_unit.transpose() * edge.across, weight: edge.weight })
        };
        let texels = size.receivers_texels();
        let points = edges.iter().filter_map(point).collect();
        Self { points, per_extent: unwarped.per_extent, texels }
    }
    fn over(&self, points: &[Point], mu: f64, ndc: DVec2) -> f64 {
        let texel = ndc * across_along_per_ndc(mu) / self.texels;
        let (scale, k) = (1.0 / (1.0 + mu), mu / (1.0 + mu) * self.per_extent);
        let map = Map { mu, scale, k, texel };
        let (sum, weights) = sums_of(points, &map);
        if weights > 0.0 { sum / weights } else { 0.0 }
    }
}

/// A warp's strength with what follows from it, and a texel's sides.
struct Map {
    mu: f64,
    scale: f64,
    k: f64,
    texel: DVec2,
}

dispatch! {
    /// The sum of what edges count, and of their weights.
    fn sums_of(points: &[Point], map: &Map) -> (f64, f64) = sums_body
}

#[inline(always)]
fn sums_body(points: &[Point], map: &Map) -> (f64, f64) {
    let (mut sum, mut weights) = (0.0, 0.0);
    for points in points.chunks(LANES) {
        let mut widths = [0.0; LANES];
        for (width, p) in widths.iter_mut().zip(points) {
            // Before the reference point there is no map.
            let q = ((1.0 + map.mu * p.eta) * map.scale).max(0.0);
            let along = p.across.x * p.x * map.k + p.across.y * q;
            *width = q * (p.across.x.abs() * map.texel.x + along.abs() * map.texel.y);
        }
        // A loop, as a closure would not be compiled for the instruction set of the dispatch.
        for width in &mut widths {
            *width = CAP_PX * (1.0 - exp_of_minus(*width / CAP_PX));
        }
        for (counts, p) in widths.iter().zip(points) {
            sum += p.weight * counts;
            weights += p.weight;
        }
    }
    (sum, weights)
}

impl Measure for SeenError {
    fn error(&self, mu: f64, ndc: DVec2) -> f64 {
        self.over(&self.points, mu, ndc)
    }
    fn rough(&self, mu: f64, ndc: DVec2) -> f64 {
        self.over(&self.points[..self.points.len().min(FEW)], mu, ndc)
    }
    fn is_less(&self, error: f64, other: f64) -> bool {
        error < other * (1.0 - f64::EPSILON.sqrt())
    }
}
