//! Triangles sorted into the horizontal bands of the image that they may touch.
//!
//! Bands are drawn independently of each other, each by one thread with its part of the image in the cache, so depth needs
//! no atomics. In a fine mesh most triangles end here: those beyond a plane of the clip volume and those whose box holds no
//! pixel centre are gone, and those whose box holds a few become the fragments they cover at once, [`LANES`] triangles side
//! by side. Only what is larger is kept as a triangle: in each of the few bands that it touches, or, where it is too large
//! for 32-bit edge functions, once in a list that every band reads.
//!
//! What a chunk of triangles leaves is bounded in bytes: filling stops there, and what is left over waits for a later round.

use std::ops::Range;

use super::clip::{ExactVertex, clip_triangle, exact_position};
use super::simd::{LANES, sign_bits};
use super::triangle_setup::{
    Corners, LargeSetup, SMALL, SmallSetup, box_of, larger, pixels_in_box, smaller, snapped_box,
};
use super::vertices::{CLIP, OUTSIDE, Projection, ScreenVertex, Viewport};
use crate::render::cpu::faces::FaceTest;
use crate::scene::Mesh;
use crate::simd::dispatch;

/// Largest box, in pixel centres along each side, of triangles that become fragments here: at most ten of them, 120 bytes.
/// Chosen by measurement (instructions on a scene of 440,000 triangles at 1024 and 2048 texels).
const TINY: i32 = 4;

/// Triangles binned between two looks at the bytes written.
const SLICE: u32 = 1 << 8;
/// Bytes after which a chunk ends early; a slice more may be written.
const CHUNK_BYTES: usize = 1 << 17;

/// One placed mesh of a batch.
#[derive(Debug, Clone, Copy)]
pub struct Draw<'a> {
    pub mesh: &'a Mesh,
    pub projection: Projection,
    /// Which of its faces are drawn.
    pub faces: FaceTest,
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

/// A covered pixel.
#[derive(Debug, Clone, Copy, Default)]
pub struct Fragment {
    /// Index of the pixel in its band.
    pub at: u32,
    pub z: f32,
    /// Scene-wide number of the triangle.
    pub id: u32,
}

/// What is left of one chunk of triangles, band by band.
#[derive(Debug, Default)]
pub struct Bins {
    bands: Vec<Bin>,
    /// Vertices made by clipping.
    pub extra: Vec<ScreenVertex>,
    /// Triangles larger than [`SmallSetup`] can hold, of all bands.
    pub large: Vec<LargeSetup>,
    polygon: Vec<ExactVertex>,
}

/// What one chunk of triangles leaves to one band.
#[derive(Debug, Default)]
pub struct Bin {
    /// Triangles, in the order of submission.
    pub entries: Vec<Entry>,
    /// Pixels of tiny triangles, in no order that matters.
    pub fragments: Vec<Fragment>,
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

dispatch! {
    /// Bins the triangles `range` of a batch, or the first of them where they write too much; the first that is not binned.
    pub fn fill(bins: &mut Bins, draws: &[Draw], vertices: &[ScreenVertex], range: Range<u32>, viewport: &Viewport, bands: Bands) -> u32 = Bins::fill
}

impl Bins {
    /// What is left to a band.
    pub fn band(&self, band: usize) -> &Bin {
        &self.bands[band]
    }

    #[inline(always)]
    fn fill(
        &mut self,
        draws: &[Draw],
        vertices: &[ScreenVertex],
        range: Range<u32>,
        viewport: &Viewport,
        bands: Bands,
    ) -> u32 {
        self.shrink();
        self.extra.clear();
        self.large.clear();
        self.bands.resize_with(bands.count as usize, Bin::default);
        for bin in &mut self.bands {
            bin.entries.clear();
            bin.fragments.clear();
        }
        let mut d = draws.partition_point(|draw| draw.first_triangle <= range.start) - 1;
        let mut start = range.start;
        while start < range.end && (start == range.start || self.bytes(Vec::len, Vec::len) < CHUNK_BYTES) {
            let draw = &draws[d];
            let draw_end = draw.first_triangle + draw.mesh.triangles().len() as u32;
            let end = range.end.min(draw_end).min(start + SLICE);
            let own = start - draw.first_triangle..end - draw.first_triangle;
            self.bin_draw(draw, own, vertices, viewport, bands);
            start = end;
            d += usize::from(end == draw_end);
        }
        start
    }

