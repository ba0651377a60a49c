//! View frustums and light pyramids as corners and half-spaces.
//!
//! ```text
//!            ___---| far
//!     near |-      |          axis ->
//! apex  <  |       |          a pyramid begins at `near` = 0 where only its sides and its base cut
//!            ---___|
//! ```

use glam::DVec3;

use super::{ConvexBody, Plane};

/// A symmetric frustum with its apex at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frustum {
    /// Where its sides meet.
    pub apex: DVec3,
    /// Unit vector to the right, across the axis.
    pub right: DVec3,
    /// Unit vector upwards, across the axis.
    pub up: DVec3,
    /// Unit vector along the axis.
    pub forward: DVec3,
    /// Tangents of half the opening angle to the right and upwards.
    pub tan_half: [f64; 2],
    /// Depth of the first cut.
    pub near: f64,
    /// Depth of the base.
    pub far: f64,
}

impl Frustum {
    /// Outward unit normals: left, right, bottom, top, near, far (the face order of [`ConvexBody::from_hexahedron`]).
    fn normals(&self) -> [DVec3; 6] {
        let [tx, ty] = self.tan_half;
        // Divided by the larger of 1 and the tangent first: the tangent of nearly a right angle squared overflows.
        let side = |across: DVec3, tangent: f64| (across - self.forward * tangent) / 1.0_f64.hypot(tangent);
        [
            side(-self.right, tx),
            side(self.right, tx),
            side(-self.up, ty),
            side(self.up, ty),
            -self.forward,
            self.forward,
        ]
    }
    /// The six half-spaces: left, right, bottom, top, near, far.
    pub fn planes(&self) -> [Plane; 6] {
        let n = self.normals();
        let at = |depth: f64| self.apex + self.forward * depth;
        let points = [self.apex, self.apex, self.apex, self.apex, at(self.near), at(self.far)];
        std::array::from_fn(|i| Plane::through(points[i], n[i]))
    }
    /// The eight corners; bit 0 of the index chooses right, bit 1 up, bit 2 far.
    pub fn corners(&self) -> [DVec3; 8] {
        let [tx, ty] = self.tan_half;
        std::array::from_fn(|i| {
            let depth = if i & 4 == 0 { self.near } else { self.far };
            let x = if i & 1 == 0 { -tx } else { tx };
            let y = if i & 2 == 0 { -ty } else { ty };
            self.apex + (self.right * x + self.up * y + self.forward) * depth
        })
    }
    /// The frustum as a body.
    pub fn body(&self) -> ConvexBody {
        let (mut corners, mut normals) = (self.corners(), self.normals());
        // (right, up, forward) of a camera is left-handed where a box's axes are right-handed.
        if self.right.cross(self.up).dot(self.forward) < 0.0 {
            for i in 0..4 {
                corners.swap(2 * i, 2 * i + 1);
            }
            normals.swap(0, 1);
        }
        ConvexBody::from_hexahedron(&corners, &normals)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_lie_on_three_planes_each_and_behind_the_others() {
        for (right, near) in [(DVec3::X, 0.5), (DVec3::NEG_X, 0.5)] {
            let f = Frustum {
                apex: DVec3::new(1.0, 2.0, 3.0),
                right,
                up: DVec3::Y,
                forward: DVec3::NEG_Z,
                tan_half: [0.8, 0.5],
                near,
                far: 20.0,
            };
            let planes = f.planes();
            for p in f.corners() {
                let on = planes.iter().filter(|q| q.distance(p).abs() < 1e-12).count();
                assert!(on == 3 && planes.iter().all(|q| q.distance(p) < 1e-12));
            }
            let mut body = f.body();
            planes.iter().for_each(|q| body.clip(q));
            assert_eq!(body.vertices().len(), 8);
        }
    }

    #[test]
    fn a_nearly_flat_cone_has_finite_planes() {
        let f = Frustum {
            apex: DVec3::ZERO,
            right: DVec3::X,
            up: DVec3::Y,
            forward: DVec3::Z,
            tan_half: [1.6e16, 1e200],
            near: 0.0,
            far: 1.0,
        };
        assert!(f.planes().iter().all(|p| p.normal.is_normalized() && p.offset.is_finite()));
    }
}
