//! Wrong pixels of maps that are not drawn, and receivers that maps do not hold, from samples.
//!
//! Source: theory.md (10.9), and its measure: docs/predict.md: over 18 techniques in 43 views the rank correlation with drawn
//! counts is 0.94 in the median; the level is off by 0.6 to 1.6 times, for bias and thin casters are not in it.

use super::asked_maps::{AskedMaps, no_shadows};
use crate::error::Result;
use crate::focus::Samples;
use crate::image::TruthMask;
use crate::parameterization::{Parameterization, Region};
use crate::progress::Progress;

/// Receivers near shadows' edges that are asked (theory.md 10.5).
const RECEIVERS: usize = 8192;

/// The expected number of wrong pixels of the samples' picture through maps of `size` texels.
///
/// # Errors
/// [`Error::InvalidArgument`](crate::Error::InvalidArgument) for samples that do not say, pixel by pixel, what is in shadow; or a
/// matrix that is not finite; [`Error::Interrupted`](crate::error::Error::Interrupted).
pub fn predict(samples: &Samples, p: &Parameterization, size: [u32; 2], progress: &Progress) -> Result<f64> {
    let asked = AskedMaps::new(samples, p, size)?;
    let (picture, shadows) = (asked.picture, asked.shadows);
    if shadows.image.is_empty() {
        return Err(no_shadows());
    }
    let eye = picture.camera.eye();
    let (near, each) = samples.near_edges_watched(RECEIVERS, || progress.check())?;
    let at_pixel = samples.at_pixels(picture, || progress.check())?;
    progress.check()?;
    let (mut flips, mut lost_near) = (0.0, 0);
    for receiver in &near {
        let i = receiver.sample as usize;
        let Some(g) = asked.texel(i) else {
            // Outside of all maps all is lit.
            lost_near += usize::from(receiver.in_shadow);
            continue;
        };
        let (point, normal) = samples.sample(i);
        let is_same = |pixel: usize| {
            at_pixel[pixel].is_some_and(|seen| picture.is_on_plane((point - eye, normal), samples.sample(seen).0 - eye))
        };
        flips += if g.is_finite() { shadows.flips_where(picture, receiver, &g, is_same) } else { 0.5 };
    }
    // What lies far from every edge is wrong where it is in shadow outside of the maps.
    let dark = (0..samples.len()).filter(|&i| shadows.states[i] == TruthMask::SHADOW);
    let lost = asked.lost(dark, progress)?.len();
    Ok((flips + lost_near as f64) * each + lost.saturating_sub(lost_near) as f64)
}

/// Samples that face the light of their shadows and that no map holds, where all is lit: all of them, and those in shadow.
///
/// # Errors
/// As [`predict`].
pub fn outside(samples: &Samples, p: &Parameterization, progress: &Progress) -> Result<[usize; 2]> {
    let asked = AskedMaps::new(samples, p, p.resolution)?;
    let states = &asked.shadows.states;
    let (camera, light) = (&asked.picture.camera, &asked.shadows.light);
    // Those that count, found in one sweep, before a map is asked.
    let facing = samples.facing_watched(camera, light, &Region::ALL, || progress.check())?;
    let lost = asked.unheld(facing.iter().map(|&i| i as usize), progress)?.into_iter();
    let count = |[all, dark]: [usize; 2], i: usize| [all + 1, dark + usize::from(states[i] == TruthMask::SHADOW)];
    Ok(lost.fold([0; 2], count))
}
