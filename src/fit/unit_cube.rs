//! The fit shared by all techniques: crops a provisional map to receivers and casters, picks near and far, adds the border.
//!
//! Source: theory.md 1.3; Kapoulkine 2007 `[kapoulkine2007]`, the unit-cube clipping article; Wimmer and Scherzer 2006
//! `[wimmer2006]`. Departures, both exact:
//! - Receivers are the instances' boxes cut by the view, not only K: nothing else can be hit by a view ray. As nearly every
//!   instance casts and receives, the casters above the receivers' rectangle fill it, so the article's second crop to the
//!   casters' rectangle has next to nothing left to cut and is made only on demand ([`Tightening`]).
//! - Casters are cut in space by the four side planes of the cropped map, which are linear functionals of position
//!   (`above.rs`). On the rectangle w is bounded below: under a directional light 1/w is an affine function of x and y, and a
//!   spot has its near plane. So no division ever sees w <= 0.
//!
//! Whether a box can still change a bound is asked with a support function (no corners, no division), first of groups of
//! instances in the scene's hierarchy, so that ten thousand instances cost tens of microseconds; only boxes that can are cut.

use glam::{DMat4, DVec3, DVec4};

use super::above::{box_of, nearest_caster, nearest_of};
use super::map_size::{MapSize, POINT_EXTENT};
use super::outlined::{outline_extent, reaching};
use super::tightening::{Tightening, casters_extent, casting, corners_extent, nearest_anywhere};
use crate::focus::{FocusedView, NEAREST_SHARE_OF_REACH, SpotFrustum, receivers_extent};
use crate::geometry::{Aabb, Rows};
use crate::rays::LightFrame;
use crate::scene::Scene;

/// Depth kept free at either end of [0, 1]. Derived from float32: 16 of its steps below 1, so that the nearest caster and the
/// farthest receiver survive a renderer's rounding.
const DEPTH_MARGIN: f64 = 16.0 / (1 << 24) as f64;

/// `clip_from_local` cropped to receivers and casters as closely as `tightening` says; w = 1 at the mean of the receivers'
/// body. By default receivers fill the map up to its border, and every caster that any texel can see lies between z = 0 and
/// the receivers' end, border texels included.
///
/// `provisional` must be a shadow map's (0.1) with w > 0 on the receivers' body. Under a placed light its depth row
/// is replaced: z / w = -1 / w, so that a depth is a w and the map can begin where single precision still tells depths
/// apart at the receivers ([`NEAREST_SHARE_OF_REACH`]); whatever has less w is lit and casts no shadow.
pub fn fit(provisional: &Rows, view: &FocusedView, scene: &Scene, size: &MapSize, tightening: Tightening) -> Fit {
    let provisional = &with_depth_of_w(provisional, view);
    let receivers = receivers_room(provisional, view, scene, size, tightening);
    let map = reaching(provisional, with_border(&receivers, size), view, size);
    let cut = cut_to(provisional, &map, view, scene, tightening);
    cut.canonical(view)
}

/// A fitted map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// From the view's local space: the crop of the provisional map.
    pub clip_from_local: Rows,
    /// The map before the crop, with the depth row that the fit chose.
    pub provisional: Rows,
    /// The crop, an affine map of NDC times a positive factor.
    pub crop: DMat4,
    /// Whether casters or receivers may lie nearer to a placed light than the map begins.
    pub begins_late: bool,
}

impl Fit {
    /// The same map with w = 1 at the mean of the receivers' body.
    pub(super) fn canonical(self, view: &FocusedView) -> Self {
        let k = canonical_factor(&self.clip_from_local, view);
        Self { clip_from_local: self.clip_from_local.scaled(k), crop: self.crop * k, ..self }
    }
    /// The largest distance from a placed light at which the map begins, over the rays through the corners of what it holds.
    pub fn begins_at(&self, view: &FocusedView) -> f64 {
        let light = view.rays.point.truncate();
        if let Some(outline) = view.outline {
            let corners = outline.corners.iter().map(|ray| outline.rays.on_ray(*ray));
            return corners.chain([outline.middle]).map(|p| self.begins_on_ray(p, light)).fold(0.0, f64::max);
        }
        view.receivers.vertices().iter().map(|p| self.begins_on_ray(*p, light)).fold(0.0, f64::max)
    }
    /// The distance from a placed light at which the map begins on the ray through a point.
    fn begins_on_ray(&self, p: DVec3, light: DVec3) -> f64 {
        let Rows { z, w, .. } = self.clip_from_local;
        // Along a ray from the light w grows with the distance, and clip z is 0 where w has this value.
        let w_begin = w.dot(p.extend(1.0)) - z.dot(p.extend(1.0)) * w_per_z(&self.clip_from_local, p, light);
        (p - light).length() * w_begin / w.dot(p.extend(1.0))
    }
}

