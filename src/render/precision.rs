//! Whether a mesh may be projected in single precision.

use glam::{DMat4, DVec3, DVec4};

use crate::geometry::Aabb;

/// Largest ratio of the terms of a clip coordinate to w for which f32 will do.
///
/// Rounding the matrix and the four terms' sum costs at most 2^-23 of the terms together, and a seventh of that on average: 8
/// is one unit in the last place of depth 1 then. A mesh as large as its map has a ratio of 1 to 3.
const SINGLE_TERMS: f64 = 8.0;

/// Whether f32 is enough for the vertices of a mesh in a box.
pub(crate) fn single_is_enough(clip_from_local: &DMat4, bounds_local: &Aabb) -> bool {
    let corners = bounds_local.corners();
    let reach = corners.iter().fold(DVec3::ZERO, |r, p| r.max(p.abs())).extend(1.0);
    let terms = (0..4).map(|i| clip_from_local.row(i).abs().dot(reach)).fold(0.0, f64::max);
    // The smallest w of what is both in the box and in view. Behind the inverse, w of a point in view is the inverse of its
    // fourth coordinate, which is largest at a corner of the clip volume.
    let w = clip_from_local.row(3);
    let in_box = corners.iter().map(|p| w.dot(p.extend(1.0))).fold(f64::INFINITY, f64::min);
    if terms <= SINGLE_TERMS * in_box {
        return true;
    }
    let local_from_clip = clip_from_local.inverse();
    let in_view = (0..8)
        .map(|c| DVec4::new(f64::from(c & 1) * 2.0 - 1.0, f64::from(c >> 1 & 1) * 2.0 - 1.0, f64::from(c >> 2), 1.0))
        .map(|ndc| (local_from_clip * ndc).w)
        .fold(0.0, |largest: f64, w| if w.is_nan() { f64::INFINITY } else { largest.max(w) });
    in_view > 0.0 && terms <= SINGLE_TERMS / in_view
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn f64_is_for_meshes_beyond_the_map() {
        let unit = Aabb::from_points([DVec3::NEG_ONE, DVec3::ONE]);
        for (ratio, single) in [(0.01, true), (1.0, true), (100.0, false), (1e12, false)] {
            let m = DMat4::from_scale(DVec3::new(ratio, ratio, 0.5 * ratio));
            assert_eq!(single_is_enough(&m, &unit), single, "ratio {ratio}");
        }
        assert!(!single_is_enough(&DMat4::from_diagonal(DVec4::new(1.0, 1.0, 1.0, 0.0)), &unit), "singular");
    }
}
