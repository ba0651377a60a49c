//! Why a pixel is wrong: each misclassified pixel has one cause.
//!
//! ```text
//!            light                    acne      a surface shadows itself, or a lit one its lit neighbour in a crease
//!   - - - - - \ - - - -  near         edge      a silhouette passes within a texel: it is drawn where it is not
//!        ______\__ blocker            leak      without its bias the pixel would be dark: peter-panning at contacts,
//!   gap ^      |s \                             light through thin walls
//!   ____|______|___\_____ receiver    missing   the blocker is not in the map: cut off, beyond it, or thinner than a texel
//!                                     other     what the map holds is not what the light meets: a wrong map
//! ```
//!
//! Counterfactuals on the very texels that were read. A pixel in false shadow is acne where it would be lit if the texels that
//! hold the receiver itself were: those whose `gap`, from the receiver's plane to what they hold (at the texel's own centre, so
//! that a slope is no gap), is no larger than a texel. Nearer than that to its plane nothing can be told from the receiver at
//! this resolution. A pixel in false light is a leak where it would be dark without bias, by texels that hold a caster: at
//! least half as far from the plane as the blocker (or a texel) is. Edges have a shadow's edge to be displaced: a pixel whose
//! truth is what the map says, within the texel's extent in the image.

use glam::DVec3;
use rayon::prelude::*;

use super::against_truth::{LIT_FROM, code};
use super::distance::distances;
use crate::error::Result;
use crate::image::{Surfaces, TruthMask};
use crate::progress::Progress;
use crate::scene::Light;

/// Why a pixel is wrong, as the image of causes has it.
pub mod cause {
    /// The pixel is right.
    pub const NONE: i8 = 0;
    /// A surface shadows itself, or its lit neighbour.
    pub const ACNE: i8 = 1;
    /// A silhouette is displaced.
    pub const EDGE: i8 = 2;
    /// The bias carries the receiver past its caster.
    pub const LEAK: i8 = 3;
    /// The caster is not in the map.
    pub const MISSING: i8 = 4;
    /// The map holds what the light does not meet.
    pub const OTHER: i8 = 5;
    /// Nothing there, or undecided.
    pub const NOT_COMPARED: i8 = -1;
}

/// A texel that a lookup reads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tap {
    /// Its weight; those of a lookup sum to 1.
    pub weight: f64,
    /// From the receiver's plane towards the light to what it holds, world units; minus infinity for nothing.
    pub gap: f64,
    /// Whether the comparison says shadow.
    pub is_dark: bool,
    /// Whether it would without bias.
    pub is_dark_unbiased: bool,
}

impl Default for Tap {
    /// One that is not read.
    fn default() -> Self {
        Self { weight: 0.0, gap: f64::NEG_INFINITY, is_dark: false, is_dark_unbiased: false }
    }
}

/// What the map says at a receiver. Lengths in world units unless the name says otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Probe {
    /// Whether any map holds the receiver and casters above it.
    pub is_held: bool,
    /// World size of a texel across the ray, its longer side.
    pub texel: f64,
    /// The texels that are read; the rest have no weight.
    pub taps: [Tap; 4],
    /// The largest gap of the texels read and of those around.
    pub gap_around: f64,
    /// Where the ray of the dark texel of the largest gap meets the receiver's plane, and that gap.
    pub darkest: Option<(DVec3, f64)>,
    /// How far in the image a silhouette may be displaced, pixels.
    pub reach_px: f64,
}

/// The blocker of a receiver that is nearest to the light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blocker {
    /// Distance from the receiver, world units.
    pub distance: f64,
    /// Whether the map's volume holds it.
    pub is_in_map: bool,
}

impl Probe {
    /// The share of dark among the texels that satisfy a condition.
    fn dark(&self, is_meant: impl Fn(&Tap) -> bool) -> f64 {
        self.taps.iter().filter(|tap| is_meant(tap)).map(|tap| tap.weight).sum()
    }
}

/// The cause of a pixel in false shadow, the nearest pixel in true shadow being `distance` away; nothing where that depends on
/// whether the map is right at [`Probe::darkest`]: [`cause::ACNE`] then, else [`cause::OTHER`].
pub fn cause_of_shadow(probe: &Probe, distance: f64) -> Option<i8> {
    // What would remain dark if the receiver did not shade itself.
    let others = probe.dark(|tap| tap.is_dark && tap.gap > probe.texel);
    if 1.0 - others >= f64::from(LIT_FROM) {
        return Some(cause::ACNE);
    }
    (distance <= probe.reach_px).then_some(cause::EDGE)
}

/// The cause of a pixel in false light, the nearest pixel in true light being `distance` away.
pub fn cause_of_light(probe: &Probe, blocker: Option<Blocker>, distance: f64) -> i8 {
    let near_edge = distance <= probe.reach_px;
    let Some(blocker) = blocker else {
        // A blocker that no ray finds again grazes the receiver's ray.
        return if near_edge { cause::EDGE } else { cause::OTHER };
    };
    if !probe.is_held || !blocker.is_in_map {
        return cause::MISSING;
    }
    let least = 0.5 * blocker.distance.min(probe.texel);
    if 1.0 - probe.dark(|tap| tap.is_dark_unbiased && tap.gap > least) < f64::from(LIT_FROM) {
        return cause::LEAK;
    }
    if near_edge && probe.gap_around > least { cause::EDGE } else { cause::MISSING }
}

