//! Depth maps of an uneven lattice: what is drawn goes batch by batch and round by round into bands.
//!
//! Departure from [`raster`](crate::render::cpu::raster): the one grid of 1/256 cannot be fine enough where rows are dense, so
//! places are f64 and edges are evaluated row by row ([`triangle`](super::triangle)).

use std::mem::MaybeUninit;

use glam::DVec4;
use rayon::prelude::*;

use super::batch::Batch;
use super::bins::Bins;
use super::fill::less_of;
use super::lattice::Lattice;
use super::vertex::EvenVertex;
use crate::error::Result;
use crate::progress::Progress;
use crate::render::cpu::faces::Faces;
use crate::render::cpu::raster::{
    BandArea, Bands, DepthPixels, LayerPixels, Pending, Pixels, ROUND, batches, by_test, fill_bins,
};
use crate::render::cpu::rooms::{Rooms, Turn};
use crate::render::{Keep, Volume};
use crate::scene::Scene;

/// Vertices or triangles after which a batch ends; its vertices take 16 MB. One instance is never split.
const BATCH: usize = 1 << 19;

/// Memory for one batch, kept from one call to the next: fresh pages cost more than the work on them.
#[derive(Debug, Default)]
pub struct Scratch {
    vertices: Vec<EvenVertex>,
    bins: Vec<Bins>,
}

impl Scratch {
    /// Gives back what only a mesh larger than a batch has needed, and what bins have beyond 32 MB.
    pub fn shrink(&mut self) {
        self.vertices.truncate(2 * BATCH);
        self.vertices.shrink_to(2 * BATCH);
        self.bins.iter_mut().for_each(|bins| bins.shrink(2));
    }
}

/// A part of what is drawn, projected and binned.
struct Round<'a> {
    batch: &'a Batch<'a>,
    vertices: &'a [EvenVertex],
    bins: &'a [Bins],
    is_first: bool,
}

impl Round<'_> {
    /// What is left to a band.
    fn turn(&self, band: usize) -> Turn {
        Turn { is_first: self.is_first, is_empty: self.bins.iter().all(|bins| bins.is_empty(band)) }
    }
    /// Draws it, or only a part where somebody has asked to stop.
    fn draw<P: Pixels>(&self, band: usize, area: BandArea, pixels: &mut P, progress: &Progress) {
        for bins in self.bins.iter().take_while(|_| progress.check().is_ok()) {
            self.batch.fill(bins, self.vertices, band, area, pixels);
        }
    }
}

impl Lattice {
    /// Draws depth, 1 where nothing is, into all of `depth` (rows from the top).
    pub fn depth(
        &self,
        scene: &Scene,
        faces: Faces,
        keep: Keep,
        depth: &mut [MaybeUninit<f32>],
        scratch: &mut Scratch,
        progress: &Progress,
    ) -> Result<()> {
        self.depth_from::<false>(scene, (faces, keep), depth, scratch, progress)
    }

    /// Draws depth minus 1, 0 where nothing is, into all of `depth`.
    pub fn depth_to_far(
        &self,
        scene: &Scene,
        faces: Faces,
        keep: Keep,
        depth: &mut [MaybeUninit<f32>],
        scratch: &mut Scratch,
        progress: &Progress,
    ) -> Result<()> {
        self.depth_from::<true>(scene, (faces, keep), depth, scratch, progress)
    }

    fn depth_from<const TO_FAR: bool>(
        &self,
        scene: &Scene,
        what: (Faces, Keep),
        depth: &mut [MaybeUninit<f32>],
        scratch: &mut Scratch,
        progress: &Progress,
    ) -> Result<()> {
        let (far, bands) = (DepthPixels::<TO_FAR>::FAR, Bands::new(self.size));
        let mut rooms = Rooms::new(self.size, far);
        self.for_each_round(scene, what, less_of::<DepthPixels<TO_FAR>>(), scratch, progress, |round| {
            rooms.parts(bands, depth).try_for_each_init(Vec::new, |spare, part| {
                let (band, area) = (part.band, part.area);
                part.draw(round.turn(band), spare, |depth| {
                    round.draw(band, area, &mut DepthPixels::<TO_FAR> { depth }, progress);
                });
                progress.check()
            })
        })?;
        rooms.finish(depth);
        Ok(())
    }

