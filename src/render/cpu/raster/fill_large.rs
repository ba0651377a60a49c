//! Filling triangles of any size into one band of an image, block by block.
//!
//! ```text
//!     . . # # . . . . . .      strips of rows: columns that no edge lets in anywhere in a strip are passed over
//!     . . + # # + . . . .      + blocks that an edge crosses are tested by the edges that do
//!     . . . + # # # + . .      # others are filled
//! ```

use super::bins::BandArea;
use super::lanes::Lanes;
use super::pixels::Pixels;
use super::run::Run;
use super::simd::LANES;
use super::triangle_setup::LargeSetup;

/// Columns and rows of a block. Edge coefficients are below 2^25 (twice the guard band in grid steps), so that over a block an
/// edge function that changes its sign stays below 2^25 (32 + 8) < 2^31.
const BLOCK: [i32; 2] = [32, 8];

/// Fills a triangle; the first and the last column that it may touch in the band, the last one less where there are none.
#[inline(always)]
pub fn fill_large<L: Lanes, P: Pixels>(lanes: L, s: &LargeSetup, area: BandArea, pixels: &mut P) -> [i32; 2] {
    let width = area.size[0] as i32;
    let [x0, y0, x1, y1] = s.pixels.map(i32::from);
    let (first_row, end_row) = (y0.max(area.first_row), (y1 + 1).min(area.first_row + area.rows));
    // Blocks begin here, whichever of them are filled: the depths of a pixel are told from its block.
    let first_block = x0 & -(LANES as i32);
    let (mut top, mut touched) = (first_row, [x1, x0 - 1]);
    while top < end_row {
        let rows = BLOCK[1].min(end_row - top);
        let [first, last] = columns_of(s, top, rows);
        let mut left = first_block + (first - first_block) / BLOCK[0] * BLOCK[0];
        while left <= last {
            let columns = BLOCK[0].min((x1 + 1 - left + LANES as i32 - 1) & -(LANES as i32)).min(width - left);
            let within = [(first - left).max(0) & -(LANES as i32), columns.min(last + 1 - left)];
            fill_block(lanes, s, [left, top], [columns, rows], within, area, pixels);
            left += BLOCK[0];
        }
        if first <= last {
            touched = [touched[0].min(first), touched[1].max(last)];
        }
        top += BLOCK[1];
    }
    touched
}

/// The first and the last column of its box that no edge excludes in all of some rows; the last one may be less.
#[inline(always)]
fn columns_of(s: &LargeSetup, top: i32, rows: i32) -> [i32; 2] {
    let [x0, _, x1, _] = s.pixels.map(f64::from);
    let (mut first, mut last) = (x0, x1);
    for edge in s.edges {
        let (a, b) = (i64::from(edge.step_x), i64::from(edge.step_y));
        // At column 0 the largest value of the rows; below 2^53, so told exactly. Quotients are rounded, which keeps their order.
        let e = (edge.value + b * i64::from(top) + (b * i64::from(rows - 1)).max(0)) as f64;
        if a > 0 {
            first = first.max(-e / a as f64);
        } else if a < 0 {
            last = last.min(e / -a as f64);
        } else if e < 0.0 {
            last = -1.0;
        }
    }
    // Casts round towards zero and saturate; what is negative is before all columns.
    [first.min(x1 + 1.0) as i32, if last < 0.0 { -1 } else { last as i32 }]
}

