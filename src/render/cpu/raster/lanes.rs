//! The vector operations of the fill loops, spelled out: left to itself the compiler turns them into scalar code or into
//! masked stores, from which later loads of the same pixels cannot be forwarded (measured: three times the instructions).
//!
//! Two implementations with the same results: AVX2, and arrays for every other processor.

use super::simd::LANES;

/// Depth of the far plane where triangles are numbered; less than what is there.
pub const FAR_OF_IDS: f32 = 0.0;

/// [`LANES`] 32-bit numbers side by side.
pub trait Lanes: Copy {
    type Int: Copy;
    type Float: Copy;
    fn ints(self, x: [i32; LANES]) -> Self::Int;
    fn floats(self, x: [f32; LANES]) -> Self::Float;
    /// The numbers, one after the other.
    fn to_ints(self, x: Self::Int) -> [i32; LANES];
    fn add(self, a: Self::Int, b: Self::Int) -> Self::Int;
    /// Bitwise or.
    fn or(self, a: Self::Int, b: Self::Int) -> Self::Int;
    fn add_floats(self, a: Self::Float, b: Self::Float) -> Self::Float;
    /// `z` held between two others; none may be NaN.
    fn clamp(self, z: Self::Float, low: Self::Float, high: Self::Float) -> Self::Float;
    /// Keeps the smaller depth where `outside` is not negative.
    fn nearest(self, depth: &mut [f32; LANES], z: Self::Float, outside: Self::Int);
    /// Keeps the two smallest depths that differ, where `outside` is not negative.
    fn nearest_two(self, first: &mut [f32; LANES], second: &mut [f32; LANES], z: Self::Float, outside: Self::Int);
    /// Keeps the smaller depth, with the number of the triangle; of equal depths before the far plane the smaller
    /// number.
    fn nearest_with_id(
        self,
        depth: &mut [f32; LANES],
        id: &mut [u32; LANES],
        z: Self::Float,
        outside: Self::Int,
        new_id: u32,
    );
}

/// The two smallest of two depths and a third that differ from each other; the order in which depths come does not matter.
#[inline(always)]
pub fn two_nearest(first: f32, second: f32, z: f32) -> (f32, f32) {
    if z < first {
        (z, first)
    } else if z > first && z < second {
        (first, z)
    } else {
        (first, second)
    }
}

/// For every processor.
#[derive(Debug, Clone, Copy)]
pub struct Plain;

impl Lanes for Plain {
    type Int = [i32; LANES];
    type Float = [f32; LANES];
    #[inline(always)]
    fn ints(self, x: [i32; LANES]) -> Self::Int {
        x
    }
    #[inline(always)]
    fn floats(self, x: [f32; LANES]) -> Self::Float {
        x
    }
    #[inline(always)]
    fn to_ints(self, x: Self::Int) -> [i32; LANES] {
        x
    }
    #[inline(always)]
    fn add(self, a: Self::Int, b: Self::Int) -> Self::Int {
        std::array::from_fn(|l| a[l].wrapping_add(b[l]))
    }
    #[inline(always)]
    fn or(self, a: Self::Int, b: Self::Int) -> Self::Int {
        std::array::from_fn(|l| a[l] | b[l])
    }
    #[inline(always)]
    fn add_floats(self, a: Self::Float, b: Self::Float) -> Self::Float {
        std::array::from_fn(|l| a[l] + b[l])
    }
    #[inline(always)]
    fn clamp(self, z: Self::Float, low: Self::Float, high: Self::Float) -> Self::Float {
        std::array::from_fn(|l| {
            let z = if z[l] > low[l] { z[l] } else { low[l] };
            if z < high[l] { z } else { high[l] }
        })
    }
    #[inline(always)]
    fn nearest(self, depth: &mut [f32; LANES], z: Self::Float, outside: Self::Int) {
        for l in 0..LANES {
            if outside[l] >= 0 && z[l] < depth[l] {
                depth[l] = z[l];
            }
        }
    }
    #[inline(always)]
    fn nearest_two(self, first: &mut [f32; LANES], second: &mut [f32; LANES], z: Self::Float, outside: Self::Int) {
        for l in 0..LANES {
            if outside[l] >= 0 {
                (first[l], second[l]) = two_nearest(first[l], second[l], z[l]);
            }
        }
    }
    #[inline(always)]
    fn nearest_with_id(
        self,
        depth: &mut [f32; LANES],
        id: &mut [u32; LANES],
        z: Self::Float,
        outside: Self::Int,
        new_id: u32,
    ) {
        for l in 0..LANES {
            let first = z[l] == depth[l] && z[l] < FAR_OF_IDS && new_id < id[l];
            if outside[l] >= 0 && (z[l] < depth[l] || first) {
                (depth[l], id[l]) = (z[l], new_id);
            }
        }
    }
}

/// Proof that the processor has AVX2 and FMA: there is no way to one but [`Avx2::detect`].
#[cfg(target_arch = "x86_64")]
#[derive(Debug, Clone, Copy)]
pub struct Avx2(());

