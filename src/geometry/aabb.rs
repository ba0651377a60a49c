//! Axis-aligned boxes.

use glam::{DAffine3, DVec3};

/// An axis-aligned box; empty when `min > max` on any axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb {
    /// The smallest corner.
    pub min: DVec3,
    /// The largest corner.
    pub max: DVec3,
}

impl Aabb {
    /// The box of nothing, neutral under [`Aabb::union`].
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The box of some points.
    pub fn from_points(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, Self::with_point)
    }
    /// This box grown to hold one more point.
    pub fn with_point(self, p: DVec3) -> Self {
        Self { min: self.min.min(p), max: self.max.max(p) }
    }
    /// The smallest box around both.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }
    /// Whether it holds no point at all.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }
    /// The middle.
    pub fn center(&self) -> DVec3 {
        // Halved first: the sum of two huge coordinates could overflow.
        0.5 * self.min + 0.5 * self.max
    }
    /// The edge lengths.
    pub fn extent(&self) -> DVec3 {
        self.max - self.min
    }
    /// The length of the diagonal.
    pub fn diagonal(&self) -> f64 {
        self.extent().length()
    }
    /// The eight corners; bit 0 of the index chooses max in x, bit 1 in y, bit 2 in z.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            DVec3::new(
                if i & 1 == 0 { self.min.x } else { self.max.x },
                if i & 2 == 0 { self.min.y } else { self.max.y },
                if i & 4 == 0 { self.min.z } else { self.max.z },
            )
        })
    }
    /// The box around this box's image under an affine map.
    pub fn transformed(&self, target_from_source: &DAffine3) -> Self {
        Self::from_points(self.corners().map(|p| target_from_source.transform_point3(p)))
    }
    /// Whether a point lies inside or on the border.
    pub fn contains(&self, p: DVec3) -> bool {
        p.cmpge(self.min).all() && p.cmple(self.max).all()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_is_neutral_and_corners_span_the_box() {
        let b = Aabb { min: DVec3::new(-1.0, 2.0, 3.0), max: DVec3::new(4.0, 5.0, 6.0) };
        assert!(Aabb::EMPTY.is_empty() && !b.is_empty());
        assert_eq!(Aabb::EMPTY.union(b), b);
        assert_eq!(Aabb::from_points(b.corners()), b);
        assert!(b.contains(b.center()) && !b.contains(DVec3::ZERO));
    }
}
