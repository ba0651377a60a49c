//! The shadow mask: each pixel of a G-buffer looked up in the map that serves its depth.

use rayon::prelude::*;

use super::lookup::{MapLookup, faces_light, partition_at, receiver};
use super::memory::{unwritten, written};
use crate::error::Result;
use crate::image::{DepthMaps, GBuffer, ShadowMask};
use crate::parameterization::Parameterization;
use crate::progress::Progress;
use crate::render::MaskSettings;
use crate::scene::{Camera, Light};

/// The lookups into the maps of all partitions.
pub fn lookups(
    p: &Parameterization,
    light: &Light,
    origin: glam::DVec3,
    settings: &MaskSettings,
) -> Result<Vec<MapLookup>> {
    let one = |partition| MapLookup::new(partition, light, origin, settings.resolution, settings.bias, settings.filter);
    p.partitions.iter().map(one).collect()
}

/// The light that arrives at each pixel.
pub fn mask(
    gbuffer: &GBuffer,
    camera: &Camera,
    light: &Light,
    p: &Parameterization,
    lookups: &[MapLookup],
    maps: &DepthMaps,
    progress: &Progress,
) -> Result<ShadowMask> {
    let width = gbuffer.size[0] as usize;
    let layer = maps.size[0] as usize * maps.size[1] as usize;
    let mut data = unwritten::<f32>(gbuffer.depth.len())?;
    data.par_chunks_mut(width).enumerate().try_for_each(|(y, row)| {
        progress.check()?;
        for (x, out) in row.iter_mut().enumerate() {
            out.write(match receiver(gbuffer, y * width + x) {
                None => f32::NAN,
                Some((p_relative, normal)) => {
                    let p_world = gbuffer.origin + p_relative;
                    if faces_light(light, p_world, normal) {
                        let k = partition_at(&p.partitions, camera.depth_of(p_world));
                        lookups[k].light(&maps.data[k * layer..][..layer], p_relative, normal)
                    } else {
                        0.0
                    }
                }
            });
        }
        Ok(())
    })?;
    // SAFETY: every row has been written, or the error has been returned.
    let data = unsafe { written(data) };
    Ok(ShadowMask { size: gbuffer.size, data })
}
