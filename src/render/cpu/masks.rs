//! The light at surfaces that are there: the mask of one light, and the states of many.

use std::mem::MaybeUninit;

use super::casters::keep_of;
use super::lookup::{Lookups, MaskInput, OnlyMap, set_states};
use super::passes::pixel_count;
use super::scratches::{Scratch, Scratches};
use super::stored::StoredMap;
use crate::error::Result;
use crate::image::{ShadowMask, ShadowStates, Surfaces};
use crate::memory::{check_images, unwritten, written};
use crate::parameterization::Parameterization;
use crate::progress::Progress;
use crate::render::{Asked, Cull, Keep, LightMaps, MaskSettings};
use crate::scene::{Camera, Light, Scene};

/// Texels of the maps that are held at once, so that their lights look at a receiver together: 256 MiB, which are the maps of 32
/// lights at 1448 x 1448 texels. One map of any size is held.
const MOST_TEXELS: usize = 1 << 26;

/// Surfaces that light falls on, through maps that are drawn for it.
pub(super) struct Lighting<'a> {
    pub scratches: &'a Scratches,
    pub scene: &'a Scene,
    pub surfaces: Surfaces<'a>,
    pub camera: &'a Camera,
    pub cull: Cull,
    pub progress: &'a Progress,
}

/// The maps of a light.
struct Maps<'a> {
    scene: &'a Scene,
    p: &'a Parameterization,
    settings: &'a MaskSettings,
    cull: Cull,
    /// What pixels look up in each, where only that is drawn.
    asked: Option<Vec<Option<Asked>>>,
}

impl Maps<'_> {
    /// Draws all of map `k`.
    fn draw(&self, k: usize, map: &mut [MaybeUninit<f32>], scratch: &mut Scratch, progress: &Progress) -> Result<()> {
        let keep = match &self.asked {
            // A map that no pixel asks is not drawn, or does not matter.
            Some(asked) => asked[k].as_ref().map_or(Keep::InVolume, Keep::Asked),
            None => keep_of(self.cull)?,
        };
        let MaskSettings { resolution: size, stored, .. } = *self.settings;
        StoredMap { scene: self.scene, partition: &self.p.partitions[k], size, stored, keep }
            .draw(map, scratch, progress)
    }
}

impl Lighting<'_> {
    /// The maps of the light of a mask.
    fn maps<'a>(&'a self, input: &MaskInput, p: &'a Parameterization, settings: &'a MaskSettings) -> Result<Maps<'a>> {
        let Self { scene, cull, .. } = *self;
        let asked = if cull == Cull::Seen { Some(input.asks()?) } else { None };
        Ok(Maps { scene, p, settings, cull, asked })
    }

    /// The mask of one light.
    pub fn mask(&self, light: &Light, p: &Parameterization, settings: &MaskSettings) -> Result<ShadowMask> {
        let Self { surfaces, camera, progress, .. } = *self;
        let lookups = &Lookups::new(p, camera, light, surfaces.origin, settings)?;
        let input = MaskInput { surfaces, camera, light, lookups, progress };
        let maps = self.maps(&input, p, settings)?;
        self.scratches.lend(|scratch| input.mask(|k, depth| maps.draw(k, depth, scratch, progress)))
    }

    /// The states of lights, in pictures where none arrives yet. Lights with one map each look at a receiver together, as many as
    /// have their maps held at once; those of several maps, of which one is held at a time, come before, by way of their masks.
    pub fn states(
        &self,
        lights: &[LightMaps],
        settings: &MaskSettings,
        mut states: ShadowStates,
    ) -> Result<ShadowStates> {
        let has_one = |i: &usize| lights[*i].p.partitions.len() == 1;
        let mut order: Vec<usize> = (0..lights.len()).collect();
        order.sort_by_key(has_one);
        let mut held: Vec<OnlyMap> = Vec::new();
        for (part, i) in order.into_iter().enumerate() {
            self.progress.begin_part(part, lights.len());
            let one = &lights[i];
            let own = one.settings(settings);
            if !has_one(&i) {
                states.set(i, &self.mask(one.light, one.p, &own)?);
                continue;
            }
            let texels = held.iter().map(|one| one.map.len()).sum::<usize>() + pixel_count(one.resolution);
            // A pass sets bits of one picture.
            let is_next = held.first().is_some_and(|first| first.picture() != i / ShadowStates::PER_PICTURE);
            if texels > MOST_TEXELS || is_next {
                self.set(&mut held, &mut states)?;
            }
            held.push(self.only_map(i, one, &own)?);
        }
        self.set(&mut held, &mut states)?;
        Ok(states)
    }

    /// The only map of light number `i`, drawn.
    fn only_map<'a>(&self, i: usize, of: &LightMaps<'a>, settings: &MaskSettings) -> Result<OnlyMap<'a>> {
        let Self { surfaces, camera, progress, .. } = *self;
        let LightMaps { light, p, resolution } = *of;
        let lookups = Lookups::new(p, camera, light, surfaces.origin, settings)?;
        let input = MaskInput { surfaces, camera, light, lookups: &lookups, progress };
        let maps = self.maps(&input, p, settings)?;
        check_images("resolution", 1, resolution, size_of::<f32>())?;
        let mut map = unwritten::<f32>(pixel_count(resolution))?;
        self.scratches.lend(|scratch| maps.draw(0, &mut map, scratch, progress))?;
        // SAFETY: the map has been drawn.
        Ok(OnlyMap { number: i, light, lookups, map: unsafe { written(map) } })
    }

    /// Sets the states of the lights of one picture whose maps are held, and lets the maps go.
    fn set(&self, held: &mut Vec<OnlyMap>, states: &mut ShadowStates) -> Result<()> {
        if let Some(first) = held.first() {
            set_states(&self.surfaces, held, states.of_light(first.number).0, self.progress)?;
        }
        held.clear();
        Ok(())
    }
}
