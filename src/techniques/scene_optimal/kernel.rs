//! Sums over samples, several at once.
//!
//! A map is w = 1 + h·y and the sides a, b of a texel in the plane of q. With r the rows of d(pixel) / dy of a sample and
//! s = r·y, which no map changes,
//!
//! ```text
//!      G = w [r·a + s (h·a),  r·b + s (h·b)]
//! ```
//!
//! is linear in (a, h·a) and (b, h·b): for the derivative of the sum by anything that moves a map, eight sums over the samples do.

use glam::DVec2;

use super::objective::{Areas, Capped, Cost, Free, Longest, Measure, Objective, Squares, Texel, Widths};
use crate::simd::dispatch;

/// A sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Its ray; in a problem from the middle of the hull, in units of the hull's extent.
    pub y: DVec2,
    /// d(pixel) / dy, two rows; or across an edge in the first, the second zero.
    pub rows: [DVec2; 2],
    /// Pixels that it stands for.
    pub weight: f64,
}

/// Samples of a block.
pub(super) const LANES: usize = 8;

type Lanes = [f64; LANES];

/// Samples side by side; what fills the last block up has weight 0.
#[derive(Debug, Clone)]
pub(super) struct Block {
    y: [Lanes; 2],
    /// Of both rows the two coordinates, and s.
    rows: [[Lanes; 3]; 2],
    weight: Lanes,
}

/// A map: h, and of both sides of a texel x, y and h·side.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sides {
    pub h: [f64; 2],
    pub sides: [[f64; 3]; 2],
}

/// Sums of what the samples count.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sums {
    /// Of the samples that w is positive at.
    pub value: f64,
    /// Weight of the others.
    pub lost: f64,
}

/// The derivatives of the sum by y w, and by the numbers of [`Sides::sides`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Slopes {
    pub by_w: [f64; 2],
    pub by_sides: [[f64; 3]; 2],
}

impl Block {
    /// The weight of its samples.
    pub fn weight(&self) -> f64 {
        self.weight.iter().sum()
    }
}

/// Samples in blocks, in their order.
pub(super) fn blocks_of(samples: &[Sample]) -> Vec<Block> {
    let block = |samples: &[Sample]| {
        let lanes = |of: &dyn Fn(&Sample) -> f64| std::array::from_fn(|i| samples.get(i).map_or(0.0, of));
        let row = |k: usize| [lanes(&|s| s.rows[k].x), lanes(&|s| s.rows[k].y), lanes(&|s| s.rows[k].dot(s.y))];
        Block { y: [lanes(&|s| s.y.x), lanes(&|s| s.y.y)], rows: [row(0), row(1)], weight: lanes(&|s| s.weight) }
    };
    samples.chunks(LANES).map(block).collect()
}

/// The sum of a map.
pub(super) fn sum(blocks: &[Block], map: &Sides, cost: &Cost) -> Sums {
    match (cost.objective, cost.cap.is_finite()) {
        (Objective::Edge, true) => sum_of(blocks, map, Widths(Capped(cost.cap))),
        (Objective::Edge, false) => sum_of(blocks, map, Widths(Free)),
        (Objective::L1, true) => sum_of(blocks, map, Longest(Capped(cost.cap))),
        (Objective::L1, false) => sum_of(blocks, map, Longest(Free)),
        (Objective::L2, _) => sum_of(blocks, map, Squares),
        (Objective::Area, _) => sum_of(blocks, map, Areas),
    }
}

/// The same with derivatives.
pub(super) fn slopes(blocks: &[Block], map: &Sides, cost: &Cost) -> (Sums, Slopes) {
    match (cost.objective, cost.cap.is_finite()) {
        (Objective::Edge, true) => slopes_of(blocks, map, Widths(Capped(cost.cap))),
        (Objective::Edge, false) => slopes_of(blocks, map, Widths(Free)),
        (Objective::L1, true) => slopes_of(blocks, map, Longest(Capped(cost.cap))),
        (Objective::L1, false) => slopes_of(blocks, map, Longest(Free)),
        (Objective::L2, _) => slopes_of(blocks, map, Squares),
        (Objective::Area, _) => slopes_of(blocks, map, Areas),
    }
}

