//! Why pixels are in false shadow: what their dark texels hold.

use super::rays::{LightRays, Met, Receiver};
use super::way::{Between, Way, find};
use crate::aliasing::causes::{Holds, Probe, cause, cause_of_shadow};
use crate::aliasing::texel::Eye;
use crate::error::Result;
use crate::progress::Progress;

/// The cause of each pixel and how far its edge lies, pixels; NaN where no edge is displaced.
pub(super) fn causes(
    wrong: &[(&Probe, Receiver)],
    rays: &LightRays,
    eye: &Eye,
    progress: &Progress,
) -> Result<Vec<(i8, f64)>> {
    // Dark texels that hold more than the receiver's plane: whose they are, which they are.
    let dark: Vec<(usize, usize)> = (0..wrong.len())
        .flat_map(|i| (0..4).map(move |k| (i, k)))
        .filter(|&(i, k)| {
            let (probe, tap) = (wrong[i].0, &wrong[i].0.taps[k]);
            tap.is_dark && tap.gap > probe.grain
        })
        .collect();
    let texel = |&(i, k): &(usize, usize)| (&wrong[i].1, wrong[i].0.taps[k].centre, wrong[i].0.taps[k].gap);
    let met = rays.confirmed(&dark.iter().map(texel).collect::<Vec<_>>(), progress)?;
    let mut ways: Vec<Way> = Vec::with_capacity(dark.len());
    let mut way_of = vec![None; dark.len()];
    for (n, (of, met)) in dark.iter().zip(&met).enumerate() {
        let (receiver, centre, _) = texel(of);
        if let Some(met) = *met {
            way_of[n] = Some(ways.len());
            let here = Met { height: 0.0, face: receiver.face, triangle: -1 };
            ways.push(Way::new(*receiver, centre, [here, met]));
        }
    }
    find(&mut ways, rays, progress)?;
    let mut result = Vec::with_capacity(wrong.len());
    let mut n = 0;
    for (i, (probe, _)) in wrong.iter().enumerate() {
        let (mut holds, mut edge) = ([(0.0, Holds::Itself); 4], None);
        while n < dark.len() && dark[n].0 == i {
            let k = dark[n].1;
            let weight = probe.taps[k].weight;
            holds[k] = (weight, Holds::Wrong);
            if let Some(way) = way_of[n].map(|w: usize| &ways[w]) {
                let is_caster = way.between == Between::Silhouette;
                holds[k].1 = if is_caster { Holds::Caster } else { Holds::Itself };
                if is_caster && edge.is_none_or(|(most, _)| weight > most) {
                    edge = Some((weight, way));
                }
            }
            n += 1;
        }
        let found = cause_of_shadow(&holds);
        let moved = edge.filter(|_| found == cause::EDGE).map_or(f64::NAN, |(_, way)| way.displacement(rays, eye));
        result.push((found, moved));
    }
    Ok(result)
}
