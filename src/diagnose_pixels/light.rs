//! Why pixels are in false light: what became of what keeps the light from them.

use glam::DVec2;

use super::rays::{Asked, LightRays, Met, Receiver};
use super::way::{Between, Way, continued, find, rise_of_followed};
use crate::aliasing::causes::{Blocker, Probe, cause, cause_of_light, is_dark};
use crate::aliasing::texel::Eye;
use crate::error::Result;
use crate::progress::Progress;

/// Places on the way to a texel's centre that have to be dark, those first that lie furthest from what is known to be. At uneven
/// distances: bars at even ones would be met by all looks or by none.
const LOOKS: [&[f64]; 4] =
    [&[0.55], &[0.27, 0.81], &[0.12, 0.41, 0.68, 0.93], &[0.05, 0.19, 0.34, 0.48, 0.61, 0.74, 0.87, 0.97]];
/// Lengths of ways that are looked at closely enough before each round, texels: chosen so that looks are about an eighth of a texel
/// apart.
const COVERED: [f64; 4] = [0.0, 0.0, 0.5, 0.75];

/// The cause of each pixel and how far its edge lies, pixels; NaN where no edge is displaced.
pub(super) fn causes(
    wrong: &[(&Probe, Receiver)],
    rays: &LightRays,
    eye: &Eye,
    progress: &Progress,
) -> Result<Vec<(i8, f64)>> {
    let mut result = vec![(cause::MISSING, f64::NAN); wrong.len()];
    let blockers = blockers(wrong, rays, progress)?;
    let mut open: Vec<usize> = Vec::new();
    for (i, (probe, _)) in wrong.iter().enumerate() {
        match blockers[i].0 {
            _ if !probe.is_held => {}
            Blocker::CutOff => {}
            // The edge passes through the pixel's centre.
            Blocker::Grazing => result[i] = (cause::EDGE, 0.0),
            Blocker::Held => open.push(i),
        }
    }
    let is_leak = leaks(&open, wrong, &blockers, rays, progress)?;
    for (&i, _) in open.iter().zip(&is_leak).filter(|(_, leaks)| **leaks) {
        result[i].0 = cause::LEAK;
    }
    open.retain(|&i| result[i].0 != cause::LEAK);
    // The lit texel that counts most.
    let lit = |i: usize| {
        let (probe, receiver) = &wrong[i];
        let taps = probe.taps.iter().filter(|tap| !tap.is_dark);
        let most = taps.max_by(|a, b| a.weight.total_cmp(&b.weight)).copied().unwrap_or_default();
        (receiver, most.centre, most.gap)
    };
    let met = rays.confirmed(&open.iter().map(|&i| lit(i)).collect::<Vec<_>>(), progress)?;
    let is_drawn = drawn(&open, wrong, &blockers, rays, progress)?;
    let mut ways = Vec::new();
    let mut edges = Vec::new();
    for ((&i, met), is_drawn) in open.iter().zip(met).zip(is_drawn) {
        result[i].0 = cause_of_light(met.is_some(), is_drawn);
        if let (cause::EDGE, Some(met)) = (result[i].0, met) {
            let (receiver, centre, _) = lit(i);
            edges.push(i);
            ways.push(Way::new(*receiver, centre, [blockers[i].1, met]));
        }
    }
    find(&mut ways, rays, progress)?;
    for (i, way) in edges.into_iter().zip(&ways) {
        result[i].1 = way.displacement(rays, eye);
    }
    Ok(result)
}

/// What keeps the light from each pixel, as the map sees it.
fn blockers(wrong: &[(&Probe, Receiver)], rays: &LightRays, progress: &Progress) -> Result<Vec<(Blocker, Met)>> {
    let at = |receiver: &Receiver| Asked { map: receiver.map, point: receiver.p, at_most: f64::INFINITY };
    let asked: Vec<Asked> = wrong.iter().map(|(_, receiver)| at(receiver)).collect();
    let met = rays.met(&asked, progress)?;
    let is_blocker = |i: usize, met: &Met| met.height > 0.0 && met.face != wrong[i].1.face;
    let none: Vec<usize> = (0..wrong.len()).filter(|&i| !is_blocker(i, &met[i])).collect();
    let beyond = rays.met_from_light(&none.iter().map(|&i| asked[i]).collect::<Vec<_>>(), progress)?;
    let mut found: Vec<(Blocker, Met)> = met.into_iter().map(|met| (Blocker::Held, met)).collect();
    for (&i, met) in none.iter().zip(&beyond) {
        found[i].0 = if is_blocker(i, met) { Blocker::CutOff } else { Blocker::Grazing };
    }
    Ok(found)
}

