//! The space in which perspective warps act: light rays run along its third axis, the view direction along its second.
//!
//! Source: theory.md 5.1 to 5.4, (5.1) and (5.2). For a directional light it is light space itself; for a spot the NDC
//! of the light's perspective, turned. What LiSPSM needs, and all techniques that differ from it in the warp distance
//! alone.

use glam::{DVec2, DVec3};

use super::light_projection::spot_depth_range;
use crate::focus::{FocusedView, SpotFrustum};
use crate::geometry::Rows;
use crate::note::{Detail, Kind, Note};
use crate::rays::LightFrame;
use crate::scene::{Light, Scene};

/// Below this sine between light and view (theory.md 5.2) the axis turns with every rounding error and the warp distance is a
/// million times the near depth: no map shows such a warp.
pub const LEAST_KAPPA: f64 = 1e-6;

/// The smallest warp distance as a share of the body. Derived from f64: w spans one over this, and half of the digits of its
/// smallest value must be left.
pub const LEAST_LAMBDA: f64 = 1.0 / (1 << 26) as f64;

/// Where a warp acts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WarpSpace {
    /// From local space: x across, y along the warp axis, z along the light; w = 1, or the depth from a spot.
    pub rows: Rows,
    /// Smallest and largest y of the receivers' body.
    pub y: [f64; 2],
    /// The x of the reference point.
    pub x_ref: f64,
    /// The z of the reference point.
    pub z_ref: f64,
    /// Eye depth where a line across the light, along the axis, begins at the near end.
    pub eye_depth: f64,
    /// Growth of eye depth along that line, per unit of y: the sine of the angle between light and view, for a directional
    /// light and the axis of the view.
    pub rate: f64,
    /// Units of y in a world unit along the axis, at the middle of the receivers' body.
    pub per_length: f64,
}