    /// Bytes of everything, by the number of entries and of fragments in a list.
    fn bytes(&self, entries: fn(&Vec<Entry>) -> usize, fragments: fn(&Vec<Fragment>) -> usize) -> usize {
        let bands = self.bands.iter();
        let in_bands =
            bands.map(|b| entries(&b.entries) * size_of::<Entry>() + fragments(&b.fragments) * size_of::<Fragment>());
        in_bands.sum::<usize>()
            + self.extra.len() * size_of::<ScreenVertex>()
            + self.large.len() * size_of::<LargeSetup>()
    }

    /// Gives memory back where bands that are full by turns have gathered more than a chunk needs.
    pub fn shrink(&mut self) {
        if self.bytes(Vec::capacity, Vec::capacity) > 2 * CHUNK_BYTES {
            for bin in &mut self.bands {
                *bin = Bin::default();
            }
        }
    }

    /// Bins the triangles `range` of a draw.
    #[inline(always)]
    fn bin_draw(
        &mut self,
        draw: &Draw,
        range: Range<u32>,
        vertices: &[ScreenVertex],
        viewport: &Viewport,
        bands: Bands,
    ) {
        let own = &vertices[draw.first_vertex as usize..][..draw.mesh.positions_local().len()];
        let triangles = &draw.mesh.triangles()[range.start as usize..range.end as usize];
        let (groups, rest) = triangles.as_chunks::<LANES>();
        let mut first = range.start;
        for group in groups {
            self.bin_group(draw, group, LANES, first, own, viewport, bands);
            first += LANES as u32;
        }
        if let Some(last) = rest.last() {
            let mut padded = [*last; LANES];
            padded[..rest.len()].copy_from_slice(rest);
            self.bin_group(draw, &padded, rest.len(), first, own, viewport, bands);
        }
    }

    /// Bins the first `count` triangles of a group, the first of which is number `first` in its mesh.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    fn bin_group(
        &mut self,
        draw: &Draw,
        group: &[[u32; 3]; LANES],
        count: usize,
        first: u32,
        own: &[ScreenVertex],
        viewport: &Viewport,
        bands: Bands,
    ) {
        let corners = Corners::gather(|l, k| {
            let i = group[l][k] as usize;
            debug_assert!(i < own.len());
            // SAFETY: `Mesh::new` has checked every index against the number of vertices, `own` has one for each, and
            // meshes do not change.
            unsafe { own.get_unchecked(i) }
        });
        let pixels = snapped_box(&corners).pixels(viewport.size);
        let (mut live, mut clip, mut tiny) = ([0i32; LANES], [0i32; LANES], [0i32; LANES]);
        for l in 0..LANES {
            let [a, b, c] = [corners.code[0][l], corners.code[1][l], corners.code[2][l]];
            let seen = a & b & c & OUTSIDE == 0;
            let whole = (a | b | c) & CLIP == 0;
            let [x0, y0, x1, y1] = [pixels.at[0][l], pixels.at[1][l], pixels.at[2][l], pixels.at[3][l]];
            let some = (x0 <= x1) & (y0 <= y1);
            let few = (x1 - x0 < TINY) & (y1 - y0 < TINY) & pixels.small[l];
            live[l] = -i32::from(seen & whole & some);
            tiny[l] = -i32::from(seen & whole & some & few);
            clip[l] = -i32::from(seen & !whole);
        }
        let mut lanes = (1u32 << count) - 1;
        if !draw.faces.takes_all() {
            lanes &= taken(draw, group);
        }
        let (live, tiny, clip) = (sign_bits(&live) & lanes, sign_bits(&tiny) & lanes, sign_bits(&clip) & lanes);
        let id = draw.first_id + first;
        if tiny != 0 {
            let setup = SmallSetup::new::<1>(&corners, &pixels);
            self.emit(&setup, &pixels.at, tiny, id, viewport.size, bands);
        }
        let mut rest = (live & !tiny) | clip;
        while rest != 0 {
            let l = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let id = id + l as u32;
            if clip >> l & 1 == 0 && !pixels.small[l] {
                self.bin_large(draw, &group[l], corners.triangle(l), id, viewport);
            } else if clip >> l & 1 == 0 {
                let vertices = group[l].map(|i| draw.first_vertex + i);
                self.push(Entry { vertices, id }, [pixels.at[1][l], pixels.at[3][l]], bands);
            } else {
                let v = group[l].map(|i| own[i as usize]);
                self.bin_clipped(draw, &group[l], v, id, viewport, bands);
            }
        }
    }

