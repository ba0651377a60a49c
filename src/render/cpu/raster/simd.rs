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

/// Four records of four numbers, turned: element l of result k is element k of record l.
#[inline(always)]
pub fn transposed(records: [&[f32; 4]; 4]) -> [[f32; 4]; 4] {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{
            __m128, _mm_loadu_ps, _mm_movehl_ps, _mm_movelh_ps, _mm_storeu_ps, _mm_unpackhi_ps, _mm_unpacklo_ps,
        };
        // SAFETY: SSE is part of every x86-64; loads and stores are of whole records, without demands on alignment.
        unsafe {
            let r: [__m128; 4] = [
                _mm_loadu_ps(records[0].as_ptr()),
                _mm_loadu_ps(records[1].as_ptr()),
                _mm_loadu_ps(records[2].as_ptr()),
                _mm_loadu_ps(records[3].as_ptr()),
            ];
            let (xy01, xy23) = (_mm_unpacklo_ps(r[0], r[1]), _mm_unpacklo_ps(r[2], r[3]));
            let (zw01, zw23) = (_mm_unpackhi_ps(r[0], r[1]), _mm_unpackhi_ps(r[2], r[3]));
            let mut out = [[0f32; 4]; 4];
            _mm_storeu_ps(out[0].as_mut_ptr(), _mm_movelh_ps(xy01, xy23));
            _mm_storeu_ps(out[1].as_mut_ptr(), _mm_movehl_ps(xy23, xy01));
            _mm_storeu_ps(out[2].as_mut_ptr(), _mm_movelh_ps(zw01, zw23));
            _mm_storeu_ps(out[3].as_mut_ptr(), _mm_movehl_ps(zw23, zw01));
            out
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    std::array::from_fn(|k| std::array::from_fn(|l| records[l][k]))
}
