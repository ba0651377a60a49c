//! Why a pixel is wrong: each misclassified pixel has one cause.
//!
//! ```text
//!            light                    acne      what the texel holds is the receiver itself
//!   - - - - - \ - - - -  near         edge      a silhouette passes through the texel: it is drawn where it is not
//!        ______\__ blocker            leak      bias carries the receiver past its blocker: peter-panning at contacts,
//!   gap ^      |s \                             light through thin walls
//!   ____|______|___\_____ receiver    missing   the blocker is not in the map: cut off, beyond it, or thinner than a texel
//! ```
//!
//! Decided by distances along the light ray, in world units: `gap` from the receiver's plane to what a texel holds (at the
//! texel's own centre, so that a slope is no gap), `s` from the receiver to the blocker that is nearest to the light (what an
//! exact map would hold), `carry` of the bias, and `texel`, the world size of a texel across the ray. Nearer than a texel to its
//! plane nothing can be told from the receiver itself at this resolution.

use rayon::prelude::*;

use super::against_truth::code;
use super::distance::distances;
use crate::image::{Surfaces, TruthMask};
use crate::scene::Light;

/// Why a pixel is wrong, as the image of causes has it.
pub mod cause {
    /// The pixel is right.
    pub const NONE: i8 = 0;
    /// A surface shadows itself.
    pub const ACNE: i8 = 1;
    /// A silhouette is displaced.
    pub const EDGE: i8 = 2;
    /// The bias carries the receiver past its caster.
    pub const LEAK: i8 = 3;
    /// The caster is not in the map.
    pub const MISSING: i8 = 4;
    /// Nothing there, or undecided.
    pub const NOT_COMPARED: i8 = -1;
}

/// What the map says at a receiver. Lengths in world units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Probe {
    /// Whether any map holds the receiver and casters above it.
    pub is_held: bool,
    /// World size of a texel across the ray, its longer side.
    pub texel: f64,
    /// How far the bias moves the receiver towards the light.
    pub carry: f64,
    /// From the receiver's plane towards the light to what the texels that were read hold: the largest. Minus infinity for none.
    pub gap: f64,
    /// The same of the texels around, too.
    pub gap_around: f64,
}

/// The blocker of a receiver that is nearest to the light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blocker {
    /// Distance from the receiver, world units.
    pub distance: f64,
    /// Whether the map's volume holds it.
    pub is_in_map: bool,
}

/// The cause of a pixel's error, `error` one of [`code`]; nothing where there is none.
pub fn cause_of(error: i8, probe: &Probe, blocker: Option<Blocker>) -> i8 {
    match error {
        code::FALSE_SHADOW if probe.is_held && probe.gap <= probe.texel => cause::ACNE,
        code::FALSE_SHADOW => cause::EDGE,
        code::FALSE_LIGHT => cause_of_light(probe, blocker),
        code::NOT_COMPARED => cause::NOT_COMPARED,
        _ => cause::NONE,
    }
}

fn cause_of_light(probe: &Probe, blocker: Option<Blocker>) -> i8 {
    // A blocker that no ray finds again grazes the receiver's ray: its silhouette passes here.
    let Some(blocker) = blocker else { return cause::EDGE };
    if !probe.is_held || !blocker.is_in_map {
        return cause::MISSING;
    }
    if blocker.distance <= probe.carry {
        return cause::LEAK;
    }
    // Something around casts a shadow on this plane: nearer to the light than bias carries, and either more than a texel, or
    // half as far as the blocker that should be there.
    let least = probe.carry.max(0.5 * blocker.distance.min(probe.texel));
    if probe.gap_around > least { cause::EDGE } else { cause::MISSING }
}

/// How far from each wrong pixel the nearest one is whose truth is what the map says there, among surfaces that face the light;
/// NaN where the pixel is right.
pub fn displacement(surfaces: &Surfaces, light: &Light, differences: &[i8], truth: &[i8]) -> Vec<f32> {
    let is = |wanted: i8| -> Vec<bool> {
        (0..truth.len())
            .into_par_iter()
            .map(|i| {
                truth[i] == wanted
                    && surfaces.receiver(i).is_some_and(|(p, n)| light.illuminates(surfaces.origin + p, n))
            })
            .collect()
    };
    let (to_shadow, to_light) =
        (distances(&is(TruthMask::SHADOW), surfaces.size), distances(&is(TruthMask::LIT), surfaces.size));
    let one = |(i, &error): (usize, &i8)| match error {
        code::FALSE_SHADOW => to_shadow[i],
        code::FALSE_LIGHT => to_light[i],
        _ => f32::NAN,
    };
    differences.iter().enumerate().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const HELD: Probe = Probe { is_held: true, texel: 1.0, carry: 0.2, gap: 5.0, gap_around: 5.0 };
    const FAR: Option<Blocker> = Some(Blocker { distance: 5.0, is_in_map: true });

    #[test]
    fn each_cause_has_its_picture() {
        assert_eq!(cause_of(code::AGREE, &HELD, None), cause::NONE);
        assert_eq!(cause_of(code::NOT_COMPARED, &HELD, None), cause::NOT_COMPARED);
        assert_eq!(cause_of(code::FALSE_SHADOW, &HELD, None), cause::EDGE);
        assert_eq!(cause_of(code::FALSE_SHADOW, &Probe { gap: 0.3, ..HELD }, None), cause::ACNE);
        assert_eq!(cause_of(code::FALSE_LIGHT, &HELD, FAR), cause::EDGE);
        assert_eq!(cause_of(code::FALSE_LIGHT, &HELD, Some(Blocker { distance: 0.1, is_in_map: true })), cause::LEAK);
        assert_eq!(
            cause_of(code::FALSE_LIGHT, &HELD, Some(Blocker { distance: 5.0, is_in_map: false })),
            cause::MISSING
        );
        assert_eq!(cause_of(code::FALSE_LIGHT, &Probe { is_held: false, ..HELD }, FAR), cause::MISSING);
        let thin = Probe { gap: 0.0, gap_around: f64::NEG_INFINITY, ..HELD };
        assert_eq!(cause_of(code::FALSE_LIGHT, &thin, FAR), cause::MISSING);
        // A contact nearer than a texel is an edge where the texel beside it holds the caster.
        let contact = Some(Blocker { distance: 0.5, is_in_map: true });
        assert_eq!(cause_of(code::FALSE_LIGHT, &Probe { gap_around: 0.4, ..HELD }, contact), cause::EDGE);
        assert_eq!(cause_of(code::FALSE_LIGHT, &Probe { gap_around: 0.1, ..HELD }, contact), cause::MISSING);
    }
}
