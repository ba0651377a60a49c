//! A shadow mask held against ray-traced truth, pixel by pixel.

use std::mem::MaybeUninit;

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::image::{ShadowMask, TruthMask};
use crate::memory::{unwritten, written};
use crate::progress::Progress;

/// How many pixels are right and wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Misclassified {
    /// The map says shadow, rays say lit: acne, lost light.
    pub false_shadow: u64,
    /// The map says lit, rays say shadow: leaks, peter-panning, lost casters.
    pub false_light: u64,
    /// Pixels that show something in both and that rays could decide.
    pub compared: u64,
    /// Pixels whose truth changes with the numerical offset of the ray.
    pub undecided: u64,
    /// Pixels in which only one of the two saw a surface: silhouettes against the background.
    pub unmatched: u64,
}

/// What the difference image says of a pixel.
pub mod code {
    /// Mask and truth agree.
    pub const AGREE: i8 = 0;
    /// Shadow where there should be light.
    pub const FALSE_SHADOW: i8 = 1;
    /// Light where there should be shadow.
    pub const FALSE_LIGHT: i8 = 2;
    /// Nothing there, or undecided.
    pub const NOT_COMPARED: i8 = -1;
}

impl Misclassified {
    /// All wrong pixels.
    pub fn count(&self) -> u64 {
        self.false_shadow + self.false_light
    }
    /// Wrong pixels by compared pixels; 0 where nothing was compared.
    pub fn fraction(&self) -> f64 {
        if self.compared == 0 { 0.0 } else { self.count() as f64 / self.compared as f64 }
    }
}

/// Pixels between two looks at the progress: well below a millisecond.
const AT_ONCE: usize = 1 << 16;

/// The counts and the difference image (see [`code`]) of a mask and the truth of the same view.
///
/// # Errors
/// [`Error::InvalidArgument`] where the sizes differ, a mask value lies outside [0, 1], or a truth value is none of
/// [`TruthMask`]'s. [`Error::Interrupted`].
pub fn misclassified(mask: &[f32], truth: &[i8], progress: &Progress) -> Result<(Misclassified, Vec<i8>)> {
    if mask.len() != truth.len() {
        let expected = format!("as many pixels as the mask: {}", mask.len());
        return Err(Error::argument("truth", expected, truth.len(), "render both at one size"));
    }
    let mut image = unwritten::<i8>(mask.len())?;
    let part = |mask: &[f32], truth: &[i8], image: &mut [MaybeUninit<i8>]| {
        progress.check()?;
        let mut m = Misclassified::default();
        for ((&light, &truth), code) in mask.iter().zip(truth).zip(image) {
            code.write(m.add(light, truth)?);
        }
        Ok(m)
    };
    // Little is done on the calling thread, which may be none of a pool.
    let parts: Vec<Result<Misclassified>> = if mask.len() <= AT_ONCE {
        vec![part(mask, truth, &mut image)]
    } else {
        let parts = mask.par_chunks(AT_ONCE).zip(truth.par_chunks(AT_ONCE)).zip(image.par_chunks_mut(AT_ONCE));
        parts.map(|((mask, truth), image)| part(mask, truth, image)).collect()
    };
    let mut all = Misclassified::default();
    // Of several errors the first in the picture.
    for found in parts {
        let m = found?;
        all.false_shadow += m.false_shadow;
        all.false_light += m.false_light;
        all.compared += m.compared;
        all.undecided += m.undecided;
        all.unmatched += m.unmatched;
    }
    // SAFETY: every pixel has been written, or the error has been returned.
    Ok((all, unsafe { written(image) }))
}

impl Misclassified {
    /// Counts a pixel; its code.
    fn add(&mut self, light: f32, truth: i8) -> Result<i8> {
        if !(light.is_nan() || (0.0..=1.0).contains(&light)) {
            return Err(Error::argument("mask", "values in [0, 1], NaN where nothing is", light, "check the mask"));
        }
        let truth_lit = match truth {
            TruthMask::LIT => true,
            TruthMask::SHADOW => false,
            TruthMask::UNDECIDED | TruthMask::NOTHING => {
                self.undecided += u64::from(truth == TruthMask::UNDECIDED);
                self.unmatched += u64::from((truth == TruthMask::NOTHING) != light.is_nan());
                return Ok(code::NOT_COMPARED);
            }
            other => {
                let expected = "1 lit, 0 shadow, -1 undecided or -2 nothing";
                return Err(Error::argument("truth", expected, other, "call trace.shadow_mask"));
            }
        };
        if light.is_nan() {
            self.unmatched += 1;
            return Ok(code::NOT_COMPARED);
        }
        self.compared += 1;
        Ok(match (light >= ShadowMask::LIT_FROM, truth_lit) {
            (false, true) => {
                self.false_shadow += 1;
                code::FALSE_SHADOW
            }
            (true, false) => {
                self.false_light += 1;
                code::FALSE_LIGHT
            }
            _ => code::AGREE,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_combination_is_counted_once() {
        let mask = [1.0, 0.0, 1.0, 0.0, 1.0, f32::NAN, f32::NAN, 0.0];
        let truth = [1, 0, 0, 1, -1, -2, 1, -2];
        let (m, image) = misclassified(&mask, &truth, &Progress::new()).unwrap();
        assert_eq!(image, [0, 0, 2, 1, -1, -1, -1, -1]);
        let expected = Misclassified { false_shadow: 1, false_light: 1, compared: 4, undecided: 1, unmatched: 2 };
        assert_eq!(m, expected);
        assert_eq!(m.fraction(), 0.5);
    }

    #[test]
    fn one_flipped_pixel_changes_the_count() {
        let truth = [1i8; 64];
        let mut mask = [1f32; 64];
        assert_eq!(misclassified(&mask, &truth, &Progress::new()).unwrap().0.count(), 0);
        mask[17] = 0.0;
        assert_eq!(misclassified(&mask, &truth, &Progress::new()).unwrap().0.count(), 1);
    }

    #[test]
    fn many_pixels_are_counted_as_few_are() {
        let n = 3 * AT_ONCE + 17;
        let mask: Vec<f32> = (0..n).map(|i| if i % 11 == 0 { f32::NAN } else { (i % 3) as f32 / 2.0 }).collect();
        let mut truth: Vec<i8> = (0..n).map(|i| (i % 4) as i8 - 2).collect();
        let (m, image) = misclassified(&mask, &truth, &Progress::new()).unwrap();
        let (mut counted, mut codes) = (Misclassified::default(), Vec::new());
        for (&light, &truth) in mask.iter().zip(&truth) {
            codes.push(counted.add(light, truth).unwrap());
        }
        assert_eq!((m, image), (counted, codes));
        (truth[2 * AT_ONCE], truth[n - 1]) = (7, 9);
        assert!(misclassified(&mask, &truth, &Progress::new()).unwrap_err().to_string().contains("got 7"));
    }

    #[test]
    fn bad_input_is_an_error_and_nothing_compared_is_zero() {
        assert!(misclassified(&[1.0], &[], &Progress::new()).is_err());
        assert!(misclassified(&[1.5], &[1], &Progress::new()).is_err());
        assert!(misclassified(&[1.0], &[7], &Progress::new()).is_err());
        assert_eq!(misclassified(&[f32::NAN], &[-2], &Progress::new()).unwrap().0.fraction(), 0.0);
    }
}