/// Whether pixels would be dark without bias, by texels that hold a caster and not the receiver's own surface.
fn leaks(
    of: &[usize],
    wrong: &[(&Probe, Receiver)],
    blockers: &[(Blocker, Met)],
    rays: &LightRays,
    progress: &Progress,
) -> Result<Vec<bool>> {
    let taps = of.iter().flat_map(|&i| (0..4).map(move |k| (i, k)));
    let is_meant = |&(i, k): &(usize, usize)| {
        let (probe, tap) = (wrong[i].0, &wrong[i].0.taps[k]);
        tap.is_dark_unbiased && tap.gap.abs() > probe.grain && is_dark(probe.dark_unbiased())
    };
    // Higher or lower than a surface that is followed can get: a caster without more ado.
    let may_continue = |&(i, k): &(usize, usize)| {
        let tap = &wrong[i].0.taps[k];
        tap.gap.abs() <= rise_of_followed(&wrong[i].1, tap.centre)
    };
    let (taps, casters): (Vec<_>, Vec<_>) = taps.filter(is_meant).partition(may_continue);
    let mut dark = vec![0.0; wrong.len()];
    for (i, k) in casters {
        dark[i] += wrong[i].0.taps[k].weight;
    }
    let ask = |&(i, k): &(usize, usize)| rays.at(&wrong[i].1, wrong[i].0.taps[k].centre);
    let held = rays.met(&taps.iter().map(ask).collect::<Vec<_>>(), progress)?;
    // The blocker itself; else what continues it; else all but what continues the receiver.
    let open = |n: &usize| held[*n].face != blockers[taps[*n].0].1.face;
    let open: Vec<usize> = (0..taps.len()).filter(open).collect();
    let way = |&n: &usize| {
        let (i, k) = taps[n];
        Way::new(wrong[i].1, wrong[i].0.taps[k].centre, [blockers[i].1, held[n]])
    };
    let mut ways: Vec<Way> = open.iter().map(way).collect();
    find(&mut ways, rays, progress)?;
    let apart: Vec<usize> = (0..open.len()).filter(|&w| ways[w].between == Between::Silhouette).collect();
    let ends: Vec<_> = apart.iter().map(|&w| (wrong[taps[open[w]].0].1, ways[w].centre, held[open[w]])).collect();
    let mut is_caster = vec![true; taps.len()];
    for (w, continues) in apart.into_iter().zip(continued(&ends, rays, progress)?) {
        is_caster[open[w]] = !continues;
    }
    for (&(i, k), _) in taps.iter().zip(&is_caster).filter(|(_, is_caster)| **is_caster) {
        dark[i] += wrong[i].0.taps[k].weight;
    }
    Ok(of.iter().map(|&i| is_dark(dark[i])).collect())
}

/// Whether the shadow that each pixel lies in holds the centre of a texel around: all of the way to it is dark.
fn drawn(
    of: &[usize],
    wrong: &[(&Probe, Receiver)],
    blockers: &[(Blocker, Met)],
    rays: &LightRays,
    progress: &Progress,
) -> Result<Vec<bool>> {
    let mut result: Vec<bool> = of.iter().map(|&i| holds_a_centre(wrong[i].0, blockers[i].1, rays)).collect();
    // The nearest centre first, which decides most; the others where it does not.
    let centres = |n: usize| {
        let probe = wrong[of[n]].0;
        let dark = (0..9).filter(|&k| probe.around[k] > probe.touch).map(|k| probe.centre_of(k));
        let mut dark: Vec<DVec2> = dark.collect();
        dark.sort_by(|a, b| a.distance_squared(probe.place).total_cmp(&b.distance_squared(probe.place)));
        dark
    };
    for (skipped, most) in [(0, 1), (1, 8)] {
        let open = (0..of.len()).filter(|&n| !result[n]);
        let ways = open.flat_map(|n| centres(n).into_iter().skip(skipped).take(most).map(move |centre| (n, centre)));
        for n in dark_ways(ways.collect(), |n| &wrong[of[n]].1, rays, progress)? {
            result[n] = true;
        }
    }
    Ok(result)
}

/// Of ways from receivers to centres, the receivers of those that are dark all along.
fn dark_ways<'a>(
    mut ways: Vec<(usize, DVec2)>,
    receiver: impl Fn(usize) -> &'a Receiver,
    rays: &LightRays,
    progress: &Progress,
) -> Result<Vec<usize>> {
    for (round, looks) in LOOKS.iter().enumerate() {
        let is_done = |&(n, centre): &(usize, DVec2)| receiver(n).place.distance(centre) < COVERED[round];
        let (done, open): (Vec<_>, Vec<_>) = ways.into_iter().partition(is_done);
        let asked = open.iter().flat_map(|&(n, centre)| {
            let receiver = receiver(n);
            looks.iter().map(move |&t| rays.at(receiver, receiver.place.lerp(centre, t)))
        });
        let met = rays.met(&asked.collect::<Vec<_>>(), progress)?;
        let is_dark = |(way, met): &(&(usize, DVec2), &[Met])| met.iter().all(|m| m.height > receiver(way.0).touch);
        let dark = open.iter().zip(met.chunks(looks.len())).filter(is_dark).map(|(way, _)| *way);
        ways = done.into_iter().chain(dark).collect();
    }
    Ok(ways.into_iter().map(|(n, _)| n).collect())
}

/// Whether the shadow of the blocker's triangle holds the centre of a texel around.
fn holds_a_centre(probe: &Probe, blocker: Met, rays: &LightRays) -> bool {
    let lookup = rays.lookups.map(probe.map);
    let [Some(a), Some(b), Some(c)] = rays.corners(blocker).map(|corner| lookup.place_of(corner)) else {
        return false;
    };
    (0..9).filter(|&k| probe.around[k] > probe.touch).any(|k| {
        let centre = probe.centre_of(k);
        let side = |a: DVec2, b: DVec2| (b - a).perp_dot(centre - a);
        let sides = [side(a, b), side(b, c), side(c, a)];
        sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0)
    })
}