    /// Turns tiny triangles into the fragments they cover, one pixel of each box after the other.
    #[inline(always)]
    fn emit(
        &mut self,
        setup: &SmallSetup,
        pixels: &[[i32; LANES]; 4],
        tiny: u32,
        id: u32,
        size: [u32; 2],
        bands: Bands,
    ) {
        let in_band = (1i32 << bands.log2_rows) - 1;
        let [mut columns_left, mut rows_left] = [[0i32; LANES]; 2];
        for l in 0..LANES {
            columns_left[l] = pixels[2][l] - pixels[0][l];
            rows_left[l] = pixels[3][l] - pixels[1][l];
        }
        let mut edge_row = setup.edge;
        let mut z_row = setup.z[0];
        for j in 0..TINY {
            let has_row = !sign_bits(&rows_left) & tiny;
            if has_row == 0 {
                break;
            }
            let mut edge = edge_row;
            let mut z = z_row;
            let mut left = columns_left;
            for i in 0..TINY {
                let has_pixel = !sign_bits(&left) & has_row;
                if has_pixel == 0 {
                    break;
                }
                let mut outside = [0i32; LANES];
                for l in 0..LANES {
                    outside[l] = edge[0][l] | edge[1][l] | edge[2][l];
                }
                let mut bits = !sign_bits(&outside) & has_pixel;
                while bits != 0 {
                    let l = bits.trailing_zeros() as usize % LANES;
                    bits &= bits - 1;
                    let (x, y) = (pixels[0][l] + i, pixels[1][l] + j);
                    let z = smaller(larger(z[l], setup.z_range[0][l]), setup.z_range[1][l]);
                    let at = (y & in_band) * size[0] as i32 + x;
                    let bin = &mut self.bands[(y >> bands.log2_rows) as usize];
                    bin.fragments.push(Fragment { at: at as u32, z, id: id + l as u32 });
                }
                for l in 0..LANES {
                    for k in 0..3 {
                        edge[k][l] += setup.step_x[k][l];
                    }
                    z[l] += setup.z[1][l];
                    left[l] -= 1;
                }
            }
            for l in 0..LANES {
                for k in 0..3 {
                    edge_row[k][l] += setup.step_y[k][l];
                }
                z_row[l] += setup.z[2][l];
                rows_left[l] -= 1;
            }
        }
    }

    /// Leaves a triangle to the bands of its first to its last row.
    #[inline(always)]
    fn push(&mut self, entry: Entry, rows: [i32; 2], bands: Bands) {
        let [first, last] = rows.map(|row| (row >> bands.log2_rows) as usize);
        for bin in &mut self.bands[first..=last] {
            bin.entries.push(entry);
        }
    }

    #[cold]
    fn bin_large(&mut self, draw: &Draw, indices: &[u32; 3], v: [ScreenVertex; 3], id: u32, viewport: &Viewport) {
        let positions = draw.mesh.positions_local();
        let exact = [0, 1, 2].map(|k: usize| {
            let clip = draw.projection.clip(positions[indices[k] as usize].as_dvec3());
            exact_position(viewport, clip, v[k])
        });
        self.large.extend(LargeSetup::new(v, exact, viewport.size, id));
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
        let clip = indices.map(|i| draw.projection.clip(positions[i as usize].as_dvec3()));
        let mut polygon = std::mem::take(&mut self.polygon);
        clip_triangle(viewport, clip, v, &mut polygon);
        let first = Entry::EXTRA | self.extra.len() as u32;
        self.extra.extend(polygon.iter().map(|v| v.screen));
        for k in 2..polygon.len() {
            let corners = [polygon[0], polygon[k - 1], polygon[k]];
            let (min, max) = box_of(corners.map(|v| v.screen));
            if max[0] - min[0] > SMALL || max[1] - min[1] > SMALL {
                let (screen, exact) = (corners.map(|v| v.screen), corners.map(|v| v.exact));
                self.large.extend(LargeSetup::new(screen, exact, viewport.size, id));
                continue;
            }
            let (min, max) = pixels_in_box(min, max, viewport.size);
            if min[0] <= max[0] && min[1] <= max[1] {
                let vertices = [first, first + k as u32 - 1, first + k as u32];
                self.push(Entry { vertices, id }, [min[1], max[1]], bands);
            }
        }
        self.polygon = polygon;
    }
}

/// A bit for each of some triangles of a draw whose faces are drawn.
#[cold]
fn taken(draw: &Draw, group: &[[u32; 3]; LANES]) -> u32 {
    let positions = draw.mesh.positions_local();
    let bit = |l: usize| {
        let clip = group[l].map(|i| draw.projection.clip(positions[i as usize].as_dvec3()));
        u32::from(draw.faces.takes(clip)) << l
    };
    (0..LANES).map(bit).sum()
}
