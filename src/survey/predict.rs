//! Wrong pixels of maps that are not drawn, and receivers that maps do not hold, from samples.
//!
//! Source: theory.md (10.9), and its measure: docs/predict.md.

use super::asked_maps::{AskedMaps, no_shadows};
use super::reading::{Reading, Receiver};
use crate::error::{Error, Result};
use crate::focus::Samples;
use crate::image::TruthMask;
use crate::parameterization::Parameterization;
use crate::progress::Progress;
use crate::render::cpu::lookup::Lookups;
use crate::render::{Bias, Filter, MaskSettings, Stored};

/// Receivers near shadows' edges that are asked (theory.md 10.5).
const RECEIVERS: usize = 8192;
/// Of the other receivers in shadow, and of those in the light, as many are asked: bias and curved surfaces alone make them wrong,
/// which neighbours have in common.
const OTHERS: usize = 2048;
/// Receivers between two looks at whether to go on: a millisecond of work.
const AT_ONCE: usize = 256;

/// The expected number of wrong pixels of the samples' picture through maps of `size` texels. `gaps` has, for each pixel of it, how
/// far before what it shows what shades that lies, world units ([`mapped_gaps`](super::mapped_gaps)).
///
/// # Errors
/// [`Error::InvalidArgument`] for samples that do not say, pixel by pixel, what is in shadow, for gaps of another picture, an unusable
/// bias or a matrix that is not finite; [`Error::Interrupted`].
pub fn predict(
    samples: &Samples,
    p: &Parameterization,
    size: [u32; 2],
    gaps: &[f32],
    bias: Bias,
    progress: &Progress,
) -> Result<f64> {
    let asked = AskedMaps::new(samples, p, size)?;
    let (picture, shadows) = (asked.picture, asked.shadows);
    if shadows.image.is_empty() {
        return Err(no_shadows());
    }
    if gaps.len() != shadows.image.len() {
        let fix = "take those of the samples' own picture";
        return Err(Error::argument("gaps", format!("{} pixels", shadows.image.len()), gaps.len(), fix));
    }
    if let Some(gap) = gaps.iter().find(|gap| !(gap.is_finite() && **gap >= 0.0)) {
        let fix = "0 where nothing shades a pixel";
        return Err(Error::argument("gaps", "finite distances, at least 0", gap, fix));
    }
    let (filter, stored) = (Filter::Nearest, Stored::default());
    let settings = MaskSettings { resolution: size, size: picture.size, bias, filter, blend: 0.0, stored };
    let lookups = Lookups::new(p, &picture.camera, &shadows.light, samples.origin, &settings)?;
    let groups = samples.by_edges_watched([RECEIVERS, OTHERS, OTHERS], || progress.check())?;
    let mut reading = Reading::new(&asked, gaps, samples.at_pixels(picture, || progress.check())?);
    let mut wrong = 0.0;
    for (receivers, each) in groups {
        for (n, receiver) in receivers.iter().enumerate() {
            if n.is_multiple_of(AT_ONCE) {
                progress.check()?;
            }
            let i = receiver.sample as usize;
            // Outside of all maps all is lit, which is counted below.
            let Some((k, texel)) = asked.asked_texel(i) else { continue };
            let (point, normal) = samples.sample(i);
            let (p, map) = (point - samples.origin, lookups.map(k));
            let (place, in_shadow) = (receiver.place, receiver.in_shadow);
            wrong += each * reading.chance(&Receiver { p, normal, place, in_shadow, map, texel });
        }
    }
    let dark = (0..samples.len()).filter(|&i| shadows.states[i] == TruthMask::SHADOW);
    Ok(wrong + asked.lost(dark, progress)?.len() as f64)
}

/// Samples that face the light of their shadows and that no map holds, where all is lit: all of them, and those in shadow.
///
/// # Errors
/// As [`predict`].
pub fn outside(samples: &Samples, p: &Parameterization, progress: &Progress) -> Result<[usize; 2]> {
    let asked = AskedMaps::new(samples, p, p.resolution)?;
    let states = &asked.shadows.states;
    let lost = asked.all_lost(progress)?.into_iter();
    let count = |[all, dark]: [usize; 2], i: usize| [all + 1, dark + usize::from(states[i] == TruthMask::SHADOW)];
    Ok(lost.fold([0; 2], count))
}
