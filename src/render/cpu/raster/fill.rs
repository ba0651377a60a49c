//! Filling triangles into one band of an image.
//!
//! Source: Pineda 1988 `[pineda1988]`, with rows of [`LANES`] pixels at once. Small triangles (nearly all) are
//! evaluated over their whole box without a branch on coverage; larger ones in blocks (`fill_large`).

use super::bins::{BandArea, Entry};
use super::cover::{Grid, Tiles};
use super::fill_large::fill_large;
use super::lanes::Lanes;
use super::pixels::Pixels;
use super::run::Run;
use super::simd::LANES;
use super::triangle_setup::{Boxes, CornerSource, Corners, LargeSetup, SetupRows, SmallSetup};
use super::vertices::ScreenVertex;
use super::with_lanes::with_lanes;

/// A band's entries of one chunk, with the vertices they point to.
#[derive(Debug, Clone, Copy)]
pub struct Entries<'a> {
    pub entries: &'a [Entry],
    pub vertices: &'a [ScreenVertex],
    pub extra: &'a [ScreenVertex],
    /// Large triangles of all bands.
    pub large: &'a [LargeSetup],
    /// Indices of those that may touch the band.
    pub large_here: &'a [u32],
    /// The tiles of the image.
    pub grid: Grid,
    /// What is drawn already in this band, where that may hide something.
    pub cover: Option<Tiles<'a>>,
}

with_lanes! {
    /// Draws a band's entries of one chunk; bits of the columns of tiles that they touch.
    pub fn draw<P: Pixels>(entries: Entries, area: BandArea, pixels: &mut P) -> u64 = draw_entries
}

#[inline(always)]
fn draw_entries<L: Lanes, P: Pixels>(lanes: L, work: Entries, area: BandArea, pixels: &mut P) -> u64 {
    let (mut columns, grid) = (0, work.grid);
    for group in work.entries.chunks(LANES) {
        let corners = Corners::gather(lanes, OfEntries { group, work: &work });
        let boxes = Boxes::new(lanes, &corners, area.size);
        debug_assert!(lanes.signs(boxes.large) == 0, "larger ones are in `large`");
        let mut live = (1u32 << group.len()) - 1;
        if let Some(cover) = work.cover {
            live &= !hidden(lanes, cover, &corners, &boxes, area);
            if live == 0 {
                continue;
            }
        }
        let setup = SmallSetup::new::<{ LANES as i32 }>(lanes, &corners, &boxes).rows(lanes);
        let [x0, y0, x1, y1] = [
            lanes.to_ints(boxes.at[0]),
            lanes.to_ints(boxes.at[1]),
            lanes.to_ints(boxes.at[2]),
            lanes.to_ints(boxes.at[3]),
        ];
        while live != 0 {
            let l = live.trailing_zeros() as usize % LANES;
            live &= live - 1;
            let at = [x0[l], y0[l], x1[l], y1[l]];
            columns |= grid.columns(at[0], at[2]);
            Small { setup: &setup, lane: l, at, id: group[l].id }.fill(lanes, area, pixels);
        }
    }
    for &i in work.large_here {
        let [first, last] = fill_large(lanes, &work.large[i as usize], area, pixels);
        if first <= last {
            columns |= grid.columns(first, last);
        }
    }
    columns
}

/// A bit for each triangle that lies behind what is drawn in a band.
#[inline(always)]
fn hidden<L: Lanes>(lanes: L, cover: Tiles, corners: &Corners<L>, boxes: &Boxes<L>, area: BandArea) -> u32 {
    let [left, top, right, bottom] = boxes.at;
    let first = lanes.int(area.first_row);
    let top = lanes.most(lanes.sub(top, first), lanes.int(0));
    let bottom = lanes.least(lanes.sub(bottom, first), lanes.int(area.rows - 1));
    let [z0, z1, z2] = corners.z;
    cover.hidden(lanes, [left, top, right, bottom], lanes.smaller(lanes.smaller(z0, z1), z2))
}

/// The corners of a group of entries; those of the last one again where there are fewer than [`LANES`].
#[derive(Clone, Copy)]
struct OfEntries<'a> {
    group: &'a [Entry],
    work: &'a Entries<'a>,
}

impl CornerSource for OfEntries<'_> {
    #[inline(always)]
    fn corner(&self, l: usize, k: usize) -> &ScreenVertex {
        let i = self.group[l.min(self.group.len() - 1)].vertices[k];
        let Entries { vertices, extra, .. } = self.work;
        if i & Entry::EXTRA == 0 { &vertices[i as usize] } else { &extra[(i & !Entry::EXTRA) as usize] }
    }
}

/// A triangle of a setup that is filled into a band.
#[derive(Clone, Copy)]
struct Small<'a> {
    setup: &'a SetupRows,
    /// Its lane.
    lane: usize,
    /// First column and row, last column and row of its box.
    at: [i32; 4],
    id: u32,
}

