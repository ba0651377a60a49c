//! Which of a light's rays a map serves.

use glam::{DVec3, DVec4};

/// The part of the light's rays that a map serves: where up to eight linear functionals of (p, 1) are not negative.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Region {
    functionals: [DVec4; Self::MOST],
    count: usize,
}

impl Region {
    /// Most functionals.
    pub const MOST: usize = 8;
    /// What counts as on a border, relative to the terms of a functional. Derived from f64: the roundings of coefficients, of a
    /// change of origin, of the point and of the sum, 2^-53 each. A point on the border between two maps must not fall
    /// between them.
    const ROUNDING: f64 = 16.0 * f64::EPSILON;
    /// All rays.
    pub const ALL: Self = Self { functionals: [DVec4::ZERO; Self::MOST], count: 0 };

    /// Where all of these, at most [`Region::MOST`], are not negative.
    ///
    /// # Panics
    /// For more.
    pub fn new(functionals: &[DVec4]) -> Self {
        let mut region = Self { count: functionals.len(), ..Self::ALL };
        region.functionals[..functionals.len()].copy_from_slice(functionals);
        region
    }
    /// The functionals of (p, 1).
    pub fn functionals(&self) -> &[DVec4] {
        &self.functionals[..self.count]
    }
    /// The same for points told relative to `origin`.
    pub fn relative_to(&self, origin: DVec3) -> Self {
        let moved = |f: DVec4| f.truncate().extend(f.dot(origin.extend(1.0)));
        Self { functionals: self.functionals.map(moved), ..*self }
    }
    /// Whether a point lies in it or, up to rounding, on its border.
    pub fn contains(&self, p: DVec3) -> bool {
        self.functionals().iter().all(|f| Self::is_on_side(*f, p))
    }
    /// Whether one functional is, up to rounding, not negative at a point.
    #[inline(always)]
    pub(crate) fn is_on_side(functional: DVec4, p: DVec3) -> bool {
        let p4 = p.extend(1.0);
        functional.dot(p4) >= -Self::ROUNDING * functional.abs().dot(p4.abs())
    }
    /// Where both are; nothing where that takes more functionals than a region has.
    pub fn and(&self, other: &Self) -> Option<Self> {
        let all = [self.functionals(), other.functionals()].concat();
        (all.len() <= Self::MOST).then(|| Self::new(&all))
    }
}
