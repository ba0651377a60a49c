//! The kernel of this processor, chosen at run time.

/// Defines functions that run their generic body with the best kernel of this processor, the whole body compiled for it.
macro_rules! dispatched {
    ($($(#[$meta:meta])* fn $name:ident($($arg:ident: $type:ty),*) $(-> $out:ty)? = $body:ident;)*) => {$(
        $(#[$meta])*
        fn $name($($arg: $type),*) $(-> $out)? {
            #[cfg(target_arch = "x86_64")]
            {
                $(#[$meta])*
                #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
                fn with_avx2($($arg: $type),*) $(-> $out)? {
                    $body::<$crate::trace::kernel::Avx2>($($arg),*)
                }
                if $crate::trace::kernel::has_avx2() {
                    // SAFETY: the processor has the features, just asked.
                    return unsafe { with_avx2($($arg),*) };
                }
            }
            $body::<$crate::trace::kernel::Portable>($($arg),*)
        }
    )*};
}
pub(in crate::trace) use dispatched;

/// Whether this processor runs [`Avx2`](super::Avx2). The standard library remembers the answer.
#[cfg(target_arch = "x86_64")]
pub fn has_avx2() -> bool {
    use std::arch::is_x86_feature_detected as has;
    has!("avx2") && has!("fma") && has!("bmi1") && has!("bmi2") && has!("lzcnt") && has!("popcnt")
}
