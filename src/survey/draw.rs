//! Samples of a view, drawn: what the camera sees, and what of it is in shadow by an ordinary map.
//!
//! Source: theory.md 10.5: the states of one uniform map, which every engine has, place a warp as well as traced ones do.

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::focus::Samples;
use crate::image::{DepthMaps, Surfaces, TruthMask};
use crate::parameterization::Parameterization;
use crate::progress::Progress;
use crate::render::cpu::lookup::Lookups;
use crate::render::cpu::{CpuRenderer, look_up};
use crate::render::{Bias, Filter, MAX_IMAGE_SIDE, MaskSettings, Renderer, Stored, looking_pays};
use crate::scene::{Camera, Light, Scene};
use crate::techniques::{Needs, technique_of};

/// Texels along each side of the map that says what is in shadow. Chosen because it is what an engine has.
pub const SURVEY_MAP: u32 = 1024;

/// Samples at shadows' edges that are kept where no count is given.
pub const SURVEY_COUNT: usize = 4096;

/// Pixels along each side of a square picture that a technique draws for itself: a share of receivers is then known to 1 / 128 of
/// the view along each side. Chosen by leaving scenes out (docs/defaults.md).
pub const SURVEY_SIDE: f64 = 128.0;

/// Width and height of a picture of so many pixels along each side of a square, with square pixels.
pub fn survey_size(camera: &Camera, side: f64) -> [u32; 2] {
    let root = camera.aspect().sqrt();
    let pixels = |n: f64| n.round().clamp(1.0, f64::from(MAX_IMAGE_SIDE)) as u32;
    [pixels(side * root), pixels(side / root)]
}

/// The samples that a technique needs, from a picture of its own.
///
/// # Errors
/// As the renderer's.
pub fn samples_of_view(
    scene: &Scene,
    camera: &Camera,
    light: &Light,
    needs: Needs,
    progress: &Progress,
) -> Result<Option<Samples>> {
    if needs == Needs::Nothing {
        return Ok(None);
    }
    let gbuffer = CpuRenderer::new().gbuffer(scene, camera, survey_size(camera, SURVEY_SIDE), progress)?;
    samples_of_surfaces(scene, camera, light, gbuffer.surfaces(), needs, progress).map(Some)
}

/// The samples that a technique needs, of a picture that is there.
///
/// # Errors
/// As the renderer's.
pub fn samples_of_surfaces(
    scene: &Scene,
    camera: &Camera,
    light: &Light,
    surfaces: Surfaces,
    needs: Needs,
    progress: &Progress,
) -> Result<Samples> {
    let samples = Samples::of_surfaces_watched(&surfaces, camera, || progress.check())?;
    if needs < Needs::Shadows {
        return Ok(samples);
    }
    let states = mapped_states(scene, camera, light, surfaces, progress)?;
    samples.with_shadows_watched(light, states, &surfaces, SURVEY_COUNT, || progress.check())
}

/// What of a picture is in shadow by one uniform map of [`SURVEY_MAP`]² texels over the body: a state per pixel.
///
/// # Errors
/// As the renderer's.
pub fn mapped_states(
    scene: &Scene,
    camera: &Camera,
    light: &Light,
    surfaces: Surfaces,
    progress: &Progress,
) -> Result<Vec<i8>> {
    let (p, maps) = survey_maps(scene, camera, light, surfaces, progress)?;
    let mask = look_up(&maps.data, surfaces, camera, light, &p, &settings_of(surfaces.size), progress)?;
    Ok(mask.data.iter().map(|share| TruthMask::of_light(*share)).collect())
}

/// How far before what each pixel shows, towards the light, what shades it lies by the map of [`mapped_states`], world units; 0 where
/// that is lit, faces away from the light, or is nothing.
///
/// # Errors
/// As the renderer's.
pub fn mapped_gaps(
    scene: &Scene,
    camera: &Camera,
    light: &Light,
    surfaces: Surfaces,
    progress: &Progress,
) -> Result<Vec<f32>> {
    let (p, maps) = survey_maps(scene, camera, light, surfaces, progress)?;
    let lookups = Lookups::new(&p, camera, light, surfaces.origin, &settings_of(surfaces.size))?;
    let gap = |pixel: usize| {
        let (at, normal) = surfaces.receiver(pixel)?;
        let world = surfaces.origin + at;
        let k = lookups.choose(at, camera.depth_of(world)).filter(|_| light.illuminates(world, normal))?;
        let map = &maps.data[k * lookups.texels()..][..lookups.texels()];
        let read = lookups.map(k).probe(map, at, normal, false).taps.into_iter().next()?;
        read.is_dark.then_some(read.gap.max(0.0))
    };
    let mut found = vec![0.0; surfaces.triangle.len()];
    let width = surfaces.size[0] as usize;
    found.par_chunks_mut(width).enumerate().try_for_each(|(y, row): (usize, &mut [f32])| {
        progress.check()?;
        row.iter_mut().enumerate().for_each(|(x, to)| *to = gap(y * width + x).unwrap_or(0.0) as f32);
        Ok::<_, Error>(())
    })?;
    Ok(found)
}

fn survey_maps(
    scene: &Scene,
    camera: &Camera,
    light: &Light,
    surfaces: Surfaces,
    progress: &Progress,
) -> Result<(Parameterization, DepthMaps)> {
    let p = technique_of("uniform:range=body,fit=exact")?.parameterize(scene, camera, light, SURVEY_MAP)?;
    let (renderer, settings) = (CpuRenderer::new(), settings_of(surfaces.size));
    let maps = if looking_pays(scene, surfaces.size) {
        renderer.seen_maps(scene, surfaces, camera, light, &p, &settings, progress)?
    } else {
        renderer.depth_maps(scene, &p, settings.resolution, settings.stored, progress)?
    };
    Ok((p, maps))
}

fn settings_of(size: [u32; 2]) -> MaskSettings {
    let (bias, filter, stored) = (Bias::default(), Filter::Nearest, Stored::default());
    MaskSettings { resolution: [SURVEY_MAP; 2], size, bias, filter, blend: 0.0, stored }
}