/// Growth of clip w per growth of clip z along the ray from `light` through `p`.
fn w_per_z(rows: &Rows, p: DVec3, light: DVec3) -> f64 {
    rows.w.truncate().dot(p - light) / rows.z.truncate().dot(p - light)
}

/// The same map; under a placed light with the depth row that makes z / w = -1 / w.
fn with_depth_of_w(provisional: &Rows, view: &FocusedView) -> Rows {
    let placed = view.rays.point.w != 0.0;
    Rows { z: if placed { DVec4::NEG_W } else { provisional.z }, ..*provisional }
}

/// A map whose x and y span `map`, and whose depth goes from the nearest caster that `tightening` asks for to the far end of
/// `map`.
pub(super) fn cut_to(provisional: &Rows, map: &Aabb, view: &FocusedView, scene: &Scene, tightening: Tightening) -> Fit {
    let near = match tightening {
        Tightening::Exact => nearest_caster(provisional, map, view, scene),
        Tightening::Receivers => nearest_anywhere(provisional, map, view, scene),
        Tightening::Intersection => nearest_of(provisional, map, view, casting(view, scene)),
        Tightening::None => nearest_of(provisional, map, view, std::iter::once(box_of(&view.scene_box))),
        Tightening::Ignoring { least_w } => corners_extent(provisional, least_w, view, scene).map(|b| b.min.z),
    };
    let near = match (near, tightening) {
        // What lies before all casters is lit without a look at the map.
        (Some(z), Tightening::Intersection | Tightening::Ignoring { .. }) if z < map.max.z => z,
        (z, _) => z.unwrap_or(map.min.z).min(map.min.z),
    };
    let earliest = if view.rays.point.w != 0.0 {
        // z is -1 / w and negative, but for the room that a thin map has beyond its receivers.
        let far = map.max.z.min(-view.receivers.range(provisional.w).1.recip());
        far / NEAREST_SHARE_OF_REACH
    } else {
        f64::NEG_INFINITY
    };
    let (near, begins_late) = (near.max(earliest), near < earliest);
    let depth = map.max.z - near;
    let low = map.min.truncate().extend(near - DEPTH_MARGIN * depth);
    let high = map.max.truncate().extend(map.max.z + DEPTH_MARGIN * depth);
    let (clip_from_local, crop) = (provisional.cropped(low, high), Rows::crop(low, high));
    Fit { clip_from_local, provisional: *provisional, crop, begins_late }
}

/// What the receivers of a map span in its provisional NDC as [`fit`] has it, border aside.
pub fn receivers_room(
    provisional: &Rows,
    view: &FocusedView,
    scene: &Scene,
    size: &MapSize,
    tightening: Tightening,
) -> Aabb {
    let provisional = &with_depth_of_w(provisional, view);
    with_room(&across(provisional, view, scene, size, tightening), provisional, view, size)
}

/// What the receivers of a map span.
pub(super) fn across(
    provisional: &Rows,
    view: &FocusedView,
    scene: &Scene,
    size: &MapSize,
    tightening: Tightening,
) -> Aabb {
    if let Some(outline) = view.outline {
        return outline_extent(provisional, outline, view, size);
    }
    let casters = |receivers: &Aabb| match tightening {
        Tightening::Intersection => casters_extent(provisional, receivers, view, scene),
        Tightening::Ignoring { least_w } => corners_extent(provisional, least_w, view, scene),
        _ => None,
    };
    let receivers = match tightening {
        Tightening::None => Aabb::from_points(view.receivers.vertices().iter().map(|p| provisional.project(*p))),
        _ => receivers_extent(provisional, view, scene),
    };
    let Some(casters) = casters(&receivers) else { return receivers };
    let (low, high) = (receivers.min.max(casters.min).truncate(), receivers.max.min(casters.max).truncate());
    if low.cmple(high).all() {
        Aabb { min: low.extend(receivers.min.z), max: high.extend(receivers.max.z) }
    } else {
        receivers
    }
}

/// What the whole map spans where receivers fill it up to its border.
pub(super) fn with_border(receivers: &Aabb, size: &MapSize) -> Aabb {
    let border = (0.5 * (size.inset().recip() - 1.0) * receivers.extent().truncate()).extend(0.0);
    Aabb { min: receivers.min - border, max: receivers.max + border }
}

