//! The shadow mask: each pixel of a G-buffer looked up in the map that holds it.
//!
//! Which map that is depends on no map's content, so it is settled first; then the maps are drawn one after the other into
//! the same memory, and only those that some pixel asks. One map is looked up as its pixels are settled, row by row. A row is
//! taken in runs of receivers, which a map answers at once where it can.

use std::mem::MaybeUninit;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::blending::Next;
use super::lookup::Lookups;
use super::run_light::FEW;
use super::runs::Compared;
use crate::aliasing::receivers::{RUN, Receivers, Shown};
use crate::error::{Error, Result};
use crate::image::{ShadowMask, Surfaces};
use crate::memory::{unwritten, written, written_part};
use crate::parameterization::{Held, Parameterization};
use crate::progress::Progress;
use crate::render::MaskSettings;
use crate::scene::{Camera, Light};

/// A row that is yet to be written.
type RowOut<'a, T> = &'a mut [MaybeUninit<T>];

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
    MaskInput { surfaces, camera, light, lookups, progress }.mask_of(Given { maps, texels })
}

/// Where maps come from, one after the other.
trait Maps {
    /// All of the map with an index.
    fn get(&mut self, k: usize) -> Result<&[f32]>;
}

/// Maps that are there, layer after layer.
struct Given<'a> {
    maps: &'a [f32],
    texels: usize,
}

impl Maps for Given<'_> {
    fn get(&mut self, k: usize) -> Result<&[f32]> {
        Ok(&self.maps[k * self.texels..(k + 1) * self.texels])
    }
}

/// Maps that are drawn into the same memory.
struct Drawn<F> {
    draw: F,
    map: Vec<MaybeUninit<f32>>,
}

impl<F: FnMut(usize, &mut [MaybeUninit<f32>]) -> Result<()>> Maps for Drawn<F> {
    fn get(&mut self, k: usize) -> Result<&[f32]> {
        (self.draw)(k, &mut self.map)?;
        // SAFETY: the map has been drawn; `MaybeUninit<f32>` has the layout of f32.
        Ok(unsafe { std::slice::from_raw_parts(self.map.as_ptr().cast(), self.map.len()) })
    }
}

