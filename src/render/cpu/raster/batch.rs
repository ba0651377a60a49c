//! From a scene to projected vertices and binned triangles, a bounded batch at a time.

use std::ops::Range;

use glam::DMat4;
use rayon::prelude::*;

use super::binning::{Bands, Bins, Draw, fill};
use super::vertices::{OUTSIDE, Projection, ScreenVertex, Viewport};
use crate::error::{Error, Result};
use crate::progress::Progress;
use crate::render::cpu::faces::{FaceTest, Faces};
use crate::scene::Scene;

/// Vertices and triangles after which a batch ends. Its vertices take 16 bytes each, 16 MB. One instance is never split, so
/// a mesh beyond this size is a batch of its own.
const BATCH: usize = 1 << 20;
/// Triangles that one thread bins at once: what it writes stays in a level-2 cache.
const CHUNK: u32 = 1 << 12;
/// Chunks that are binned before the bands are drawn: enough for many threads. What they leave is bounded in bytes, chunk by
/// chunk ([`fill`]), so a round takes some MB whatever the scene.
const ROUND: usize = 64;
/// Vertices that are projected at once.
const VERTICES: usize = 1 << 12;

/// Memory for one batch, kept from one call to the next: fresh pages cost more than the work on them.
#[derive(Debug, Default)]
pub struct Scratch {
    pub vertices: Vec<ScreenVertex>,
    bins: Vec<Bins>,
    /// How many of the bins the present round fills.
    pub chunks: usize,
}

impl Scratch {
    /// The bins of the present round, in the order of submission.
    pub fn bins(&self) -> &[Bins] {
        &self.bins[..self.chunks]
    }
    /// Gives back what only a mesh larger than a batch has needed.
    pub fn shrink(&mut self) {
        self.vertices.truncate(2 * BATCH);
        self.vertices.shrink_to(2 * BATCH);
        self.bins.iter_mut().for_each(Bins::shrink);
        self.chunks = 0;
    }
}

/// The visible instances of a scene in the order of submission, cut into batches; after them those with an alpha test.
pub struct Batches<'a> {
    draws: Vec<Draw<'a>>,
    /// Where each batch ends in `draws`.
    ends: Vec<usize>,
    /// How many batches have no alpha test.
    plain: usize,
}

/// A part of what is drawn, projected and binned.
#[derive(Clone, Copy)]
pub struct Round<'a> {
    /// What it consists of.
    pub scratch: &'a Scratch,
    /// Its draws, where they have alpha tests.
    pub tested: Option<&'a [Draw<'a>]>,
}

impl<'a> Batches<'a> {
    /// The instances whose boxes are not outside one plane of the clip volume.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a scene whose triangles cannot be numbered in 32 bits.
    pub fn new(scene: &'a Scene, clip_from_world: &DMat4, viewport: &Viewport, faces: Faces) -> Result<Self> {
        if scene.triangle_count() >= u64::from(u32::MAX) {
            return Err(Error::argument(
                "scene",
                format!("fewer than {} triangles, instances counted each time", u32::MAX),
                scene.triangle_count(),
                "split the scene",
            ));
        }
        let visible: Vec<Option<(Projection, FaceTest)>> = (0..scene.instances().len())
            .into_par_iter()
            .map(|i| {
                let bounds = scene.mesh_of(i).bounds_local();
                let clip_from_local = scene.clip_from_local(clip_from_world, i);
                let projection = Projection::new(&clip_from_local, bounds);
                let outside =
                    bounds.corners().iter().fold(OUTSIDE, |all, &p| all & viewport.outcode(projection.clip(p)));
                (outside == 0).then(|| (projection, FaceTest::new(faces, &clip_from_local)))
            })
            .collect();
        let mut batches = Self { draws: Vec::new(), ends: Vec::new(), plain: 0 };
        let is_tested = |i: usize| scene.mesh_of(i).alpha_test().is_some();
        batches.add(scene, &visible, |i| !is_tested(i));
        batches.plain = batches.ends.len();
        batches.add(scene, &visible, is_tested);
        Ok(batches)
    }

