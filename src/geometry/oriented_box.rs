//! Parallelepipeds: what an affine map makes of an axis-aligned box.
//!
//! Support functions (the largest value of a linear functional over the box) decide most questions about a box in a
//! dozen operations, without corners and without a division; see [`OrientedBox::range`].

use glam::{DAffine3, DVec3, DVec4};

use super::Aabb;

/// The points `center + a0 half[0] + a1 half[1] + a2 half[2]`, every |a| <= 1. Flat where a half axis is zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrientedBox {
    /// The middle.
    pub center: DVec3,
    /// Half of each edge.
    pub half: [DVec3; 3],
}

impl OrientedBox {
    /// The image of a box under an affine map, told relative to `origin` (world).
    pub fn new(bounds: &Aabb, world_from_source: &DAffine3, origin: DVec3) -> Self {
        let extent = 0.5 * bounds.extent();
        let m = &world_from_source.matrix3;
        Self {
            center: m.mul_vec3(bounds.center()) + (world_from_source.translation - origin),
            half: [m.x_axis * extent.x, m.y_axis * extent.y, m.z_axis * extent.z],
        }
    }
    /// An axis-aligned box of the world, told relative to `origin`.
    pub fn around(bounds: &Aabb, origin: DVec3) -> Self {
        let half = 0.5 * bounds.extent();
        Self { center: bounds.center() - origin, half: [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * half) }
    }
    /// The smallest axis-aligned box around it.
    pub fn aabb(&self) -> Aabb {
        let reach = self.half[0].abs() + self.half[1].abs() + self.half[2].abs();
        Aabb { min: self.center - reach, max: self.center + reach }
    }
    /// Smallest and largest value over the box of `functional · (p, 1)`.
    pub fn range(&self, functional: DVec4) -> (f64, f64) {
        let direction = functional.truncate();
        let middle = direction.dot(self.center) + functional.w;
        let reach =
            direction.dot(self.half[0]).abs() + direction.dot(self.half[1]).abs() + direction.dot(self.half[2]).abs();
        (middle - reach, middle + reach)
    }
    /// The eight corners; bit k of the index chooses the positive side of `half[k]`.
    pub fn corners(&self) -> [DVec3; 8] {
        let signed = |i: usize, k: usize| if i >> k & 1 == 1 { self.half[k] } else { -self.half[k] };
        std::array::from_fn(|i| self.center + signed(i, 0) + signed(i, 1) + signed(i, 2))
    }
    /// Outward unit normals of its six faces: minus and plus of each axis. A face without an area may get any.
    pub fn normals(&self) -> [DVec3; 6] {
        let outward = |k: usize| {
            let across = self.half[(k + 1) % 3].cross(self.half[(k + 2) % 3]);
            let unit = across.try_normalize().or(self.half[k].try_normalize()).unwrap_or(DVec3::X);
            if unit.dot(self.half[k]) < 0.0 { -unit } else { unit }
        };
        let n = [outward(0), outward(1), outward(2)];
        [-n[0], n[0], -n[1], n[1], -n[2], n[2]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;

    #[test]
    fn the_range_of_a_functional_is_attained_at_corners() {
        let bounds = Aabb { min: DVec3::new(-1.0, 0.0, 2.0), max: DVec3::new(3.0, 0.0, 5.0) };
        let map = DAffine3::from_mat3_translation(
            DMat3::from_cols(DVec3::new(0.0, 2.0, 0.3), DVec3::new(-1.0, 0.2, 0.0), DVec3::new(0.1, 0.0, -4.0)),
            DVec3::new(5e6, 1.0, -3e5),
        );
        let origin = DVec3::new(5e6, 0.0, -3e5);
        let b = OrientedBox::new(&bounds, &map, origin);
        let f = DVec4::new(0.3, -2.0, 1.0, 7.0);
        let values = b.corners().map(|p| f.dot(p.extend(1.0)));
        let (low, high) = b.range(f);
        assert!((low - values.iter().copied().fold(f64::INFINITY, f64::min)).abs() < 1e-12);
        assert!((high - values.iter().copied().fold(f64::NEG_INFINITY, f64::max)).abs() < 1e-12);
        let direct = Aabb::from_points(bounds.corners().map(|p| map.transform_point3(p) - origin));
        // Rounding of coordinates near 5e6 in the direct way: half an ulp is 5e-10.
        assert!((direct.min - b.aabb().min).length() < 1e-8 && (direct.max - b.aabb().max).length() < 1e-8);
        assert!(b.normals().iter().all(|n| n.is_normalized()));
    }
}
