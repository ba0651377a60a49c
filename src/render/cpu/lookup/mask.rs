//! The shadow mask: each pixel of a G-buffer looked up in the map that holds it.
//!
//! Which map that is depends on no map's content, so it is settled first; then the maps are drawn one after the other into
//! the same memory, and only those that some pixel asks. One map is looked up as its pixels are settled, row by row.

use std::mem::MaybeUninit;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::blending::Next;
use super::lookup::Lookups;
use crate::error::{Error, Result};
use crate::image::{ShadowMask, Surfaces};
use crate::memory::{copied, unwritten, written, written_part};
use crate::parameterization::Parameterization;
use crate::progress::Progress;
use crate::render::MaskSettings;
use crate::scene::{Camera, Light};

/// What a mask is made of.
pub struct MaskInput<'a> {
    pub surfaces: Surfaces<'a>,
    pub camera: &'a Camera,
    pub light: &'a Light,
    pub lookups: &'a Lookups<'a>,
    pub progress: &'a Progress,
}

/// The light that arrives at the surfaces through maps that are there, layer after layer; `camera` tells by its depth which map
/// a receiver asks, and may be another than the one that sees the surfaces. `settings.size` is that of the camera's whole picture,
/// of which the surfaces may be a part.
///
/// # Errors
/// [`Error::InvalidArgument`] for maps of another number or size than `p` and `settings` say, no pixels, and as
/// [`Lookups::new`].
pub fn look_up(
    maps: &[f32],
    surfaces: Surfaces,
    camera: &Camera,
    light: &Light,
    p: &Parameterization,
    settings: &MaskSettings,
    progress: &Progress,
) -> Result<ShadowMask> {
    let lookups = &Lookups::new(p, camera, light, surfaces.origin, settings)?;
    let texels = lookups.texels();
    if p.partitions.is_empty() || maps.len() != texels * lookups.count() {
        let [w, h] = settings.resolution;
        let expected = format!("{} maps of {w} x {h} texels", lookups.count().max(1));
        return Err(Error::argument("maps", expected, format!("{} values", maps.len()), "render them with these maps"));
    }
    MaskInput { surfaces, camera, light, lookups, progress }.mask(|k, into| {
        copied(into, &maps[k * texels..(k + 1) * texels]);
        Ok(())
    })
}

