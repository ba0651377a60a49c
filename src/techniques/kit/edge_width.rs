//! How wide the texels of any map are across the edges of visible shadows.
//!
//! Source: theory.md 10.2, (10.1), (10.7) and (10.8).

use glam::DMat3;

use crate::fit::{MapSize, rectangle};
use crate::focus::{Outline, RayEdge};
use crate::geometry::planar_image;

/// Where an edge's width stops to count, pixels (theory.md (10.8)). Chosen by leaving scenes out (docs/defaults.md).
pub const CAP_PX: f64 = 32.0;

/// What a width counts, `c (1 - exp(-width / c))` with a finite cap c (theory.md (10.8)).
pub fn capped(width: f64, cap: f64) -> f64 {
    cap * (1.0 - (-width / cap).exp())
}

/// e to the power of -x for x of 0 or more, to a unit in the last place, without branches, for kernels: elsewhere fused
/// products are slow. That of 700 for what is beyond.
#[inline(always)]
pub fn exp_of_minus(x: f64) -> f64 {
    /// Added, it leaves a whole number in the lowest bits.
    const WHOLE: f64 = 1.5 * (1_u64 << 52) as f64;
    /// The logarithm of 2 in two parts, the first with zeros at its end.
    const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
    let x = if x < 700.0 { x } else { 700.0 };
    let shifted = x.mul_add(-std::f64::consts::LOG2_E, WHOLE);
    let power = shifted - WHOLE;
    let rest = power.mul_add(-LN_2[1], power.mul_add(-LN_2[0], -x));
    // Taylor's: half of ln 2 to the 14th over 14! is below half a unit in the last place.
    let mut sum = 1.0 / 6_227_020_800.0;
    for factorial in
        [479_001_600.0, 39_916_800.0, 3_628_800.0, 362_880.0, 40_320.0, 5_040.0, 720.0, 120.0, 24.0, 6.0, 2.0, 1.0, 1.0]
    {
        sum = rest.mul_add(sum, 1.0 / factorial);
    }
    f64::from_bits(sum.to_bits().wrapping_add(shifted.to_bits() << 52))
}

/// The same with [`CAP_PX`].
pub fn capped_px(width: f64) -> f64 {
    capped(width, CAP_PX)
}

/// The mean of what their widths count ([`capped_px`]) over edges, of the map of a homography of the light's rays
/// that is cropped to an outline. An edge where w is not positive counts as the cap; 0 without edges.
pub fn edge_width(edges: &[RayEdge], outline: &Outline, homography: &DMat3, size: &MapSize) -> f64 {
    let (low, high) = rectangle(outline, homography, size);
    let texel = (high - low) / size.receivers_texels();
    let (mut sum, mut weights) = (0.0, 0.0);
    for edge in edges {
        weights += edge.weight;
        let (_, w, per_ray) = planar_image(homography, edge.ray);
        let sides = per_ray.inverse().transpose() * edge.across * texel;
        let width = sides.x.abs() + sides.y.abs();
        sum += edge.weight * if w > 0.0 && width.is_finite() { capped_px(width) } else { CAP_PX };
    }
    if weights > 0.0 { sum / weights } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_those_of_the_library_to_the_last_place() {
        for i in 0..200_000 {
            let x = f64::from(i) * 0.0035;
            let (found, expected) = (exp_of_minus(x), (-x).exp());
            assert!((found - expected).abs() <= 2.0 * f64::EPSILON * expected, "{x}: {found} and {expected}");
        }
        assert_eq!(exp_of_minus(0.0), 1.0);
        assert_eq!(exp_of_minus(f64::INFINITY), exp_of_minus(700.0));
        assert_eq!(capped(f64::INFINITY, 32.0), 32.0);
    }
}
