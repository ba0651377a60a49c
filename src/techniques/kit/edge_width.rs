//! How wide the texels of any map are across the edges of visible shadows.
//!
//! Source: theory.md 10.2, (10.1), (10.7) and (10.8).

use glam::{DMat2, DMat3};

use crate::fit::{MapSize, rectangle};
use crate::focus::{Outline, RayEdge};

/// Where an edge's width stops to count, pixels (theory.md (10.8)). Chosen by leaving scenes out (docs/defaults.md).
pub const CAP_PX: f64 = 32.0;

/// The mean of `c (1 - exp(-edge / c))` in pixels, c = [`CAP_PX`], over edges, of the map of a homography of the light's rays
/// that is cropped to an outline. An edge where w is not positive counts as the cap; 0 without edges.
pub fn edge_width(edges: &[RayEdge], outline: &Outline, homography: &DMat3, size: &MapSize) -> f64 {
    let (low, high) = rectangle(outline, homography, size);
    let texel = (high - low) / (f64::from(size.resolution) * size.inset());
    let (mut sum, mut weights) = (0.0, 0.0);
    for edge in edges {
        weights += edge.weight;
        let clip = *homography * edge.ray.extend(1.0);
        let at = clip.truncate() / clip.z;
        let gradient = |i: usize| (homography.row(i) - homography.row(2) * at[i]).truncate() / clip.z;
        // d(ray) / d(map).
        let back = DMat2::from_cols(gradient(0), gradient(1)).transpose().inverse();
        let sides = back.transpose() * edge.across * texel;
        let width = sides.x.abs() + sides.y.abs();
        let counted = if clip.z > 0.0 && width.is_finite() { CAP_PX * (1.0 - (-width / CAP_PX).exp()) } else { CAP_PX };
        sum += edge.weight * counted;
    }
    if weights > 0.0 { sum / weights } else { 0.0 }
}