/// The plain crop `C(lo, hi)` of theory.md 0: x and y to the extents of some points, z to those of others, without border
/// or margin; w = 1 at the mean of the receivers' body.
pub fn crop(provisional: &Rows, view: &FocusedView, across: &[DVec3], depth: &[DVec3]) -> Rows {
    let across = Aabb::from_points(across.iter().map(|p| provisional.project(*p)));
    let depth = Aabb::from_points(depth.iter().map(|p| provisional.project(*p)));
    let low = across.min.truncate().extend(depth.min.z);
    let high = across.max.truncate().extend(depth.max.z);
    let cropped = provisional.cropped(low, high);
    cropped.scaled(canonical_factor(&cropped, view))
}

/// What makes w = 1 at the middle of the receivers; 1 where w is not positive there.
fn canonical_factor(rows: &Rows, view: &FocusedView) -> f64 {
    let w = rows.w.dot(view.middle().extend(1.0));
    if w > 0.0 { 1.0 / w } else { 1.0 }
}

/// What a spot's map spans along its axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpotDepths {
    /// Depth of the nearest caster above the receivers, and of the farthest receiver.
    pub range: [f64; 2],
    /// Whether a caster's box reaches closer to the light than a map can begin
    /// ([`NEAREST_SHARE_OF_REACH`]); what is there casts no shadow.
    pub begins_late: bool,
}

/// The depths along a spot's axis that receivers, and the casters above them, can have.
pub fn spot_depths(spot: &SpotFrustum, view: &FocusedView, scene: &Scene) -> SpotDepths {
    // z / w = -1 / depth: grows with depth, and needs no near or far to be known.
    let rows = Rows { z: DVec4::NEG_W, ..spot.perspective(spot.frustum.near, spot.frustum.far) };
    let extent = Aabb::from_points(view.receivers.vertices().iter().map(|p| rows.project(*p)));
    let (_, far) = view.receivers.range(spot.depth());
    let near = nearest_caster(&rows, &extent, view, scene).map_or(far, |z| -z.recip());
    // Cut by the plane of the nearest depth, up to the rounding of that cut.
    let begins_late = near <= spot.frustum.near * (1.0 + f64::EPSILON.sqrt());
    SpotDepths { range: [near, far], begins_late }
}

/// The extents padded where receivers lie in a plane or line through the light ([`Room`]).
pub(super) fn with_room(extent: &Aabb, provisional: &Rows, view: &FocusedView, size: &MapSize) -> Aabb {
    if view.outline.is_some() {
        return *extent;
    }
    let missing = 0.5 * (Room::new(view, size).least(extent.extent(), provisional) - extent.extent());
    Aabb { min: extent.min - missing.max(DVec3::ZERO), max: extent.max + missing.max(DVec3::ZERO) }
}

/// What receivers get at the least, be they in a plane or line through the light: one texel, and in depth the size of a texel
/// (theory.md 1.1). Shadows smaller than that do not show.
pub(crate) struct Room<'a> {
    view: &'a FocusedView<'a>,
    mean: DVec3,
    frame: LightFrame,
    /// World length.
    texel: f64,
}

impl<'a> Room<'a> {
    pub fn new(view: &'a FocusedView<'a>, size: &MapSize) -> Self {
        let mean = view.receivers.vertex_mean();
        let along = view.rays.direction_at(mean).unwrap_or(view.camera.forward());
        let frame = LightFrame::any(along);
        // A warped map's axes have units of their own: lengths are compared in the world.
        let length = |axis: DVec3| {
            let (low, high) = view.receivers.range(axis.extend(0.0));
            high - low
        };
        let across = length(frame.right).max(length(frame.up));
        let texel = if across > 0.0 {
            across / size.fewest()
        } else {
            let far_off = (mean - view.eye).length().max(view.camera.near());
            POINT_EXTENT * view.camera.distance_at(far_off)
        };
        Self { view, mean, frame, texel }
    }
    /// Extents of a map, NDC, that are at least those in which receivers have `extent`; no more than `extent` where that is
    /// enough.
    pub fn least(&self, extent: DVec3, provisional: &Rows) -> DVec3 {
        let texel_at = |p: DVec3| {
            let across = provisional.jacobian(p, [self.frame.right, self.frame.up]).transpose();
            let depth = provisional.derivative(p, self.frame.along).z.abs();
            self.texel * DVec3::new(across.x_axis.length(), across.y_axis.length(), depth)
        };
        if texel_at(self.mean).cmple(extent).all() {
            return extent;
        }
        // Where a texel is smallest: what is seen may lie there alone, and room costs texels.
        let vertices = self.view.receivers.vertices().iter();
        vertices.map(|p| texel_at(*p)).fold(DVec3::INFINITY, DVec3::min)
    }
}
