//! The cause of every wrong pixel of an image: probes of the maps that were read, and rays where these leave it open.

use rayon::prelude::*;

use super::looker::Looker;
use super::rays::{LightRays, Receiver};
use super::{light, shadow};
use crate::aliasing::against_truth::code;
use crate::aliasing::causes::{Probe, cause, cause_of_shadow};
use crate::aliasing::texel::Eye;
use crate::error::{Error, Result};
use crate::image::{Surfaces, TruthMask};
use crate::parameterization::Parameterization;
use crate::progress::Progress;
use crate::render::MaskSettings;
use crate::render::cpu::lookup::Lookups;
use crate::scene::{Camera, Light, Scene};
use crate::trace::Tracer;

/// Pixels between two looks at whether to stop: about a millisecond of work.
const AT_ONCE: usize = 512;

/// What an image is wrong in, and what it was made of.
#[derive(Debug, Clone, Copy)]
pub struct Wrong<'a> {
    /// What rays are traced in.
    pub scene: &'a Scene,
    /// The same, ready for rays.
    pub tracer: &'a Tracer,
    /// What the camera sees.
    pub surfaces: Surfaces<'a>,
    /// The camera.
    pub camera: &'a Camera,
    /// The light.
    pub light: &'a Light,
    /// The maps, layer after layer, as they were read.
    pub maps: &'a [f32],
    /// What the maps are.
    pub parameterization: &'a Parameterization,
    /// How they were read.
    pub settings: &'a MaskSettings,
    /// Of each pixel one of [`code`].
    pub differences: &'a [i8],
}

/// The cause of each pixel (one of [`cause`]), and how far a displaced edge lies from it, pixels; NaN where none is.
///
/// Triangles of the surfaces are numbered by the rows of the face arrays that their meshes were made from.
///
/// # Errors
/// As [`Lookups::new`], and [`Error::Interrupted`].
pub fn causes(of: &Wrong, progress: &Progress) -> Result<(Vec<i8>, Vec<f32>)> {
    let lookups = Lookups::new(of.parameterization, of.camera, of.light, of.surfaces.origin, of.settings)?;
    let rays = LightRays::new(of.scene, of.light, &lookups, of.surfaces.origin);
    let eye = Eye::new(of.camera, of.surfaces.origin, of.settings.size);
    // Most parts of a picture are right all over.
    let parts = of
        .differences
        .par_chunks(AT_ONCE)
        .enumerate()
        .filter(|(_, part)| part.iter().fold(0, |most, d| most.max(*d)) > 0);
    let wrong = parts.flat_map_iter(|(k, part)| (k * AT_ONCE..).zip(part).filter(|(_, d)| **d > 0).map(|(i, _)| i));
    let mut wrong: Vec<Place> = wrong.map(|i| of.place(i, &lookups)).collect();
    // Pixels of a texel after one another: what is seen for one of them tells of the next.
    wrong.par_sort_unstable();
    let mut found = vec![(cause::NONE, f64::NAN); wrong.len()];
    progress.set_total(wrong.len() as u64);
    found.par_chunks_mut(AT_ONCE).zip(wrong.par_chunks(AT_ONCE)).try_for_each(|(found, pixels)| {
        progress.check()?;
        let mut looker = Looker::new(&rays, of.tracer);
        for (found, place) in found.iter_mut().zip(pixels) {
            *found = of.explain(place, &mut looker, &eye);
        }
        progress.advance(pixels.len() as u64);
        Ok::<_, Error>(())
    })?;
    let mut causes: Vec<i8> = of.differences.iter().map(|&d| d.min(cause::NONE)).collect();
    let mut distance = vec![f32::NAN; causes.len()];
    for (place, (cause, moved)) in wrong.iter().zip(found) {
        (causes[place.pixel], distance[place.pixel]) = (cause, moved as f32);
    }
    Ok((causes, distance))
}

/// Where a pixel lies in the maps: the map and the row and column of the texel; those that no map holds first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    map: Option<usize>,
    texel: [i32; 2],
    pixel: usize,
}

impl Wrong<'_> {
    fn texels(&self, map: usize, lookups: &Lookups) -> &[f32] {
        let n = lookups.texels();
        &self.maps[map * n..(map + 1) * n]
    }

    fn place(&self, pixel: usize, lookups: &Lookups) -> Place {
        let nowhere = Place { map: None, texel: [0; 2], pixel };
        let Some((p, normal)) = self.surfaces.receiver(pixel) else { return nowhere };
        let eye_depth = self.camera.depth_of(self.surfaces.origin + p);
        let Some(chosen) = lookups.choose(p, eye_depth) else { return nowhere };
        // Where two maps blend, the chosen one unless it is right alone.
        let is_wrong_in = |map: usize| {
            let light = lookups.map(map).light(self.texels(map, lookups), p, normal);
            (TruthMask::of_light(light) == TruthMask::LIT) == (self.differences[pixel] == code::FALSE_LIGHT)
        };
        let map = match lookups.next(chosen, p, eye_depth) {
            Some(next) if !is_wrong_in(chosen) => next.map,
            _ => chosen,
        };
        let place = lookups.map(map).place_of(p).unwrap_or_default().floor();
        Place { map: Some(map), texel: [place.y as i32, place.x as i32], pixel }
    }

    /// The cause of a wrong pixel, and how far its edge lies.
    fn explain(&self, place: &Place, looker: &mut Looker, eye: &Eye) -> (i8, f64) {
        let (surfaces, lookups, pixel) = (&self.surfaces, looker.rays.lookups, place.pixel);
        let is_light = self.differences[pixel] == code::FALSE_LIGHT;
        let nowhere = (if is_light { cause::MISSING } else { cause_of_shadow(&[]) }, f64::NAN);
        let (Some((p, normal)), Some(map)) = (surfaces.receiver(pixel), place.map) else { return nowhere };
        let texels = self.texels(map, lookups);
        let probe = lookups.map(map).probe(texels, p, normal, false);
        let face = (surfaces.instance[pixel], surfaces.triangle[pixel]);
        let &Probe { place, texel, slope, touch, grain, .. } = &probe;
        let receiver = Receiver { map, p, normal, place, texel, slope, touch, grain, face };
        if is_light {
            let around = || lookups.map(map).probe(texels, p, normal, true);
            light::explain(&probe, around, &receiver, looker, eye)
        } else {
            shadow::explain(&probe, &receiver, looker, eye)
        }
    }
}
