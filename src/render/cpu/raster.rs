//! Filling triangles into one band of an image.
//!
//! Source: J. Pineda (1988), with rows of [`LANES`] pixels at once. Small triangles (nearly all) are evaluated over their
//! whole box without a branch on coverage; larger ones in blocks that are skipped, filled, or tested edge by edge.
//! Blocks of pixels start at multiples of [`LANES`], so that a load meets earlier stores of neighbouring triangles whole.

use super::binning::Entry;
use super::screen::ScreenVertex;
use super::setup::{LargeSetup, SmallSetup};
use super::simd::{LANES, dispatch};

/// Rows that the small path treats without a branch between them.
const ROWS: usize = 4;
/// Columns and rows of a block of the large path. Edge coefficients are below 2^25 (twice the guard band in grid steps),
/// so that over a block an edge function that changes its sign stays below 2^25 (32 + 8) < 2^31.
const BLOCK: [i32; 2] = [32, 8];

/// Where a pass keeps its pixels.
///
/// `draw` has the index of the first of [`LANES`] pixels, their depths, and which of them are covered.
pub trait Pixels {
    /// Keeps what is nearer than what is there.
    fn draw(&mut self, at: usize, z: [f32; LANES], covered: [bool; LANES], id: u32);
}

/// Depth alone.
pub struct DepthPixels<'a> {
    pub depth: &'a mut [f32],
}

/// Depth and the number of the triangle. Of equal depths the smaller number wins, whatever the order of drawing.
pub struct IdPixels<'a> {
    pub depth: &'a mut [f32],
    pub id: &'a mut [u32],
}

impl Pixels for DepthPixels<'_> {
    #[inline(always)]
    fn draw(&mut self, at: usize, z: [f32; LANES], covered: [bool; LANES], _id: u32) {
        let old: &mut [f32; LANES] = (&mut self.depth[at..at + LANES]).try_into().expect("a slice of LANES");
        for l in 0..LANES {
            old[l] = if covered[l] & (z[l] < old[l]) { z[l] } else { old[l] };
        }
    }
}

impl Pixels for IdPixels<'_> {
    #[inline(always)]
    fn draw(&mut self, at: usize, z: [f32; LANES], covered: [bool; LANES], id: u32) {
        let old: &mut [f32; LANES] = (&mut self.depth[at..at + LANES]).try_into().expect("a slice of LANES");
        let old_id: &mut [u32; LANES] = (&mut self.id[at..at + LANES]).try_into().expect("a slice of LANES");
        for l in 0..LANES {
            // Not nearer than the far plane: 1 is also what an empty pixel holds.
            let nearer = (z[l] < old[l]) | ((z[l] == old[l]) & (z[l] < 1.0) & (id < old_id[l]));
            let take = covered[l] & nearer;
            old[l] = if take { z[l] } else { old[l] };
            old_id[l] = if take { id } else { old_id[l] };
        }
    }
}

/// The part of an image that a band covers.
#[derive(Debug, Clone, Copy)]
pub struct BandArea {
    /// Size of the image; at least [`LANES`] columns.
    pub size: [u32; 2],
    /// First row.
    pub first_row: i32,
    /// Rows of this band, at least one.
    pub rows: i32,
}

dispatch! {
    /// Draws a band's entries of one chunk, depth alone.
    pub fn draw_depth(entries: &[Entry], vertices: &[ScreenVertex], extra: &[ScreenVertex], area: BandArea, pixels: &mut DepthPixels) = draw_entries
}
dispatch! {
    /// Draws a band's entries of one chunk, depth and triangle.
    pub fn draw_ids(entries: &[Entry], vertices: &[ScreenVertex], extra: &[ScreenVertex], area: BandArea, pixels: &mut IdPixels) = draw_entries
}

#[inline(always)]
fn draw_entries<P: Pixels>(
    entries: &[Entry],
    vertices: &[ScreenVertex],
    extra: &[ScreenVertex],
    area: BandArea,
    pixels: &mut P,
) {
    for group in entries.chunks(LANES) {
        let mut v = [[ScreenVertex::default(); LANES]; 3];
        for l in 0..LANES {
            let entry = &group[l.min(group.len() - 1)];
            for k in 0..3 {
                let i = entry.vertices[k];
                v[k][l] =
                    if i & Entry::EXTRA == 0 { vertices[i as usize] } else { extra[(i & !Entry::EXTRA) as usize] };
            }
        }
        let setup = SmallSetup::new(&v, area.size);
        for (l, entry) in group.iter().enumerate() {
            match setup.kind[l] {
                0 => {}
                1 if area.rows >= ROWS as i32 => fill_small::<P, ROWS>(&setup, l, area, entry.id, pixels),
                1 => fill_small::<P, 1>(&setup, l, area, entry.id, pixels),
                _ => {
                    if let Some(large) = LargeSetup::new([v[0][l], v[1][l], v[2][l]], area.size) {
                        fill_large(&large, area, entry.id, pixels);
                    }
                }
            }
        }
    }
}