    /// Adds the visible instances that are asked for.
    fn add(&mut self, scene: &'a Scene, visible: &[Option<(Projection, FaceTest)>], is_asked: impl Fn(usize) -> bool) {
        let (draws, ends) = (&mut self.draws, &mut self.ends);
        let begin = draws.len();
        let (mut first_id, mut vertices, mut triangles) = (0u32, 0usize, 0usize);
        for (i, visible) in visible.iter().enumerate() {
            let mesh = scene.mesh_of(i);
            let (v, t) = (mesh.positions_local().len(), mesh.triangles().len());
            if let Some((projection, faces)) = visible.filter(|_| is_asked(i)) {
                if vertices.max(triangles) > 0 && (vertices + v).max(triangles + t) > BATCH {
                    ends.push(draws.len());
                    (vertices, triangles) = (0, 0);
                }
                draws.push(Draw {
                    mesh,
                    projection,
                    faces,
                    first_vertex: vertices as u32,
                    first_triangle: triangles as u32,
                    first_id,
                });
                vertices += v;
                triangles += t;
            }
            first_id += t as u32;
        }
        if draws.len() > begin {
            ends.push(draws.len());
        }
    }

    /// Projects each batch and bins it round by round into `scratch`; calls `draw` after each round.
    pub fn for_each_round(
        &self,
        viewport: &Viewport,
        bands: Bands,
        scratch: &mut Scratch,
        progress: &Progress,
        mut draw: impl FnMut(Round) -> Result<()>,
    ) -> Result<()> {
        let mut start = 0;
        progress.set_total(self.draws.iter().map(|draw| draw.mesh.triangles().len() as u64).sum());
        for (batch, &end) in self.ends.iter().enumerate() {
            let draws = &self.draws[start..end];
            start = end;
            let triangle_count = project(draws, viewport, scratch, progress)?;
            // The next chunk last.
            let mut pending: Vec<Range<u32>> = (0..triangle_count)
                .step_by(CHUNK as usize)
                .map(|first| first..triangle_count.min(first + CHUNK))
                .rev()
                .collect();
            let count = |chunks: &[Range<u32>]| chunks.iter().map(|chunk| chunk.len() as u64).sum::<u64>();
            while !pending.is_empty() {
                let before = count(&pending);
                bin(draws, &mut pending, viewport, bands, scratch, progress)?;
                draw(Round { scratch, tested: (batch >= self.plain).then_some(draws) })?;
                progress.advance(before - count(&pending));
            }
        }
        Ok(())
    }
}

/// Projects the vertices of a batch; the number of its triangles.
fn project(draws: &[Draw], viewport: &Viewport, scratch: &mut Scratch, progress: &Progress) -> Result<u32> {
    let count = |d: &Draw| (d.mesh.positions_local().len(), d.mesh.triangles().len() as u32);
    let Some(last) = draws.last() else { return Ok(0) };
    let vertex_count = last.first_vertex as usize + count(last).0;
    let triangle_count = last.first_triangle + count(last).1;
    if scratch.vertices.len() < vertex_count {
        scratch.vertices.resize(vertex_count, ScreenVertex::default());
    }
    let mut rest = &mut scratch.vertices[..];
    let mut work = Vec::with_capacity(draws.len());
    for draw in draws {
        let (own, after) = rest.split_at_mut(count(draw).0);
        work.push((draw, own));
        rest = after;
    }
    work.into_par_iter().try_for_each(|(draw, out)| {
        let positions = draw.mesh.positions_local().par_chunks(VERTICES);
        positions.zip(out.par_chunks_mut(VERTICES)).try_for_each(|(positions, out)| {
            progress.check()?;
            draw.projection.project(viewport, positions, out);
            Ok(())
        })
    })?;
    Ok(triangle_count)
}

/// Bins a round of chunks of a batch; what has not found room in a chunk stays pending.
///
/// The order of triangles has no say in what is drawn: of equal depths the smaller number wins.
fn bin(
    draws: &[Draw],
    pending: &mut Vec<Range<u32>>,
    viewport: &Viewport,
    bands: Bands,
    scratch: &mut Scratch,
    progress: &Progress,
) -> Result<()> {
    let mut round = pending.split_off(pending.len().saturating_sub(ROUND));
    scratch.chunks = round.len();
    if scratch.bins.len() < scratch.chunks {
        scratch.bins.resize_with(scratch.chunks, Bins::default);
    }
    let vertices = &scratch.vertices[..];
    scratch.bins[..scratch.chunks].par_iter_mut().zip(&mut round).try_for_each(|(bins, chunk)| {
        progress.check()?;
        chunk.start = fill(bins, draws, vertices, chunk.clone(), viewport, bands);
        Ok(())
    })?;
    pending.extend(round.into_iter().filter(|chunk| !chunk.is_empty()));
    Ok(())
}