#[cfg(target_arch = "x86_64")]
impl Avx2 {
    /// The proof, where it is true.
    #[inline]
    pub fn detect() -> Option<Self> {
        (is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")).then_some(Self(()))
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::*;

    use super::{Avx2, FAR_OF_IDS, LANES, Lanes};

    impl Lanes for Avx2 {
        type Int = __m256i;
        type Float = __m256;
        #[inline(always)]
        fn ints(self, x: [i32; LANES]) -> Self::Int {
            // SAFETY: `self` proves AVX2; loads and stores are of whole arrays of eight, without demands on alignment.
            unsafe { _mm256_loadu_si256(x.as_ptr().cast()) }
        }
        #[inline(always)]
        fn floats(self, x: [f32; LANES]) -> Self::Float {
            // SAFETY: `self` proves AVX2; loads and stores are of whole arrays of eight, without demands on alignment.
            unsafe { _mm256_loadu_ps(x.as_ptr()) }
        }
        #[inline(always)]
        fn to_ints(self, x: Self::Int) -> [i32; LANES] {
            let mut out = [0; LANES];
            // SAFETY: `self` proves AVX2; loads and stores are of whole arrays of eight, without demands on alignment.
            unsafe { _mm256_storeu_si256(out.as_mut_ptr().cast(), x) };
            out
        }
        #[inline(always)]
        fn add(self, a: Self::Int, b: Self::Int) -> Self::Int {
            // SAFETY: `self` proves AVX2, which is all that this asks for.
            unsafe { _mm256_add_epi32(a, b) }
        }
        #[inline(always)]
        fn or(self, a: Self::Int, b: Self::Int) -> Self::Int {
            // SAFETY: `self` proves AVX2, which is all that this asks for.
            unsafe { _mm256_or_si256(a, b) }
        }
        #[inline(always)]
        fn add_floats(self, a: Self::Float, b: Self::Float) -> Self::Float {
            // SAFETY: `self` proves AVX2, which is all that this asks for.
            unsafe { _mm256_add_ps(a, b) }
        }
        #[inline(always)]
        fn clamp(self, z: Self::Float, low: Self::Float, high: Self::Float) -> Self::Float {
            // SAFETY: `self` proves AVX2, which is all that this asks for.
            unsafe { _mm256_min_ps(_mm256_max_ps(z, low), high) }
        }
        #[inline(always)]
        fn nearest(self, depth: &mut [f32; LANES], z: Self::Float, outside: Self::Int) {
            // SAFETY: `self` proves AVX2; loads and stores are of whole arrays of eight, without demands on alignment.
            unsafe {
                let z = _mm256_blendv_ps(z, _mm256_set1_ps(f32::INFINITY), _mm256_castsi256_ps(outside));
                _mm256_storeu_ps(depth.as_mut_ptr(), _mm256_min_ps(z, _mm256_loadu_ps(depth.as_ptr())));
            }
        }
        #[inline(always)]
        fn nearest_two(self, first: &mut [f32; LANES], second: &mut [f32; LANES], z: Self::Float, outside: Self::Int) {
            // SAFETY: `self` proves AVX2; loads and stores are of whole arrays of eight, without demands on alignment.
            unsafe {
                let far = _mm256_set1_ps(f32::INFINITY);
                let z = _mm256_blendv_ps(z, far, _mm256_castsi256_ps(outside));
                let (old, old_second) = (_mm256_loadu_ps(first.as_ptr()), _mm256_loadu_ps(second.as_ptr()));
                let equal = _mm256_cmp_ps::<_CMP_EQ_OQ>(z, old);
                let other = _mm256_blendv_ps(_mm256_max_ps(z, old), far, equal);
                _mm256_storeu_ps(first.as_mut_ptr(), _mm256_min_ps(z, old));
                _mm256_storeu_ps(second.as_mut_ptr(), _mm256_min_ps(other, old_second));
            }
        }
        #[inline(always)]
        fn nearest_with_id(
            self,
            depth: &mut [f32; LANES],
            id: &mut [u32; LANES],
            z: Self::Float,
            outside: Self::Int,
            new_id: u32,
        ) {
            // SAFETY: `self` proves AVX2; loads and stores are of whole arrays of eight, without demands on alignment.
            unsafe {
                let z = _mm256_blendv_ps(z, _mm256_set1_ps(f32::INFINITY), _mm256_castsi256_ps(outside));
                let old = _mm256_loadu_ps(depth.as_ptr());
                let old_id = _mm256_loadu_si256(id.as_ptr().cast());
                let new_id = _mm256_set1_epi32(new_id as i32);
                let before_far = _mm256_cmp_ps::<_CMP_LT_OQ>(z, _mm256_set1_ps(FAR_OF_IDS));
                let equal = _mm256_and_ps(_mm256_cmp_ps::<_CMP_EQ_OQ>(z, old), before_far);
                // The new number where depths are equal, else the largest of all.
                let candidate =
                    _mm256_or_si256(new_id, _mm256_xor_si256(_mm256_castps_si256(equal), _mm256_set1_epi32(-1)));
                let kept = _mm256_castsi256_ps(_mm256_min_epu32(old_id, candidate));
                let less = _mm256_cmp_ps::<_CMP_LT_OQ>(z, old);
                let id_now = _mm256_blendv_ps(kept, _mm256_castsi256_ps(new_id), less);
                _mm256_storeu_si256(id.as_mut_ptr().cast(), _mm256_castps_si256(id_now));
                _mm256_storeu_ps(depth.as_mut_ptr(), _mm256_min_ps(z, old));
            }
        }
    }
}
