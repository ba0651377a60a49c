//! How wide the texels of any map are across the edges of visible shadows.
//!
//! Source: theory.md 10.2, (10.1), (10.7) and (10.8).

use glam::DMat3;

use crate::fit::{MapSize, rectangle};
use crate::focus::{Outline, RayEdge};
use crate::geometry::planar_image;

/// Where an edge's width stops to count, pixels (theory.md (10.8)). Chosen by leaving scenes out (docs/defaults.md).
pub const CAP_PX: f64 = 32.0;

/// What a width counts, `c (1 - exp(-width / c))` with a finite cap c (theory.md (10.8)).
pub fn capped(width: f64, cap: f64) -> f64 {
    cap * (1.0 - (-width / cap).exp())
}

/// The same with [`CAP_PX`].
pub fn capped_px(width: f64) -> f64 {
    capped(width, CAP_PX)
}

/// The mean of what their widths count ([`capped_px`]) over edges, of the map of a homography of the light's rays
/// that is cropped to an outline. An edge where w is not positive counts as the cap; 0 without edges.
pub fn edge_width(edges: &[RayEdge], outline: &Outline, homography: &DMat3, size: &MapSize) -> f64 {
    let (low, high) = rectangle(outline, homography, size);
    let texel = (high - low) / size.receivers_texels();
    let (mut sum, mut weights) = (0.0, 0.0);
    for edge in edges {
        weights += edge.weight;
        let (_, w, per_ray) = planar_image(homography, edge.ray);
        let sides = per_ray.inverse().transpose() * edge.across * texel;
        let width = sides.x.abs() + sides.y.abs();
        sum += edge.weight * if w > 0.0 && width.is_finite() { capped_px(width) } else { CAP_PX };
    }
    if weights > 0.0 { sum / weights } else { 0.0 }
}
