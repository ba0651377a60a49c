//! Light rays: the two-dimensional space that a shadow map samples, and frames of it.
//!
//! Source: theory.md 0. A light is one homogeneous point L4, `(-l, 0)` or `(p, 1)`; a matrix is a shadow map's when its rows
//! x, y and w vanish there (0.1). Every technique is a choice of these rows.

use glam::{DMat3, DVec3, DVec4};

use crate::geometry::Rows;
use crate::scene::Light;

/// The rays of a light, told relative to a local origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightRays {
    /// The centre of projection: `(-l, 0)` for a directional light that travels along l, `(p, 1)` for one at p.
    pub point: DVec4,
}

/// Three unit vectors that turn with the light: `right x up = -along`, so coordinates in them are left-handed, as NDC is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightFrame {
    /// Map x.
    pub right: DVec3,
    /// Map y, the warp axis.
    pub up: DVec3,
    /// The way the light travels.
    pub along: DVec3,
}

impl LightRays {
    /// The rays of a light, in coordinates relative to `origin` (world).
    pub fn new(light: &Light, origin: DVec3) -> Self {
        let p = light.point();
        Self { point: if p.w == 0.0 { p } else { (p.truncate() - origin).extend(1.0) } }
    }
    /// Unit direction of the ray through a point, away from the light; nothing at the light itself.
    pub fn direction_at(&self, p: DVec3) -> Option<DVec3> {
        (p * self.point.w - self.point.truncate()).try_normalize()
    }
    /// Orientation of a map around a point (theory.md 0): +1 when triangles keep the winding that the light sees, -1 when they
    /// are mirrored, 0 when the map is singular there.
    pub fn orientation(&self, clip_from_local: &Rows, p: DVec3) -> f64 {
        let Some(direction) = self.direction_at(p) else { return 0.0 };
        let frame = LightFrame::any(direction);
        let column =
            |v: DVec4| DVec3::new(clip_from_local.x.dot(v), clip_from_local.y.dot(v), clip_from_local.w.dot(v));
        let at = column(p.extend(1.0));
        let h = DMat3::from_cols(column(frame.right.extend(0.0)), column(frame.up.extend(0.0)), at);
        let product = h.determinant() * at.z;
        if product == 0.0 { 0.0 } else { product.signum() }
    }
}

impl LightFrame {
    /// The frame of light that travels along a unit vector, with the warp axis in the plane of `towards`, and the length
    /// of `towards` in the shadow plane. Nothing when `towards` has no part across the light above rounding.
    pub fn towards(along: DVec3, towards: DVec3) -> Option<(Self, f64)> {
        let across = towards - along * towards.dot(along);
        let length = across.length();
        // Derived from f64: the projection cancels all but `length` of |towards|; half of the digits must be left.
        let least = f64::EPSILON.sqrt() * towards.length();
        if length <= least || length.is_nan() {
            return None;
        }
        // Once more against `along`: the first projection left rounding errors of size |towards|, not of size `length`.
        let up = across / length;
        let up = (up - along * up.dot(along)).normalize();
        Some((Self { right: along.cross(up), up, along }, length))
    }
    /// A frame that depends on nothing but the direction: up is world +y, or world +z for light along y.
    pub fn any(along: DVec3) -> Self {
        match Self::towards(along, DVec3::Y).or_else(|| Self::towards(along, DVec3::Z)) {
            Some((frame, _)) => frame,
            // Unreachable for a unit vector; whatever comes, the frame stays finite.
            None => Self { right: DVec3::X, up: DVec3::Y, along },
        }
    }
    /// Coordinates (x, Y, c) of (0.2) as clip rows with w = 1: across, along the warp axis, along the light.
    pub fn orthographic(&self) -> Rows {
        Rows { x: self.right.extend(0.0), y: self.up.extend(0.0), z: self.along.extend(0.0), w: DVec4::W }
    }
    /// Perspective from `apex` with half angle tangent `tan_half`: w is the depth along the axis, z runs from 0 at depth
    /// `near` to 1 at `far`.
    pub fn perspective(&self, apex: DVec3, tan_half: f64, near: f64, far: f64) -> Rows {
        let row = |v: DVec3| v.extend(-v.dot(apex));
        let w = row(self.along);
        let scale = far / (far - near);
        Rows { x: row(self.right / tan_half), y: row(self.up / tan_half), z: (w - DVec4::W * near) * scale, w }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{DirectionalLight, SpotLight};

    #[test]
    fn frames_are_orthonormal_and_keep_the_winding_for_every_direction() {
        let directions = [DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_X, DVec3::new(1e-9, -1.0, 1e-12)];
        for direction in directions {
            let light = Light::Directional(DirectionalLight::new(direction).unwrap());
            let rays = LightRays::new(&light, DVec3::splat(1e7));
            let along = rays.direction_at(DVec3::ONE).unwrap();
            let f = LightFrame::any(along);
            assert!((f.right.cross(f.up) + f.along).length() < 1e-15 && f.up.dot(along).abs() < 1e-15);
            assert_eq!(rays.orientation(&f.orthographic(), DVec3::ONE), 1.0);
            let mirrored = Rows { x: -f.orthographic().x, ..f.orthographic() };
            assert_eq!(rays.orientation(&mirrored, DVec3::ONE), -1.0);
            assert!(LightFrame::towards(along, along * 3.0).is_none());
        }
    }

    #[test]
    fn a_spot_projects_its_cone_onto_the_square() {
        let light = SpotLight::new(DVec3::new(5e6, 3.0, 0.0), DVec3::new(1.0, -1.0, 0.0), 1.0, 10.0).unwrap();
        let origin = DVec3::new(5e6, 0.0, 0.0);
        let rays = LightRays::new(&Light::Spot(light), origin);
        let frame = LightFrame::any(light.direction());
        let apex = rays.point.truncate();
        let rows = frame.perspective(apex, 0.5_f64.tan(), 1.0, 10.0);
        for row in [rows.x, rows.y, rows.w] {
            assert!(row.dot(rays.point).abs() < 1e-15);
        }
        let edge = apex + (frame.along + frame.up * 0.5_f64.tan()) * 10.0;
        assert!((rows.project(edge) - DVec3::new(0.0, 1.0, 1.0)).length() < 1e-14);
        assert!(rows.project(apex + frame.along).z.abs() < 1e-15);
        assert_eq!(rays.orientation(&rows, edge), 1.0);
    }
}
