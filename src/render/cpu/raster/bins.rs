//! What chunks of triangles leave to the horizontal bands of an image, bounded in bytes.

use super::clip::ExactVertex;
use super::fragments::Fragments;
use super::triangle_setup::LargeSetup;
use super::vertices::ScreenVertex;

/// Pixels in a cache line.
const LINE: u32 = 16;
/// Bytes after which a chunk ends early; a slice more may be written, and lists that grow have up to twice the room.
pub const CHUNK_BYTES: usize = 1 << 17;

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

/// What is left of one chunk of triangles, band by band.
#[derive(Debug, Default)]
pub struct Bins {
    bands: Vec<Bin>,
    /// Empty ones with room: neighbouring triangles fill few bands, each chunk others.
    spare: Vec<Bin>,
    /// Vertices made by clipping.
    pub extra: Vec<ScreenVertex>,
    /// Triangles too large for edge functions in 32 bits, of all bands ([`Bin::large`]).
    pub large: Vec<LargeSetup>,
    /// Room for a triangle that is clipped.
    pub polygon: Vec<ExactVertex>,
}

/// What one chunk of triangles leaves to one band.
#[derive(Debug, Default)]
pub struct Bin {
    /// Triangles, in the order of submission.
    pub entries: Vec<Entry>,
    /// Pixels of tiny triangles, in no order that matters.
    pub fragments: Fragments,
    /// Indices into [`Bins::large`].
    pub large: Vec<u32>,
    /// Bits of the columns of tiles that they may touch (of `cover::Grid`).
    pub columns: u64,
}

impl Bin {
    #[inline(always)]
    fn has_room(&self) -> bool {
        self.bytes(Vec::capacity, Vec::capacity) > 0
    }
    fn is_empty(&self) -> bool {
        self.bytes(Vec::len, Vec::len) == 0
    }
    /// Bytes by the lengths of its lists.
    #[inline(always)]
    fn bytes(&self, entries: fn(&Vec<Entry>) -> usize, numbers: fn(&Vec<u32>) -> usize) -> usize {
        let large = numbers(&self.large) * size_of::<u32>();
        entries(&self.entries) * size_of::<Entry>() + self.fragments.bytes(numbers) + large
    }
    /// It without what is in it.
    fn cleared(&mut self) -> Self {
        let mut bin = std::mem::take(self);
        bin.entries.clear();
        bin.fragments.clear();
        bin.large.clear();
        bin.columns = 0;
        bin
    }
}

/// The bands of an image: how many, how high (a power of two), and how far apart their rows lie while they are drawn.
#[derive(Debug, Clone, Copy)]
pub struct Bands {
    pub count: u32,
    pub log2_rows: u32,
    /// Pixels from one row to the next.
    pub stride: u32,
}

impl Bands {
    /// Bands of at most 32 rows and a quarter of a million pixels: a band and its vertices stay in a level-2 cache, 1024
    /// rows still feed 32 threads, and few triangles cross into a second band.
    pub fn new([width, height]: [u32; 2]) -> Self {
        const PIXELS: u32 = 1 << 18;
        let log2_rows = (PIXELS / width).clamp(1, 32).ilog2();
        // An odd number of cache lines: where rows lie a multiple of 4096 bytes apart, those of a triangle drive each other
        // out of the level-1 cache (measured: a quarter of the time of a map of 4096 columns).
        let stride = (width.div_ceil(LINE) | 1) * LINE;
        Self { count: height.div_ceil(1 << log2_rows), log2_rows, stride }
    }
    pub fn rows(self) -> usize {
        1 << self.log2_rows
    }
}

/// The part of an image that a band covers.
#[derive(Debug, Clone, Copy)]
pub struct BandArea {
    /// Size of the image; at least a vector's columns.
    pub size: [u32; 2],
    /// Pixels from one row to the next.
    pub stride: usize,
    /// First row.
    pub first_row: i32,
    /// Rows of this band, at least one.
    pub rows: i32,
}

impl Bins {
    /// What is left to a band.
    pub fn band(&self, band: usize) -> &Bin {
        &self.bands[band]
    }

    /// Whether nothing is left to a band.
    pub fn is_empty(&self, band: usize) -> bool {
        self.bands[band].is_empty()
    }

    /// Begins a chunk of an image with these bands.
    pub fn start(&mut self, bands: Bands) {
        self.extra.clear();
        self.large.clear();
        self.spare.extend(self.bands.iter_mut().filter(|bin| bin.has_room()).map(Bin::cleared));
        self.bands.resize_with(bands.count as usize, Bin::default);
        self.bands.iter_mut().for_each(|bin| bin.columns = 0);
    }
    /// Whether the chunk had better end.
    pub fn is_full(&self) -> bool {
        self.bytes(Vec::len, Vec::len) >= CHUNK_BYTES
    }
    /// Bytes of everything, by the lengths of their lists.
    fn bytes(&self, entries: fn(&Vec<Entry>) -> usize, numbers: fn(&Vec<u32>) -> usize) -> usize {
        let bands = self.bands.iter().chain(&self.spare);
        bands.map(|bin| bin.bytes(entries, numbers)).sum::<usize>()
            + self.extra.len() * size_of::<ScreenVertex>()
            + self.large.len() * size_of::<LargeSetup>()
    }

    /// Gives memory back where bands that are full by turns have gathered more than so many bytes.
    pub fn shrink(&mut self, most: usize) {
        if self.bytes(Vec::capacity, Vec::capacity) > most {
            self.bands.iter_mut().for_each(|bin| *bin = Bin::default());
            self.spare.clear();
        }
    }

    /// A band to add to.
    #[inline(always)]
    pub fn room_for(&mut self, band: usize) -> &mut Bin {
        let bin = &mut self.bands[band];
        if !bin.has_room()
            && let Some(spare) = self.spare.pop()
        {
            *bin = Bin { columns: bin.columns, ..spare };
        }
        bin
    }

    /// Leaves a triangle to the bands of its first to its last row.
    #[inline(always)]
    pub fn push(&mut self, entry: Entry, rows: [i32; 2], bands: Bands) {
        let [first, last] = rows;
        for band in first >> bands.log2_rows..=last >> bands.log2_rows {
            self.room_for(band as usize).entries.push(entry);
        }
    }

    /// Leaves a large triangle to the bands that its box touches.
    pub fn push_large(&mut self, setup: LargeSetup, bands: Bands) {
        let [_, first, _, last] = setup.pixels;
        let index = self.large.len() as u32;
        self.large.push(setup);
        for band in first >> bands.log2_rows..=last >> bands.log2_rows {
            self.room_for(band as usize).large.push(index);
        }
    }
}
