//! What chunks of triangles leave to the horizontal bands of a map, bounded in bytes.

use super::lists::{Bin, List};
use super::polygon::Polygon;
use super::tiny::Tiny;
use super::vertex::EvenVertex;
use crate::render::cpu::raster::{Bands, CHUNK_BYTES};

/// Bands up to which a triangle is listed in each that it touches; one that touches more is listed once for all.
const FEW_BANDS: u32 = 4;

/// What a chunk of triangles leaves.
#[derive(Debug, Default)]
pub struct Bins {
    pub bands: Vec<Bin>,
    /// Triangles that touch more than [`FEW_BANDS`].
    pub large: List,
    pub extra: Vec<EvenVertex>,
    /// Room for a triangle that is cut.
    pub polygon: Polygon,
    /// Tiny triangles that wait for their group to be full: lower and higher ones.
    pub tiny: [Tiny; 2],
}

impl Bins {
    /// Begins a chunk of a map with so many bands.
    pub fn start(&mut self, bands: Bands) {
        self.shrink(4);
        self.bands.resize_with(bands.count as usize, Bin::default);
        for bin in &mut self.bands {
            bin.list.clear();
            bin.fragments.clear();
        }
        self.large.clear();
        self.extra.clear();
    }
    /// Whether nothing is left to a band.
    pub fn is_empty(&self, band: usize) -> bool {
        let Bin { list, fragments } = &self.bands[band];
        let of_band = list.bytes(Vec::len, Vec::len) + fragments.bytes(Vec::len);
        of_band + self.large.bytes(Vec::len, Vec::len) == 0
    }
    /// Whether the chunk had better end.
    pub fn is_full(&self) -> bool {
        self.bytes(Vec::len, Vec::len) >= CHUNK_BYTES
    }
    /// Bytes of everything, by the lengths of its lists.
    fn bytes(&self, triangles: fn(&Vec<[u32; 3]>) -> usize, numbers: fn(&Vec<u32>) -> usize) -> usize {
        let of_band = |bin: &Bin| bin.list.bytes(triangles, numbers) + bin.fragments.bytes(numbers);
        let of_bands = self.bands.iter().map(of_band).sum::<usize>();
        of_bands + self.large.bytes(triangles, numbers) + self.extra.len() * size_of::<EvenVertex>()
    }
    /// Gives memory back where bands that are full by turns have gathered more than so many chunks need.
    pub fn shrink(&mut self, chunks: usize) {
        if self.bytes(Vec::capacity, Vec::capacity) > chunks * CHUNK_BYTES {
            *self = Self::default();
        }
    }
    /// Lists a triangle where it has rows, the first one and those before `end`, with its number in the batch if it has a test.
    pub fn push(&mut self, triangle: [u32; 3], first: u32, end: u32, number: Option<u32>, bands: Bands) {
        let (first, last) = (first >> bands.log2_rows, (end - 1) >> bands.log2_rows);
        if last - first >= FEW_BANDS {
            self.large.push(triangle, number);
        } else {
            (first..=last).for_each(|band| self.bands[band as usize].list.push(triangle, number));
        }
    }
}