    /// The same for the two nearest depths that differ.
    pub fn layers_to_far(
        &self,
        scene: &Scene,
        keep: Keep,
        first: &mut [MaybeUninit<f32>],
        second: &mut [MaybeUninit<f32>],
        scratch: &mut Scratch,
        progress: &Progress,
    ) -> Result<()> {
        let (far, bands) = (LayerPixels::FAR, Bands::new(self.size));
        let (mut rooms, mut rooms_of_second) = (Rooms::new(self.size, far), Rooms::new(self.size, far));
        let (what, less) = ((Faces::All, keep), less_of::<LayerPixels>());
        self.for_each_round(scene, what, less, scratch, progress, |round| {
            let parts = rooms.parts(bands, first).zip(rooms_of_second.parts(bands, second));
            parts.try_for_each_init(Default::default, |spare: &mut [Vec<f32>; 2], (part, part_of_second)| {
                let (band, area, [spare, spare_of_second]) = (part.band, part.area, spare);
                part.draw(round.turn(band), spare, |first| {
                    part_of_second.draw(round.turn(band), spare_of_second, |second| {
                        round.draw(band, area, &mut LayerPixels { first, second }, progress);
                    });
                });
                progress.check()
            })
        })?;
        rooms.finish(first);
        rooms_of_second.finish(second);
        Ok(())
    }

    /// Calls `draw` with each round of triangles, binned; at least once. Depths that it keeps are `less` than those of the map.
    fn for_each_round(
        &self,
        scene: &Scene,
        (faces, keep): (Faces, Keep),
        less: f64,
        scratch: &mut Scratch,
        progress: &Progress,
        mut draw: impl FnMut(Round) -> Result<()>,
    ) -> Result<()> {
        // Those with alpha tests after all others, in batches of their own.
        let by_test = by_test(scene, keep.instances(scene, &self.volume()));
        let triangles = |i: &u32| scene.mesh_of(*i as usize).triangles().len() as u64;
        progress.set_total(by_test.iter().flatten().map(triangles).sum());
        let Scratch { vertices, bins } = scratch;
        let mut is_first = true;
        for (instances, is_tested) in by_test.iter().zip([false, true]) {
            for instances in batches(scene, instances, BATCH) {
                let batch = &Batch::new(self, scene, faces, instances, is_tested, less);
                let mut pending = Pending::new(batch.project(vertices, progress)?);
                let vertices = &vertices[..];
                while !pending.is_empty() {
                    let before = pending.triangles();
                    let mut round = pending.next_round(ROUND);
                    if bins.len() < round.len() {
                        bins.resize_with(round.len(), Bins::default);
                    }
                    let filled = &mut bins[..round.len()];
                    fill_bins(filled, &mut round, progress, |bins, chunk| batch.bin(bins, vertices, chunk))?;
                    pending.put_back(round);
                    draw(Round { batch, vertices, bins: filled, is_first })?;
                    progress.advance(before - pending.triangles());
                    is_first = false;
                }
            }
        }
        if is_first {
            // Nothing is in view.
            let batch = &Batch::new(self, scene, faces, &[], false, less);
            draw(Round { batch, vertices: &[], bins: &[], is_first })?;
        }
        Ok(())
    }

    /// Where the map has texels.
    pub fn volume(&self) -> Volume {
        let ([left, right], [top, bottom]) = (self.across, self.down);
        let (x, down, z, w) = (DVec4::X, DVec4::Y, DVec4::Z, DVec4::W);
        let planes = [x - left * w, right * w - x, down - top * w, bottom * w - down, z, w - z];
        Volume::new(&self.clip_from_world, planes)
    }
}
