//! One source, compiled once for the instruction set every processor of an architecture has and once for AVX2 with FMA.
//!
//! Kernels are loops over short arrays, which the compiler turns into vector instructions. Rust neither
//! reorders nor contracts floating-point operations, and `mul_add` is fused everywhere, so both versions give the same bits.

/// Declares a function that calls the inlined `$body` compiled for the best instruction set found at run time.
macro_rules! dispatch {
    ($(#[$meta:meta])* $vis:vis fn $name:ident $(<$($generic:ident: $bound:path),+>)? ($($arg:ident: $ty:ty),* $(,)?) $(-> $ret:ty)? = $body:path) => {
        $(#[$meta])*
        $vis fn $name $(<$($generic: $bound),+>)? ($($arg: $ty),*) $(-> $ret)? {
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2,fma")]
                fn wide $(<$($generic: $bound),+>)? ($($arg: $ty),*) $(-> $ret)? {
                    $body($($arg),*)
                }
                if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                    // SAFETY: the processor has the features that `wide` is compiled for.
                    return unsafe { wide($($arg),*) };
                }
            }
            $body($($arg),*)
        }
    };
}
pub(crate) use dispatch;

/// Has the first kilobyte of an array brought to the cache while something else is done; the processor sees by itself what comes
/// after that.
#[inline(always)]
pub fn prefetch<T>(values: &[T]) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        const LINE: usize = 64;
        let start = values.as_ptr().cast::<i8>();
        for at in (0..size_of_val(values).min(16 * LINE)).step_by(LINE) {
            // SAFETY: within the array.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.add(at)) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = values;
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
    }
}