/// Fills what lies in some columns of a block.
#[inline(always)]
fn fill_block<L: Lanes, P: Pixels>(
    lanes: L,
    s: &LargeSetup,
    [left, top]: [i32; 2],
    [columns, rows]: [i32; 2],
    [first, end]: [i32; 2],
    area: BandArea,
    pixels: &mut P,
) {
    // Steps of the edges that cross the block, and their values at its first pixel; zero for one that holds all over it.
    let mut edges = [[0i32; 3]; 3];
    // The last run of pixels may start up to LANES - 1 columns before the block.
    let reach_left = (LANES as i32 - columns).max(0);
    for (edge, of) in edges.iter_mut().zip(s.edges) {
        let (a, b, e) = (i64::from(of.step_x), i64::from(of.step_y), of.value);
        let first = e + a * i64::from(left) + b * i64::from(top);
        let (across, down) = (a * i64::from(columns - 1), b * i64::from(rows - 1));
        let largest = first + across.max(0) + down.max(0);
        let smallest = first + across.min(0) + down.min(0) - a.max(0) * i64::from(reach_left);
        if largest < 0 {
            return;
        }
        if smallest < 0 {
            *edge = [of.step_x, of.step_y, first as i32];
        }
    }
    let [z0, zx, zy] = s.z;
    let z_first = (z0 + zx * f64::from(left) + zy * f64::from(top)) as f32;
    let (zx, zy) = (zx as f32, zy as f32);
    let width = area.size[0] as i32;
    let run = Run::new(lanes, edges.map(|[a, ..]| a), zx, s.z_range);
    let row = (top - area.first_row) as usize * area.stride;
    let mut x = first;
    while x < end {
        // Not beyond the last column of the image.
        let dx = x.min(width - LANES as i32 - left);
        let (edge, z) = (edges.map(|[a, _, e]| e + a * dx), z_first + zx * dx as f32);
        let at = row + (left + dx) as usize;
        if dx == x {
            run.draw_down(edge, edges.map(|[_, b, _]| b), [z, zy], rows, at, area.stride, s.id, pixels);
        } else {
            for r in 0..rows {
                let edge = [0, 1, 2].map(|k: usize| edge[k] + edges[k][1] * r);
                run.draw(edge, z + zy * r as f32, at + r as usize * area.stride, x - dx, s.id, pixels);
            }
        }
        x += LANES as i32;
    }
}

#[cfg(test)]
mod tests {
    use super::super::pixels::DepthPixels;
    use super::super::plain::Plain;
    use super::super::vertices::ScreenVertex;
    use super::*;

    const SIZE: [u32; 2] = [301, 90];

    /// Triangles of every shape about an image, from a small generator (Knuth's MMIX constants).
    fn triangles(count: u32) -> impl Iterator<Item = LargeSetup> {
        let mut state = 3u64;
        let mut number = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1u64 << 24) as f32
        };
        (0..count).filter_map(move |id| {
            let reach = [60.0, 400.0, 30_000.0][id as usize % 3];
            let middle = [301.0 * number(), 90.0 * number()];
            let v = [0, 1, 2].map(|_| {
                // Some edges lie along rows or columns.
                let [x, y] = middle.map(|m| (m + reach * (number() - 0.5)).round_ties_even() * 256.0);
                ScreenVertex { x, y, z: 0.2 + 0.6 * number(), code: 0 }
            });
            LargeSetup::new(v, v.map(|v| [v.x, v.y, v.z].map(f64::from)), SIZE, id)
        })
    }

    #[test]
    fn pixels_are_drawn_that_all_edges_let_in() {
        let stride = SIZE[0] as usize;
        let mut drawn = 0;
        for s in triangles(900) {
            let [x0, y0, x1, y1] = s.pixels.map(i32::from);
            let is_in = |x: i32, y: i32| {
                let holds = |e: &super::super::triangle_setup::Edge| {
                    e.value + i64::from(e.step_x) * i64::from(x) + i64::from(e.step_y) * i64::from(y) >= 0
                };
                (x0..=x1).contains(&x) && (y0..=y1).contains(&y) && s.edges.iter().all(holds)
            };
            for (first_row, rows) in [(0, 32), (32, 32), (64, 26)] {
                let area = BandArea { size: SIZE, stride, first_row, rows };
                let mut depth = vec![1.0; stride * rows as usize];
                let [first, last] = fill_large(Plain, &s, area, &mut DepthPixels::<false> { depth: &mut depth });
                for (i, z) in depth.iter().enumerate() {
                    let (x, y) = ((i % stride) as i32, first_row + (i / stride) as i32);
                    assert_eq!(*z < 1.0, is_in(x, y), "{s:?} at {x}, {y}");
                    assert!(*z == 1.0 || (first..=last).contains(&x), "{x} is beside {first} to {last}");
                    drawn += usize::from(*z < 1.0);
                }
            }
        }
        assert!(drawn > 100_000, "{drawn}");
    }
}
