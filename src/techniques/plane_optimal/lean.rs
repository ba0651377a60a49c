//! A plane's warp weakened until it serves all that the map must hold.
//!
//! Ours: light rays that meet the plane behind the eye have w <= 0 in (9.1), and the paper splits the view there. One map
//! serves them when w leans towards a constant: of the blends whose w spans no more than the depths that are seen, or 1 : 100,
//! the one whose texels are least wide across the edges of visible shadows (theory.md (10.8)).
//!
//! ```text
//!      w of the plane   \.  ·  ·  ·  ·  · leaned
//!                         `\.______________ 0      the ray coordinate along which w changes
//!                  behind   `\. the eye
//! ```

use glam::{DMat3, DVec2, DVec3};

use crate::fit::MapSize;
use crate::focus::{Outline, RayEdge};
use crate::geometry::Rows;
use crate::techniques::kit::edge_width;

/// The least w over the largest, where the depths that are seen are not farther apart.
pub(super) const LEAST_SHARE: f64 = 0.01;

/// Blends that are tried, more of them near the plane's own w.
const BLENDS: usize = 12;

/// Rows x, y and w of a map whose w is the plane's, `w_row` (of (ray, 1), positive where the plane serves), leaned as far as
/// needed for `depths` and as is best for `edges`; and the share of the constant in it. Nothing where the plane's w is constant: any frame is its.
pub(super) fn leaned(
    outline: &Outline,
    w_row: DVec3,
    depths: [f64; 2],
    edges: &[RayEdge],
    size: &MapSize,
) -> Option<(Rows, f64)> {
    let axis = w_row.truncate().try_normalize()?;
    let at = |p: &DVec2| w_row.dot(p.extend(1.0));
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for w in outline.corners.iter().map(at) {
        (low, high) = (low.min(w), high.max(w));
    }
    let constant = low.abs().max(high.abs());
    let floor = LEAST_SHARE.min(depths[0] / depths[1]);
    // (1 - t) low + t c = floor ((1 - t) high + t c)
    let gap = floor * high - low;
    let least = (gap / (gap + constant * (1.0 - floor))).clamp(0.0, 1.0);
    // Across the axis, along it from its lowest corner, and w: regular wherever w is not 0.
    let across = DVec2::new(axis.y, -axis.x);
    let first = outline.corners.iter().map(|p| axis.dot(*p)).fold(f64::INFINITY, f64::min);
    let y_row = axis.extend(-first);
    // y grows as w does.
    let homography = |blend: f64| {
        let w_row = w_row * (1.0 - blend) + DVec3::Z * (constant * blend);
        DMat3::from_cols(across.extend(0.0), y_row, w_row).transpose()
    };
    let blends = (0..=BLENDS).map(|i| least + (1.0 - least) * (i as f64 / BLENDS as f64).powi(2));
    let width = |blend: f64| edge_width(edges, outline, &homography(blend), size);
    // The first of equal ones: the plane's own where no edge is seen.
    let mut best = (f64::INFINITY, least);
    for blend in blends {
        let found = width(blend);
        if found < best.0 {
            best = (found, blend);
        }
    }
    Some((outline.rays.rows(&homography(best.1)), best.1))
}
