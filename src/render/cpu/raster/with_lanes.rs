//! The choice of lanes at run time.

/// Declares a function that calls the inlined `$body` with the best [`Lanes`](super::lanes::Lanes) found at run time, compiled
/// for what they ask for.
macro_rules! with_lanes {
    ($(#[$meta:meta])* $vis:vis fn $name:ident $(<$($generic:ident: $bound:path),+>)? ($($arg:ident: $ty:ty),* $(,)?) $(-> $ret:ty)? = $body:path) => {
        $(#[$meta])*
        $vis fn $name $(<$($generic: $bound),+>)? ($($arg: $ty),*) $(-> $ret)? {
            #[cfg(target_arch = "x86_64")]
            {
                use $crate::render::cpu::raster::Avx2;
                #[target_feature(enable = "avx2,fma,popcnt,bmi1")]
                fn wide $(<$($generic: $bound),+>)? (lanes: Avx2, $($arg: $ty),*) $(-> $ret)? {
                    $body(lanes, $($arg),*)
                }
                if let Some(lanes) = Avx2::detect() {
                    // SAFETY: `lanes` proves the features that `wide` is compiled for.
                    return unsafe { wide(lanes, $($arg),*) };
                }
            }
            $body($crate::render::cpu::raster::Plain, $($arg),*)
        }
    };
}
pub(in crate::render::cpu) use with_lanes;
