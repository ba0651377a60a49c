//! The size of one step of a format, in world units along the light ray: theory.md (13.10).

use glam::{DMat4, DVec3};

use super::kind::Stored;
use super::measure::DepthMeasure;
use super::texel_rays::TexelRays;
use crate::error::Result;
use crate::parameterization::Partition;

/// The distance along the light ray through a world point over which the depth that a map stores there changes by one step of
/// its format; infinity where it does not change.
///
/// # Errors
/// [`crate::Error::InvalidArgument`] for a matrix without an inverse and, where depth is linear, for a map that reaches to infinity.
pub fn step_along_ray(partition: &Partition, stored: &Stored) -> Result<impl Fn(DVec3) -> f64> {
    // Relative to the middle of the map: coordinates far from the world's origin keep their digits.
    let rays = TexelRays::new(&partition.shadow_clip_from_world, &partition.post_warp, [1, 1])?;
    let middle = rays.middle();
    let clip_from_local = partition.shadow_clip_from_world * DMat4::from_translation(middle);
    let measure = DepthMeasure::new(&clip_from_local, &partition.post_warp, stored.spacing)?;
    let away = TexelRays::new(&clip_from_local, &partition.post_warp, [1, 1])?.inverse.z_axis;
    let format = stored.format;
    Ok(move |p_world: DVec3| {
        let p = p_world - middle;
        let (p4, ray) = (p.extend(1.0), (away.truncate() - away.w * p).normalize_or_zero());
        let depth = measure.at(p4);
        format.step(depth) / measure.gradient(p4, depth).dot(ray).abs()
    })
}
