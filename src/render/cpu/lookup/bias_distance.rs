//! How far a bias carries each receiver of an image towards the light, in world units.

use std::mem::MaybeUninit;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::comparison::{Comparison, Reference};
use super::lookup::{Lookups, MapLookup};
use crate::error::Result;
use crate::image::Surfaces;
use crate::memory::{unwritten, written};
use crate::parameterization::Parameterization;
use crate::progress::Progress;
use crate::render::MaskSettings;
use crate::scene::{Camera, Light};

/// The bias of each pixel, world units along its light ray: what it is compared with lies so much nearer to the light. NaN
/// where nothing is compared: no surface, one that faces away, and none of the maps.
///
/// It is taken at the texel that the receiver falls into. A bias past the near plane of the map or the light counts up to
/// there; it is negative where the texel's centre lies on the far side of the receiver's plane.
///
/// # Errors
/// As [`Lookups::new`].
pub fn bias_distance(
    surfaces: &Surfaces,
    camera: &Camera,
    light: &Light,
    p: &Parameterization,
    settings: &MaskSettings,
    progress: &Progress,
) -> Result<Vec<f32>> {
    let lookups = &Lookups::new(p, camera, light, surfaces.origin, settings)?;
    let width = surfaces.size[0] as usize;
    let mut found = unwritten::<f32>(surfaces.triangle.len())?;
    found.par_chunks_mut(width).enumerate().try_for_each(|(y, row): (usize, &mut [MaybeUninit<f32>])| {
        progress.check()?;
        for (x, to) in row.iter_mut().enumerate() {
            to.write(at(surfaces, camera, light, lookups, y * width + x).unwrap_or(f64::NAN) as f32);
        }
        Ok::<_, crate::Error>(())
    })?;
    // SAFETY: every row has been written, or the error has been returned.
    Ok(unsafe { written(found) })
}

/// The bias of a pixel; nothing where it is not compared.
fn at(surfaces: &Surfaces, camera: &Camera, light: &Light, lookups: &Lookups, pixel: usize) -> Option<f64> {
    let (p, normal) = surfaces.receiver(pixel)?;
    let p_world = surfaces.origin + p;
    if !light.illuminates(p_world, normal) {
        return None;
    }
    let k = lookups.choose(p, camera.depth_of(p_world))?;
    lookups.map(k).carried(p, normal)
}

impl MapLookup {
    /// How far the bias carries a receiver along its ray, world units; nothing outside of the map and before its near plane.
    pub fn carried(&self, p: DVec3, normal: DVec3) -> Option<f64> {
        let unbiased = self.depth_of(p)?.min(1.0);
        let depth = match self.compare_at(p, normal) {
            Comparison::At(reference) => self.depth_at(&reference, reference.p_texel.floor() + 0.5),
            Comparison::Lit => 0.0,
        };
        let along = self.way_to_light(p);
        // Both by the same ray, so that the clamp at the far plane counts as no bias.
        Some(self.way_to_depth(p, along, depth) - self.way_to_depth(p, along, unbiased))
    }
    /// How far before the plane of a receiver, towards the light, that lies which the texel of a centre is compared with: a surface
    /// farther before it shades the receiver. Nothing where the plane is seen edge on.
    pub fn bias_at(&self, reference: &Reference, p: DVec3, normal: DVec3, centre: DVec2) -> Option<f64> {
        let on_plane = self.on_plane_at(p, normal, centre)?;
        let depth = self.depth_at(reference, centre);
        Some(self.way_to_depth(on_plane, self.way_to_light(on_plane), depth))
    }
}
