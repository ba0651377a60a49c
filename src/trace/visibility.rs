//! Which pixels of an image are lit: see [`shading`](super::shading).

use rayon::prelude::*;

use super::hierarchy::Tracer;
use super::kernel::{Kernel, dispatched};
use super::rays::{BUNDLE, Each, WorldRays};
use super::shading::{Lamp, Shader};
use super::walk::Stacks;
use crate::error::{Error, Result};
use crate::image::TruthMask;
use crate::memory::{check_images, with_room};
use crate::progress::Progress;
use crate::scene::{Camera, Light};

/// Side of the square of pixels whose rays follow each other, so that they find the same boxes in the cache.
const TILE: usize = 8;
/// Sides of the block of pixels whose rays travel together.
const BLOCK: [usize; 2] = [4, 4];
const _: () = assert!(BLOCK[0] * BLOCK[1] == BUNDLE);
/// Largest side of an image, the same as the renderers'.
const MAX_SIDE: u32 = 16384;
impl Tracer {
    /// What light does at each pixel of an image of `size` (width, height): see [`TruthMask`].
    ///
    /// The surface seen is the first one between the camera's near and far depth. It is in shadow where it faces away
    /// from the light on the side the eye sees (edge-on included, up to [`EDGE_ON`](crate::scene::EDGE_ON)), where the light
    /// does not reach (cone, range), and where anything else meets the open segment between it and the light; undecided where
    /// that changes when the rays move by what single precision resolves in this scene (the half extent times 2^-22). A light
    /// nearer than that to a surface stands on it, and the surface shades nothing from it: its light arrives on both sides.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a side of 0 or above 16384; [`Error::Interrupted`].
    pub fn shadow_mask(
        &self,
        camera: &Camera,
        light: &Light,
        size: [u32; 2],
        progress: &Progress,
    ) -> Result<TruthMask> {
        let mut masks = self.shadow_masks(camera, &[*light], size, progress)?;
        Ok(masks.remove(0))
    }

    /// The same for each of several lights. The rays from the eye are traced once.
    ///
    /// # Errors
    /// As [`Tracer::shadow_mask`].
    pub fn shadow_masks(
        &self,
        camera: &Camera,
        lights: &[Light],
        size: [u32; 2],
        progress: &Progress,
    ) -> Result<Vec<TruthMask>> {
        if !size.iter().all(|n| (1..=MAX_SIDE).contains(n)) {
            let expected = format!("sides between 1 and {MAX_SIDE}");
            return Err(Error::argument("size", expected, format!("{} x {}", size[0], size[1]), "choose another size"));
        }
        let [width, height] = size.map(|n| n as usize);
        let shader = Shader::new(&self.inner, camera);
        let lamps: Vec<Lamp> = lights.iter().map(|light| Lamp::new(&self.inner, light)).collect();
        check_images("size", lights.len(), size, size_of::<i8>())?;
        let mut masks = Vec::with_capacity(lights.len());
        for _ in lights {
            let mut data: Vec<i8> = with_room("size", width * height)?;
            data.resize(width * height, TruthMask::NOTHING);
            masks.push(data);
        }
        progress.set_total(height as u64);
        // The same rows of all masks.
        let mut bands: Vec<Vec<&mut [i8]>> = Vec::new();
        bands.resize_with(height.div_ceil(TILE), || Vec::with_capacity(lights.len()));
        for mask in &mut masks {
            bands.iter_mut().zip(mask.chunks_mut(width * TILE)).for_each(|(band, rows)| band.push(rows));
        }
        bands.into_par_iter().enumerate().try_for_each(|(band, mut rows)| {
            let (top, mut stacks) = (band * TILE, Stacks::default());
            for x in (0..width).step_by(TILE) {
                progress.check()?;
                tile(&shader, camera, &lamps, size, [x, top], &mut rows, &mut stacks);
            }
            progress.advance(TILE.min(height - top) as u64);
            Ok(())
        })?;
        Ok(masks.into_iter().map(|data| TruthMask { size, data }).collect())
    }
}

dispatched! {
    fn tile(
        shader: &Shader<'_>, camera: &Camera, lamps: &[Lamp<'_>], size: [u32; 2], corner: [usize; 2],
        rows: &mut [&mut [i8]], stacks: &mut Stacks
    ) = tile_with;
}

#[inline(always)]
fn tile_with<K: Kernel>(
    shader: &Shader,
    camera: &Camera,
    lamps: &[Lamp],
    size: [u32; 2],
    [left, top]: [usize; 2],
    rows: &mut [&mut [i8]],
    stacks: &mut Stacks,
) {
    let [width, height] = size.map(|n| n as usize);
    let (tile_width, height) = (TILE.min(width - left), TILE.min(height - top));
    let ray_of = camera.pixel_rays(size);
    for y in (0..height).step_by(BLOCK[1]) {
        for x in (left..left + tile_width).step_by(BLOCK[0]) {
            let at = |r: usize| [x + r % BLOCK[0], y + r / BLOCK[0]];
            let mut rays = WorldRays::UNSET;
            let mut bits = 0;
            for r in 0..BUNDLE {
                let [x, y] = at(r);
                rays.set(r, &shader.world_ray(&ray_of(x as f64 + 0.5, (top + y) as f64 + 0.5)));
                bits |= u32::from(x < left + tile_width && y < height) << r;
            }
            shader.pixels::<K>(&rays, bits, lamps, stacks, |lamp, answers| {
                for r in Each(bits) {
                    let [x, y] = at(r);
                    rows[lamp][y * width + x] = answers[r];
                }
            });
        }
    }
}
