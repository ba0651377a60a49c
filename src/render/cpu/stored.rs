//! Maps as they are stored: the depths that a pass draws, turned texel by texel into those of a surface, a spacing and a format.
//!
//! Source: theory.md 13. The WGSL twin follows [`Encoder::value`].

use std::mem::MaybeUninit;

use glam::DMat4;
use rayon::prelude::*;

use super::faces::Faces;
use super::passes::{Pass, checked_matrix};
use super::scratches::Scratch;
use super::uneven_lattice::Lattice;
use crate::error::{Error, Result};
use crate::memory::{unwritten, written_part};
use crate::parameterization::{Partition, PostWarp};
use crate::progress::Progress;
use crate::render::stored::{Encoder, Format, Layers, Stored, StoredSurface, TexelRays};
use crate::render::{Keep, Volume};
use crate::scene::Scene;

/// One map of a scene.
pub struct StoredMap<'a> {
    pub scene: &'a Scene,
    pub partition: &'a Partition,
    pub size: [u32; 2],
    pub stored: Stored,
    pub keep: Keep<'a>,
}

impl StoredMap<'_> {
    /// Draws it into all of `map`, rows from the top.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a matrix that cannot be drawn with, and for what [`Encoder::new`] refuses.
    pub fn draw(&self, map: &mut [MaybeUninit<f32>], scratch: &mut Scratch, progress: &Progress) -> Result<()> {
        let Stored { surface, format, .. } = self.stored.checked()?;
        let clip_from_world = checked_matrix(&self.partition.shadow_clip_from_world)?;
        let (scene, size, post_warp, keep) = (self.scene, self.size, &self.partition.post_warp, self.keep);
        let lattice = self.lattice(&clip_from_world)?;
        let faces = if surface == StoredSurface::Back { Faces::Averted } else { Faces::All };
        let Scratch { raster, lattice: spare } = scratch;
        let mut pass = Pass { scene, clip_from_world, size, faces, keep, scratch: raster, progress };
        if self.stored.is_plain() {
            match lattice {
                None => pass.depth(map)?,
                Some(lattice) => lattice.depth(scene, faces, keep, map, spare, progress)?,
            }
            if format == Format::F32 {
                return Ok(());
            }
            return self.in_rows(map, progress, |_, row| row.iter_mut().for_each(|z| *z = format.quantise(*z)));
        }
        // Relative to the scene's origin: depths along the light keep their digits wherever the scene is.
        let clip_from_relative = clip_from_world * DMat4::from_translation(scene.origin());
        let encoder = Encoder::new(TexelRays::new(&clip_from_relative, post_warp, size)?, self.stored)?;
        if !surface.takes_two() {
            match lattice {
                None => pass.depth_to_far(map)?,
                Some(lattice) => lattice.depth_to_far(scene, faces, keep, map, spare, progress)?,
            }
            return self.in_rows(map, progress, |y, row| {
                for (x, z) in row.iter_mut().enumerate() {
                    let layers = Layers { first: 1.0 + f64::from(*z), second: 1.0 };
                    *z = format.quantise(encoder.texel(x, y, layers) as f32);
                }
            });
        }
        let mut second = unwritten::<f32>(map.len())?;
        match lattice {
            None => pass.layers_to_far(map, &mut second)?,
            Some(lattice) => lattice.layers_to_far(scene, keep, map, &mut second, spare, progress)?,
        }
        // SAFETY: all of it has been drawn.
        let second = unsafe { &*written_part(&mut second) };
        let width = size[0] as usize;
        self.in_rows(map, progress, |y, row| {
            for (x, (z, second)) in row.iter_mut().zip(&second[y * width..]).enumerate() {
                let layers = Layers { first: 1.0 + f64::from(*z), second: 1.0 + f64::from(*second) };
                *z = format.quantise(encoder.texel(x, y, layers) as f32);
            }
        })
    }

    /// The lattice of an uneven map.
    fn lattice(&self, clip_from_world: &DMat4) -> Result<Option<Lattice>> {
        Ok(match &self.partition.post_warp {
            PostWarp::None => None,
            PostWarp::Log { scale, offset } => Some(Lattice::logarithmic(clip_from_world, *scale, *offset, self.size)?),
            PostWarp::Rectilinear(warp) => Some(Lattice::rectilinear(clip_from_world, warp, self.size)),
        })
    }

    /// The volume that it is drawn from.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a matrix that cannot be drawn with.
    pub fn volume(&self) -> Result<Volume> {
        let clip_from_world = checked_matrix(&self.partition.shadow_clip_from_world)?;
        let even = Volume::of_clip(&clip_from_world, 0.0);
        Ok(self.lattice(&clip_from_world)?.map_or(even, |lattice| lattice.volume()))
    }

    /// Calls `work` with each row of a map that has been drawn.
    fn in_rows(
        &self,
        map: &mut [MaybeUninit<f32>],
        progress: &Progress,
        work: impl Fn(usize, &mut [f32]) + Sync,
    ) -> Result<()> {
        // SAFETY: as the callers, which are all in this file, see to.
        let map = unsafe { written_part(map) };
        map.par_chunks_mut(self.size[0] as usize).enumerate().try_for_each(|(y, row)| {
            progress.check()?;
            work(y, row);
            Ok::<_, Error>(())
        })
    }
}
