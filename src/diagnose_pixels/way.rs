//! What lies between a pixel and where the ray of a texel's centre meets its plane: a silhouette, or one surface.
//!
//! ```text
//!          h        _____             t = 0 at the pixel, 1 at the centre. Light meets surfaces at heights h over the plane. Of
//!   height |  __   |     |            the steps across which the height changes much, the one nearest to the centre has the
//!  ___P____|_|__|__|_____|_q_ plane   edge of what the texel holds, however many others there are. Halving it tells a
//!   t=0                  t=1          silhouette, where the height jumps, from a surface that rises: acne, a crease.
//! ```

use glam::DVec2;

use super::looker::{Looker, Way};
use super::rays::{Met, Receiver};

/// Steps that the way is looked at in: edges nearer together than one may be taken for each other.
const STEPS: usize = 4;
/// The part of the largest change of height that makes a step one with an edge: the next bar stands about as high.
const MUCH: f64 = 0.5;
/// Halvings after which a change of height that follows from a slope is a surface's own: 1/256 of the way.
const CERTAIN: u32 = 6;
/// The steepest rise of a lit surface over the receiver's plane, texels a texel, beside what the plane's own slope adds:
/// derived from 3.6 degrees between the surface and the light.
const STEEPEST: f64 = 16.0;
/// Steps in which a receiver's own surface is followed.
const FOLLOWED: usize = 16;
/// Steps before its end, in which it has to be there.
const LED: usize = 3;
/// The steepest rise of a surface that is followed, texels a texel, beside what the plane's own slope adds.
const FOLLOWED_RISE: f64 = 8.0;

/// What lies between the ends of a way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Between {
    /// A silhouette.
    Silhouette,
    /// One surface.
    Surface,
}

/// A place on a way, and what light meets there.
type Look = (f64, Met);

/// How much higher the second look is, world units.
fn rise([(_, near), (_, far)]: &[Look; 2]) -> f64 {
    if near.height == far.height { 0.0 } else { far.height - near.height }
}

/// How far a surface of a steepness can rise along a part of a way, world units.
fn most(steepest: f64, receiver: &Receiver, texels: f64) -> f64 {
    steepest * (1.0 + receiver.slope) * texels * receiver.texel
}

/// What is between the ends of a step, as far as that is known.
fn decided(step: &[Look; 2], receiver: &Receiver, way: &Way, is_last: bool) -> Option<Between> {
    let [(from, near), (to, far)] = step;
    let is_jump = rise(step).abs() > steepest_rise(receiver, (to - from) * way.length());
    match near.face == far.face || (is_last && !is_jump) {
        true => Some(Between::Surface),
        false if is_jump => Some(Between::Silhouette),
        false => None,
    }
}

/// How far any surface can rise along a part of a way, texels, in world units.
pub(super) fn steepest_rise(receiver: &Receiver, texels: f64) -> f64 {
    most(STEEPEST, receiver, texels)
}

/// What is between the ends of a way from a receiver, at which light meets what is known.
pub(super) fn between(looker: &mut Looker, receiver: &Receiver, way: &Way, [near, far]: [Met; 2]) -> Between {
    let whole = [(0.0, near), (1.0, far)];
    // Nothing that lies on the way can take a jump of all of it back.
    if let Some(between) = decided(&whole, receiver, way, false) {
        return between;
    }
    let mut looks = [whole[0]; STEPS + 1];
    for k in 1..STEPS {
        let t = k as f64 / STEPS as f64;
        looks[k] = (t, looker.met(receiver, way.at(t), Met::ANYWHERE));
    }
    looks[STEPS] = whole[1];
    let steps = || looks.windows(2).map(|two| [two[0], two[1]]).rev();
    let most = steps().map(|step| rise(&step).abs()).fold(0.0, f64::max);
    // Where one surface fills the step that changes most, the edge may lie in another.
    for step in steps().filter(|step| rise(step).abs() >= MUCH * most).take(2) {
        if halved(looker, receiver, way, step) == Between::Silhouette {
            return Between::Silhouette;
        }
    }
    Between::Surface
}

/// What is between the ends of a step, by its halves across which the height changes more.
fn halved(looker: &mut Looker, receiver: &Receiver, way: &Way, mut step: [Look; 2]) -> Between {
    for halvings in 0..=CERTAIN {
        if let Some(between) = decided(&step, receiver, way, halvings == CERTAIN) {
            return between;
        }
        let t = 0.5 * (step[0].0 + step[1].0);
        let middle = (t, looker.met(receiver, way.at(t), Met::ANYWHERE));
        let halves = [[step[0], middle], [middle, step[1]]];
        step = if rise(&halves[0]).abs() > rise(&halves[1]).abs() { halves[0] } else { halves[1] };
    }
    Between::Surface
}

/// How far a receiver's own surface that is followed to a texel's centre can leave its plane, world units.
pub(super) fn rise_of_followed(receiver: &Receiver, centre: DVec2) -> f64 {
    most(FOLLOWED_RISE, receiver, receiver.place.distance(centre))
}

/// Whether a receiver's own surface goes on below all else to what light meets at the end of a way.
pub(super) fn is_continued(looker: &mut Looker, receiver: &Receiver, way: &Way, end: &Met) -> bool {
    let rise = rise_of_followed(receiver, way.places[1]) / FOLLOWED as f64;
    // Back from the end, first: where nothing near enough to what is met there precedes it, nothing leads to it.
    for back in 1..=LED {
        let (t, reach) = (1.0 - back as f64 / FOLLOWED as f64, back as f64 * rise);
        if looker.met(receiver, way.at(t), [end.height - reach, end.height + reach]).triangle < 0 {
            return false;
        }
    }
    let (mut height, mut face) = (0.0, receiver.face);
    for step in 1..=FOLLOWED {
        let t = step as f64 / FOLLOWED as f64;
        let met = looker.met(receiver, way.at(t), [height - 2.0 * rise, height + rise]);
        if met.height < height - rise {
            return false;
        }
        (height, face) = (met.height, met.face);
    }
    face == end.face
}
