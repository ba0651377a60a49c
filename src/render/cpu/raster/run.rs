//! [`LANES`](super::simd::LANES) neighbouring columns of a triangle, filled row by row.

use super::lanes::Lanes;
use super::pixels::Pixels;

/// 0, 1, 2... times a step.
#[inline(always)]
fn steps<L: Lanes>(lanes: L, step: i32) -> L::Int {
    lanes.ints(std::array::from_fn(|i| step.wrapping_mul(i as i32)))
}

/// Edge functions and depth along runs of pixels, relative to the first pixel of a run.
pub struct Run<L: Lanes> {
    lanes: L,
    edges: [L::Int; 3],
    z: L::Float,
    z_range: [L::Float; 2],
}

impl<L: Lanes> Run<L> {
    #[inline(always)]
    pub fn new(lanes: L, steps_x: [i32; 3], z_per_x: f32, z_range: [f32; 2]) -> Self {
        Self {
            lanes,
            edges: steps_x.map(|step| steps(lanes, step)),
            z: lanes.floats(std::array::from_fn(|i| z_per_x * i as f32)),
            z_range: z_range.map(|z| lanes.float(z)),
        }
    }

    /// Draws the run whose first pixel has these edge functions and this depth; of its pixels the first `drawn` have been drawn.
    #[inline(always)]
    pub fn draw<P: Pixels>(&self, edge: [i32; 3], z: f32, at: usize, drawn: i32, id: u32, pixels: &mut P) {
        let lanes = self.lanes;
        let edge = |k: usize| lanes.add(lanes.int(edge[k]), self.edges[k]);
        let mut outside = lanes.or(lanes.or(edge(0), edge(1)), edge(2));
        if P::ONCE && drawn > 0 {
            outside = lanes.or(outside, lanes.ints(std::array::from_fn(|l| (l as i32).wrapping_sub(drawn))));
        }
        let z = lanes.clamp(lanes.add_floats(lanes.float(z), self.z), self.z_range[0], self.z_range[1]);
        pixels.draw(lanes, at, z, outside, id);
    }

    /// Draws a column of such runs, none of which has been drawn in part: so many rows whose indices are `stride` apart, each of
    /// which adds these steps to the edge functions and to the depth.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    pub fn draw_down<P: Pixels>(
        &self,
        edge: [i32; 3],
        step_y: [i32; 3],
        [z, z_per_y]: [f32; 2],
        rows: i32,
        mut at: usize,
        stride: usize,
        id: u32,
        pixels: &mut P,
    ) {
        let lanes = self.lanes;
        let first = |k: usize| lanes.add(lanes.int(edge[k]), self.edges[k]);
        let mut edge = [first(0), first(1), first(2)];
        let step = [lanes.int(step_y[0]), lanes.int(step_y[1]), lanes.int(step_y[2])];
        let (z, z_per_y) = (lanes.float(z), lanes.float(z_per_y));
        let mut down = lanes.float(0.0);
        for _ in 0..rows {
            let outside = lanes.or(lanes.or(edge[0], edge[1]), edge[2]);
            let z = lanes.add_floats(z, lanes.mul_floats(z_per_y, down));
            let z = lanes.clamp(lanes.add_floats(z, self.z), self.z_range[0], self.z_range[1]);
            pixels.draw(lanes, at, z, outside, id);
            edge = lanes.add_three(edge, step);
            down = lanes.add_floats(down, lanes.float(1.0));
            at += stride;
        }
    }
}