impl MaskInput<'_> {
    /// The light that arrives at each pixel; `draw` writes all of the map with an index.
    pub fn mask(&self, mut draw: impl FnMut(usize, &mut [MaybeUninit<f32>]) -> Result<()>) -> Result<ShadowMask> {
        let pixels = self.surfaces.triangle.len();
        let mut map = unwritten::<f32>(self.lookups.texels())?;
        let (mut data, mut partition) = (unwritten::<f32>(pixels)?, unwritten::<i16>(pixels)?);
        let is_single = self.lookups.count() == 1;
        if is_single {
            draw(0, &mut map)?;
        }
        let asked: Vec<AtomicBool> = (0..self.lookups.count()).map(|_| AtomicBool::new(false)).collect();
        self.for_each_row(&mut data, &mut partition, |first, light, chosen| {
            for (x, (light, chosen)) in light.iter_mut().zip(chosen.iter_mut()).enumerate() {
                let (settled, map) = self.settle(first + x);
                light.write(settled);
                chosen.write(map.map_or(ShadowMask::NO_MAP, |k| k as i16));
                if let Some(k) = map.filter(|_| !is_single) {
                    asked[k].store(true, Ordering::Relaxed);
                    if let Some(next) = self.next(first + x, k) {
                        asked[next.map].store(true, Ordering::Relaxed);
                    }
                }
            }
            if is_single {
                // SAFETY: the map has been drawn, the row written above.
                unsafe { self.look_up(0, written_map(&map), first, light, chosen) };
            }
        })?;
        for k in (0..asked.len()).filter(|&k| asked[k].load(Ordering::Relaxed)) {
            draw(k, &mut map)?;
            self.for_each_row(&mut data, &mut partition, |first, light, chosen| {
                // SAFETY: the map has been drawn, the rows written when they were settled.
                unsafe { self.look_up(k, written_map(&map), first, light, chosen) };
            })?;
        }
        // SAFETY: every row has been written, or the error has been returned.
        let (data, partition) = unsafe { (written(data), written(partition)) };
        Ok(ShadowMask { size: self.surfaces.size, data, partition })
    }

    /// Calls `work` with each row: the index of its first pixel, its light and its maps.
    fn for_each_row(
        &self,
        data: &mut [MaybeUninit<f32>],
        partition: &mut [MaybeUninit<i16>],
        work: impl Fn(usize, &mut [MaybeUninit<f32>], &mut [MaybeUninit<i16>]) + Sync,
    ) -> Result<()> {
        let width = self.surfaces.size[0] as usize;
        let rows = data.par_chunks_mut(width).zip(partition.par_chunks_mut(width)).enumerate();
        rows.try_for_each(|(y, (light, chosen))| {
            self.progress.check()?;
            work(y * width, light, chosen);
            Ok(())
        })
    }

    /// The light at a pixel as far as it needs no map, and the map it needs.
    pub(super) fn settle(&self, pixel: usize) -> (f32, Option<usize>) {
        let Some((p_relative, normal)) = self.surfaces.receiver(pixel) else { return (f32::NAN, None) };
        let p_world = self.surfaces.origin + p_relative;
        if !self.light.illuminates(p_world, normal) {
            return (0.0, None);
        }
        // What its maps give is added.
        let map = self.lookups.choose(p_relative, self.camera.depth_of(p_world));
        (if map.is_some() { 0.0 } else { 1.0 }, map)
    }

    /// The map whose light is mixed into that of map `k` at a pixel.
    pub(super) fn next(&self, pixel: usize, k: usize) -> Option<Next> {
        if self.lookups.blend == 0.0 {
            return None;
        }
        let (p_relative, _) = self.surfaces.receiver(pixel)?;
        self.lookups.next(k, p_relative, self.camera.depth_of(self.surfaces.origin + p_relative))
    }

    /// The share that map `k` has in the light of a pixel which asks map `chosen`.
    fn share(&self, pixel: usize, chosen: usize, k: usize) -> f32 {
        // Both shares are those of single precision, so that they sum to 1.
        match self.next(pixel, chosen) {
            None => f32::from(u8::from(chosen == k)),
            Some(Next { map, share }) if map == k => share as f32,
            Some(Next { share, .. }) if chosen == k => 1.0 - share as f32,
            Some(_) => 0.0,
        }
    }

    /// Adds the light of map `k` to the pixels of a row that ask it, or into which it is mixed.
    ///
    /// # Safety
    /// The row has been written.
    unsafe fn look_up(
        &self,
        k: usize,
        map: &[f32],
        first: usize,
        light: &mut [MaybeUninit<f32>],
        chosen: &mut [MaybeUninit<i16>],
    ) {
        // SAFETY: as the caller promises.
        let (light, chosen) = unsafe { (written_part(light), written_part(chosen)) };
        for (x, (light, &mut chosen)) in light.iter_mut().zip(chosen).enumerate() {
            let Ok(chosen) = usize::try_from(chosen) else { continue };
            let share = self.share(first + x, chosen, k);
            if share > 0.0
                && let Some((p_relative, normal)) = self.surfaces.receiver(first + x)
            {
                *light += share * self.lookups.map(k).light(map, p_relative, normal);
            }
        }
    }
}

/// A map that has been drawn.
///
/// # Safety
/// All of it has been written.
unsafe fn written_map(map: &[MaybeUninit<f32>]) -> &[f32] {
    // SAFETY: as the caller promises; `MaybeUninit<f32>` has the layout of f32.
    unsafe { std::slice::from_raw_parts(map.as_ptr().cast(), map.len()) }
}
