//! The light at surfaces that are there: the mask of one light, and the states of many.

use std::mem::MaybeUninit;

use super::casters::keep_of;
use super::lookup::{Lookups, MaskInput, OnlyMap, set_states};
use super::passes::pixel_count;
use super::renderer::CpuRenderer;
use super::stored::StoredMap;
use crate::error::Result;
use crate::image::{ShadowMask, ShadowStates, Surfaces};
use crate::memory::{check_images, unwritten, written_part};
use crate::parameterization::Parameterization;
use crate::progress::Progress;
use crate::render::{Cull, Keep, LightMaps, MaskSettings};
use crate::scene::{Camera, Light, Scene};

/// Texels of the maps that are held at once, so that their lights look at a receiver together: 256 MiB, which are the maps of 32
/// lights at 1448 x 1448 texels. One map of any size is held.
const MOST_TEXELS: usize = 1 << 26;

impl CpuRenderer {
    /// The mask of surfaces through maps that are drawn for it.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn mask_of_surfaces(
        &self,
        scene: &Scene,
        surfaces: Surfaces,
        camera: &Camera,
        light: &Light,
        p: &Parameterization,
        settings: &MaskSettings,
        cull: Cull,
        progress: &Progress,
    ) -> Result<ShadowMask> {
        let lookups = &Lookups::new(p, camera, light, surfaces.origin, settings)?;
        let input = MaskInput { surfaces, camera, light, lookups, progress };
        let asked = if cull == Cull::Seen { Some(input.asks()?) } else { None };
        let keep = |k: usize| match &asked {
            // A map that no pixel asks is not drawn, or does not matter.
            Some(asked) => Ok(asked[k].as_ref().map_or(Keep::InVolume, Keep::Asked)),
            None => keep_of(cull),
        };
        let (size, stored) = (settings.resolution, settings.stored);
        self.with_scratch(|scratch| {
            input.mask(|k, depth| {
                let map = StoredMap { scene, partition: &p.partitions[k], size, stored, keep: keep(k)? };
                map.draw(depth, scratch, progress)
            })
        })
    }

    /// The states of surfaces, in pictures where no light arrives yet. Lights with one map each look at a receiver together, as many
    /// as have their maps held at once; those of several maps, of which one is held at a time, come by way of their masks.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn states_of_surfaces(
        &self,
        scene: &Scene,
        surfaces: Surfaces,
        camera: &Camera,
        lights: &[LightMaps],
        settings: &MaskSettings,
        cull: Cull,
        mut states: ShadowStates,
        progress: &Progress,
    ) -> Result<ShadowStates> {
        let mut together: Vec<usize> = Vec::new();
        let texels = |of: &[usize]| of.iter().map(|&i| pixel_count(lights[i].resolution)).sum::<usize>();
        for (i, one) in lights.iter().enumerate() {
            progress.begin_part(i, lights.len());
            if one.p.partitions.len() > 1 {
                let settings = &one.settings(settings);
                let mask =
                    self.mask_of_surfaces(scene, surfaces, camera, one.light, one.p, settings, cull, progress)?;
                states.set(i, &mask);
            } else {
                let is_full = texels(&together) + pixel_count(one.resolution) > MOST_TEXELS;
                // A pass sets bits of one picture.
                let is_next = together
                    .first()
                    .is_some_and(|first| i / ShadowStates::PER_PICTURE != first / ShadowStates::PER_PICTURE);
                if is_full || is_next {
                    self.states_together(
                        scene,
                        surfaces,
                        camera,
                        lights,
                        &together,
                        settings,
                        cull,
                        &mut states,
                        progress,
                    )?;
                    together.clear();
                }
                together.push(i);
            }
        }
        self.states_together(scene, surfaces, camera, lights, &together, settings, cull, &mut states, progress)?;
        Ok(states)
    }

    /// Sets the states of some lights of one picture, each with one map.
    #[allow(clippy::too_many_arguments)]
    fn states_together(
        &self,
        scene: &Scene,
        surfaces: Surfaces,
        camera: &Camera,
        lights: &[LightMaps],
        together: &[usize],
        settings: &MaskSettings,
        cull: Cull,
        states: &mut ShadowStates,
        progress: &Progress,
    ) -> Result<()> {
        let Some(&first) = together.first() else { return Ok(()) };
        let mut drawn: Vec<(usize, Lookups, Vec<MaybeUninit<f32>>)> = Vec::with_capacity(together.len());
        for &i in together {
            let LightMaps { light, p, resolution: size } = lights[i];
            let lookups = Lookups::new(p, camera, light, surfaces.origin, &lights[i].settings(settings))?;
            let input = MaskInput { surfaces, camera, light, lookups: &lookups, progress };
            let asked = if cull == Cull::Seen { input.asks()?.pop().flatten() } else { None };
            let keep = match (&asked, cull) {
                (Some(asked), _) => Keep::Asked(asked),
                (None, Cull::Seen) => Keep::InVolume,
                (None, cull) => keep_of(cull)?,
            };
            check_images("resolution", 1, size, size_of::<f32>())?;
            let mut map = unwritten::<f32>(pixel_count(size))?;
            let stored = StoredMap { scene, partition: &p.partitions[0], size, stored: settings.stored, keep };
            self.with_scratch(|scratch| stored.draw(&mut map, scratch, progress))?;
            drawn.push((i, lookups, map));
        }
        let only_maps: Vec<OnlyMap> = drawn
            .iter_mut()
            .map(|(i, lookups, map)| OnlyMap {
                light: lights[*i].light,
                lookup: lookups.map(0),
                // SAFETY: the map has been drawn.
                map: unsafe { written_part(map) },
                bit: (*i % ShadowStates::PER_PICTURE) as u32,
            })
            .collect();
        set_states(&surfaces, &only_maps, states.of_light(first).0, progress)
    }
}
