//! The volume of a map or picture, and whether boxes have a part in it.
//!
//! A box is outside only if it lies beyond one plane by more than a renderer's arithmetic can bring back: then each of its
//! triangles has all corners beyond that plane, and no renderer draws any of it.

use glam::{DMat4, DVec4};

use crate::geometry::Aabb;
use crate::scene::Enter;

/// Roundings of a clip coordinate in single precision, relative to its terms in a mesh's own frame: a dozen.
const SINGLE: f64 = 16.0 * f32::EPSILON as f64;
/// Roundings of matrices and of a group's box in double precision, relative to terms in the world.
const DOUBLE: f64 = 64.0 * f64::EPSILON;

/// Where clip coordinates lie between six planes.
#[derive(Debug, Clone, Copy)]
pub struct Volume {
    clip_from_world: DMat4,
    /// Functionals of clip coordinates that are not negative inside.
    planes: [DVec4; 6],
}

impl Volume {
    /// What a matrix takes between planes: functionals of clip coordinates that are not negative inside.
    pub fn new(clip_from_world: &DMat4, planes: [DVec4; 6]) -> Self {
        Self { clip_from_world: *clip_from_world, planes }
    }
    /// What a matrix takes to `-w <= x, y <= w` and `near w <= z <= (near + 1) w`.
    pub fn of_clip(clip_from_world: &DMat4, near: f64) -> Self {
        let (x, y, z, w) = (DVec4::X, DVec4::Y, DVec4::Z, DVec4::W);
        Self::new(clip_from_world, [w + x, w - x, w + y, w - y, z - near * w, (near + 1.0) * w - z])
    }
    /// The matrix.
    pub fn clip_from_world(&self) -> &DMat4 {
        &self.clip_from_world
    }
    /// How a group of instances is met.
    pub fn enter(&self, bounds: &Aabb) -> Enter {
        self.place(&self.clip_from_world, bounds)
    }
    /// Whether a placed mesh in a box may have a part in it.
    pub fn may_hold(&self, clip_from_local: &DMat4, bounds: &Aabb) -> bool {
        self.place(clip_from_local, bounds) != Enter::No
    }
    /// Whether a box lies outside of it, across its border or in it. Written so that a NaN is across.
    fn place(&self, clip_from_source: &DMat4, bounds: &Aabb) -> Enter {
        let (center, half) = (bounds.center(), 0.5 * bounds.extent());
        let rows = [0, 1, 2, 3].map(|i| clip_from_source.row(i));
        let clip = DVec4::from_array(rows.map(|row| row.dot(center.extend(1.0))));
        let reach = DVec4::from_array(rows.map(|row| row.truncate().abs().dot(half)));
        let terms = DVec4::from_array(rows.map(|row| row.abs().dot(center.abs().extend(1.0))));
        let source_from_clip = clip_from_source.transpose();
        let rounding = SINGLE * (clip.abs() + reach) + DOUBLE * (terms + reach);
        let mut place = Enter::All;
        for plane in &self.planes {
            let (value, reach) = (plane.dot(clip), (source_from_clip * *plane).truncate().abs().dot(half));
            let rounding = plane.abs().dot(rounding);
            if value + reach < -rounding {
                return Enter::No;
            }
            if !(value - reach > rounding) {
                place = Enter::Each;
            }
        }
        place
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn cube(x: f64, y: f64, z: f64) -> Aabb {
        let p = DVec3::new(x, y, z);
        Aabb { min: p - DVec3::ONE, max: p + DVec3::ONE }
    }

    #[test]
    fn boxes_are_kept_when_any_corner_is_inside_or_planes_disagree() {
        let clip = glam::dcamera::rh::proj::directx::perspective(1.0, 1.0, 0.1, 100.0);
        let volume = Volume::of_clip(&clip, 0.0);
        assert_eq!(volume.enter(&cube(0.0, 0.0, -10.0)), Enter::All);
        assert_eq!(volume.enter(&cube(0.0, 0.0, 0.0)), Enter::Each, "around the eye");
        assert_eq!(volume.enter(&cube(0.0, 0.0, 10.0)), Enter::No, "behind the eye");
        assert_eq!(volume.enter(&cube(50.0, 0.0, -10.0)), Enter::No, "to the right");
        assert_eq!(volume.enter(&cube(0.0, 0.0, -200.0)), Enter::No, "beyond far");
        assert_eq!(volume.enter(&Aabb { min: DVec3::splat(-1e9), max: DVec3::splat(1e9) }), Enter::Each);
        assert_eq!(volume.enter(&cube(f64::NAN, 0.0, -10.0)), Enter::Each);
    }

    #[test]
    fn places_far_from_the_origin_are_told_apart() {
        // One unit of map at coordinates of 5e6: single precision would hold half a unit of them.
        let far = DVec3::new(5e6, 0.0, -3e6);
        let clip = DMat4::from_translation(DVec3::new(-far.x, -far.y, 0.5 - far.z));
        let small = |x: f64| {
            let p = far + DVec3::new(x, 0.0, 0.0);
            Aabb { min: p - 0.1, max: p + 0.1 }
        };
        let volume = Volume::of_clip(&clip, 0.0);
        assert_eq!([0.0, 1.0, 1.2].map(|x| volume.enter(&small(x))), [Enter::All, Enter::Each, Enter::No]);
    }
}
