//! Triangles sorted into the horizontal bands of the image that they may touch.
//!
//! Bands are drawn independently of each other, each by one thread with its part of the image in the cache, so depth needs
//! no atomics. Most triangles of a fine mesh never get here: those beyond a plane of the clip volume, and those whose box
//! holds no pixel centre.

use super::clip::clip_triangle;
use super::screen::{CLIP, OUTSIDE, SUBPIXEL_BITS, ScreenVertex, Viewport, clip_position};
use crate::scene::Mesh;

/// One placed mesh of a batch.
#[derive(Debug, Clone, Copy)]
pub struct Draw<'a> {
    pub mesh: &'a Mesh,
    pub clip_from_local: [[f32; 4]; 4],
    /// Where its vertices start in the batch.
    pub first_vertex: u32,
    /// Where its triangles start in the batch.
    pub first_triangle: u32,
    /// The scene-wide number of its first triangle, instances counted each time.
    pub first_id: u32,
}

/// A triangle that may touch a band.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub struct Entry {
    /// Indices into the batch's vertices, or with [`Entry::EXTRA`] into [`Bins::extra`].
    pub vertices: [u32; 3],
    /// Scene-wide number of the triangle.
    pub id: u32,
}

impl Entry {
    /// Marks indices of vertices made by clipping.
    pub const EXTRA: u32 = 1 << 31;
}

/// The triangles of one chunk, band by band.
#[derive(Debug, Default)]
pub struct Bins {
    /// Sorted by band; within a band in the order of submission.
    entries: Vec<Entry>,
    /// Where the entries of each band end.
    ends: Vec<u32>,
    /// Vertices made by clipping.
    pub extra: Vec<ScreenVertex>,
    /// Entries before sorting, with their first and last band.
    unsorted: Vec<(Entry, [u16; 2])>,
    polygon: Vec<ScreenVertex>,
}

/// The bands of an image: how many, and how high (a power of two).
#[derive(Debug, Clone, Copy)]
pub struct Bands {
    pub count: u32,
    pub log2_rows: u32,
}

impl Bands {
    /// Bands of at most 32 rows and a quarter of a million pixels: a band and its vertices stay in a level-2 cache, 1024
    /// rows still feed 32 threads, and few triangles cross into a second band.
    pub fn new([width, height]: [u32; 2]) -> Self {
        const PIXELS: u32 = 1 << 18;
        let log2_rows = (PIXELS / width).clamp(1, 32).ilog2();
        Self { count: height.div_ceil(1 << log2_rows), log2_rows }
    }
    pub fn rows(self) -> usize {
        1 << self.log2_rows
    }
}

/// The pixels whose centres lie in a box on the grid: first column, first row, last column, last row.
///
/// Centres on the left or top border count, those on the right or bottom border do not: the top-left rule gives none of
/// them to a triangle in the box.
#[inline(always)]
pub fn pixels_in_box(min: [i32; 2], max: [i32; 2], size: [u32; 2]) -> ([i32; 2], [i32; 2]) {
    const HALF: i32 = 1 << (SUBPIXEL_BITS - 1);
    let first = [0, 1].map(|k| ((min[k] + HALF - 1) >> SUBPIXEL_BITS).max(0));
    let last = [0, 1].map(|k| ((max[k] - HALF - 1) >> SUBPIXEL_BITS).min(size[k] as i32 - 1));
    (first, last)
}

/// To the grid, halves to even: one instruction on every processor.
#[inline(always)]
pub fn snapped(x: f32) -> i32 {
    // SAFETY: vertices that are drawn lie within the guard band, far inside the range of i32. Other values (NaN included)
    // come only from vertices that need clipping; `to_int_unchecked` demands a check for those.
    x.round_ties_even() as i32
}

