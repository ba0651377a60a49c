//! What every renderer does.

use super::{Bias, Casters, Cull, Filter, Stored};
use crate::error::{Error, Result};
use crate::image::{DepthMaps, Footprint, GBuffer, ShadowMask, ShadowStates, Surfaces};
use crate::memory::{check_images, with_room};
use crate::parameterization::Parameterization;
use crate::progress::Progress;
use crate::scene::{Camera, Light, Scene};

/// Largest side of an image: what every graphics device in use offers (WebGPU promises 8192, desktop drivers 16384).
pub const MAX_IMAGE_SIDE: u32 = 16384;

/// How a shadow mask is computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaskSettings {
    /// Width and height of the shadow map, texels.
    pub resolution: [u32; 2],
    /// Width and height of the image, pixels.
    pub size: [u32; 2],
    /// Added before the comparison.
    pub bias: Bias,
    /// How the map is read.
    pub filter: Filter,
    /// The last share of each map's range, 0 to 1, over which the light of the next map is mixed in (14.6).
    pub blend: f64,
    /// What the map stores.
    pub stored: Stored,
}

/// A light with its maps.
#[derive(Debug, Clone, Copy)]
pub struct LightMaps<'a> {
    /// The light.
    pub light: &'a Light,
    /// Its maps.
    pub p: &'a Parameterization,
    /// Width and height of each map, texels.
    pub resolution: [u32; 2],
}

impl LightMaps<'_> {
    /// How its mask is computed; all else is that of all lights.
    pub fn settings(&self, of_all: &MaskSettings) -> MaskSettings {
        MaskSettings { resolution: self.resolution, ..*of_all }
    }
}

/// A renderer. Implementations agree: see tests.
///
/// Pixel and texel centres at half integers; top-left fill rule on a grid of 1/256; everything with clip `0 <= z <= w`,
/// both sides of every triangle.
pub trait Renderer: Send + Sync {
    /// "cpu" or "gpu".
    fn backend(&self) -> &'static str;
    /// The device in words.
    fn adapter(&self) -> String;
    /// Gives back what it keeps between calls: memory for images and, on a device, the geometry of scenes. The next call makes
    /// it anew.
    fn release(&self) -> Result<()>;
    /// The shadow maps of all partitions, `resolution` texels (width, height) each, as they are stored.
    fn depth_maps(
        &self,
        scene: &Scene,
        p: &Parameterization,
        resolution: [u32; 2],
        stored: Stored,
        progress: &Progress,
    ) -> Result<DepthMaps> {
        self.maps_of(scene, p, resolution, stored, Cull::Volume, progress)
    }
    /// The same of the instances that `cull` keeps.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for [`Cull::Seen`]: what is seen takes a picture, see [`Renderer::seen_maps`].
    fn maps_of(
        &self,
        scene: &Scene,
        p: &Parameterization,
        resolution: [u32; 2],
        stored: Stored,
        cull: Cull,
        progress: &Progress,
    ) -> Result<DepthMaps>;
    /// The shadow maps as far as the pixels of a picture look them up: [`Cull::Seen`]. A mask of these pixels looked up with these
    /// settings is that of whole maps.
    #[allow(clippy::too_many_arguments)]
    fn seen_maps(
        &self,
        scene: &Scene,
        surfaces: Surfaces,
        camera: &Camera,
        light: &Light,
        p: &Parameterization,
        settings: &MaskSettings,
        progress: &Progress,
    ) -> Result<DepthMaps>;
    /// What becomes of each instance in each map; `picture` says what is seen, as [`Renderer::seen_maps`] takes it, where
    /// [`Cull::Seen`] is asked for.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for [`Cull::Seen`] without a picture.
    #[allow(clippy::too_many_arguments)]
    fn casters(
        &self,
        scene: &Scene,
        p: &Parameterization,
        cull: Cull,
        picture: Option<(Surfaces, &Camera, &Light)>,
        settings: &MaskSettings,
        progress: &Progress,
    ) -> Result<Vec<Casters>>;
    /// What the camera sees in an image of `size` pixels (width, height).
    fn gbuffer(&self, scene: &Scene, camera: &Camera, size: [u32; 2], progress: &Progress) -> Result<GBuffer>;
    /// What a texel of the maps, `resolution` texels (width, height) each, looks like at each pixel of an image of `size`
    /// pixels: `aliasing::footprint` of what the camera sees.
    #[allow(clippy::too_many_arguments)]
    fn footprint(
        &self,
        scene: &Scene,
        camera: &Camera,
        light: &Light,
        p: &Parameterization,
        resolution: [u32; 2],
        size: [u32; 2],
        progress: &Progress,
    ) -> Result<Footprint>;
    /// The light that arrives at each pixel, through the shadow map.
    ///
    /// Each pixel asks the map that [`Parameterization::choose`] finds. In shadow: pixels whose surface faces away from the
    /// light (on the side seen by the eye) and those outside a spot's cone or range. Lit: receivers that no map holds, and
    /// those nearer to the light than their map's near plane. Where maps blend, the map that is asked is the chosen one.
    fn shadow_mask(
        &self,
        scene: &Scene,
        camera: &Camera,
        light: &Light,
        p: &Parameterization,
        settings: &MaskSettings,
        progress: &Progress,
    ) -> Result<ShadowMask> {
        self.mask_of(scene, camera, light, p, settings, Cull::Volume, progress)
    }
    /// The same through maps of the instances that `cull` keeps, which changes no pixel.
    #[allow(clippy::too_many_arguments)]
    fn mask_of(
        &self,
        scene: &Scene,
        camera: &Camera,
        light: &Light,
        p: &Parameterization,
        settings: &MaskSettings,
        cull: Cull,
        progress: &Progress,
    ) -> Result<ShadowMask>;
    /// At which pixels each of several lights arrives: where its [`Renderer::mask_of`] is lit, from [`ShadowMask::LIT_FROM`] on.
    /// Each light has a resolution of its own in place of that of the settings.
    ///
    /// # Errors
    /// As the masks, and [`Error::InvalidArgument`] without a light.
    fn shadow_states(
        &self,
        scene: &Scene,
        camera: &Camera,
        lights: &[LightMaps],
        settings: &MaskSettings,
        cull: Cull,
        progress: &Progress,
    ) -> Result<ShadowStates> {
        let mut states = no_states(lights, settings.size)?;
        for (i, one) in lights.iter().enumerate() {
            progress.begin_part(i, lights.len());
            let mask = self.mask_of(scene, camera, one.light, one.p, &one.settings(settings), cull, progress)?;
            states.set(i, &mask);
        }
        Ok(states)
    }
}