impl WarpSpace {
    /// The space of a view's light, with the axis towards `towards`; where no warp can act, the reason. Notes what the beginning
    /// of a spot's map leaves out.
    pub fn of(
        view: &FocusedView,
        scene: &Scene,
        towards: DVec3,
        notes: &mut Vec<Note>,
    ) -> Option<Result<Self, Detail>> {
        match (&view.light, view.spot()) {
            (Light::Directional(l), _) => Some(Self::directional(view, l.direction(), towards)),
            (_, Some(spot)) => {
                let depths = spot_depth_range(&spot, view, scene, notes);
                let parallel = view.camera.is_orthographic();
                Some(if parallel { Err(Detail::ParallelRays) } else { Self::spot(view, &spot, depths, towards) })
            }
            // Refused before: a point light has no single map.
            _ => None,
        }
    }
    /// Light space with the axis in the plane of `towards` (theory.md (0.2), 5.1 and 5.3); where no warp can act, the reason.
    pub fn directional(view: &FocusedView, along: DVec3, towards: DVec3) -> Result<Self, Detail> {
        if view.camera.is_orthographic() {
            return Err(Detail::ParallelRays);
        }
        let (frame, across) = LightFrame::towards(along, towards).ok_or(Detail::LightAlongAxis)?;
        if across < LEAST_KAPPA {
            return Err(Detail::LightAlongAxis);
        }
        let rate = frame.up.dot(view.camera.forward());
        if rate < LEAST_KAPPA {
            return Err(Detail::DepthFallsAlongAxis);
        }
        let rows = frame.orthographic();
        let (y_min, y_max) = view.receivers.range(rows.y);
        let [c_min, c_max] = view.casters_along(along);
        let space = Self {
            rows,
            y: [y_min, y_max],
            x_ref: frame.right.dot(view.eye),
            z_ref: 0.5 * (c_min + c_max),
            eye_depth: view.eye_depth[0],
            rate,
            per_length: 1.0,
        };
        space.checked()
    }
    /// The NDC of a spot's perspective between two depths, turned so that `towards` at the middle of the receivers points
    /// along y (theory.md 5.4); where no warp can act, the reason.
    pub fn spot(view: &FocusedView, spot: &SpotFrustum, depth_range: [f64; 2], towards: DVec3) -> Result<Self, Detail> {
        let upright = spot.perspective(depth_range[0], depth_range[1]);
        let mean = view.receivers.vertex_mean();
        let moved = upright.derivative(mean, towards).truncate();
        let ray = view.rays.direction_at(mean).ok_or(Detail::LightAlongAxis)?;
        let across = towards - ray * ray.dot(towards);
        let (axis, length) = (moved.try_normalize(), across.length());
        let axis = axis.filter(|_| length > LEAST_KAPPA).ok_or(Detail::LightAlongAxis)?;
        let rows = upright.then(&[
            [axis.y, -axis.x, 0.0, 0.0],
            [axis.x, axis.y, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ]);
        let vertices = view.receivers.vertices();
        let images = vertices.iter().map(|p| rows.project(*p));
        let (mut low, mut high, mut sum) = (DVec2::INFINITY, DVec2::NEG_INFINITY, DVec2::ZERO);
        for p in images {
            (low, high, sum) = (low.min(p.truncate()), high.max(p.truncate()), sum + p.truncate());
        }
        let depth_of = |p: &DVec3| (*p - view.eye).dot(view.camera.forward());
        // Both ends of the line through the image of the vertex nearest the eye, back in space: at the spot depth of that
        // vertex, since z of the perspective depends on nothing else. Vertices on the near plane are equally near up to
        // rounding; their mean does not depend on which of them rounding puts first.
        let [eye_near, eye_far] = view.eye_depth;
        let tied = eye_near + f64::EPSILON.sqrt() * (eye_far - eye_near);
        let (mut first_x, mut spot_depth, mut count) = (0.0, 0.0, 0.0);
        for p in vertices.iter().filter(|p| depth_of(p) <= tied) {
            first_x += rows.project(*p).x;
            spot_depth += spot.depth().dot(p.extend(1.0));
            count += 1.0;
        }
        let (first_x, spot_depth) = (first_x / count, spot_depth / count);
        let tangent = spot.frustum.half[0];
        let back = |y: f64| {
            let (x, y) = (axis.y * first_x + axis.x * y, -axis.x * first_x + axis.y * y);
            let across = (spot.frame.right * x + spot.frame.up * y) * tangent;
            depth_of(&(spot.frustum.apex + (spot.frame.along + across) * spot_depth))
        };
        let (z0, z1) = (back(low.y), back(high.y));
        let space = Self {
            rows,
            y: [low.y, high.y],
            x_ref: sum.x / vertices.len() as f64,
            z_ref: 0.5,
            eye_depth: z0,
            rate: (z1 - z0) / (high.y - low.y),
            per_length: moved.length() / length,
        };
        space.checked()
    }
    fn checked(self) -> Result<Self, Detail> {
        let scale = self.y[0].abs().max(self.y[1].abs());
        if self.extent() <= f64::EPSILON.sqrt() * scale {
            return Err(Detail::FlatBody);
        }
        if self.eye_depth <= 0.0 {
            return Err(Detail::BehindEye);
        }
        // The far end must lie deeper by more than rounding.
        let grows = self.rate * self.extent() > f64::EPSILON * self.eye_depth;
        if grows { Ok(self) } else { Err(Detail::DepthFallsAlongAxis) }
    }
    /// Extent of the receivers' body along the axis.
    pub fn extent(&self) -> f64 {
        self.y[1] - self.y[0]
    }
    /// The warp distance that makes the error equal at both ends of a line across the light that begins at eye depth `near`
    /// and ends at `far`: `(near + √(near far)) / rate` (5.2).
    pub fn equal_error_distance(&self, near: f64, far: f64) -> f64 {
        near * (1.0 + (far / near).sqrt()) / self.rate
    }
    /// Eye depths at both ends of the line across the light along the whole body: Δz apart.
    pub fn line(&self) -> [f64; 2] {
        [self.eye_depth, self.eye_depth + self.rate * self.extent()]
    }
    /// The same space for another map without a warp, as a whole.
    pub fn unwarped(&self, rows: &Rows, view: &FocusedView) -> Self {
        let images = view.receivers.vertices().iter().map(|p| rows.project(*p).y);
        let y = images.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], y| [low.min(y), high.max(y)]);
        Self { rows: *rows, y, x_ref: 0.0, ..*self }
    }
    /// A warp distance kept within what digits can hold; notes what is raised. Beyond the largest, infinity included, the map
    /// is uniform to the last bit.
    pub fn limited(&self, distance: f64, notes: &mut Vec<Note>) -> f64 {
        let least = LEAST_LAMBDA * self.extent();
        if distance < least {
            let (given, least) = (distance / self.per_length, least / self.per_length);
            notes.push(Note::new(Kind::WarpDistanceRaised, &[("given", given), ("least", least)]));
        }
        distance.clamp(least, self.extent() / f64::EPSILON)
    }
    /// The provisional map with the reference point `distance` before the near end (5.1). x, y, w are those of the
    /// perspective; the fit crops.
    pub fn warped(&self, distance: f64) -> Rows {
        let Self { rows, .. } = self;
        let middle = distance + 0.5 * self.extent();
        Rows {
            x: rows.x - rows.w * self.x_ref,
            // Over w, a constant and Y - Ymin differ by a crop. From far away the constant would cancel; from nearby, where
            // all but the near end has nearly the same (Y - Ymin) / w, the other does.
            y: if distance < self.extent() { -rows.w * distance } else { rows.y - rows.w * self.y[0] },
            z: rows.z - rows.w * self.z_ref,
            w: rows.y / middle + rows.w * ((distance - self.y[0]) / middle),
        }
    }
}
