//! The volume of a map or picture, and whether boxes have a part in it.
//!
//! A box is outside only if it lies beyond one plane by more than a renderer's arithmetic can bring back: then each of its
//! triangles has all corners beyond that plane, and no renderer draws any of it.

use glam::{DMat4, DVec4, Vec3};

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

/// A volume as a placed mesh sees it, for many boxes of its parts.
#[derive(Debug, Clone, Copy)]
pub struct PlacedVolume {
    planes: [PlacedPlane; 6],
}

/// A plane of the volume in a mesh's own frame.
#[derive(Debug, Clone, Copy)]
struct PlacedPlane {
    /// Not negative inside.
    plane: DVec4,
    /// The terms of its clip coordinates for each unit along an axis, and those that every point has.
    terms: DVec4,
}

impl PlacedVolume {
    /// Of a mesh that a matrix takes to clip space.
    pub fn new(volume: &Volume, clip_from_local: &DMat4) -> Self {
        let local_from_clip = clip_from_local.transpose();
        let terms = DMat4::from_cols_array(&local_from_clip.to_cols_array().map(f64::abs));
        let placed = |plane: DVec4| PlacedPlane { plane: local_from_clip * plane, terms: terms * plane.abs() };
        Self { planes: volume.planes.map(placed) }
    }
    /// Whether a box of the mesh's frame lies outside. The terms of a part's clip coordinates may cancel, unlike those of a whole
    /// mesh, whose frame begins in its middle; so roundings are told from the terms.
    pub fn excludes(&self, min: Vec3, max: Vec3) -> bool {
        let (min, max) = (min.as_dvec3(), max.as_dvec3());
        let (center, half) = (0.5 * (min + max), 0.5 * (max - min));
        let reach = (center.abs() + half).extend(1.0);
        self.planes.iter().any(|PlacedPlane { plane, terms }| {
            let farthest = plane.dot(center.extend(1.0)) + plane.truncate().abs().dot(half);
            farthest < -(SINGLE + DOUBLE) * terms.dot(reach)
        })
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn parts_of_a_mesh_are_outside_where_all_their_points_are() {
        let clip = glam::dcamera::rh::proj::directx::perspective(1.0, 1.0, 0.1, 100.0);
        let volume = Volume::of_clip(&clip, 0.0);
        let placed = PlacedVolume::new(&volume, &(clip * DMat4::from_translation(DVec3::NEG_Z * 10.0)));
        let part = |x: f32, z: f32| placed.excludes(Vec3::new(x, 0.0, z), Vec3::new(x + 1.0, 1.0, z + 1.0));
        // At a distance of 10 the map ends at 10 tan(1/2) = 5.46, of 9 at 4.92.
        assert_eq!(
            [(0.0, 0.0), (5.4, 0.0), (5.5, 0.0), (-6.4, 0.0), (-6.5, 0.0)].map(|(x, z)| part(x, z)),
            [false, false, true, false, true]
        );
        // Near the far plane z and w differ by less than single precision tells.
        assert_eq!([9.8, 9.95, -95.0, -91.01].map(|z| part(0.0, z)), [false, true, true, false]);
        assert!(!part(f32::NAN, 0.0));
        // Coordinates that cancel: the place beyond the plane is less than what single precision makes of it.
        let far = DMat4::from_translation(DVec3::new(1.0 - 1e-9 - 1.0, 0.0, 0.5));
        let placed = PlacedVolume::new(&Volume::of_clip(&far, 0.0), &far);
        assert!(!placed.excludes(Vec3::new(1.0 + f32::EPSILON, 0.0, 0.0), Vec3::new(1.5, 0.1, 0.1)));
        assert!(placed.excludes(Vec3::new(1.0 + 64.0 * f32::EPSILON, 0.0, 0.0), Vec3::new(1.5, 0.1, 0.1)));
    }

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
