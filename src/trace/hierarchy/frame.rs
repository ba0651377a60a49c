//! Where an instance stands: maps between its local frame and the world, in f64 about the scene's origin.

use glam::{DAffine3, DMat3, DVec3};

/// Above this condition number the inverse of a transform loses more than the rounding of baked vertices to f32 does:
/// the inverse errs by condition * 2^-53, baking by 2^-24.
const MAX_CONDITION: f64 = (1u64 << 29) as f64;

/// An invertible placement.
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    /// World positions are relative to the scene's origin.
    pub world_from_local: DAffine3,
    pub local_from_world: DAffine3,
    /// Bound on how much `local_from_world` lengthens a vector (Frobenius norm).
    pub local_per_world: f64,
    /// Bound on how much `world_from_local` lengthens a vector.
    pub world_per_local: f64,
}

impl Frame {
    /// The frame of a map whose translation is already relative to the scene's origin; none where the map flattens, so
    /// far as f64 can tell.
    pub fn new(world_from_local: DAffine3) -> Option<Self> {
        let linear = world_from_local.matrix3;
        let size = linear.to_cols_array().iter().fold(0.0f64, |m, x| m.max(x.abs()));
        if !(size > 0.0 && size.is_finite()) {
            return None;
        }
        // To size about 1 by a power of two, exactly: the determinant is a product of three lengths and would
        // underflow at 1e-120.
        let scale = power_of_two_near(size);
        let unit_from_local = linear * (1.0 / scale);
        let local_from_unit = unit_from_local.inverse();
        let condition = frobenius(&unit_from_local) * frobenius(&local_from_unit);
        if condition.is_nan() || condition > MAX_CONDITION {
            return None;
        }
        let inverse = local_from_unit * (1.0 / scale);
        if !inverse.is_finite() {
            return None;
        }
        let local_from_world = DAffine3::from_mat3_translation(inverse, inverse * -world_from_local.translation);
        Some(Self {
            world_from_local,
            local_from_world,
            local_per_world: frobenius(&inverse),
            world_per_local: frobenius(&linear),
        })
    }
    /// Product of both norms: how much errors grow on the way there and back.
    pub fn condition(&self) -> f64 {
        self.local_per_world * self.world_per_local
    }
    /// Bound on the magnitude of world coordinates of the local cube [-1, 1]^3.
    pub fn reach(&self) -> f64 {
        // A corner of the cube is sqrt(3) from its middle.
        self.world_from_local.translation.abs().max_element() + 3f64.sqrt() * self.world_per_local
    }
}

/// A power of two within a factor of two of a positive number, both it and its inverse normal.
#[inline(always)]
pub fn power_of_two_near(x: f64) -> f64 {
    /// The exponents' bits.
    const EXPONENT: u64 = 0x7ff << 52;
    const LEAST: f64 = f64::from_bits(23 << 52);
    const MOST: f64 = f64::from_bits(2023 << 52);
    // As vector instructions have them; the largest of a NaN.
    let x = if x < MOST { x } else { MOST };
    let x = if x > LEAST { x } else { LEAST };
    f64::from_bits(x.to_bits() & EXPONENT)
}

/// The inverse of what [`power_of_two_near`] returns, without a division.
#[inline(always)]
pub fn inverse_power_of_two(x: f64) -> f64 {
    f64::from_bits((2046 << 52) - x.to_bits())
}

fn frobenius(m: &DMat3) -> f64 {
    let square = |v: DVec3| v.length_squared();
    let size = m.to_cols_array().iter().fold(0.0f64, |s, x| s.max(x.abs()));
    if !(size > 0.0 && size.is_finite()) {
        return size;
    }
    let scale = power_of_two_near(size);
    let m = *m * (1.0 / scale);
    (square(m.x_axis) + square(m.y_axis) + square(m.z_axis)).sqrt() * scale
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_maps_are_told_from_small_ones() {
        for scale in [1e-200, 1e-9, 1.0, 1e9, 1e140] {
            let map = DMat3::from_rotation_y(0.3) * DMat3::from_diagonal(DVec3::new(scale, -2.0 * scale, 3.0 * scale));
            let frame = Frame::new(DAffine3::from_mat3(map)).unwrap();
            let back = frame.local_from_world.transform_vector3(frame.world_from_local.transform_vector3(DVec3::ONE));
            assert!((back - DVec3::ONE).length() < 1e-14);
            assert!(frame.condition() < 30.0);
        }
        let flat = DMat3::from_rotation_x(0.7) * DMat3::from_diagonal(DVec3::new(1.0, 0.0, 1.0));
        assert!(Frame::new(DAffine3::from_mat3(flat)).is_none());
        assert!(Frame::new(DAffine3::from_mat3(DMat3::ZERO)).is_none());
        assert!(Frame::new(DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(1.0, 1e-12, 1.0)))).is_none());
    }

    #[test]
    fn powers_of_two_are_near() {
        for x in [1e-300, 0.7, 1.0, 1.9, 3e200] {
            let p = power_of_two_near(x);
            assert!(p <= x && x < 2.0 * p && (p.to_bits() << 12) == 0);
        }
        for x in [0.0, 5e-324, 1e-300, 0.3, 1.0, 7.0, 1e300, f64::MAX, f64::INFINITY, f64::NAN] {
            let p = power_of_two_near(x);
            assert!(p.is_normal() && p > 0.0);
            assert_eq!(inverse_power_of_two(p), p.recip());
        }
    }
}
