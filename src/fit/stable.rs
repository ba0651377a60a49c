//! Texel snapping: a uniform map whose texel lattice stands still in the world while the camera moves.
//!
//! Source: theory.md 1.4 (a sphere around the frustum, moved in whole texels), after Valient 2008 `[valient2008]`.
//! Departures: the radius is rounded up to a part of itself, not to an absolute length, so that it means the same at
//! any scale; the depth range is the scene's.

use glam::{DMat4, DVec2, DVec3};

use super::map_size::MapSize;
use crate::geometry::{Aabb, Rows};
use crate::rays::LightFrame;
use crate::scene::Camera;

/// The radius is rounded up to this share of the power of two below it. Chosen because it wastes at most 0.1 % of the
/// texels while rounding noise of an animated field of view or aspect no longer changes the texel size.
const RADIUS_QUANTUM: f64 = 1.0 / 1024.0;

/// Depth kept free at either end, as a share of the scene's: far above rounding, far below a texel.
const DEPTH_MARGIN: f64 = 16.0 / (1 << 24) as f64;

/// A stable map and the numbers it is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StableGrid {
    /// `clip_from_world`.
    pub clip_from_world: Rows,
    /// The light's frame, about the world's origin.
    pub frame: LightFrame,
    /// What crops it, an affine map.
    pub crop: DMat4,
    /// World size of a texel along x and y; does not depend on the camera's pose.
    pub texel: DVec2,
    /// Radius of the sphere around the frustum before it is rounded up.
    pub radius: f64,
    /// Middle of the sphere, world.
    pub center: DVec3,
}

/// The stable map of directional light with depth from the two ends of `depth_range` (world, along the light).
pub fn stable_grid(camera: &Camera, along: DVec3, depth_range: [f64; 2], size: &MapSize) -> StableGrid {
    let frame = LightFrame::any(along);
    let frustum = camera.frustum_at(camera.eye());
    let (center_depth, radius) = frustum.sphere();
    let center = frustum.at(frustum.center[0], frustum.center[1], center_depth);
    let quantum = RADIUS_QUANTUM * radius.log2().floor().exp2();
    let rounded = (radius / quantum).ceil() * quantum;
    let texel = 2.0 * rounded / size.between();
    let half = 0.5 * texel * size.texels();
    let light = DVec2::new(frame.right.dot(center), frame.up.dot(center));
    let snapped = (light / texel).round() * texel;
    let [near, far] = depth_range;
    let low = (snapped - half).extend(near);
    let high = (snapped + half).extend(far);
    let clip_from_world = frame.orthographic().cropped(low, high);
    StableGrid { clip_from_world, frame, crop: Rows::crop(low, high), texel, radius, center }
}

/// The depth range along the light that holds a scene, whatever the camera does.
pub fn scene_depth(bounds: &Aabb, along: DVec3) -> [f64; 2] {
    let (low, high) = bounds
        .corners()
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(along.dot(*p)), high.max(along.dot(*p))));
    // A flat scene across the light still needs a depth.
    let margin = (DEPTH_MARGIN * (high - low)).max(DEPTH_MARGIN * bounds.diagonal()).max(f64::MIN_POSITIVE);
    let rounding = 4.0 * f64::EPSILON * (low.abs().max(high.abs()));
    [low - margin - rounding, high + margin + rounding]
}
