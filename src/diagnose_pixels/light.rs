//! Why a pixel is in false light: what became of what keeps the light from it.

use glam::{DVec2, DVec3};

use super::caster::Caster;
use super::displaced::displacement;
use super::kept::Kept;
use super::looker::{Dark, Looker, Way};
use super::rays::{Met, Receiver};
use super::way::{Between, between, rise_of_followed};
use crate::aliasing::causes::{Blocker, Probe, cause, cause_of_light, is_dark};
use crate::aliasing::texel::Eye;

/// Where another shadow is looked for between a lit texel's centre and the end of the pixel's own shadow, parts of the way.
const LOOKS: [f64; 3] = [0.75, 0.5, 0.25];

/// The cause of a pixel and how far its edge lies, pixels; NaN where no edge is displaced. `around` probes the texels around,
/// too.
pub(super) fn explain(
    probe: &Probe,
    around: impl Fn() -> Probe,
    receiver: &Receiver,
    looker: &mut Looker,
    eye: &Eye,
) -> (i8, f64) {
    if !probe.is_held {
        return (cause::MISSING, f64::NAN);
    }
    let (kind, blocker) = blocker(receiver, looker);
    let blocker = match (kind, blocker) {
        (Blocker::Held, Some(blocker)) => blocker,
        // The edge passes through the pixel's centre.
        (Blocker::Grazing, _) => return (cause::EDGE, 0.0),
        _ => return (cause::MISSING, f64::NAN),
    };
    if is_leak(probe, receiver, &blocker, looker) {
        return (cause::LEAK, f64::NAN);
    }
    // The lit texel that counts most.
    let lit = probe.taps.iter().filter(|tap| !tap.is_dark);
    let Some(lit) = lit.max_by(|a, b| a.weight.total_cmp(&b.weight)) else { return (cause::MISSING, f64::NAN) };
    let way = Way::new(receiver, lit.centre, looker.rays);
    let is_right = looker.confirmed(receiver, &way, lit).is_some();
    let found = cause_of_light(is_right, is_right && is_drawn(&around(), receiver, &blocker, looker));
    if found != cause::EDGE {
        return (found, f64::NAN);
    }
    let lit_way = way;
    let (dark, way) = edge(receiver, &way, blocker, looker);
    // No silhouette on the way: what the texel stores of the same shadow is not far enough above the receiver. An open caster
    // has no such surface, and at a contact the receiver's depth changes more within the texel.
    if dark.is_all && looker.is_dark_and_held(receiver, &lit_way, lit) {
        return (cause::MISSING, f64::NAN);
    }
    (found, displacement(&dark, &way, receiver, looker.rays, eye))
}

/// What keeps the light from a pixel, as the map sees it.
fn blocker<'a>(receiver: &Receiver, looker: &mut Looker<'a>) -> (Blocker, Option<Caster<'a>>) {
    if let Some(known) = looker.known(receiver, receiver.p) {
        return (Blocker::Held, Some(known));
    }
    let is_blocker = |met: &Met| met.height > 0.0 && met.face != receiver.face;
    let met = looker.met(receiver, receiver.p, [0.0, f64::INFINITY]);
    if is_blocker(&met) {
        return (Blocker::Held, Some(looker.remember(receiver, &met)));
    }
    let is_cut_off = is_blocker(&looker.met_from_light(receiver.p));
    (if is_cut_off { Blocker::CutOff } else { Blocker::Grazing }, None)
}

/// Whether a pixel would be dark without bias, by texels that hold a caster and not the receiver's own surface.
fn is_leak(probe: &Probe, receiver: &Receiver, blocker: &Caster, looker: &mut Looker) -> bool {
    if !is_dark(probe.dark_unbiased()) {
        return false;
    }
    let shows_first = !looker.rays.lookups.map(receiver.map).what().surface.is_behind_first();
    let mut holds_caster = |gap: f64, centre: DVec2| {
        // Higher or lower than a surface that is followed can get: a caster without more ado.
        if shows_first && gap.abs() > rise_of_followed(receiver, centre) {
            return true;
        }
        let way = Way::new(receiver, centre, looker.rays);
        let Kept { first, held, .. } = looker.at_end(receiver, &way);
        // What shades pixel and centre both; all but what continues the receiver; of that what continues the blocker.
        let is_above = |caster: &Caster, point: DVec3, to_light: DVec3| {
            caster.shades(point) && caster.height(point, to_light) > receiver.touch
        };
        let (end, to_light) = (way.at(1.0), looker.rays.to_light(receiver.p));
        if (shows_first && is_above(blocker, end, looker.rays.to_light(end)))
            || (held.triangle >= 0 && is_above(&looker.caster(&held), receiver.p, to_light))
        {
            return true;
        }
        if !shows_first {
            // What lies behind the receiver's own surface is no caster of it, nor is that surface under one without far side.
            return ![first, held].iter().any(|met| looker.is_continued(receiver, &way, met));
        }
        if !looker.is_continued(receiver, &way, &held) {
            return true;
        }
        let here = blocker.seen_from(receiver.p, to_light);
        between(looker, receiver, &way, [here, held]) == Between::Surface
    };
    let taps = probe.taps.iter().filter(|tap| probe.is_meant(tap));
    is_dark(taps.filter(|tap| holds_caster(tap.gap, tap.centre)).map(|tap| tap.weight).sum())
}

/// Whether the shadow that a pixel lies in holds the centre of a texel around: all of the way to it is dark.
fn is_drawn<'a>(probe: &Probe, receiver: &Receiver, blocker: &Caster<'a>, looker: &mut Looker<'a>) -> bool {
    let mut ways = [(f64::INFINITY, None); 9];
    for k in (0..9).filter(|&k| probe.around[k] > probe.touch) {
        let way = Way::new(receiver, probe.centre_of(k), looker.rays);
        if blocker.shades(way.at(1.0)) {
            return true;
        }
        ways[k] = (way.length(), Some(way));
    }
    // The nearest centre first, which decides most.
    ways.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    ways.iter().filter_map(|(_, way)| *way).any(|way| looker.dark(receiver, &way, *blocker).is_all)
}

/// The end of the shadow that is nearest to a lit texel's centre on the way to it, and the way that leads to that end.
fn edge<'a>(receiver: &Receiver, way: &Way, blocker: Caster<'a>, looker: &mut Looker<'a>) -> (Dark, Way) {
    let first = looker.dark(receiver, way, blocker);
    for t in LOOKS.into_iter().take_while(|&t| t > first.to) {
        if let Some(caster) = looker.about(receiver, way, t) {
            let rest = way.after(t);
            return (looker.dark(receiver, &rest, caster), rest);
        }
    }
    (first, *way)
}
