//! Pixels behind an alpha test: of what a triangle covers only that is drawn which exists.
//!
//! Coverage and depth come from the fill loops as they are, so that a test that lets everything through changes no bit.

use super::bins::BandArea;
use super::drawn_mesh::Draw;
use super::lanes::Lanes;
use super::pixels::{Fragment, Pixels};
use super::simd::LANES;
use crate::render::cpu::tested_triangle::TestedTriangle;

/// Pixels that take what exists of the triangles of some draws.
pub struct Tested<'a, P> {
    pixels: &'a mut P,
    draws: &'a [Draw<'a>],
    area: BandArea,
    /// NDC of the middle of the image's first pixel, and steps to the right and down.
    first: [f64; 2],
    step: [f64; 2],
    /// The last triangles, by their number modulo [`LANES`]: fragments of so many come by turns.
    known: [Option<(u32, TestedTriangle<'a>)>; LANES],
}

impl<'a, P: Pixels> Tested<'a, P> {
    /// For a band of an image of `size` pixels, which may be narrower than the memory that it is drawn into.
    pub fn new(pixels: &'a mut P, draws: &'a [Draw<'a>], area: BandArea, size: [u32; 2]) -> Self {
        let step = [2.0 / f64::from(size[0]), -2.0 / f64::from(size[1])];
        let first = [0.5 * step[0] - 1.0, 0.5 * step[1] + 1.0];
        Self { pixels, draws, area, first, step, known: [None; LANES] }
    }

    /// Whether what triangle `id` has at a pixel of the band exists.
    #[inline]
    fn exists(&mut self, at: usize, id: u32) -> bool {
        let triangle = match self.known[id as usize % LANES] {
            Some((known, triangle)) if known == id => triangle,
            _ => {
                let Some(triangle) = self.triangle(id) else { return true };
                self.known[id as usize % LANES] = Some((id, triangle));
                triangle
            }
        };
        let stride = self.area.stride;
        let (x, y) = (at % stride, at / stride + self.area.first_row as usize);
        triangle.exists_at(self.first[0] + x as f64 * self.step[0], self.first[1] + y as f64 * self.step[1])
    }

    fn triangle(&self, id: u32) -> Option<TestedTriangle<'a>> {
        let draw = &self.draws[self.draws.partition_point(|draw| draw.first_id <= id) - 1];
        TestedTriangle::new(draw.mesh, (id - draw.first_id) as usize, &draw.projection.matrix())
    }
}

impl<P: Pixels> Pixels for Tested<'_, P> {
    const FAR: f32 = P::FAR;
    const ONCE: bool = P::ONCE;

    #[inline(always)]
    fn draw<L: Lanes>(&mut self, lanes: L, at: usize, z: L::Float, outside: L::Int, id: u32) {
        let mut outside = lanes.to_ints(outside);
        for l in 0..LANES {
            if outside[l] >= 0 && !self.exists(at + l, id) {
                outside[l] = -1;
            }
        }
        self.pixels.draw(lanes, at, z, lanes.ints(outside), id);
    }

    #[inline(always)]
    fn draw_fragment(&mut self, fragment: &Fragment) {
        if self.exists(fragment.at as usize, fragment.id) {
            self.pixels.draw_fragment(fragment);
        }
    }

    fn hiding(&self) -> &[f32] {
        self.pixels.hiding()
    }
}