dispatch! {
    fn sum_of<M: Measure>(blocks: &[Block], map: &Sides, measure: M) -> Sums = sum_body
}

dispatch! {
    fn slopes_of<M: Measure>(blocks: &[Block], map: &Sides, measure: M) -> (Sums, Slopes) = slopes_body
}

/// w of a sample, 0 where it is not positive, and whether it is.
#[inline(always)]
fn w_of(block: &Block, map: &Sides, i: usize) -> (f64, f64) {
    let w = map.h[0].mul_add(block.y[0][i], map.h[1].mul_add(block.y[1][i], 1.0));
    if w > 0.0 { (w, 0.0) } else { (0.0, block.weight[i]) }
}

/// A matrix times a number. Loops, as closures would not be compiled for the instruction set of the dispatch.
#[inline(always)]
fn times(g: Texel, w: f64) -> Texel {
    [[g[0][0] * w, g[0][1] * w], [g[1][0] * w, g[1][1] * w]]
}

/// G / w of a sample.
#[inline(always)]
fn texel_per_w<M: Measure>(block: &Block, map: &Sides, i: usize) -> Texel {
    let mut g = [[0.0; 2]; 2];
    for row in 0..M::ROWS {
        let [x, y, s] = &block.rows[row];
        for side in 0..2 {
            let [by_x, by_y, along] = map.sides[side];
            g[row][side] = x[i].mul_add(by_x, y[i].mul_add(by_y, s[i] * along));
        }
    }
    g
}

#[inline(always)]
fn sum_body<M: Measure>(blocks: &[Block], map: &Sides, measure: M) -> Sums {
    let (mut value, mut lost) = ([0.0; LANES], [0.0; LANES]);
    for block in blocks {
        for i in 0..LANES {
            let (w, lost_here) = w_of(block, map, i);
            let g = times(texel_per_w::<M>(block, map, i), w);
            value[i] = block.weight[i].mul_add(measure.of(g).0, value[i]);
            lost[i] += lost_here;
        }
    }
    Sums { value: value.iter().sum(), lost: lost.iter().sum() }
}

#[inline(always)]
fn slopes_body<M: Measure>(blocks: &[Block], map: &Sides, measure: M) -> (Sums, Slopes) {
    let (mut value, mut lost) = ([0.0; LANES], [0.0; LANES]);
    let (mut by_w, mut by_sides) = ([[0.0; LANES]; 2], [[[0.0; LANES]; 3]; 2]);
    for block in blocks {
        for i in 0..LANES {
            let (w, lost_here) = w_of(block, map, i);
            let per_w = texel_per_w::<M>(block, map, i);
            let (counts, by_g) = measure.of(times(per_w, w));
            let weight = block.weight[i];
            value[i] = weight.mul_add(counts, value[i]);
            lost[i] += lost_here;
            // Where w is not positive, G is 0 and nothing moves it.
            let weight = if w > 0.0 { weight } else { 0.0 };
            let mut turned = 0.0;
            for row in 0..M::ROWS {
                for side in 0..2 {
                    turned = per_w[row][side].mul_add(by_g[row][side], turned);
                }
            }
            for j in 0..2 {
                by_w[j][i] = (weight * turned).mul_add(block.y[j][i], by_w[j][i]);
            }
            for row in 0..M::ROWS {
                for side in 0..2 {
                    let moved = weight * w * by_g[row][side];
                    for k in 0..3 {
                        by_sides[side][k][i] = moved.mul_add(block.rows[row][k][i], by_sides[side][k][i]);
                    }
                }
            }
        }
    }
    let total = |lanes: &Lanes| lanes.iter().sum::<f64>();
    let slopes = Slopes {
        by_w: [0, 1].map(|j| total(&by_w[j])),
        by_sides: [0, 1].map(|side| [0, 1, 2].map(|k| total(&by_sides[side][k]))),
    };
    (Sums { value: total(&value), lost: total(&lost) }, slopes)
}
