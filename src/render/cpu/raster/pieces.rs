//! The runs of triangles of a batch in the order in which they are drawn: nearest first, so that what lies behind them can be
//! left out (`cover`).
//!
//! Only slabs of depth are drawn one after the other, each of them as many triangles as a round takes. Within a slab triangles
//! keep their order, in which neighbours lie side by side: a full sort gained nothing more and scattered what is written.

use std::ops::Range;

use rayon::prelude::*;

use super::cover::{Cover, Footprint, Footprints, Grid, Hidden};
use super::drawn_mesh::Draw;
use super::vertices::Viewport;

/// Slabs that depth is divided into before they are gathered into rounds.
const SLABS: usize = 256;
/// Footprints that one thread finds at once: some 20 µs of work.
const FOOTPRINTS: usize = 1 << 9;

/// A run of triangles of a draw.
#[derive(Debug, Clone, Copy)]
pub struct Piece {
    /// Triangles of the batch before it.
    pub start: u32,
    /// The draw's place in the batch.
    pub draw: u32,
    /// Its first triangle, in the order of the draw.
    pub first: u32,
    pub count: u32,
    pub footprint: Footprint,
    /// What becomes of it behind what is drawn already.
    pub hidden: Hidden,
}

/// What is drawn of a batch.
#[derive(Debug, Default)]
pub struct Pieces {
    list: Vec<Piece>,
    /// Triangles of all of them.
    pub triangles: u32,
}

impl Pieces {
    /// In the order of the draws.
    pub fn new(draws: &[Draw]) -> Self {
        let mut all = Self::default();
        for (draw, i) in draws.iter().zip(0..) {
            for Range { start: first, end } in draw.kept.pieces() {
                let (start, count) = (all.triangles, end - first);
                let (footprint, hidden) = (Footprint::default(), Hidden::None);
                all.list.push(Piece { start, draw: i, first, count, footprint, hidden });
                all.triangles += count;
            }
        }
        all
    }

    /// Slab by slab of at least so many triangles, with the footprints of all pieces.
    pub fn order(&mut self, draws: &[Draw], viewport: &Viewport, grid: Grid, slab: u32) {
        let of_draw: Vec<Footprints> = draws.iter().map(|draw| Footprints::new(draw, viewport, grid)).collect();
        self.list.par_iter_mut().with_min_len(FOOTPRINTS).for_each(|piece| {
            let [min, max] = draws[piece.draw as usize].kept.bounds(piece.first);
            piece.footprint = of_draw[piece.draw as usize].of(min, max);
        });
        // Depths of what is in view are at most 1 apart; what is unknown or beyond comes first or last.
        let slab_of = |piece: &Piece| {
            let from_near = piece.footprint.nearest - viewport.near;
            // Casts saturate.
            ((from_near * SLABS as f32) as usize).min(SLABS - 1)
        };
        let (mut counts, mut pieces) = ([0; SLABS], [0; SLABS]);
        for piece in &self.list {
            counts[slab_of(piece)] += piece.count;
            pieces[slab_of(piece)] += 1;
        }
        // Slabs whose first triangles fall into the same round are one: their pieces lie behind those of all rounds before.
        let (mut before, mut round, mut places, mut last) = (0, [0; SLABS], Vec::new(), None);
        let mut placed = 0;
        for s in 0..SLABS {
            if last != Some(before / slab) {
                last = Some(before / slab);
                places.push(placed);
            }
            round[s] = places.len() - 1;
            before += counts[s];
            placed += pieces[s];
        }
        // In their order within a round.
        let unsorted = self.list.clone();
        for piece in unsorted {
            let place = &mut places[round[slab_of(&piece)]];
            self.list[*place] = piece;
            *place += 1;
        }
        let mut start = 0;
        for piece in &mut self.list {
            piece.start = start;
            start += piece.count;
        }
    }

    /// The pieces of some triangles.
    pub fn of(&self, triangles: &Range<u32>) -> &[Piece] {
        &self.list[self.places(triangles)]
    }

    /// Looks which pieces of some triangles lie behind what is drawn.
    pub fn hide(&mut self, triangles: &Range<u32>, cover: &Cover) {
        let places = self.places(triangles);
        self.list[places].par_iter_mut().with_min_len(FOOTPRINTS).for_each(|piece| {
            piece.hidden = cover.of(&piece.footprint);
        });
    }

    fn places(&self, triangles: &Range<u32>) -> Range<usize> {
        if triangles.is_empty() { 0..0 } else { self.at(triangles.start)..self.at(triangles.end - 1) + 1 }
    }

    /// The place in the list of the piece that a triangle belongs to.
    pub fn at(&self, triangle: u32) -> usize {
        self.list.partition_point(|piece| piece.start <= triangle) - 1
    }
}

impl std::ops::Index<usize> for Pieces {
    type Output = Piece;
    fn index(&self, i: usize) -> &Piece {
        &self.list[i]
    }
}