/// An error that says what [`Cull::Seen`] takes.
pub(crate) fn no_picture() -> Error {
    let fix = "ask for the mask, or give the picture whose pixels look up the map";
    Error::argument("cull", "\"none\" or \"volume\" where there is no picture", "\"seen\"", fix)
}

/// Pictures in which no light arrives yet.
///
/// # Errors
/// [`Error::InvalidArgument`] without a light, and for pictures that do not fit into memory.
pub(crate) fn no_states(lights: &[LightMaps], size: [u32; 2]) -> Result<ShadowStates> {
    if lights.is_empty() {
        return Err(Error::argument(
            "lights",
            "at least one light",
            "none",
            "give a list of lights, and maps for each",
        ));
    }
    let pictures = ShadowStates::pictures(lights.len());
    check_images("size", pictures, check_size("size", size)?, size_of::<u32>())?;
    let values = pictures * size[0] as usize * size[1] as usize;
    let mut data = with_room("size", values)?;
    data.resize(values, 0);
    Ok(ShadowStates { size, data })
}

/// The size if both sides are between 1 and [`MAX_IMAGE_SIDE`].
pub fn check_size(name: &'static str, size: [u32; 2]) -> Result<[u32; 2]> {
    if size.iter().all(|&n| (1..=MAX_IMAGE_SIDE).contains(&n)) {
        return Ok(size);
    }
    let expected = format!("sides between 1 and {MAX_IMAGE_SIDE}");
    Err(Error::argument(name, expected, format!("{} x {}", size[0], size[1]), "choose another size"))
}

/// The share over which maps blend, if it is between 0 and 1.
pub(crate) fn check_blend(blend: f64) -> Result<f64> {
    if (0.0..=1.0).contains(&blend) {
        return Ok(blend);
    }
    let fix = "0 switches blending off, 0.1 blends over the last tenth of each map's range";
    Err(Error::argument("blend", "a number from 0 to 1", blend, fix))
}

/// Refuses scenes whose positions would not survive in f32.
pub(crate) fn check_extent(scene: &Scene) -> Result<()> {
    // Derived from f32: coordinates relative to the middle must not overflow, and their last digits must be normal numbers.
    let smallest = f64::from(f32::MIN_POSITIVE) / f64::from(f32::EPSILON);
    let extent = scene.bounds().extent().max_element();
    if extent == 0.0 || (smallest..=f64::from(f32::MAX)).contains(&extent) {
        return Ok(());
    }
    let expected = format!("an extent between {smallest:e} and {:e} (positions are stored as f32)", f32::MAX);
    Err(Error::argument("scene", expected, format!("{extent:e}"), "scale the scene and the camera"))
}

/// Refuses more maps than a mask can number.
pub(crate) fn check_count(p: &Parameterization) -> Result<()> {
    let most = i16::MAX as usize;
    if p.partitions.len() <= most {
        return Ok(());
    }
    let fix = "divide the view into fewer parts";
    Err(Error::argument("parameterization", format!("at most {most} maps"), p.partitions.len(), fix))
}
