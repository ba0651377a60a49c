//! Why a pixel is in false shadow: what its dark texels hold.

use super::displaced::displacement;
use super::looker::{Looker, Way};
use super::rays::{Met, Receiver};
use super::way::{Between, between};
use crate::aliasing::causes::{Holds, Probe, cause, cause_of_shadow};
use crate::aliasing::texel::Eye;

/// The cause of a pixel and how far its edge lies, pixels; NaN where no edge is displaced.
pub(super) fn explain(probe: &Probe, receiver: &Receiver, looker: &mut Looker, eye: &Eye) -> (i8, f64) {
    let (mut holds, mut edge) = (Vec::new(), None);
    // Dark texels that hold more than the receiver's plane: whose they are, which they are.
    for tap in probe.taps.iter().filter(|tap| tap.is_dark && tap.gap > probe.grain) {
        holds.push((tap.weight, Holds::Wrong));
        let held = holds.len() - 1;
        let way = Way::new(receiver, tap.centre, looker.rays);
        let Some(kept) = looker.confirmed(receiver, &way, tap) else { continue };
        holds[held].1 = Holds::Itself;
        let met = kept.first;
        if met.face == receiver.face || kept.held.face == receiver.face {
            continue;
        }
        // Under a caster that has no far side the map may hold what it would shade.
        if kept.held != met && looker.is_continued(receiver, &way, &kept.held) {
            continue;
        }
        // From the centre, where it is dark, towards the pixel.
        let back = way.back();
        let caster = looker.remember(receiver, &met);
        let dark = looker.dark(receiver, &back, caster);
        let here = Met { height: 0.0, at: receiver.p, face: receiver.face, triangle: -1 };
        if dark.is_jump || between(looker, receiver, &way, [here, met]) == Between::Silhouette {
            holds[held].1 = Holds::Caster;
            if edge.is_none_or(|(most, _, _)| tap.weight > most) {
                edge = Some((tap.weight, dark, back));
            }
        }
    }
    let found = cause_of_shadow(&holds);
    let moved = edge.filter(|_| found == cause::EDGE);
    (found, moved.map_or(f64::NAN, |(_, dark, way)| displacement(&dark, &way, receiver, looker.rays, eye)))
}
