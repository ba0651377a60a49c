//! What a map stores of a light ray, by rays: the surface that light meets first, or what follows from those behind it.
//!
//! ```text
//!      light      front: a    back: b, the first whose outer side is averted    second: b
//!        |        midpoint: half way from a to b    dual: that, at most so many texels behind a
//!      __a__
//!     |  b__|     Light and shadow end at the silhouettes of what light meets first, whichever of these is stored.
//!   _____|_____
//! ```
//! Source: theory.md 13. The encoder in `render::stored` makes the same of rasterised depths.

use glam::DVec3;

use super::rays::{LightRays, Met};
use crate::render::StoredSurface;
use crate::trace::OneByOne;

/// What a map stores of a ray.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kept {
    /// What light meets first.
    pub first: Met,
    /// The surface whose depth is stored: of `midpoint` and `dual`, which are moved away from it, the first.
    pub held: Met,
    /// How far before a point of the ray the stored depth lies, towards the light; minus infinity where none is stored.
    pub height: f64,
    /// Where that is.
    at: DVec3,
    /// Whether it is so far away that its number may be rounded to that of no caster.
    pub is_at_end: bool,
}

impl Kept {
    /// The same from another point of the ray.
    pub fn seen_from(self, point: DVec3, to_light: DVec3) -> Self {
        let [first, held] = [self.first, self.held].map(|met| met.seen_from(point, to_light));
        let height = if self.height.is_finite() { (self.at - point).dot(to_light) } else { self.height };
        Self { first, held, height, ..self }
    }
}

impl LightRays<'_> {
    /// What a map stores of the ray through a point.
    pub fn kept(&self, tracer: &mut OneByOne, map: usize, point: DVec3) -> Kept {
        let first = self.met(tracer, map, point, Met::ANYWHERE);
        let (lookup, nothing) = (self.lookups.map(map), (Met::NOTHING, f64::NEG_INFINITY));
        let stored = lookup.what();
        let (held, height) = match stored.surface {
            StoredSurface::Front => (first, first.height),
            _ if first.triangle < 0 || !lookup.is_before_far(first.at) => nothing,
            StoredSurface::Back => {
                let back = self.averted(tracer, map, point, first);
                (back, back.height)
            }
            StoredSurface::Second => {
                let second = self.second(tracer, map, point, &first);
                (second, second.height)
            }
            StoredSurface::Midpoint => match self.second(tracer, map, point, &first) {
                second if second.triangle < 0 => nothing,
                second => (first, 0.5 * (first.height + second.height)),
            },
            StoredSurface::Dual => {
                let second = self.second(tracer, map, point, &first);
                // Infinite without a second.
                let half = 0.5 * (first.height - second.height);
                (first, first.height - half.min(stored.limit * lookup.texel_at(first.at)))
            }
        };
        let at = point + height * self.to_light(point);
        // Nothing where it is moved beyond the map's depths.
        let depth = if height.is_finite() { lookup.depth_at_point(at) } else { 1.0 };
        let is_stored = stored.surface == StoredSurface::Front || depth < 1.0;
        let height = if is_stored { height } else { f64::NEG_INFINITY };
        Kept { first, held, height, at, is_at_end: depth + stored.format.step(depth) >= 1.0 }
    }

    /// The nearest surface behind the first that a rasteriser gives another depth; nothing where the far plane cuts it off.
    fn second(&self, tracer: &mut OneByOne, map: usize, point: DVec3, first: &Met) -> Met {
        let lookup = self.lookups.map(map);
        let below = first.height - lookup.same_depth(first.at);
        let second = self.met(tracer, map, point, [f64::NEG_INFINITY, below]);
        if second.triangle >= 0 && lookup.is_before_far(second.at) { second } else { Met::NOTHING }
    }

    /// The nearest surface from the first on whose outer side is averted; nothing where the far plane cuts it off.
    fn averted(&self, tracer: &mut OneByOne, map: usize, point: DVec3, first: Met) -> Met {
        let (lookup, step, mut met) = (self.lookups.map(map), self.again(), first);
        while met.triangle >= 0 && !self.is_averted(&met) {
            met = self.met(tracer, map, point, [f64::NEG_INFINITY, met.height - step]);
        }
        if met.triangle >= 0 && lookup.is_before_far(met.at) { met } else { Met::NOTHING }
    }
}
