//! Numbers that a depth format holds.
//!
//! Source: the conversions of Vulkan, Direct3D 11 and WebGPU: unsigned normalised integers of n bits hold k / (2^n - 1), the
//! nearest of them; halves are IEEE 754 binary16, rounded to nearest even, subnormals included.

use half::f16;

use crate::names::name_of;

/// The numbers that a map can hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Format {
    /// Single precision.
    #[default]
    F32,
    /// Half precision.
    F16,
    /// 16 bits from 0 to 1.
    Unorm16,
    /// 24 bits from 0 to 1.
    Unorm24,
}

impl Format {
    /// The names users write.
    pub const NAMES: [(&'static str, Self); 4] =
        [("f32", Self::F32), ("f16", Self::F16), ("unorm16", Self::Unorm16), ("unorm24", Self::Unorm24)];

    /// The name users write.
    pub fn name(self) -> &'static str {
        name_of(&Self::NAMES, self)
    }
    /// The largest whole number of a normalised integer; nothing for floats.
    pub fn levels(self) -> Option<f64> {
        match self {
            Self::F32 | Self::F16 => None,
            Self::Unorm16 => Some(65_535.0),
            Self::Unorm24 => Some(16_777_215.0),
        }
    }
    /// The number of the format nearest to a depth in [0, 1], as single precision.
    #[inline]
    pub fn quantise(self, z: f32) -> f32 {
        match self {
            Self::F32 => z,
            Self::F16 => f16::from_f32(z).to_f32(),
            Self::Unorm16 => unorm(z, 65_535.0),
            Self::Unorm24 => unorm(z, 16_777_215.0),
        }
    }
    /// The distance between neighbouring numbers of the format at a depth: of floats, from the largest number not above it to the next.
    pub fn step(self, z: f64) -> f64 {
        // Powers of two from the least normal number on; subnormals are spaced as the first of them.
        let float = |digits: i32, least_exponent: i32| {
            let exponent = if z > 0.0 { z.abs().log2().floor() as i32 } else { least_exponent };
            2f64.powi(exponent.clamp(least_exponent, 1023) - digits)
        };
        match self {
            Self::F32 => float(23, -126),
            Self::F16 => float(10, -14),
            Self::Unorm16 | Self::Unorm24 => self.levels().map_or(0.0, f64::recip),
        }
    }
}

/// The nearest multiple of 1 / levels.
#[inline]
fn unorm(z: f32, levels: f64) -> f32 {
    ((f64::from(z).clamp(0.0, 1.0) * levels).round_ties_even() / levels) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_to_the_nearest_of_the_format() {
        for (_, format) in Format::NAMES {
            assert_eq!((format.quantise(0.0), format.quantise(1.0)), (0.0, 1.0), "{format:?}");
            let mut last = 0.0;
            for i in 0..=100_000 {
                let z = i as f32 / 100_000.0;
                let held = format.quantise(z);
                assert_eq!(format.quantise(held), held, "{format:?}: {held} is a number of the format");
                let half = 0.5 * format.step(f64::from(z));
                // The rounding of the format's number to single precision is the rest.
                let apart = (f64::from(held) - f64::from(z)).abs();
                assert!(apart <= half * (1.0 + 1e-6) + 0.5 * f64::from(f32::EPSILON), "{format:?}: {z} {held}");
                assert!(held >= last, "{format:?}: ascends");
                last = held;
            }
        }
        assert_eq!(Format::F16.quantise(f32::from_bits(0x3380_0000)), 2f32.powi(-24), "the least subnormal");
        assert_eq!(Format::F16.quantise(2f32.powi(-25)), 0.0, "halves to even");
        assert_eq!(Format::F16.quantise(1.0 + 2f32.powi(-11)), 1.0, "halves to even");
        assert_eq!(Format::Unorm16.quantise(0.5), (32768.0 / 65535.0) as f32);
    }

    #[test]
    fn steps_are_the_distance_to_the_next_number() {
        for z in [1e-30f32, 1e-4, 0.24, 0.25, 0.3, 0.5, 0.99] {
            let next = f32::from_bits(z.to_bits() + 1);
            assert_eq!(Format::F32.step(f64::from(z)), f64::from(next) - f64::from(z));
            let held = f16::from_f32(z);
            let next = f16::from_bits(held.to_bits() + 1);
            assert_eq!(Format::F16.step(held.to_f64()), next.to_f64() - held.to_f64(), "{z}");
        }
        assert_eq!((Format::F32.step(0.0), Format::F16.step(0.0)), (2f64.powi(-149), 2f64.powi(-24)));
        assert_eq!((Format::Unorm16.step(0.7), Format::Unorm24.step(0.1)), (1.0 / 65535.0, 1.0 / 16777215.0));
    }
}
