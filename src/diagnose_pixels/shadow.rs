//! Why a pixel is in false shadow: what its dark texels hold.

use super::displaced::displacement;
use super::looker::{Looker, Way};
use super::rays::{Met, Receiver};
use super::way::{Between, between};
use crate::aliasing::causes::{Holds, Probe, cause, cause_of_shadow};
use crate::aliasing::texel::Eye;

/// The cause of a pixel and how far its edge lies, pixels; NaN where no edge is displaced.
pub(super) fn explain(probe: &Probe, receiver: &Receiver, looker: &mut Looker, eye: &Eye) -> (i8, f64) {
    let (mut holds, mut edge) = ([(0.0, Holds::Itself); 4], None);
    // Dark texels that hold more than the receiver's plane: whose they are, which they are.
    let dark = |k: &usize| probe.taps[*k].is_dark && probe.taps[*k].gap > probe.grain;
    for k in (0..4).filter(dark) {
        let tap = &probe.taps[k];
        holds[k] = (tap.weight, Holds::Wrong);
        let way = Way::new(receiver, tap.centre, looker.rays);
        let Some(met) = looker.confirmed(receiver, &way, tap.gap) else { continue };
        holds[k].1 = Holds::Itself;
        if met.face == receiver.face {
            continue;
        }
        // From the centre, where it is dark, towards the pixel.
        let back = way.back();
        let caster = looker.remember(receiver, &met);
        let dark = looker.dark(receiver, &back, caster);
        let here = Met { height: 0.0, at: receiver.p, face: receiver.face, triangle: -1 };
        if dark.is_jump || between(looker, receiver, &way, [here, met]) == Between::Silhouette {
            holds[k].1 = Holds::Caster;
            if edge.is_none_or(|(most, _, _)| tap.weight > most) {
                edge = Some((tap.weight, dark, back));
            }
        }
    }
    let found = cause_of_shadow(&holds);
    let moved = edge.filter(|_| found == cause::EDGE);
    (found, moved.map_or(f64::NAN, |(_, dark, way)| displacement(&dark, &way, receiver, looker.rays, eye)))
}
