//! The vector operations with AVX2.

use std::arch::x86_64::*;
use std::mem::MaybeUninit;

use super::lanes::{FAR_OF_IDS, Lanes, ORDERS};
use super::simd::LANES;

/// Proof that the processor has AVX2 and FMA, and counts and finds bits, as all of these do: there is no way to one but [`Avx2::detect`].
#[derive(Debug, Clone, Copy)]
pub struct Avx2(());

impl Avx2 {
    /// The proof, where it is true.
    #[inline]
    pub fn detect() -> Option<Self> {
        let has_vectors = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
        let has_bits = is_x86_feature_detected!("popcnt") && is_x86_feature_detected!("bmi1");
        (has_vectors && has_bits).then_some(Self(()))
    }
}

// SAFETY of all that follows: `self` proves AVX2, which is all that these operations ask for; loads and stores are of whole arrays,
// without demands on alignment.
impl Lanes for Avx2 {
    type Int = __m256i;
    type Float = __m256;
    #[inline(always)]
    fn ints(self, x: [i32; LANES]) -> Self::Int {
        // SAFETY: as above.
        unsafe { _mm256_loadu_si256(x.as_ptr().cast()) }
    }
    #[inline(always)]
    fn unsigned(self, x: &[u32; LANES]) -> Self::Int {
        // SAFETY: as above.
        unsafe { _mm256_loadu_si256(x.as_ptr().cast()) }
    }
    #[inline(always)]
    fn floats(self, x: [f32; LANES]) -> Self::Float {
        // SAFETY: as above.
        unsafe { _mm256_loadu_ps(x.as_ptr()) }
    }
    #[inline(always)]
    fn int(self, x: i32) -> Self::Int {
        // SAFETY: as above.
        unsafe { _mm256_set1_epi32(x) }
    }
    #[inline(always)]
    fn float(self, x: f32) -> Self::Float {
        // SAFETY: as above.
        unsafe { _mm256_set1_ps(x) }
    }
    #[inline(always)]
    fn to_ints(self, x: Self::Int) -> [i32; LANES] {
        let mut out = [0; LANES];
        // SAFETY: as above.
        unsafe { _mm256_storeu_si256(out.as_mut_ptr().cast(), x) };
        out
    }
    #[inline(always)]
    fn to_floats(self, x: Self::Float) -> [f32; LANES] {
        let mut out = [0.0; LANES];
        // SAFETY: as above.
        unsafe { _mm256_storeu_ps(out.as_mut_ptr(), x) };
        out
    }
    #[inline(always)]
    fn bits_of(self, x: Self::Float) -> Self::Int {
        // SAFETY: as above.
        unsafe { _mm256_castps_si256(x) }
    }
    #[inline(always)]
    fn rounded(self, x: Self::Int) -> Self::Float {
        // SAFETY: as above.
        unsafe { _mm256_cvtepi32_ps(x) }
    }
    #[inline(always)]
    fn snapped(self, x: Self::Float) -> Self::Int {
        // SAFETY: as above.
        unsafe { _mm256_cvtps_epi32(x) }
    }
    #[inline(always)]
    fn add(self, a: Self::Int, b: Self::Int) -> Self::Int {
        // SAFETY: as above.
        unsafe { _mm256_add_epi32(a, b) }
    }
    #[inline(always)]
    fn sub(self, a: Self::Int, b: Self::Int) -> Self::Int {
        // SAFETY: as above.
        unsafe { _mm256_sub_epi32(a, b) }
    }
    #[inline(always)]
    fn mul(self, a: Self::Int, b: Self::Int) -> Self::Int {
        // SAFETY: as above.
        unsafe { _mm256_mullo_epi32(a, b) }
    }
    #[inline(always)]
    fn and(self, a: Self::Int, b: Self::Int) -> Self::Int {
        // SAFETY: as above.
        unsafe { _mm256_and_si256(a, b) }
    }
    #[inline(always)]
    fn or(self, a: Self::Int, b: Self::Int) -> Self::Int {
        // SAFETY: as above.
        unsafe { _mm256_or_si256(a, b) }
    }
    #[inline(always)]
    fn xor(self, a: Self::Int, b: Self::Int) -> Self::Int {
        // SAFETY: as above.
        unsafe { _mm256_xor_si256(a, b) }
    }
    #[inline(always)]
    fn shifted(self, x: Self::Int, by: u32) -> Self::Int {
        // SAFETY: as above.
        unsafe { _mm256_sra_epi32(x, _mm_cvtsi32_si128(by as i32)) }
    }
    #[inline(always)]
    fn least(self, a: Self::Int, b: Self::Int) -> Self::Int {
        // SAFETY: as above.
        unsafe { _mm256_min_epi32(a, b) }
    }
    #[inline(always)]
    fn most(self, a: Self::Int, b: Self::Int) -> Self::Int {
        // SAFETY: as above.
        unsafe { _mm256_max_epi32(a, b) }
    }
    #[inline(always)]
    fn less(self, a: Self::Int, b: Self::Int) -> Self::Int {
        // SAFETY: as above.
        unsafe { _mm256_cmpgt_epi32(b, a) }
    }
    #[inline(always)]
    fn equal(self, a: Self::Int, b: Self::Int) -> Self::Int {
        // SAFETY: as above.
        unsafe { _mm256_cmpeq_epi32(a, b) }
    }
    #[inline(always)]
    fn signs(self, x: Self::Int) -> u32 {
        // SAFETY: as above.
        unsafe { _mm256_movemask_ps(_mm256_castsi256_ps(x)) as u32 }
    }
    #[inline(always)]
    fn add_floats(self, a: Self::Float, b: Self::Float) -> Self::Float {
        // SAFETY: as above.
        unsafe { _mm256_add_ps(a, b) }
    }
    #[inline(always)]
    fn sub_floats(self, a: Self::Float, b: Self::Float) -> Self::Float {
        // SAFETY: as above.
        unsafe { _mm256_sub_ps(a, b) }
    }
    #[inline(always)]
    fn mul_floats(self, a: Self::Float, b: Self::Float) -> Self::Float {
        // SAFETY: as above.
        unsafe { _mm256_mul_ps(a, b) }
    }
    #[inline(always)]
    fn fused(self, a: Self::Float, b: Self::Float, c: Self::Float) -> Self::Float {
        // SAFETY: as above, and `self` proves FMA, too.
        unsafe { _mm256_fmadd_ps(a, b, c) }
    }
    #[inline(always)]
    fn div_floats(self, a: Self::Float, b: Self::Float) -> Self::Float {
        // SAFETY: as above.
        unsafe { _mm256_div_ps(a, b) }
    }
    #[inline(always)]
    fn smaller(self, a: Self::Float, b: Self::Float) -> Self::Float {
        // SAFETY: as above.
        unsafe { _mm256_min_ps(a, b) }
    }
    #[inline(always)]
    fn larger(self, a: Self::Float, b: Self::Float) -> Self::Float {
        // SAFETY: as above.
        unsafe { _mm256_max_ps(a, b) }
    }
    #[inline(always)]
    fn at_most(self, a: Self::Float, b: Self::Float) -> Self::Int {
        // SAFETY: as above.
        unsafe { _mm256_castps_si256(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b)) }
    }
    #[inline(always)]
    fn pick(self, mask: Self::Int, a: Self::Float, b: Self::Float) -> Self::Float {
        // SAFETY: as above.
        unsafe { _mm256_blendv_ps(b, a, _mm256_castsi256_ps(mask)) }
    }
    #[inline(always)]
    fn order(self, bits: u32) -> Self::Int {
        // SAFETY: as above.
        unsafe { _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(ORDERS[bits as usize % ORDERS.len()] as i64)) }
    }
    #[inline(always)]
    fn looked_up(self, table: &[f32], places: Self::Int) -> Self::Float {
        assert!(!table.is_empty() && table.len() <= i32::MAX as usize);
        // SAFETY: as above, and every place is one of the table's.
        unsafe {
            let places = _mm256_min_epu32(places, _mm256_set1_epi32(table.len() as i32 - 1));
            _mm256_i32gather_ps::<4>(table.as_ptr(), places)
        }
    }
    #[inline(always)]
    fn ordered_ints(self, x: Self::Int, order: Self::Int) -> Self::Int {
        // SAFETY: as above.
        unsafe { _mm256_permutevar8x32_epi32(x, order) }
    }
    #[inline(always)]
    fn ordered_floats(self, x: Self::Float, order: Self::Int) -> Self::Float {
        // SAFETY: as above.
        unsafe { _mm256_permutevar8x32_ps(x, order) }
    }
    #[inline(always)]
    fn put_ints(self, x: Self::Int, to: &mut [MaybeUninit<u32>; LANES]) {
        // SAFETY: as above.
        unsafe { _mm256_storeu_si256(to.as_mut_ptr().cast(), x) }
    }
    #[inline(always)]
    fn put_floats(self, x: Self::Float, to: &mut [MaybeUninit<f32>; LANES]) {
        // SAFETY: as above.
        unsafe { _mm256_storeu_ps(to.as_mut_ptr().cast(), x) }
    }
    #[inline(always)]
    fn turned(self, records: [&[f32; 4]; LANES]) -> [Self::Float; 4] {
        // SAFETY: as above.
        unsafe {
            let a = _mm256_castps128_ps256(_mm_loadu_ps(records[0].as_ptr()));
            let a = _mm256_insertf128_ps::<1>(a, _mm_loadu_ps(records[4].as_ptr()));
            let b = _mm256_castps128_ps256(_mm_loadu_ps(records[1].as_ptr()));
            let b = _mm256_insertf128_ps::<1>(b, _mm_loadu_ps(records[5].as_ptr()));
            let c = _mm256_castps128_ps256(_mm_loadu_ps(records[2].as_ptr()));
            let c = _mm256_insertf128_ps::<1>(c, _mm_loadu_ps(records[6].as_ptr()));
            let d = _mm256_castps128_ps256(_mm_loadu_ps(records[3].as_ptr()));
            let d = _mm256_insertf128_ps::<1>(d, _mm_loadu_ps(records[7].as_ptr()));
            let (low_ab, low_cd) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
            let (high_ab, high_cd) = (_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
            [
                _mm256_shuffle_ps::<0b01_00_01_00>(low_ab, low_cd),
                _mm256_shuffle_ps::<0b11_10_11_10>(low_ab, low_cd),
                _mm256_shuffle_ps::<0b01_00_01_00>(high_ab, high_cd),
                _mm256_shuffle_ps::<0b11_10_11_10>(high_ab, high_cd),
            ]
        }
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
