//! Which vertices of a batch are projected: block by block, those of the triangles that a round bins and no others, right before
//! it does, so that they are in the cache.

use std::ops::Range;

use rayon::prelude::*;

use super::cover::Hidden;
use super::drawn_mesh::Draw;
use super::pieces::Piece;
use super::vertices::{ScreenVertex, Viewport};
use crate::error::Result;
use crate::progress::Progress;
use crate::render::cpu::kept::{RUN, vertices_of};
use crate::simd::prefetch;

/// The blocks of a batch's vertices, a word for each run of a draw.
#[derive(Debug)]
pub struct Projected {
    /// Where the words of each draw begin, and behind the last where they end.
    starts: Vec<usize>,
    /// Those that are projected.
    done: Vec<u64>,
    /// Those that are to be.
    needed: Vec<u64>,
    /// The draws that have such.
    of_draws: Range<usize>,
}

impl Projected {
    /// None of a batch's, for which there is room afterwards.
    pub fn new(draws: &[Draw], vertices: &mut Vec<ScreenVertex>) -> Self {
        let (mut starts, mut words, mut count) = (Vec::with_capacity(draws.len() + 1), 0, 0);
        for draw in draws {
            starts.push(words);
            words += draw.kept.vertex_runs();
            count += draw.kept.positions.len();
        }
        starts.push(words);
        if vertices.len() < count {
            vertices.resize(count, ScreenVertex::default());
        }
        Self { starts, done: vec![0; words], needed: vec![0; words], of_draws: 0..0 }
    }

    /// The vertices of some pieces are to be projected, but of those that are hidden.
    pub fn need(&mut self, draws: &[Draw], pieces: &[Piece]) {
        for piece in pieces.iter().filter(|piece| piece.hidden != Hidden::All) {
            let draw = piece.draw as usize;
            draws[draw].kept.need(piece.first, &mut self.needed[self.starts[draw]..self.starts[draw + 1]]);
            let Range { start, end } = self.of_draws;
            self.of_draws = if start < end { start.min(draw)..end.max(draw + 1) } else { draw..draw + 1 };
        }
    }

    /// Projects what is needed and is not projected yet.
    ///
    /// # Errors
    /// Where the caller wants it to stop.
    pub fn project(
        &mut self,
        draws: &[Draw],
        viewport: &Viewport,
        vertices: &mut [ScreenVertex],
        progress: &Progress,
    ) -> Result<()> {
        let some = std::mem::take(&mut self.of_draws);
        let Some(first) = draws[some.clone()].first() else { return Ok(()) };
        let mut rest = &mut vertices[first.first_vertex as usize..];
        let mut work = Vec::new();
        for d in some {
            let draw = &draws[d];
            let (own, after) = rest.split_at_mut(draw.kept.positions.len());
            rest = after;
            let words = self.starts[d]..self.starts[d + 1];
            let bits = self.needed[words.clone()].iter_mut().zip(&mut self.done[words]);
            let runs = draw.kept.positions.chunks(RUN).zip(own.chunks_mut(RUN));
            for ((needed, done), (positions, out)) in bits.zip(runs) {
                let fresh = std::mem::take(needed) & !*done;
                *done |= fresh;
                if fresh != 0 {
                    work.push((draw, fresh, positions, out));
                }
            }
        }
        work.into_par_iter().try_for_each(|(draw, fresh, positions, out)| {
            progress.check()?;
            let mut ranges = vertices_of(fresh, out.len()).peekable();
            while let Some(vertices) = ranges.next() {
                if let Some(next) = ranges.peek() {
                    prefetch(&positions[next.clone()]);
                    prefetch(&out[next.clone()]);
                }
                draw.projection.project(viewport, &positions[vertices.clone()], &mut out[vertices]);
            }
            Ok(())
        })
    }
}