/// Fills triangle `l` of a setup, N rows at a time.
///
/// A box is moved up or to the left where it would leave the band, which covers more pixels, never others: coverage is
/// decided by the edges alone, and drawing a pixel twice changes nothing.
#[inline(always)]
fn fill_small<P: Pixels, const N: usize>(s: &SmallSetup, l: usize, area: BandArea, id: u32, pixels: &mut P) {
    let width = area.size[0] as i32;
    let [x0, y0, x1, y1] = [s.pixels[0][l], s.pixels[1][l], s.pixels[2][l], s.pixels[3][l]];
    let first_row = y0.max(area.first_row) - area.first_row;
    let last_row = y1.min(area.first_row + area.rows - 1) - area.first_row;
    let z_range = [s.z_range[0][l], s.z_range[1][l]];
    let mut x = x0;
    while x <= x1 {
        let column = x.min(width - LANES as i32);
        let mut row = first_row;
        while row <= last_row {
            row = row.min(area.rows - N as i32);
            let (dx, dy) = (column - x0, row + area.first_row - y0);
            let mut edge = [[0i32; LANES]; 3];
            for k in 0..3 {
                let start = s.edge[k][l] + s.step_x[k][l] * dx + s.step_y[k][l] * dy;
                for (i, e) in edge[k].iter_mut().enumerate() {
                    *e = start + s.step_x[k][l] * i as i32;
                }
            }
            let mut z_row = [0f32; LANES];
            for (i, z) in z_row.iter_mut().enumerate() {
                *z = s.z[0][l] + s.z[1][l] * (dx + i as i32) as f32;
            }
            let at = row as usize * width as usize + column as usize;
            for r in 0..N {
                let mut z = [0f32; LANES];
                let mut covered = [false; LANES];
                for i in 0..LANES {
                    z[i] = (z_row[i] + s.z[2][l] * (dy + r as i32) as f32).max(z_range[0]).min(z_range[1]);
                    covered[i] = edge[0][i] | edge[1][i] | edge[2][i] >= 0;
                }
                pixels.draw(at + r * width as usize, z, covered, id);
                for k in 0..3 {
                    for e in &mut edge[k] {
                        *e += s.step_y[k][l];
                    }
                }
            }
            row += N as i32;
        }
        x += LANES as i32;
    }
}

/// Fills a triangle of any size, block by block.
#[inline(always)]
fn fill_large<P: Pixels>(s: &LargeSetup, area: BandArea, id: u32, pixels: &mut P) {
    let width = area.size[0] as i32;
    let [x0, y0, x1, y1] = s.pixels;
    let (first_row, end_row) = (y0.max(area.first_row), (y1 + 1).min(area.first_row + area.rows));
    let mut top = first_row;
    while top < end_row {
        let rows = BLOCK[1].min(end_row - top);
        let mut left = x0 & -(LANES as i32);
        while left <= x1 {
            let columns = BLOCK[0].min((x1 + 1 - left + LANES as i32 - 1) & -(LANES as i32)).min(width - left);
            fill_block(s, [left, top], [columns, rows], area, id, pixels);
            left += BLOCK[0];
        }
        top += BLOCK[1];
    }
}

#[inline(always)]
fn fill_block<P: Pixels>(
    s: &LargeSetup,
    [left, top]: [i32; 2],
    [columns, rows]: [i32; 2],
    area: BandArea,
    id: u32,
    pixels: &mut P,
) {
    // Steps of the edges that cross the block, and their values at its first pixel; zero for one that holds all over it.
    let mut edges = [[0i32; 3]; 3];
    // The last run of pixels may start up to LANES - 1 columns before the block.
    let reach_left = if columns < LANES as i32 { LANES as i32 - columns } else { 0 };
    for (edge, [a, b, e]) in edges.iter_mut().zip(s.edges) {
        let first = e + a * i64::from(left) + b * i64::from(top);
        let (across, down) = (a * i64::from(columns - 1), b * i64::from(rows - 1));
        let largest = first + across.max(0) + down.max(0);
        let smallest = first + across.min(0) + down.min(0) - a.max(0) * i64::from(reach_left);
        if largest < 0 {
            return;
        }
        if smallest < 0 {
            *edge = [a as i32, b as i32, first as i32];
        }
    }
    let [z0, zx, zy] = s.z;
    let z_first = (z0 + zx * f64::from(left) + zy * f64::from(top)) as f32;
    let (zx, zy) = (zx as f32, zy as f32);
    let width = area.size[0] as i32;
    for r in 0..rows {
        let row = (top + r - area.first_row) as usize * width as usize;
        let mut x = 0;
        while x < columns {
            let dx = x.min(width - LANES as i32 - left);
            let mut z = [0f32; LANES];
            let mut covered = [false; LANES];
            for i in 0..LANES {
                let c = dx + i as i32;
                z[i] = (z_first + zx * c as f32 + zy * r as f32).max(s.z_range[0]).min(s.z_range[1]);
                let e = edges.map(|[a, b, e]| e + a * c + b * r);
                covered[i] = e[0] | e[1] | e[2] >= 0;
            }
            pixels.draw(row + (left + dx) as usize, z, covered, id);
            x += LANES as i32;
        }
    }
}
