//! What the texels of a band keep of the depths that are drawn.

use std::ops::Range;

use crate::render::cpu::raster::{smaller, two_nearest};

/// The texels of a band of rows.
pub trait Texels: Send {
    /// Keeps what is nearer in some texels; `z` gives the NDC depth of the `i`-th of them.
    fn draw(&mut self, at: Range<usize>, z: impl Fn(usize) -> f64);
}

/// The nearest depth, from the near plane at 0 or to the far plane at 0.
pub struct Nearest<'a, const TO_FAR: bool> {
    pub depth: &'a mut [f32],
}

/// The two nearest depths that differ, to the far plane at 0.
pub struct NearestTwo<'a> {
    pub first: &'a mut [f32],
    pub second: &'a mut [f32],
}

impl<const TO_FAR: bool> Texels for Nearest<'_, TO_FAR> {
    #[inline(always)]
    fn draw(&mut self, at: Range<usize>, z: impl Fn(usize) -> f64) {
        for (i, texel) in self.depth[at].iter_mut().enumerate() {
            let z = if TO_FAR { z(i) - 1.0 } else { z(i) };
            *texel = smaller(z as f32, *texel);
        }
    }
}

impl Texels for NearestTwo<'_> {
    #[inline(always)]
    fn draw(&mut self, at: Range<usize>, z: impl Fn(usize) -> f64) {
        for (i, (first, second)) in self.first[at.clone()].iter_mut().zip(&mut self.second[at]).enumerate() {
            (*first, *second) = two_nearest(*first, *second, (z(i) - 1.0) as f32);
        }
    }
}
