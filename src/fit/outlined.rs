//! What a map spans that must hold an outline of samples instead of its body.
//!
//! Source: theory.md 10.3 (what a map must hold) and 1.3. Across the light the map is cut to the outline's image; along it to
//! what of the receivers' body lies over that rectangle, so that receivers which no sample shows still have their depth. The
//! warp's w need not be positive on the rest of the body, which no point of the map is in. A map with slack, which is held while the
//! camera moves, reaches to the far end of whatever can come into view over its rectangle.

use glam::{DMat3, DVec2, DVec3};

use super::map_size::{MapSize, POINT_EXTENT};
use super::tightening::sides;
use crate::focus::{FocusedView, Outline};
use crate::geometry::{Aabb, ConvexBody, Plane, Rows, planar_image};

/// What has less w than this share of an outline's largest is left out of the map. Derived from f64: half of the digits.
const LEAST_W: f64 = 1.0 / (1 << 26) as f64;

/// What an outline spans in the NDC of a map: at least a texel across, and in depth what of the view's body lies over it.
pub(super) fn outline_extent(rows: &Rows, outline: &Outline, view: &FocusedView, size: &MapSize) -> Aabb {
    let homography = outline.rays.homography(rows);
    let (low, high) = rectangle(outline, &homography, size);
    let middle = rows.project(outline.middle).z;
    let flat = Aabb { min: low.extend(middle), max: high.extend(middle) };
    let (near, far) = depths_over(rows, &flat, view.receivers, view);
    // A texel's depth for a body without any, as across.
    let least = texel(outline, size)
        * rows.derivative(outline.middle, view.rays.direction_at(outline.middle).unwrap_or(DVec3::Z)).z.abs();
    let missing = (0.5 * (least - (far - near))).max(0.0);
    Aabb { min: low.extend(near - missing), max: high.extend(far + missing) }
}

/// The same map with a depth for all that can come into view over it, where its size has slack: it is held while the camera moves.
pub(super) fn reaching(rows: &Rows, map: Aabb, view: &FocusedView, size: &MapSize) -> Aabb {
    if view.outline.is_none() || size.slack <= 1.0 {
        return map;
    }
    let (_, far) = depths_over(rows, &map, view.reachable(), view);
    Aabb { max: map.max.truncate().extend(far), ..map }
}

/// The depths of an extent and of what of a body lies over its rectangle.
fn depths_over(rows: &Rows, extent: &Aabb, mut body: ConvexBody, view: &FocusedView) -> (f64, f64) {
    for side in sides(rows, extent, view).iter().flatten() {
        if let Some(plane) = Plane::where_positive(*side) {
            body.clip(&plane);
        }
    }
    let depths = body.vertices().iter().map(|p| rows.project(*p).z).filter(|z| z.is_finite());
    depths.fold((extent.min.z, extent.max.z), |(near, far), z| (near.min(z), far.max(z)))
}

/// The rectangle around an outline's image, at least a texel wide and high.
pub fn rectangle(outline: &Outline, homography: &DMat3, size: &MapSize) -> (DVec2, DVec2) {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    outline.images(homography, LEAST_W, |p| (low, high) = (low.min(p), high.max(p)));
    // NDC per unit of the ray's coordinates, at the middle.
    let (_, _, per_ray) = planar_image(homography, outline.rays.ray(outline.middle));
    let least = DVec2::new(per_ray.row(0).length(), per_ray.row(1).length()) * ray_texel(outline, size);
    let missing = (0.5 * (least - (high - low))).max(DVec2::ZERO);
    (low - missing, high + missing)
}

/// The side of a texel of a map without a warp, in the ray's coordinates.
fn ray_texel(outline: &Outline, size: &MapSize) -> f64 {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    outline.corners.iter().for_each(|p| (low, high) = (low.min(*p), high.max(*p)));
    let extent = (high - low).max_element();
    let least = POINT_EXTENT * outline.middle.length() / outline.rays.scale(outline.middle);
    (extent / size.fewest()).max(least)
}

/// The same in the world, at the middle.
fn texel(outline: &Outline, size: &MapSize) -> f64 {
    ray_texel(outline, size) * outline.rays.scale(outline.middle)
}
