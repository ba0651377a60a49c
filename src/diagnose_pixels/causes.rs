//! The cause of every wrong pixel of an image: probes of the maps that were read, and rays where these leave it open.

use glam::DVec3;
use rayon::prelude::*;

use crate::aliasing::against_truth::code;
use crate::aliasing::causes::{Blocker, Probe, cause, cause_of_light, cause_of_shadow, displacement};
use crate::aliasing::texel::{Eye, TexelMap, texel_in_image};
use crate::error::{Error, Result};
use crate::image::Surfaces;
use crate::parameterization::Parameterization;
use crate::progress::Progress;
use crate::render::MaskSettings;
use crate::render::cpu::lookup::Lookups;
use crate::scene::{Camera, Light, Scene};
use crate::trace::{FirstLit, Tracer};

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
    /// Of each pixel one of [`crate::image::TruthMask`]'s.
    pub truth: &'a [i8],
}

/// The cause of each pixel (one of [`cause`]), and the distance in pixels to the nearest one whose truth is what the map says.
///
/// Triangles of the surfaces are numbered by the rows of the face arrays that their meshes were made from.
///
/// # Errors
/// As [`Lookups::new`] and [`Tracer::first_from_light`].
pub fn causes(of: &Wrong, progress: &Progress) -> Result<(Vec<i8>, Vec<f32>)> {
    let work = Work::new(of)?;
    let distance = displacement(&of.surfaces, of.light, of.differences, of.truth, progress)?;
    let wrong: Vec<usize> = (0..of.differences.len()).filter(|&i| of.differences[i] > 0).collect();
    let mut probes = vec![Probe::default(); wrong.len()];
    probes.par_chunks_mut(AT_ONCE).zip(wrong.par_chunks(AT_ONCE)).try_for_each(|(probes, pixels)| {
        progress.check()?;
        probes.iter_mut().zip(pixels).for_each(|(probe, &i)| *probe = work.probe(i));
        Ok::<_, Error>(())
    })?;
    let mut causes: Vec<i8> = of.differences.iter().map(|&d| d.min(cause::NONE)).collect();
    // Rays: of false light to the receiver itself, of false shadow that is open to where its darkest texel meets the plane.
    let mut asked: Vec<(usize, &Probe, DVec3)> = Vec::new();
    for (&i, probe) in wrong.iter().zip(&probes) {
        let (receiver, _) = of.surfaces.receiver(i).unwrap_or_default();
        if of.differences[i] == code::FALSE_LIGHT {
            asked.push((i, probe, receiver));
        } else {
            match cause_of_shadow(probe, f64::from(distance[i])) {
                Some(cause) => causes[i] = cause,
                None => asked.push((i, probe, probe.darkest.map_or(receiver, |(at, _)| at))),
            }
        }
    }
    let points: Vec<DVec3> = asked.iter().map(|(_, _, p)| of.surfaces.origin + *p).collect();
    let found = of.tracer.first_from_light(of.light, &points, progress)?;
    for ((i, probe, _), first) in asked.into_iter().zip(&found) {
        causes[i] = if of.differences[i] == code::FALSE_LIGHT {
            cause_of_light(probe, work.blocker(i, first), f64::from(distance[i]))
        } else {
            // Where the map is right, a lit surface is shaded by its lit neighbour.
            let is_right = probe.darkest.is_some_and(|(_, gap)| (first.before - gap).abs() <= probe.texel);
            if is_right { cause::ACNE } else { cause::OTHER }
        };
    }
    Ok((causes, distance))
}

/// What all pixels share.
struct Work<'a> {
    of: &'a Wrong<'a>,
    lookups: Lookups<'a>,
    eye: Eye,
    texels: Vec<TexelMap>,
}

impl<'a> Work<'a> {
    fn new(of: &'a Wrong<'a>) -> Result<Self> {
        let lookups = Lookups::new(of.parameterization, of.light, of.surfaces.origin, of.settings)?;
        let local = of.parameterization.relative_to(of.surfaces.origin)?;
        let texels = local.partitions.iter().map(|map| TexelMap::new(map, of.settings.resolution)).collect();
        Ok(Self { of, lookups, eye: Eye::new(of.camera, of.surfaces.origin, of.surfaces.size), texels })
    }

    fn map_of(&self, p_local: DVec3) -> Option<usize> {
        self.lookups.choose(p_local, self.of.camera.depth_of(self.of.surfaces.origin + p_local))
    }

    /// What the map of a pixel holds.
    fn probe(&self, pixel: usize) -> Probe {
        let Some((p, normal)) = self.of.surfaces.receiver(pixel) else { return Probe::default() };
        let Some(k) = self.map_of(p) else { return Probe::default() };
        let n = self.lookups.texels();
        let mut probe = self.lookups.map(k).probe(&self.of.maps[k * n..(k + 1) * n], p, normal);
        let texel = texel_in_image(&self.texels[k], &self.eye, p, normal);
        // A lookup is right at the centres it reads, each way; twice that, for slopes that change, and for pixels that are
        // right or wrong at their own centres a step and a half.
        let reach = 2.0 * self.of.settings.filter.reach_texels() * texel.major.hypot(texel.minor) + 1.5;
        probe.reach_px = if reach.is_finite() { reach } else { f64::INFINITY };
        probe
    }

    /// What the light meets first on its way to a pixel; nothing where that is the receiver itself.
    fn blocker(&self, pixel: usize, first: &FirstLit) -> Option<Blocker> {
        let (surfaces, hit) = (&self.of.surfaces, first.hit);
        if hit.triangle < 0 || first.before <= 0.0 {
            return None;
        }
        let row = self.of.scene.mesh_of(hit.instance as usize).source_face(hit.triangle as usize) as i32;
        if (hit.instance, row) == (surfaces.instance[pixel], surfaces.triangle[pixel]) {
            return None;
        }
        let (p, _) = surfaces.receiver(pixel)?;
        let at = first.at - surfaces.origin;
        let is_in_map = self.map_of(p).is_some_and(|k| self.lookups.map(k).holds_depth(at));
        Some(Blocker { distance: first.before, is_in_map })
    }
}
