//! Planes as the border of a half-space.

use glam::{DVec3, DVec4};

/// The half-space `normal · p + offset <= 0`; the normal is a unit vector that points out of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Unit vector, out of the half-space.
    pub normal: DVec3,
    /// Minus the distance of the plane from the origin along the normal.
    pub offset: f64,
}

impl Plane {
    /// The half-space behind the plane through `p` with an outward unit `normal`.
    pub fn through(p: DVec3, normal: DVec3) -> Self {
        Self { normal, offset: -normal.dot(p) }
    }
    /// The half-space where `functional · (p, 1) >= 0`; nothing for a functional without a direction.
    pub fn where_positive(functional: DVec4) -> Option<Self> {
        let length = functional.truncate().length();
        (length > 0.0).then(|| Self { normal: -functional.truncate() / length, offset: -functional.w / length })
    }
    /// The distance of points as a linear functional of (p, 1).
    pub fn functional(&self) -> DVec4 {
        self.normal.extend(self.offset)
    }
    /// How far a point lies outside; negative inside.
    pub fn distance(&self, p: DVec3) -> f64 {
        self.normal.dot(p) + self.offset
    }
}