impl Small<'_> {
    /// Fills the triangle, run by run from the first column of its box on.
    ///
    /// The depth of a pixel is found from the first pixel of its own block of [`LANES`] columns, wherever the run begins, so
    /// it has the same bits in each.
    #[inline(always)]
    fn fill<L: Lanes, P: Pixels>(&self, lanes: L, area: BandArea, pixels: &mut P) {
        let width = area.size[0] as i32;
        let [x0, y0, x1, y1] = self.at;
        if width % LANES as i32 != 0 && x1 >= (width & -(LANES as i32)) {
            return self.fill_at_edge(lanes, area, pixels);
        }
        let (s, l, block) = (self.setup, self.lane, x0 & -(LANES as i32));
        let (first_row, last_row) = (y0.max(area.first_row), y1.min(area.first_row + area.rows - 1));
        let [z_first, z_x, z_y] = [lanes.float(s.z[0][l]), lanes.float(s.z[1][l]), lanes.float(s.z[2][l])];
        let [z_least, z_most] = [lanes.float(s.z_range[0][l]), lanes.float(s.z_range[1][l])];
        let (step_x, step_y) = (lanes.of_three(&s.step_x, l), lanes.of_three(&s.step_y, l));
        let (each, rows_down) = (lanes.ints([0, 1, 2, 3, 4, 5, 6, 7]), lanes.int(first_row - y0));
        let edge_row = lanes.add_three(lanes.of_three(&s.edge, l), lanes.times_three(step_y, rows_down));
        let mut x = x0;
        while x <= x1 {
            // Not beyond the last column of the image: pixels that are drawn twice have the same depth again.
            let column = x.min(width - LANES as i32);
            let across = lanes.add(lanes.int(column - block), each);
            let mut edge = lanes.add_three(edge_row, lanes.times_three(step_x, across));
            let of_block = lanes.rounded(lanes.and(across, lanes.int(-(LANES as i32))));
            let in_block = lanes.rounded(lanes.and(across, lanes.int(LANES as i32 - 1)));
            let z_column = lanes.add_floats(z_first, lanes.mul_floats(z_x, of_block));
            let z_within = lanes.mul_floats(z_x, in_block);
            let mut down = lanes.rounded(rows_down);
            let mut at = (first_row - area.first_row) as usize * area.stride + column as usize;
            // Not an inclusive range, which takes six instructions more a row.
            for _ in first_row..last_row + 1 {
                let outside = lanes.or(lanes.or(edge[0], edge[1]), edge[2]);
                let z_row = lanes.add_floats(z_column, lanes.mul_floats(z_y, down));
                let z = lanes.clamp(lanes.add_floats(z_row, z_within), z_least, z_most);
                pixels.draw(lanes, at, z, outside, self.id);
                edge = lanes.add_three(edge, step_y);
                down = lanes.add_floats(down, lanes.float(1.0));
                at += area.stride;
            }
            x += LANES as i32;
        }
    }

    /// Fills a triangle in the last columns of an image whose width is no multiple of [`LANES`].
    ///
    /// Runs start at multiples of [`LANES`]. The one that would leave the image on the right is moved to the left, which covers
    /// more pixels, never others: coverage is decided by the edges alone, and the second depth of a pixel differs from its
    /// first by a rounding at most.
    #[inline(always)]
    fn fill_at_edge<L: Lanes, P: Pixels>(&self, lanes: L, area: BandArea, pixels: &mut P) {
        let (s, l, width) = (self.setup, self.lane, area.size[0] as i32);
        let [x0, y0, x1, y1] = self.at;
        let x0 = x0 & -(LANES as i32);
        let first_row = y0.max(area.first_row);
        let last_row = y1.min(area.first_row + area.rows - 1);
        let (step_x, step_y) = ([0, 1, 2].map(|k: usize| s.step_x[k][l]), [0, 1, 2].map(|k: usize| s.step_y[k][l]));
        let [z_first, z_x, z_y] = [s.z[0][l], s.z[1][l], s.z[2][l]];
        let run = Run::new(lanes, step_x, z_x, [s.z_range[0][l], s.z_range[1][l]]);
        let mut x = x0;
        while x <= x1 {
            let column = x.min(width - LANES as i32);
            let (dx, dy) = (column - x0, first_row - y0);
            let mut edge = [0, 1, 2].map(|k: usize| s.edge[k][l] + step_x[k] * dx + step_y[k] * dy);
            let z_column = z_first + z_x * dx as f32;
            let mut at = (first_row - area.first_row) as usize * area.stride + column as usize;
            let mut rows_down = dy as f32;
            for _ in first_row..last_row + 1 {
                run.draw(edge, z_column + z_y * rows_down, at, x - column, self.id, pixels);
                edge = [0, 1, 2].map(|k: usize| edge[k] + step_y[k]);
                at += area.stride;
                rows_down += 1.0;
            }
            x += LANES as i32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bins::Bands;
    use super::super::pixels::{DepthPixels, IdPixels, LayerPixels};
    use super::super::plain::Plain;
    use super::super::projection::project_all;
    use super::super::triangle_setup::{SMALL, box_of, pixels_in_box};
    use super::super::vertices::Viewport;
    use super::*;

    /// Vertices from a small generator (Knuth's MMIX constants): some triangles tiny, some over the whole image.
    fn vertices(count: usize, size: [u32; 2]) -> Vec<ScreenVertex> {
        let mut state = 7u64;
        let mut number = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1u64 << 24) as f32
        };
        let mut middle = glam::Vec3::ZERO;
        let positions: Vec<glam::Vec3> = (0..count)
            .map(|i| {
                if i % 3 == 0 {
                    middle = glam::Vec3::new(number(), number(), number()) * 2.0 - 1.0;
                }
                let reach = [0.02, 0.1, 1.0, 20.0][i / 3 % 4];
                let p = middle + reach * (glam::Vec3::new(number(), number(), number()) - 0.5);
                p.with_z(-0.5 + 0.4 * p.z.clamp(-1.0, 1.0))
            })
            .collect();
        let identity = glam::Mat4::IDENTITY.to_cols_array_2d();
        let mut out = vec![ScreenVertex::default(); count];
        project_all(&identity, &Viewport::new(size, size, IdPixels::FAR), &positions, &mut out);
        out
    }

    #[test]
    fn both_instruction_sets_draw_the_same_bits() {
        let size = [101, 70];
        let vertices = vertices(3 * 900, size);
        let entries: Vec<Entry> =
            (0..900).map(|id| Entry { vertices: [3 * id, 3 * id + 1, 3 * id + 2], id: id / 2 }).collect();
        let corners = |e: &Entry| e.vertices.map(|i| vertices[i as usize]);
        let has_pixels = |e: &&Entry| {
            let (min, max) = box_of(corners(e));
            let (first, last) = pixels_in_box(min, max, size);
            first[0] <= last[0] && first[1] <= last[1]
        };
        let (small, others): (Vec<Entry>, Vec<Entry>) = entries.iter().filter(has_pixels).partition(|e| {
            let (min, max) = box_of(corners(e));
            max[0] - min[0] <= SMALL && max[1] - min[1] <= SMALL
        });
        let large: Vec<LargeSetup> = others
            .iter()
            .filter_map(|e| {
                let exact = corners(e).map(|v| [v.x, v.y, v.z].map(f64::from));
                LargeSetup::new(corners(e), exact, size, e.id)
            })
            .collect();
        assert!(large.len() > 100 && small.len() > 200);
        let (grid, cover) = (Grid::new(size, Bands::new(size)), None);
        let work =
            Entries { entries: &small, vertices: &vertices, extra: &[], large: &large, large_here: &[], grid, cover };
        let all_large: Vec<u32> = (0..large.len() as u32).collect();
        let drawn = |plain: bool, large: &[u32], cover: Option<Tiles>, first_row: i32, rows: i32| {
            let work = Entries { large_here: large, cover, ..work };
            let n = size[0] as usize * rows as usize;
            let (mut depth, mut id) = (vec![IdPixels::FAR; n], vec![u32::MAX; n]);
            let pixels = &mut IdPixels { depth: &mut depth, id: &mut id };
            let area = BandArea { size, stride: size[0] as usize, first_row, rows };
            if plain {
                draw_entries(Plain, work, area, pixels)
            } else {
                draw(work, area, pixels)
            };
            let mut alone = vec![IdPixels::FAR; n];
            let pixels = &mut DepthPixels::<true> { depth: &mut alone };
            if plain {
                draw_entries(Plain, work, area, pixels)
            } else {
                draw(work, area, pixels)
            };
            assert_eq!(depth, alone);
            let (mut first, mut second) = (vec![0.0; n], vec![0.0; n]);
            let pixels = &mut LayerPixels { first: &mut first, second: &mut second };
            if plain {
                draw_entries(Plain, work, area, pixels)
            } else {
                draw(work, area, pixels)
            };
            // In the last columns pixels of depth alone are drawn twice; large triangles hide those.
            assert!(large.is_empty() || depth == first);
            assert!(second.iter().zip(&first).all(|(second, first)| second > first || *first == 0.0));
            assert!(large.is_empty() || second.iter().any(|z| *z < 0.0));
            (depth.iter().chain(&second).map(|z| z.to_bits()).collect::<Vec<_>>(), id)
        };
        for (first_row, rows) in [(0, 70), (32, 32), (64, 6), (69, 1)] {
            let (plain, best) =
                (drawn(true, &all_large, None, first_row, rows), drawn(false, &all_large, None, first_row, rows));
            assert!(plain.1.iter().any(|&id| id != u32::MAX));
            assert_eq!(plain, best);
            // Large ones lie before nearly all others.
            let farthest: Vec<f32> = (0..14).map(|i| [-0.9, -0.5, 0.0][i % 3]).collect();
            let cover = Some(Tiles { grid, farthest: &farthest });
            let hidden = drawn(false, &[], cover, first_row, rows);
            assert_eq!(drawn(true, &[], cover, first_row, rows), hidden);
            assert!(rows < 32 || hidden != drawn(false, &[], None, first_row, rows), "some are hidden");
        }
    }
}
