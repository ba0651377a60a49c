//! The widths and the lane tricks of the rasteriser's kernels; see [`crate::simd`] for how they are compiled.

/// Elements that kernels treat at once: a 256-bit register of 32-bit numbers.
pub const LANES: usize = 8;

/// Bit l says whether lane l of `mask` is negative.
#[inline(always)]
pub fn sign_bits(mask: &[i32; LANES]) -> u32 {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_mm_castsi128_ps, _mm_movemask_ps, _mm_set_epi32};
        let [a, b, c, d, e, f, g, h] = *mask;
        // SAFETY: SSE2 is part of every x86-64. The compiler joins the lanes back into the register they come from.
        unsafe {
            let low = _mm_movemask_ps(_mm_castsi128_ps(_mm_set_epi32(d, c, b, a)));
            let high = _mm_movemask_ps(_mm_castsi128_ps(_mm_set_epi32(h, g, f, e)));
            (low | high << 4) as u32
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    mask.iter().enumerate().map(|(l, &m)| u32::from(m < 0) << l).sum()
}
