//! From a scene to projected vertices and binned triangles, a bounded batch at a time.

use std::ops::Range;

use glam::DMat4;
use rayon::prelude::*;

use super::binning::{Binning, Draw, fill};
use super::bins::{Bands, Bins};
use super::vertices::{Projection, ScreenVertex, Viewport};
use crate::error::{Error, Result};
use crate::progress::Progress;
use crate::render::cpu::faces::{FaceTest, Faces};
use crate::render::cpu::kept::Kept;
use crate::render::{Keep, Volume};
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
/// Matrices that one thread forms at once: some 50 µs of work.
const MATRICES: usize = 1 << 8;

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

/// The instances of a scene that are drawn, cut into batches; after those without an alpha test those with one.
pub struct Batches<'a> {
    scene: &'a Scene,
    clip_from_world: DMat4,
    faces: Faces,
    volume: Volume,
    /// Without alpha tests, and with them in ascending order.
    instances: [Vec<u32>; 2],
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
    /// The instances that `keep` takes.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a scene whose triangles cannot be numbered in 32 bits.
    pub fn new(
        scene: &'a Scene,
        clip_from_world: &DMat4,
        viewport: &Viewport,
        faces: Faces,
        keep: Keep,
    ) -> Result<Self> {
        if scene.triangle_count() >= u64::from(u32::MAX) {
            return Err(Error::argument(
                "scene",
                format!("fewer than {} triangles, instances counted each time", u32::MAX),
                scene.triangle_count(),
                "split the scene",
            ));
        }
        let volume = Volume::of_clip(clip_from_world, f64::from(viewport.near));
        let [plain, mut tested] = by_test(scene, keep.instances(scene, &volume));
        // Their triangles are found by number (tested.rs); the hierarchy has an order of its own.
        tested.sort_unstable();
        Ok(Self { scene, clip_from_world: *clip_from_world, faces, volume, instances: [plain, tested] })
    }

    /// Projects each batch and bins it round by round into `scratch`, with the numbers of triangles if fragments are to be
    /// `numbered`; calls `draw` after each round.
    pub fn for_each_round(
        &self,
        viewport: &Viewport,
        bands: Bands,
        numbered: bool,
        scratch: &mut Scratch,
        progress: &Progress,
        mut draw: impl FnMut(Round) -> Result<()>,
    ) -> Result<()> {
        let triangles = |i: &u32| self.scene.mesh_of(*i as usize).triangles().len() as u64;
        progress.set_total(self.instances.iter().flatten().map(triangles).sum());
        let count = |chunks: &[Range<u32>]| chunks.iter().map(|chunk| chunk.len() as u64).sum::<u64>();
        for (instances, is_tested) in self.instances.iter().zip([false, true]) {
            for batch in batches(self.scene, instances, BATCH) {
                let draws = &self.draws(batch);
                let triangle_count = project(draws, viewport, scratch, progress)?;
                // The next chunk last.
                let mut pending: Vec<Range<u32>> = (0..triangle_count)
                    .step_by(CHUNK as usize)
                    .map(|first| first..triangle_count.min(first + CHUNK))
                    .rev()
                    .collect();
                while !pending.is_empty() {
                    let before = count(&pending);
                    bin(draws, &mut pending, viewport, bands, numbered || is_tested, scratch, progress)?;
                    draw(Round { scratch, tested: is_tested.then_some(draws) })?;
                    progress.advance(before - count(&pending));
                }
            }
        }
        Ok(())
    }

    /// The draws of a batch.
    fn draws(&self, instances: &[u32]) -> Vec<Draw<'a>> {
        let scene = self.scene;
        let draw = |&i: &u32| {
            let mesh = scene.mesh_of(i as usize);
            let clip_from_local = scene.clip_from_local(&self.clip_from_world, i as usize);
            Draw {
                mesh,
                kept: Kept::new(mesh, &clip_from_local, &self.volume),
                projection: Projection::new(&clip_from_local, mesh.bounds_local()),
                faces: FaceTest::new(self.faces, &clip_from_local),
                first_vertex: 0,
                first_triangle: 0,
                // All numbers are below 2^32, see `new`.
                first_id: scene.first_triangles()[i as usize] as u32,
            }
        };
        let mut draws: Vec<Draw> = instances.par_iter().with_min_len(MATRICES).map(draw).collect();
        let (mut vertices, mut triangles) = (0, 0);
        for draw in &mut draws {
            (draw.first_vertex, draw.first_triangle) = (vertices, triangles);
            vertices += draw.kept.positions.len() as u32;
            triangles += draw.kept.triangles.len() as u32;
        }
        draws
    }
}

/// Instances without alpha tests, and with them, in the order in which they come.
pub fn by_test(scene: &Scene, instances: Vec<u32>) -> [Vec<u32>; 2] {
    if scene.meshes().iter().all(|mesh| mesh.alpha_test().is_none()) {
        return [instances, Vec::new()];
    }
    let is_tested = |i: &u32| scene.mesh_of(*i as usize).alpha_test().is_some();
    let (tested, plain) = instances.into_iter().partition(is_tested);
    [plain, tested]
}

/// Instances cut into batches of at most `most` vertices and triangles; one instance is never split.
pub fn batches<'a>(scene: &'a Scene, instances: &'a [u32], most: usize) -> impl Iterator<Item = &'a [u32]> {
    let mut rest = instances;
    std::iter::from_fn(move || {
        let (mut vertices, mut triangles) = (0, 0);
        let is_full = |&i: &u32| {
            let mesh = scene.mesh_of(i as usize);
            vertices += mesh.positions_local().len();
            triangles += mesh.triangles().len();
            vertices.max(triangles) > most
        };
        let len = rest.iter().position(is_full).map_or(rest.len(), |len| len.max(1));
        let (batch, after) = rest.split_at(len);
        rest = after;
        (!batch.is_empty()).then_some(batch)
    })
}

/// Projects the vertices of a batch; the number of its triangles.
fn project(draws: &[Draw], viewport: &Viewport, scratch: &mut Scratch, progress: &Progress) -> Result<u32> {
    let count = |d: &Draw| (d.kept.positions.len(), d.kept.triangles.len() as u32);
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
        let positions = draw.kept.positions.par_chunks(VERTICES);
        let needed = draw.kept.vertices(VERTICES);
        positions.zip(out.par_chunks_mut(VERTICES)).zip(needed).try_for_each(|((positions, out), needed)| {
            progress.check()?;
            if needed {
                draw.projection.project(viewport, positions, out);
            }
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
    numbered: bool,
    scratch: &mut Scratch,
    progress: &Progress,
) -> Result<()> {
    let mut round = pending.split_off(pending.len().saturating_sub(ROUND));
    scratch.chunks = round.len();
    if scratch.bins.len() < scratch.chunks {
        scratch.bins.resize_with(scratch.chunks, Bins::default);
    }
    let work = Binning { draws, vertices: &scratch.vertices, viewport, bands, numbered };
    scratch.bins[..scratch.chunks].par_iter_mut().zip(&mut round).try_for_each(|(bins, chunk)| {
        progress.check()?;
        chunk.start = fill(&work, bins, chunk.clone());
        Ok(())
    })?;
    pending.extend(round.into_iter().filter(|chunk| !chunk.is_empty()));
    Ok(())
}
