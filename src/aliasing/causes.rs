//! Why a pixel is wrong: each misclassified pixel has one cause.
//!
//! ```text
//!            light                    acne      a surface shadows itself, or a lit one its lit neighbour in a crease
//!   - - - - - \ - - - -  near         edge      a silhouette passes between the pixel and a texel's centre: drawn elsewhere
//!        ______\__ blocker            leak      without its bias the pixel would be dark: peter-panning at contacts,
//!   gap ^      |s \                             light through thin walls
//!   ____|______|___\_____ receiver    missing   the map does not hold the caster: cut off, or its shadow holds no texel's centre
//!                                     other     the stored surface does not exist along that ray: the map is wrong
//! ```
//!
//! Counterfactuals on the texels that were read. What a dark texel holds ([`Holds`]) is found by following what light meets from
//! the pixel's own ray to that of the texel's centre: the same surface all of the way, or another beyond a silhouette. Nothing
//! depends on how far apart or how high the surfaces are, so that a caster close to its receiver or to the next one is not
//! taken for it.

use glam::DVec2;

use crate::image::ShadowMask;

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
    /// Its centre in the map, texels.
    pub centre: DVec2,
    /// From the receiver's plane towards the light to what it holds, world units; minus infinity for nothing.
    pub gap: f64,
    /// One step of the map's numbers there, world units along the light's ray.
    pub step: f64,
    /// Whether the comparison says shadow.
    pub is_dark: bool,
    /// Whether it would without bias.
    pub is_dark_unbiased: bool,
}

/// What the map says at a receiver. Lengths in world units unless the name says otherwise.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Probe {
    /// Whether any map holds the receiver and casters above it.
    pub is_held: bool,
    /// The receiver's place in it, texels.
    pub place: DVec2,
    /// World size of a texel across the ray, its longer side.
    pub texel: f64,
    /// The tangent of the angle between the receiver's normal and the light.
    pub slope: f64,
    /// A gap up to which the map cannot tell a surface from the receiver's plane: rasterisers round vertices to a part of a
    /// texel, and depths to single precision.
    pub grain: f64,
    /// The same of a ray: single precision of the receiver's position.
    pub touch: f64,
    /// The texels that are read with a weight.
    pub taps: Vec<Tap>,
    /// Gaps of the texel that the receiver falls into and of the eight about it, rows from the top; minus infinity where they
    /// were not asked for.
    pub around: [f64; 9],
}

impl Probe {
    /// Whether a texel makes it dark without bias, and holds another surface than the receiver's plane.
    pub fn is_meant(&self, tap: &Tap) -> bool {
        tap.is_dark_unbiased && tap.gap.abs() > self.grain
    }
    /// The share of such texels.
    pub fn dark_unbiased(&self) -> f64 {
        self.taps.iter().filter(|tap| self.is_meant(tap)).map(|tap| tap.weight).sum()
    }
    /// The centre of one of the texels that [`Probe::around`] lists.
    pub fn centre_of(&self, around: usize) -> DVec2 {
        self.place.floor() + DVec2::new((around % 3) as f64, (around / 3) as f64) - 0.5
    }
}

/// What a texel holds, seen from a receiver.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Holds {
    /// The receiver's own surface, or one that continues it without a silhouette in between.
    Itself,
    /// A surface beyond a silhouette.
    Caster,
    /// Nothing that light meets there.
    Wrong,
}

/// What keeps the light from a receiver.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Blocker {
    /// No ray finds it again: it grazes the receiver's own.
    Grazing,
    /// All of it lies outside of the map's depths.
    CutOff,
    /// Some of it lies within the map's depths.
    Held,
}

/// Whether a share of dark makes a pixel dark.
pub fn is_dark(share: f64) -> bool {
    1.0 - share < f64::from(ShadowMask::LIT_FROM)
}

/// The cause of a pixel in false shadow, from the weights of its dark texels and what they hold.
pub fn cause_of_shadow(taps: &[(f64, Holds)]) -> i8 {
    let share = |of: Holds| taps.iter().filter(|(_, holds)| *holds == of).map(|(weight, _)| weight).sum::<f64>();
    let (casters, wrong) = (share(Holds::Caster), share(Holds::Wrong));
    // What would remain dark if the receiver did not shade itself.
    match is_dark(casters + wrong) {
        false => cause::ACNE,
        true if casters >= wrong => cause::EDGE,
        true => cause::OTHER,
    }
}

/// The cause of a pixel in false light whose blocker the map could hold and which is no leak: `is_right` where the map holds
/// what light meets, `is_drawn` where the blocker's shadow about the pixel holds a texel's centre.
pub fn cause_of_light(is_right: bool, is_drawn: bool) -> i8 {
    match (is_right, is_drawn) {
        (false, _) => cause::OTHER,
        (true, true) => cause::EDGE,
        (true, false) => cause::MISSING,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Holds::{Caster, Itself, Wrong};

    #[test]
    fn false_shadow_is_acne_where_it_would_be_lit_without_the_receiver() {
        assert_eq!(cause_of_shadow(&[(1.0, Itself)]), cause::ACNE);
        assert_eq!(cause_of_shadow(&[(1.0, Caster)]), cause::EDGE);
        assert_eq!(cause_of_shadow(&[(1.0, Wrong)]), cause::OTHER);
        assert_eq!(cause_of_shadow(&[(0.25, Itself), (0.25, Caster), (0.5, Caster)]), cause::EDGE);
        // At one half it is lit.
        assert_eq!(cause_of_shadow(&[(0.3, Itself), (0.5, Caster)]), cause::ACNE);
        assert_eq!(cause_of_shadow(&[(0.3, Wrong), (0.4, Caster)]), cause::EDGE);
        assert_eq!(cause_of_shadow(&[(0.4, Wrong), (0.3, Caster), (0.3, Itself)]), cause::OTHER);
    }

    #[test]
    fn false_light_is_dark_without_bias_by_what_stands_above_the_plane() {
        let tap = |gap| {
            let (centre, is_dark, is_dark_unbiased) = (DVec2::ZERO, false, true);
            Tap { weight: 0.5, centre, gap, step: 0.0, is_dark, is_dark_unbiased }
        };
        let probe = |a, b| Probe { grain: 0.01, taps: vec![tap(a), tap(b)], ..Probe::default() };
        assert_eq!(probe(5.0, 0.02).dark_unbiased(), 1.0);
        assert_eq!(probe(5.0, 0.005).dark_unbiased(), 0.5);
        assert!(is_dark(0.51) && !is_dark(0.5));
        assert_eq!(cause_of_light(false, true), cause::OTHER);
        assert_eq!(cause_of_light(true, true), cause::EDGE);
        assert_eq!(cause_of_light(true, false), cause::MISSING);
    }

    #[test]
    fn the_nine_texels_about_a_place_have_its_own_in_the_middle() {
        let probe = Probe { place: DVec2::new(7.2, 3.9), ..Probe::default() };
        assert_eq!(probe.centre_of(4), DVec2::new(7.5, 3.5));
        assert_eq!(probe.centre_of(0), DVec2::new(6.5, 2.5));
        assert_eq!(probe.centre_of(5), DVec2::new(8.5, 3.5));
    }
}
