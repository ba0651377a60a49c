//! The cause of every wrong pixel of an image: probes of the maps that were read, and rays where these leave it open.

use rayon::prelude::*;

use super::rays::{LightRays, Receiver};
use super::{light, shadow};
use crate::aliasing::against_truth::code;
use crate::aliasing::causes::{Probe, cause};
use crate::aliasing::texel::Eye;
use crate::error::{Error, Result};
use crate::image::Surfaces;
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
/// As [`Lookups::new`] and [`Tracer::first_hit`].
pub fn causes(of: &Wrong, progress: &Progress) -> Result<(Vec<i8>, Vec<f32>)> {
    let lookups = Lookups::new(of.parameterization, of.light, of.surfaces.origin, of.settings)?;
    let wrong: Vec<usize> = (0..of.differences.len()).filter(|&i| of.differences[i] > 0).collect();
    let mut probes = vec![(Probe::default(), Receiver::default()); wrong.len()];
    probes.par_chunks_mut(AT_ONCE).zip(wrong.par_chunks(AT_ONCE)).try_for_each(|(probes, pixels)| {
        progress.check()?;
        probes.iter_mut().zip(pixels).for_each(|(probe, &i)| *probe = of.probe(i, &lookups));
        Ok::<_, Error>(())
    })?;
    let rays = LightRays {
        scene: of.scene,
        tracer: of.tracer,
        light: of.light,
        lookups: &lookups,
        origin: of.surfaces.origin,
    };
    let eye = Eye::new(of.camera, of.surfaces.origin, of.surfaces.size);
    let mut causes: Vec<i8> = of.differences.iter().map(|&d| d.min(cause::NONE)).collect();
    let mut distance = vec![f32::NAN; causes.len()];
    for (error, explain) in [(code::FALSE_SHADOW, shadow::causes as Explain), (code::FALSE_LIGHT, light::causes)] {
        let pixels: Vec<usize> = (0..wrong.len()).filter(|&n| of.differences[wrong[n]] == error).collect();
        let probes: Vec<(&Probe, Receiver)> = pixels.iter().map(|&n| (&probes[n].0, probes[n].1)).collect();
        for (n, (cause, moved)) in pixels.into_iter().zip(explain(&probes, &rays, &eye, progress)?) {
            causes[wrong[n]] = cause;
            distance[wrong[n]] = moved as f32;
        }
    }
    Ok((causes, distance))
}

/// The causes of errors of one kind, and how far edges lie.
type Explain = fn(&[(&Probe, Receiver)], &LightRays, &Eye, &Progress) -> Result<Vec<(i8, f64)>>;

impl Wrong<'_> {
    /// What the map of a pixel holds, and the pixel's surface; defaults where no map does.
    fn probe(&self, pixel: usize, lookups: &Lookups) -> (Probe, Receiver) {
        let (surfaces, n) = (&self.surfaces, lookups.texels());
        let Some((p, normal)) = surfaces.receiver(pixel) else { return Default::default() };
        let receiver =
            Receiver { p, normal, face: (surfaces.instance[pixel], surfaces.triangle[pixel]), ..Receiver::default() };
        let depth = self.camera.depth_of(surfaces.origin + p);
        let Some(map) = lookups.choose(p, depth) else { return (Probe::default(), receiver) };
        let probe = lookups.map(map).probe(&self.maps[map * n..(map + 1) * n], p, normal);
        let Probe { place, texel, slope, touch, grain, .. } = probe;
        (Probe { map, ..probe }, Receiver { map, place, texel, slope, touch, grain, ..receiver })
    }
}
