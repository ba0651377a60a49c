//! The widths and the lane tricks of the rasteriser's kernels; see [`crate::simd`] for how they are compiled.

/// Elements that kernels treat at once: a 256-bit register of 32-bit numbers.
pub const LANES: usize = 8;

/// Declares a function that calls the inlined `$body` with the best [`Lanes`](super::lanes::Lanes) found at run time, compiled
/// for what they ask for.
macro_rules! with_lanes {
    ($(#[$meta:meta])* $vis:vis fn $name:ident $(<$generic:ident: $bound:path>)? ($($arg:ident: $ty:ty),* $(,)?) $(-> $ret:ty)? = $body:path) => {
        $(#[$meta])*
        $vis fn $name $(<$generic: $bound>)? ($($arg: $ty),*) $(-> $ret)? {
            #[cfg(target_arch = "x86_64")]
            {
                use super::avx2::Avx2;
                #[target_feature(enable = "avx2,fma,popcnt,bmi1")]
                fn wide $(<$generic: $bound>)? (lanes: Avx2, $($arg: $ty),*) $(-> $ret)? {
                    $body(lanes, $($arg),*)
                }
                if let Some(lanes) = Avx2::detect() {
                    // SAFETY: `lanes` proves the features that `wide` is compiled for.
                    return unsafe { wide(lanes, $($arg),*) };
                }
            }
            $body(super::plain::Plain, $($arg),*)
        }
    };
}
pub(super) use with_lanes;

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