impl Bins {
    /// Bins the triangles `range` of a batch.
    pub fn fill(
        &mut self,
        draws: &[Draw],
        vertices: &[ScreenVertex],
        range: std::ops::Range<u32>,
        viewport: &Viewport,
        bands: Bands,
    ) {
        self.extra.clear();
        self.unsorted.clear();
        self.unsorted.reserve((range.end - range.start) as usize);
        self.ends.clear();
        self.ends.resize(bands.count as usize, 0);
        let mut d = draws.partition_point(|draw| draw.first_triangle <= range.start) - 1;
        let mut start = range.start;
        while start < range.end {
            let draw = &draws[d];
            let count = draw.mesh.triangles().len() as u32;
            let end = range.end.min(draw.first_triangle + count);
            self.bin_draw(draw, vertices, start - draw.first_triangle..end - draw.first_triangle, viewport, bands);
            start = end;
            d += 1;
        }
        self.sort();
    }

    /// The triangles of a band.
    pub fn band(&self, band: usize) -> &[Entry] {
        let start = if band == 0 { 0 } else { self.ends[band - 1] };
        &self.entries[start as usize..self.ends[band] as usize]
    }

    fn bin_draw(
        &mut self,
        draw: &Draw,
        vertices: &[ScreenVertex],
        range: std::ops::Range<u32>,
        viewport: &Viewport,
        bands: Bands,
    ) {
        let own = &vertices[draw.first_vertex as usize..][..draw.mesh.positions_local().len()];
        let triangles = &draw.mesh.triangles()[range.start as usize..range.end as usize];
        for (indices, triangle) in triangles.iter().zip(range.start..) {
            let v = indices.map(|i| own[i as usize]);
            let all_outside = v[0].code & v[1].code & v[2].code & OUTSIDE;
            let any = v[0].code | v[1].code | v[2].code;
            if all_outside != 0 {
                continue;
            }
            let id = draw.first_id + triangle;
            if any & CLIP != 0 {
                self.bin_clipped(draw, indices, v, id, viewport, bands);
                continue;
            }
            self.push(Entry { vertices: indices.map(|i| draw.first_vertex + i), id }, v, viewport, bands);
        }
    }

    #[inline(always)]
    fn push(&mut self, entry: Entry, v: [ScreenVertex; 3], viewport: &Viewport, bands: Bands) {
        let (x, y) = (v.map(|v| v.x), v.map(|v| v.y));
        let min = [x[0].min(x[1]).min(x[2]), y[0].min(y[1]).min(y[2])].map(snapped);
        let max = [x[0].max(x[1]).max(x[2]), y[0].max(y[1]).max(y[2])].map(snapped);
        let (first, last) = pixels_in_box(min, max, viewport.size);
        if (first[0] <= last[0]) & (first[1] <= last[1]) {
            let range = [first[1] >> bands.log2_rows, last[1] >> bands.log2_rows].map(|b| b as u16);
            self.unsorted.push((entry, range));
            for band in range[0]..=range[1] {
                self.ends[usize::from(band)] += 1;
            }
        }
    }

    #[cold]
    fn bin_clipped(
        &mut self,
        draw: &Draw,
        indices: &[u32; 3],
        v: [ScreenVertex; 3],
        id: u32,
        viewport: &Viewport,
        bands: Bands,
    ) {
        let positions = draw.mesh.positions_local();
        let clip = indices.map(|i| clip_position(&draw.clip_from_local, positions[i as usize]));
        let mut polygon = std::mem::take(&mut self.polygon);
        clip_triangle(viewport, clip, v, &mut polygon);
        let first = Entry::EXTRA | self.extra.len() as u32;
        self.extra.extend_from_slice(&polygon);
        for k in 2..polygon.len() {
            let vertices = [first, first + k as u32 - 1, first + k as u32];
            self.push(Entry { vertices, id }, [polygon[0], polygon[k - 1], polygon[k]], viewport, bands);
        }
        self.polygon = polygon;
    }

    /// Counting sort by band; `ends` comes in as counts.
    fn sort(&mut self) {
        let mut total = 0;
        for end in &mut self.ends {
            let count = *end;
            *end = total;
            total += count;
        }
        self.entries.resize(total as usize, Entry::default());
        for (entry, range) in &self.unsorted {
            for band in range[0]..=range[1] {
                let next = &mut self.ends[usize::from(band)];
                self.entries[*next as usize] = *entry;
                *next += 1;
            }
        }
    }
}
