//! Where the bands of an image are drawn: beside the image, with rows that do not lie a multiple of 4096 bytes apart
//! ([`Bands::stride`]), from where they are copied to it.
//!
//! A band of a large image is drawn in memory of its thread, which stays in the level-2 cache: the image is written once, and read
//! again only by a second round. A small image has many rounds and memory for all of its bands.

use std::mem::MaybeUninit;

use rayon::prelude::*;

use super::raster::{BandArea, Bands, is_small};
use crate::memory::{copied, written_part};

/// Memory for bands of an image.
#[derive(Debug)]
pub struct Rooms<T> {
    size: [u32; 2],
    /// What is there where nothing has been drawn.
    pub far: T,
    /// The bands of a small image.
    kept: Vec<Vec<T>>,
    rows: usize,
    stride: usize,
}

/// What is left to a band by a round.
#[derive(Debug, Clone, Copy)]
pub struct Turn {
    /// Whether nothing has been drawn before, to any band.
    pub is_first: bool,
    pub is_empty: bool,
}

/// A band with its place in the image.
#[derive(Debug)]
pub struct Part<'a, T> {
    pub band: usize,
    pub area: BandArea,
    far: T,
    /// Its memory in a small image.
    kept: Option<&'a mut Vec<T>>,
    out: &'a mut [MaybeUninit<T>],
}

impl<T: Copy + Send + Sync> Rooms<T> {
    pub fn new(size: [u32; 2], far: T) -> Self {
        Self { size, far, kept: Vec::new(), rows: 0, stride: 0 }
    }

    /// The bands of an image, in their order.
    pub fn parts<'a>(
        &'a mut self,
        bands: Bands,
        image: &'a mut [MaybeUninit<T>],
    ) -> impl IndexedParallelIterator<Item = Part<'a, T>> {
        let ([width, height], far) = (self.size, self.far);
        (self.rows, self.stride) = (bands.rows(), bands.stride as usize);
        self.kept.resize_with(bands.count as usize, Vec::new);
        let (rows, stride) = (self.rows, self.stride);
        let outs = image.par_chunks_mut(rows * width as usize);
        outs.zip(&mut self.kept).enumerate().map(move |(band, (out, kept))| {
            let first_row = band * rows;
            let rows = rows.min(height as usize - first_row) as i32;
            let area = BandArea { size: [width, height], stride, first_row: first_row as i32, rows };
            Part { band, area, far, kept: is_small([width, height]).then_some(kept), out }
        })
    }

    /// Writes what has not been written to the image.
    pub fn finish(&self, image: &mut [MaybeUninit<T>]) {
        if is_small(self.size) {
            let width = self.size[0] as usize;
            let outs = image.par_chunks_mut(self.rows * width);
            outs.zip(&self.kept).for_each(|(out, kept)| put_out(kept, self.stride, width, out));
        }
    }
}

impl<T: Copy> Part<'_, T> {
    /// Draws what a round leaves to the band, in `spare` memory unless it has its own.
    pub fn draw(self, turn: Turn, spare: &mut Vec<T>, draw: impl FnOnce(&mut [T])) {
        let BandArea { size: [width, _], stride, rows, .. } = self.area;
        let (width, is_kept) = (width as usize, self.kept.is_some());
        let room = self.kept.unwrap_or(spare);
        if !turn.is_first && turn.is_empty {
            return;
        }
        if turn.is_first {
            room.clear();
            room.resize(rows as usize * stride, self.far);
        } else if !is_kept {
            room.resize(rows as usize * stride, self.far);
            // SAFETY: the first round has written everything.
            let drawn = unsafe { written_part(self.out) };
            for (to, from) in room.chunks_exact_mut(stride).zip(drawn.chunks_exact(width)) {
                to[..width].copy_from_slice(from);
            }
        }
        draw(room);
        if !is_kept {
            put_out(room, stride, width, self.out);
        }
    }
}

/// Copies a band to its place in an image.
fn put_out<T: Copy>(room: &[T], stride: usize, width: usize, out: &mut [MaybeUninit<T>]) {
    for (from, to) in room.chunks_exact(stride).zip(out.chunks_exact_mut(width)) {
        copied(to, &from[..width]);
    }
}
