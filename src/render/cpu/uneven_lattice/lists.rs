//! What a chunk of triangles leaves to a band of a map.

use crate::render::cpu::raster::Fragments;

/// Marks indices of vertices made by clipping.
pub const EXTRA: u32 = 1 << 31;
/// Triangles of a batch, as indices into its vertices, or with [`EXTRA`] into those that clipping made.
#[derive(Debug, Default)]
pub struct List {
    pub triangles: Vec<[u32; 3]>,
    /// Where they have alpha tests their numbers in the batch.
    pub numbers: Vec<u32>,
}

/// What a chunk leaves to a band.
#[derive(Debug, Default)]
pub struct Bin {
    pub list: List,
    /// Texels of tiny triangles.
    pub fragments: Fragments,
}

impl List {
    pub fn clear(&mut self) {
        self.triangles.clear();
        self.numbers.clear();
    }
    pub fn push(&mut self, triangle: [u32; 3], number: Option<u32>) {
        self.triangles.push(triangle);
        self.numbers.extend(number);
    }
    /// Bytes by the lengths of its lists.
    pub fn bytes(&self, triangles: fn(&Vec<[u32; 3]>) -> usize, numbers: fn(&Vec<u32>) -> usize) -> usize {
        triangles(&self.triangles) * size_of::<[u32; 3]>() + numbers(&self.numbers) * size_of::<u32>()
    }
}
