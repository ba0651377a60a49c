//! Densities of texels along a map's axes that make the widths of texels across shadows' edges least in sum.
//!
//! Source: theory.md 10.7. With C(u) the widths binned over an axis, Σ C / f' under ∫ f' = 2 is least for f' ∝ √C (10.13). A cap
//! is a concave function of the width, below its tangent at any density, so widths weighted by its slope there have a least
//! sum at which the capped one is no more than before (10.14): a few such steps are taken.

use glam::{DMat3, DVec2};

use crate::fit::MapSize;
use crate::focus::RayEdge;
use crate::geometry::planar_image;
use crate::techniques::kit::capped;

/// Widths of a map's texels across edges, and where they are.
#[derive(Debug, Clone)]
pub struct EdgeWidths {
    widths: Vec<EdgeWidth>,
    bins: usize,
}

#[derive(Debug, Clone, Copy)]
struct EdgeWidth {
    /// Bins along x and y.
    bins: [u32; 2],
    /// |n·g1| and |n·g2|, pixels.
    sides: DVec2,
    /// Pixels that it stands for.
    weight: f64,
}

/// Texels per unit of each bin along x and y, relative to their mean along the axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Densities {
    /// Along x, and along y from the bottom.
    pub along: [Vec<f64>; 2],
}

impl EdgeWidths {
    /// The widths in the map of a homography of rays, clip x, y and w, whose receivers fill a size's inset, over so many
    /// bins along either axis of that. Edges beside it, or behind the projection centre, are left out.
    pub fn new(edges: &[RayEdge], homography: &DMat3, size: &MapSize, bins: usize) -> Self {
        let (texel, inset) = (2.0 / size.texels(), size.inset());
        let width = |edge: &RayEdge| {
            let (at, w, per_ray) = planar_image(homography, edge.ray);
            let sides = (per_ray.inverse().transpose() * edge.across * texel).abs();
            let share = 0.5 + 0.5 * at / inset;
            let is_inside = share.cmpge(DVec2::splat(-1e-9)).all() && share.cmple(DVec2::splat(1.0 + 1e-9)).all();
            let bin = |share: f64| ((share * bins as f64) as usize).min(bins - 1) as u32;
            let found = EdgeWidth { bins: [bin(share.x), bin(share.y)], sides, weight: edge.weight };
            (w > 0.0 && is_inside && sides.is_finite()).then_some(found)
        };
        Self { widths: edges.iter().filter_map(width).collect(), bins }
    }
    /// The mean of what the widths count under densities, pixels; 0 without edges.
    pub fn mean(&self, densities: &Densities, cap: f64) -> f64 {
        let (mut sum, mut weights) = (0.0, 0.0);
        for edge in &self.widths {
            sum += edge.weight * counted(edge.under(densities), cap).0;
            weights += edge.weight;
        }
        if weights > 0.0 { sum / weights } else { 0.0 }
    }
    /// Widths along x and along y, by bin, of texels of a map without densities; each weighted by how much it counts under
    /// some.
    fn costs(&self, densities: &Densities, cap: f64) -> [Vec<f64>; 2] {
        let mut costs = [vec![0.0; self.bins], vec![0.0; self.bins]];
        for edge in &self.widths {
            let weight = edge.weight * counted(edge.under(densities), cap).1;
            costs[0][edge.bins[0] as usize] += weight * edge.sides.x;
            costs[1][edge.bins[1] as usize] += weight * edge.sides.y;
        }
        costs
    }
}

impl EdgeWidth {
    /// The width of a texel across the edge under densities.
    fn under(&self, densities: &Densities) -> f64 {
        let [x, y] = [0, 1].map(|axis| densities.along[axis][self.bins[axis] as usize]);
        self.sides.x / x + self.sides.y / y
    }
}

impl Densities {
    /// Steps of (10.14). Chosen because less than 2 in a thousand is gained after them, as a test holds.
    pub const STEPS: usize = 6;

    /// Even ones.
    pub fn even(bins: usize) -> Self {
        Self { along: [vec![1.0; bins], vec![1.0; bins]] }
    }
    /// The least sum of what widths count, smoothed, and nowhere below a share of the mean; nothing without edges. Never worse
    /// than even ones.
    pub fn least(widths: &EdgeWidths, floor: f64, cap: f64) -> Option<Self> {
        (!widths.widths.is_empty()).then(|| Self::after(Self::STEPS, widths, floor, cap))
    }
    /// The best of so many steps from even ones.
    pub fn after(steps: usize, widths: &EdgeWidths, floor: f64, cap: f64) -> Self {
        let mut best = Self::even(widths.bins);
        let mut least = widths.mean(&best, cap);
        let mut found = best.clone();
        for _ in 0..steps {
            let costs = widths.costs(&found, cap);
            found = Self { along: costs.map(|costs| smooth_density(&costs, floor)) };
            let mean = widths.mean(&found, cap);
            if mean < least {
                (best, least) = (found.clone(), mean);
            }
        }
        best
    }
}

/// What a width counts under a cap (10.8), and its slope.
fn counted(width: f64, cap: f64) -> (f64, f64) {
    if cap == f64::INFINITY { (width, 1.0) } else { (capped(width, cap), (-width / cap).exp()) }
}

/// The densities of equal pieces, 1 in the mean, with the least sum of costs over them (10.13): as the roots of the costs.
/// Even ones without a cost.
pub fn least_density(costs: &[f64]) -> Vec<f64> {
    relative(costs.iter().map(|cost| cost.sqrt()).collect())
}

/// [`least_density`], smoothed with weights 1/4, 1/2, 1/4, and nowhere below a share of the mean.
fn smooth_density(costs: &[f64], floor: f64) -> Vec<f64> {
    let least = least_density(costs);
    let at = |i: usize| least[i.min(least.len() - 1)];
    let smooth = |i: usize| 0.25 * at(i.saturating_sub(1)) + 0.5 * at(i) + 0.25 * at(i + 1);
    raised(relative((0..least.len()).map(smooth).collect()), floor)
}

/// The same over their mean; even ones where that is 0.
fn relative(densities: Vec<f64>) -> Vec<f64> {
    let mean = densities.iter().sum::<f64>() / densities.len() as f64;
    if mean > 0.0 && mean.is_finite() {
        densities.iter().map(|density| density / mean).collect()
    } else {
        vec![1.0; densities.len()]
    }
}

/// Densities with mean 1, those below a floor raised to it, and the others lowered by one factor so that the mean stays.
fn raised(mut densities: Vec<f64>, floor: f64) -> Vec<f64> {
    // Lowered ones may fall below the floor in turn: at least one more each time.
    for _ in 0..densities.len() {
        let (low, high): (Vec<f64>, Vec<f64>) = densities.iter().partition(|density| **density <= floor);
        let (left, above) = (densities.len() as f64 - floor * low.len() as f64, high.iter().sum::<f64>());
        if high.is_empty() {
            return vec![1.0; densities.len()];
        }
        let factor = left / above;
        densities.iter_mut().for_each(|d| *d = if *d <= floor { floor } else { *d * factor });
        if densities.iter().all(|density| *density >= floor) {
            break;
        }
    }
    densities
}
