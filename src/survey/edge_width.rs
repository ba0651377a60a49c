//! How wide the texels of maps are across the edges of visible shadows, from samples: what says whether held maps still serve.
//!
//! Source: theory.md (10.7) and (10.8), for maps of any kind; [`techniques::kit::edge_width`](crate::techniques::kit::edge_width)
//! is the same for one homography that is being fitted.

use glam::DVec2;

use super::predict::no_shadows;
use crate::aliasing::texel::{Eye, TexelMap, texel_in_image};
use crate::error::Result;
use crate::focus::Samples;
use crate::parameterization::{Parameterization, Region};
use crate::techniques::Holds;
use crate::techniques::kit::{CAP_PX, capped_px};

/// The mean width, capped at [`CAP_PX`], that a texel of maps of `size` texels has across the edges of the samples' shadows,
/// pixels. An edge that no map holds counts as the cap; 0 without edges.
///
/// # Errors
/// [`Error::InvalidArgument`](crate::Error::InvalidArgument) for samples without shadow states, or a matrix that is not finite.
pub fn edge_width(samples: &Samples, p: &Parameterization, size: [u32; 2]) -> Result<f64> {
    let (Some(picture), Some(shadows)) = (&samples.picture, &samples.shadows) else { return Err(no_shadows()) };
    let camera = &picture.camera;
    let eye = Eye::new(camera, samples.origin, picture.size);
    let local = p.relative_to(samples.origin)?;
    let maps: Vec<TexelMap> = local.partitions.iter().map(|map| TexelMap::new(map, size)).collect();
    let (mut sum, mut weights) = (0.0, 0.0);
    for edge in &shadows.edges {
        let (point, normal) = samples.sample(edge.sample as usize);
        if !samples.counts(camera, &shadows.light, &Region::ALL, point, normal) {
            continue;
        }
        let (at, n) = (point - samples.origin, DVec2::from_array(edge.normal.map(f64::from)));
        let width = local.choose(at, camera.depth_of(point)).map(|k| {
            let [xx, xy, yx, yy] = texel_in_image(&maps[k], &eye, at, normal).jacobian;
            n.dot(DVec2::new(xx, yx)).abs() + n.dot(DVec2::new(xy, yy)).abs()
        });
        let weight = f64::from(edge.weight);
        sum += weight * width.filter(|width| width.is_finite()).map_or(CAP_PX, capped_px);
        weights += weight;
    }
    Ok(if weights > 0.0 { sum / weights } else { 0.0 })
}

/// Samples that maps must hold and do not: of those that face the light all, or those in shadow and their neighbours in the
/// picture.
///
/// # Errors
/// As [`edge_width`].
pub fn missed(samples: &Samples, p: &Parameterization, holds: Holds) -> Result<usize> {
    let (Some(picture), Some(shadows)) = (&samples.picture, &samples.shadows) else { return Err(no_shadows()) };
    let (camera, local) = (&picture.camera, p.relative_to(samples.origin)?);
    let is_missed = |i: usize| {
        let (point, normal) = samples.sample(i);
        samples.counts(camera, &shadows.light, &Region::ALL, point, normal)
            && local.choose(point - samples.origin, camera.depth_of(point)).is_none()
    };
    Ok(match holds {
        Holds::Shadow => shadows.shaded.iter().filter(|&&i| is_missed(i as usize)).count(),
        Holds::Seen | Holds::Body => (0..samples.len()).filter(|&i| is_missed(i)).count(),
    })
}