impl MaskInput<'_> {
    /// The light that arrives at each pixel; `draw` writes all of the map with an index.
    pub fn mask(&self, draw: impl FnMut(usize, &mut [MaybeUninit<f32>]) -> Result<()>) -> Result<ShadowMask> {
        self.mask_of(Drawn { draw, map: unwritten(self.lookups.texels())? })
    }

    fn mask_of(&self, mut maps: impl Maps) -> Result<ShadowMask> {
        let pixels = self.surfaces.triangle.len();
        let (mut data, mut partition) = (unwritten::<f32>(pixels)?, unwritten::<i16>(pixels)?);
        let is_single = self.lookups.count() == 1;
        let only = if is_single { maps.get(0)? } else { &[] };
        let asked: Vec<AtomicBool> = (0..self.lookups.count()).map(|_| AtomicBool::new(false)).collect();
        self.for_each_row(&mut data, &mut partition, |first, light, chosen| {
            if is_single {
                self.light_by_only_map(only, first, light, chosen);
            } else {
                self.settle(first, light, chosen, &asked);
            }
        })?;
        for k in (0..asked.len()).filter(|&k| asked[k].load(Ordering::Relaxed)) {
            let map = maps.get(k)?;
            self.for_each_row(&mut data, &mut partition, |first, light, chosen| {
                // SAFETY: the rows were written when they were settled.
                unsafe { self.look_up(k, map, first, written_part(light), written_part(chosen)) };
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

    /// Writes a row of light where there is one map, and which pixels ask it.
    fn light_by_only_map(&self, map: &[f32], first: usize, light: RowOut<f32>, chosen: RowOut<i16>) {
        let lookup = self.lookups.map(0);
        let (mut run, mut found, mut lit) = (Receivers::NONE, Compared::NONE, [1.0; RUN]);
        for x in (0..light.len()).step_by(RUN) {
            let count = RUN.min(light.len() - x);
            run.read(&self.surfaces, first + x, count);
            let shown = run.shown(&self.surfaces, self.light, first + x, count);
            lookup.light_of_facing(map, &run, &shown, &mut found, &mut lit);
            for i in 0..count {
                let is_held = shown[i] == Shown::Facing && found.is_held[i];
                chosen[x + i].write(if is_held { 0 } else { ShadowMask::NO_MAP });
                light[x + i].write(if is_held { lit[i] } else { without_map(shown[i]) });
            }
        }
    }

    /// Writes a row of light as far as it needs no map, and the map that each pixel asks; what their maps give is added.
    fn settle(&self, first: usize, light: RowOut<f32>, chosen: RowOut<i16>, asked: &[AtomicBool]) {
        let mut run = Receivers::NONE;
        for x in (0..light.len()).step_by(RUN) {
            let count = RUN.min(light.len() - x);
            run.read(&self.surfaces, first + x, count);
            let shown = run.shown(&self.surfaces, self.light, first + x, count);
            let maps = self.maps_of(&run, &shown);
            let mut last = ShadowMask::NO_MAP;
            for i in 0..count {
                let is_held = maps[i] != ShadowMask::NO_MAP;
                light[x + i].write(if is_held { 0.0 } else { without_map(shown[i]) });
                chosen[x + i].write(maps[i]);
                // Neighbours mostly ask the same map.
                if is_held && maps[i] != last {
                    asked[maps[i] as usize].store(true, Ordering::Relaxed);
                    last = maps[i];
                }
                if is_held && let Some(next) = self.next(first + x + i, maps[i] as usize) {
                    asked[next.map].store(true, Ordering::Relaxed);
                }
            }
        }
    }

    /// The map that each receiver of a run asks: [`Lookups::choose`].
    pub(super) fn maps_of(&self, run: &Receivers, shown: &[Shown; RUN]) -> [i16; RUN] {
        let (mut chosen, mut held) = ([ShadowMask::NO_MAP; RUN], [Held::Outside; RUN]);
        // From which map on each receiver looks, of those that have not found theirs; no map for the others.
        let none = self.lookups.count();
        let mut from = [none; RUN];
        for i in (0..RUN).filter(|&i| shown[i] == Shown::Facing) {
            from[i] = self.lookups.p.first_map(self.camera.depth_of(self.surfaces.origin + run.point(i)));
        }
        let mut k = from.into_iter().min().unwrap_or(none);
        while k < none {
            self.lookups.map(k).holds_run(run, &mut held);
            let mut next = none;
            for i in 0..RUN {
                if from[i] <= k {
                    from[i] = k + 1;
                    match held[i] {
                        Held::Within => (chosen[i], from[i]) = (k as i16, none),
                        Held::Beyond if chosen[i] == ShadowMask::NO_MAP => chosen[i] = k as i16,
                        Held::Beyond | Held::Outside => {}
                    }
                }
                next = next.min(from[i]);
            }
            k = next;
        }
        chosen
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
    fn look_up(&self, k: usize, map: &[f32], first: usize, light: &mut [f32], chosen: &[i16]) {
        let lookup = self.lookups.map(k);
        let (mut run, mut found, mut lit) = (Receivers::NONE, Compared::NONE, [1.0; RUN]);
        for (x, (light, chosen)) in (0..).step_by(RUN).zip(light.chunks_mut(RUN).zip(chosen.chunks(RUN))) {
            let mut shares = [0.0; RUN];
            for (i, (share, chosen)) in shares.iter_mut().zip(chosen).enumerate() {
                *share = match usize::try_from(*chosen) {
                    Ok(chosen) if self.lookups.blend != 0.0 => self.share(first + x + i, chosen, k),
                    Ok(chosen) => f32::from(u8::from(chosen == k)),
                    Err(_) => 0.0,
                };
            }
            let count = shares.iter().filter(|share| **share > 0.0).count();
            if count == 0 {
                continue;
            }
            run.read(&self.surfaces, first + x, light.len());
            if lookup.is_common() && count >= FEW {
                lookup.compare_run(&run, &mut found);
                lookup.light_of_run(map, &found, &mut lit);
            } else {
                for i in (0..light.len()).filter(|&i| shares[i] > 0.0) {
                    lit[i] = lookup.light(map, run.point(i), run.normal(i));
                }
            }
            for (i, light) in light.iter_mut().enumerate() {
                if shares[i] > 0.0 {
                    *light += shares[i] * lit[i];
                }
            }
        }
    }
}

/// The light of a pixel that asks no map: none to speak of where it shows nothing, all of it where no map holds the receiver.
fn without_map(shown: Shown) -> f32 {
    match shown {
        Shown::Nothing => f32::NAN,
        Shown::Averted => 0.0,
        Shown::Facing => 1.0,
    }
}
