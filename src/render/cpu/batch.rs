//! From a scene to projected vertices and binned triangles, a bounded batch at a time.

use std::ops::Range;

use glam::DMat4;
use rayon::prelude::*;

use super::binning::{Bands, Bins, Draw, fill};
use super::screen::{OUTSIDE, ScreenVertex, Viewport, clip_position, project_all, single_precision};
use crate::error::{Error, Result};
use crate::progress::Progress;
use crate::scene::Scene;

/// Vertices and triangles after which a batch ends. Its vertices take 16 bytes each, 16 MB. One instance is never split, so
/// a mesh beyond this size is a batch of its own.
const BATCH: usize = 1 << 20;
/// Triangles that one thread bins at once: what it writes stays in a level-2 cache.
const CHUNK: u32 = 1 << 12;
/// Chunks that are binned before the bands are drawn: enough for many threads, while what they leave, up to 120 bytes a
/// triangle where all are tiny, stays below 32 MB whatever the scene.
const ROUND: u32 = 64;
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
        self.chunks = 0;
    }
}

/// The visible instances of a scene in the order of submission, cut into batches.
pub struct Batches<'a> {
    draws: Vec<Draw<'a>>,
    /// Where each batch ends in `draws`.
    ends: Vec<usize>,
}

impl<'a> Batches<'a> {
    /// The instances whose boxes are not outside one plane of the clip volume.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a scene whose triangles cannot be numbered in 32 bits.
    pub fn new(scene: &'a Scene, clip_from_world: &DMat4) -> Result<Self> {
        if scene.triangle_count() >= u64::from(u32::MAX) {
            return Err(Error::argument(
                "scene",
                format!("fewer than {} triangles, instances counted each time", u32::MAX),
                scene.triangle_count(),
                "split the scene",
            ));
        }
        let visible: Vec<Option<[[f32; 4]; 4]>> = (0..scene.instances().len())
            .into_par_iter()
            .map(|i| {
                let clip_from_local = single_precision(&scene.clip_from_local(clip_from_world, i));
                let corners = scene.mesh_of(i).bounds_local().corners();
                let outside =
                    corners.iter().fold(OUTSIDE, |all, p| all & outcode(clip_position(&clip_from_local, p.as_vec3())));
                (outside == 0).then_some(clip_from_local)
            })
            .collect();
        let (mut draws, mut ends) = (Vec::new(), Vec::new());
        let (mut first_id, mut vertices, mut triangles) = (0u32, 0usize, 0usize);
        for (i, visible) in visible.into_iter().enumerate() {
            let mesh = scene.mesh_of(i);
            let (v, t) = (mesh.positions_local().len(), mesh.triangles().len());
            if let Some(clip_from_local) = visible {
                if vertices.max(triangles) > 0 && (vertices + v).max(triangles + t) > BATCH {
                    ends.push(draws.len());
                    (vertices, triangles) = (0, 0);
                }
                draws.push(Draw {
                    mesh,
                    clip_from_local,
                    first_vertex: vertices as u32,
                    first_triangle: triangles as u32,
                    first_id,
                });
                vertices += v;
                triangles += t;
            }
            first_id += t as u32;
        }
        if !draws.is_empty() {
            ends.push(draws.len());
        }
        Ok(Self { draws, ends })
    }

    /// Projects each batch and bins it round by round into `scratch`; calls `draw` after each round.
    pub fn for_each_round(
        &self,
        viewport: &Viewport,
        bands: Bands,
        scratch: &mut Scratch,
        progress: &Progress,
        mut draw: impl FnMut(&Scratch) -> Result<()>,
    ) -> Result<()> {
        let mut start = 0;
        for &end in &self.ends {
            let draws = &self.draws[start..end];
            start = end;
            let triangle_count = project(draws, viewport, scratch, progress)?;
            for first in (0..triangle_count).step_by((ROUND * CHUNK) as usize) {
                bin(draws, first..triangle_count.min(first + ROUND * CHUNK), viewport, bands, scratch, progress)?;
                draw(scratch)?;
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
            project_all(&draw.clip_from_local, viewport, positions, out);
            Ok(())
        })
    })?;
    Ok(triangle_count)
}

/// Bins triangles of a batch.
fn bin(
    draws: &[Draw],
    triangles: Range<u32>,
    viewport: &Viewport,
    bands: Bands,
    scratch: &mut Scratch,
    progress: &Progress,
) -> Result<()> {
    scratch.chunks = (triangles.end - triangles.start).div_ceil(CHUNK) as usize;
    if scratch.bins.len() < scratch.chunks {
        scratch.bins.resize_with(scratch.chunks, Bins::default);
    }
    let vertices = &scratch.vertices[..];
    scratch.bins[..scratch.chunks].par_iter_mut().enumerate().try_for_each(|(c, bins)| {
        progress.check()?;
        let first = triangles.start + c as u32 * CHUNK;
        fill(bins, draws, vertices, first..triangles.end.min(first + CHUNK), viewport, bands);
        Ok(())
    })
}

/// The planes of the clip volume a point is beyond.
fn outcode([x, y, z, w]: [f32; 4]) -> u32 {
    let beyond = [x < -w, x > w, y < -w, y > w, z < 0.0, z > w];
    beyond.iter().enumerate().map(|(bit, &b)| u32::from(b) << bit).sum()
}
