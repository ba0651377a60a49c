//! A shadow mask held against ray-traced truth, pixel by pixel.

use crate::error::{Error, Result};
use crate::image::TruthMask;
use crate::progress::Progress;

/// A filtered mask counts as lit from here on.
pub(super) const LIT_FROM: f32 = 0.5;

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

/// Pixels between two looks at the progress: some milliseconds.
const AT_ONCE: usize = 1 << 20;

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
    let mut m = Misclassified::default();
    let mut image = Vec::with_capacity(mask.len());
    for (i, (&light, &truth)) in mask.iter().zip(truth).enumerate() {
        if i % AT_ONCE == 0 {
            progress.check()?;
        }
        if !(light.is_nan() || (0.0..=1.0).contains(&light)) {
            return Err(Error::argument("mask", "values in [0, 1], NaN where nothing is", light, "check the mask"));
        }
        let truth_lit = match truth {
            TruthMask::LIT => true,
            TruthMask::SHADOW => false,
            TruthMask::UNDECIDED | TruthMask::NOTHING => {
                m.undecided += u64::from(truth == TruthMask::UNDECIDED);
                m.unmatched += u64::from((truth == TruthMask::NOTHING) != light.is_nan());
                image.push(code::NOT_COMPARED);
                continue;
            }
            other => {
                let expected = "1 lit, 0 shadow, -1 undecided or -2 nothing";
                return Err(Error::argument("truth", expected, other, "call trace.shadow_mask"));
            }
        };
        if light.is_nan() {
            m.unmatched += 1;
            image.push(code::NOT_COMPARED);
            continue;
        }
        m.compared += 1;
        image.push(match (light >= LIT_FROM, truth_lit) {
            (false, true) => {
                m.false_shadow += 1;
                code::FALSE_SHADOW
            }
            (true, false) => {
                m.false_light += 1;
                code::FALSE_LIGHT
            }
            _ => code::AGREE,
        });
    }
    Ok((m, image))
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
    fn bad_input_is_an_error_and_nothing_compared_is_zero() {
        assert!(misclassified(&[1.0], &[], &Progress::new()).is_err());
        assert!(misclassified(&[1.5], &[1], &Progress::new()).is_err());
        assert!(misclassified(&[1.0], &[7], &Progress::new()).is_err());
        assert_eq!(misclassified(&[f32::NAN], &[-2], &Progress::new()).unwrap().0.fraction(), 0.0);
    }
}