/// How far from each wrong pixel the nearest one is whose truth is what the map says there, among surfaces that face the light;
/// infinite where there is none, NaN where the pixel is right.
///
/// # Errors
/// [`crate::Error::Interrupted`].
pub fn displacement(
    surfaces: &Surfaces,
    light: &Light,
    differences: &[i8],
    truth: &[i8],
    progress: &Progress,
) -> Result<Vec<f32>> {
    let faces_light: Vec<bool> = (0..truth.len())
        .into_par_iter()
        .map(|i| surfaces.receiver(i).is_some_and(|(p, n)| light.illuminates(surfaces.origin + p, n)))
        .collect();
    let to = |wanted: i8| {
        let set: Vec<bool> = truth.iter().zip(&faces_light).map(|(&t, &faces)| t == wanted && faces).collect();
        distances(&set, surfaces.size, progress)
    };
    let (to_shadow, to_light) = (to(TruthMask::SHADOW)?, to(TruthMask::LIT)?);
    let one = |(i, &error): (usize, &i8)| match error {
        code::FALSE_SHADOW => to_shadow[i],
        code::FALSE_LIGHT => to_light[i],
        _ => f32::NAN,
    };
    Ok(differences.iter().enumerate().map(one).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const CASTER: Tap = Tap { weight: 1.0, gap: 5.0, is_dark: true, is_dark_unbiased: true };
    const ITSELF: Tap = Tap { weight: 1.0, gap: 0.3, is_dark: true, is_dark_unbiased: true };
    const LIT: Tap = Tap { weight: 1.0, gap: -1.0, is_dark: false, is_dark_unbiased: false };

    fn probe(taps: &[Tap]) -> Probe {
        let mut all = [Tap::default(); 4];
        for (to, tap) in all.iter_mut().zip(taps) {
            *to = Tap { weight: tap.weight / taps.len() as f64, ..*tap };
        }
        Probe { is_held: true, texel: 1.0, taps: all, gap_around: 5.0, darkest: None, reach_px: 4.0 }
    }

    #[test]
    fn false_shadow_is_acne_an_edge_or_asks_whether_the_map_is_right() {
        assert_eq!(cause_of_shadow(&probe(&[ITSELF]), 1.0), Some(cause::ACNE));
        assert_eq!(cause_of_shadow(&probe(&[CASTER]), 1.0), Some(cause::EDGE));
        assert_eq!(cause_of_shadow(&probe(&[CASTER]), 4.5), None);
        // Lit taps have no say, however large their gap; of the dark ones those of the receiver itself decide.
        let high = Tap { gap: 9.0, ..LIT };
        assert_eq!(cause_of_shadow(&probe(&[ITSELF, high, ITSELF, high]), 1.0), Some(cause::ACNE));
        assert_eq!(cause_of_shadow(&probe(&[ITSELF, CASTER, CASTER, CASTER]), 1.0), Some(cause::EDGE));
        assert_eq!(cause_of_shadow(&probe(&[ITSELF, ITSELF, CASTER, CASTER]), 1.0), Some(cause::ACNE));
    }

    #[test]
    fn false_light_is_a_leak_only_where_the_bias_made_it() {
        let far = Some(Blocker { distance: 5.0, is_in_map: true });
        let past = Tap { is_dark: false, ..CASTER };
        assert_eq!(cause_of_light(&probe(&[past]), far, 1.0), cause::LEAK);
        // Lit without bias, too.
        assert_eq!(cause_of_light(&probe(&[LIT]), far, 1.0), cause::EDGE);
        assert_eq!(cause_of_light(&probe(&[LIT]), far, 9.0), cause::MISSING);
        // Dark without bias, but by the receiver itself.
        let acne = Tap { gap: 0.01, is_dark: false, ..CASTER };
        assert_eq!(cause_of_light(&probe(&[acne]), far, 1.0), cause::EDGE);
        // A contact nearer than a texel is told from the receiver by half its distance.
        let contact = Some(Blocker { distance: 0.02, is_in_map: true });
        let touching = Tap { gap: 0.015, is_dark: false, ..CASTER };
        assert_eq!(cause_of_light(&probe(&[touching]), contact, 1.0), cause::LEAK);
        let thin = Probe { gap_around: f64::NEG_INFINITY, ..probe(&[LIT]) };
        assert_eq!(cause_of_light(&thin, far, 1.0), cause::MISSING);
        assert_eq!(
            cause_of_light(&probe(&[past]), Some(Blocker { distance: 5.0, is_in_map: false }), 1.0),
            cause::MISSING
        );
        assert_eq!(cause_of_light(&Probe { is_held: false, ..probe(&[LIT]) }, far, 1.0), cause::MISSING);
        assert_eq!(cause_of_light(&probe(&[LIT]), None, 1.0), cause::EDGE);
        assert_eq!(cause_of_light(&probe(&[LIT]), None, 9.0), cause::OTHER);
    }
}
