//! What a pass keeps of the triangles that cover a pixel: the nearest depth, the two nearest, or the nearest with its triangle.

use super::lanes::{FAR_OF_IDS, Lanes, two_nearest};
use super::simd::LANES;
use super::triangle_setup::smaller;

/// A covered pixel.
#[derive(Debug, Clone, Copy)]
pub struct Fragment {
    /// Index of the pixel in its band.
    pub at: u32,
    pub z: f32,
    /// Scene-wide number of the triangle; 0 where nobody asks for it.
    pub id: u32,
}

/// Where a pass keeps its pixels.
pub trait Pixels {
    /// Depth of the far plane, where nothing is drawn; that of the near plane is 1 less.
    const FAR: f32;
    /// Whether a triangle may be drawn to a pixel once only: another time its depth differs by a rounding.
    const ONCE: bool = false;
    /// Keeps what is nearer than what is there, of equal depths the smaller number: [`LANES`] pixels from index `at`, their
    /// depths, and negative numbers where they are not covered.
    fn draw<L: Lanes>(&mut self, lanes: L, at: usize, z: L::Float, outside: L::Int, id: u32);
    /// The same for one pixel.
    fn draw_fragment(&mut self, fragment: &Fragment);
    /// For each pixel a depth behind which nothing changes it.
    fn hiding(&self) -> &[f32];
}

/// Depth alone, from the near plane at 0 or to the far plane at 0.
pub struct DepthPixels<'a, const TO_FAR: bool> {
    pub depth: &'a mut [f32],
}

/// The two nearest depths that differ, to the far plane at 0.
pub struct LayerPixels<'a> {
    pub first: &'a mut [f32],
    pub second: &'a mut [f32],
}

/// Depth and the number of the triangle.
pub struct IdPixels<'a> {
    pub depth: &'a mut [f32],
    pub id: &'a mut [u32],
}

#[inline(always)]
fn lanes_at<T>(pixels: &mut [T], at: usize) -> &mut [T; LANES] {
    pixels[at..].first_chunk_mut().expect("runs of pixels end within the band")
}

impl<const TO_FAR: bool> Pixels for DepthPixels<'_, TO_FAR> {
    const FAR: f32 = if TO_FAR { 0.0 } else { 1.0 };
    #[inline(always)]
    fn draw<L: Lanes>(&mut self, lanes: L, at: usize, z: L::Float, outside: L::Int, _id: u32) {
        lanes.nearest(lanes_at(self.depth, at), z, outside);
    }

    #[inline(always)]
    fn draw_fragment(&mut self, f: &Fragment) {
        let old = &mut self.depth[f.at as usize];
        *old = smaller(f.z, *old);
    }

    fn hiding(&self) -> &[f32] {
        self.depth
    }
}

impl Pixels for LayerPixels<'_> {
    const FAR: f32 = 0.0;
    const ONCE: bool = true;
    #[inline(always)]
    fn draw<L: Lanes>(&mut self, lanes: L, at: usize, z: L::Float, outside: L::Int, _id: u32) {
        lanes.nearest_two(lanes_at(self.first, at), lanes_at(self.second, at), z, outside);
    }

    #[inline(always)]
    fn draw_fragment(&mut self, f: &Fragment) {
        let (first, second) = (&mut self.first[f.at as usize], &mut self.second[f.at as usize]);
        (*first, *second) = two_nearest(*first, *second, f.z);
    }

    fn hiding(&self) -> &[f32] {
        self.second
    }
}

impl Pixels for IdPixels<'_> {
    const FAR: f32 = FAR_OF_IDS;
    #[inline(always)]
    fn draw<L: Lanes>(&mut self, lanes: L, at: usize, z: L::Float, outside: L::Int, id: u32) {
        lanes.nearest_with_id(lanes_at(self.depth, at), lanes_at(self.id, at), z, outside, id);
    }

    #[inline(always)]
    fn draw_fragment(&mut self, f: &Fragment) {
        let (old, old_id) = (&mut self.depth[f.at as usize], &mut self.id[f.at as usize]);
        // At the far plane nothing is drawn: its pixels belong to no triangle, whose number is the largest.
        if f.z < *old || (f.z == *old && f.z < Self::FAR && f.id < *old_id) {
            (*old, *old_id) = (f.z, f.id);
        }
    }

    fn hiding(&self) -> &[f32] {
        self.depth
    }
}
