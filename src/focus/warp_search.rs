//! The warp distance with the least error: a search over the strength of the warp that knows the uniform map.
//!
//! Source: theory.md 5.2 (its option), closed_forms: every published closed form is worse than no warp for light within
//! about two thirds of the half field of view, a search never is. The error is that of [`BodyError`].
//!
//! The fit cuts a map to the instances' boxes inside the body, so what receivers span is known for a warp only once the
//! boxes were looked at. The search looks twice or thrice: each look bounds x / q from both sides, at one mu, hence for all
//! mu, and the search runs on the bound. As the bound is exact for the uniform map, what it finds is never worse.
//!
//! ```text
//!      Y ^   bounds found at mu = 0: |    and at mu > 0: \ /
//!        |      |\  boxes  /|
//!        |      | \       / |       between them lies all that receivers can be
//!        |         \     /
//! ```

use super::body_error::{BodyError, Spread, q_at};
use super::warp::{LEAST_LAMBDA, WarpSpace};
use crate::geometry::{Aabb, Rows};

/// Smallest strength of a warp that is tried. Chosen because the error changes by at most the cube of 1 + mu.
const LEAST_MU: f64 = 1e-3;
/// Ratio of the strengths of the first scan.
const STEP: f64 = 1.6;
/// Minima of the scan that are looked at closely.
const MINIMA: usize = 3;
/// Steps of the golden section: brackets of two steps of the scan shrink to 1e-4 of mu.
const GOLDEN_STEPS: usize = 19;

/// A strength mu = D / Pn of a warp, 0 for none, and its error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strength {
    /// Extent of the body along the axis over the warp distance.
    pub mu: f64,
    /// Error of the map after the fit.
    pub error: f64,
}

/// The range of x / q of receivers, known at one strength.
#[derive(Debug, Clone, Copy)]
struct Bound {
    mu: f64,
    x: [f64; 2],
}

impl Strength {
    /// A strength with the error that its map will have. `extent` tells what receivers span in the NDC of a provisional map, as
    /// the fit will have it.
    pub fn of(mu: f64, space: &WarpSpace, error: &BodyError, extent: impl Fn(&Rows) -> Aabb) -> Self {
        let ndc = extent(&provisional(space, mu)).extent().truncate();
        Self { mu, error: error.error(mu, &error.largest(mu), &error.spread_of(mu, ndc)) }
    }
}

/// The strength with the least error, and the uniform map of the same space; `extent` as for [`Strength::of`].
pub fn best_strength(
    space: &WarpSpace,
    error: &BodyError,
    resolution: u32,
    extent: impl Fn(&Rows) -> Aabb,
) -> [Strength; 2] {
    let known = |mu: f64| -> (Strength, Bound, Aabb) {
        let ndc = extent(&provisional(space, mu));
        let spread = error.spread_of(mu, ndc.extent().truncate());
        let strength = Strength { mu, error: error.error(mu, &error.largest(mu), &spread) };
        // x / q from x / w, as in `spread_of`.
        let scale = (1.0 + mu) / (1.0 + 0.5 * mu);
        let shift = if mu == 0.0 { space.x_ref } else { 0.0 };
        let bound = Bound { mu, x: [(ndc.min.x - shift) * scale, (ndc.max.x - shift) * scale] };
        (strength, bound, ndc)
    };
    let (uniform, first, ndc) = known(0.0);
    let eta = [ndc.min.y, ndc.max.y].map(|y| (y - space.y[0]) / space.extent());
    let mut bounds = [first, first];
    let mut best = uniform;
    for _ in 0..3 {
        let bounded = |mu: f64| -> f64 {
            let largest = error.largest(mu);
            error.error(mu, &largest, &spread(space.extent(), mu, largest.x, eta, &bounds, resolution))
        };
        let found = least(bounded, uniform);
        if found.mu == 0.0 {
            break;
        }
        let (is, bound, _) = known(found.mu);
        let (better, settled) = (is.error < best.error, found.error <= is.error * (1.0 + f64::EPSILON.sqrt()));
        if better {
            best = is;
        }
        if settled || !better {
            break;
        }
        bounds[1] = bound;
    }
    [best, uniform]
}

/// What receivers span at most in the map of a warp: that of the body, and what the bounds leave.
fn spread(extent: f64, mu: f64, body: [f64; 2], eta: [f64; 2], bounds: &[Bound; 2], resolution: u32) -> Spread {
    let q = eta.map(|eta| q_at(mu, eta));
    let side = |k: usize, tighter: fn(f64, f64) -> f64, wider: fn(f64, f64) -> f64| -> f64 {
        // x / q along a bound is a quotient of lines in eta: at its ends, or where the bounds cross.
        let at = |eta: f64| {
            let by = |b: &Bound| b.x[k] * q_at(b.mu, eta) / q_at(mu, eta);
            tighter(by(&bounds[0]), by(&bounds[1]))
        };
        let mut widest = wider(at(eta[0]), at(eta[1]));
        let [(a, b), (c, d)] = bounds.map(|b| (b.x[k] / (1.0 + b.mu), b.x[k] * b.mu / (1.0 + b.mu)));
        let crossing = (c - a) / (b - d);
        if crossing > eta[0] && crossing < eta[1] {
            widest = wider(widest, at(crossing));
        }
        tighter(widest, body[k])
    };
    let (low, high) = (side(0, f64::max, f64::min), side(1, f64::min, f64::max));
    let along = extent * (eta[1] - eta[0]) / (q[0] * q[1]);
    let across = (high - low).max(0.0);
    // The fit gives a body in the plane of the light one texel across (NDC x is across, NDC y along / (1 + mu), up to a common
    // factor).
    let texels = f64::from(resolution);
    Spread { across: across.max(along / ((1.0 + mu) * texels)), along: along.max(across * (1.0 + mu) / texels) }
}

/// The least value over all strengths: a scan, then golden sections around its lowest minima.
fn least(error: impl Fn(f64) -> f64, uniform: Strength) -> Strength {
    const COUNT: usize = 54;
    let mut scan = [0.0; COUNT];
    let mu_at = |i: f64| (LEAST_MU * STEP.powf(i)).min(1.0 / LEAST_LAMBDA);
    let mut mu = LEAST_MU;
    for value in &mut scan {
        *value = error(mu);
        mu = (mu * STEP).min(1.0 / LEAST_LAMBDA);
    }
    let mut minima = [(f64::INFINITY, 0); MINIMA];
    for i in 0..COUNT {
        let before = if i == 0 { uniform.error } else { scan[i - 1] };
        let after = if i + 1 < COUNT { scan[i + 1] } else { f64::INFINITY };
        if scan[i] <= before && scan[i] <= after && scan[i] < minima[MINIMA - 1].0 {
            minima[MINIMA - 1] = (scan[i], i);
            minima.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
    }
    // A minimum between the uniform map and the first strength shows in no neighbour.
    let mut best = uniform;
    for (value, i) in minima {
        if value == f64::INFINITY {
            continue;
        }
        let (at, value) = golden(|i| error(mu_at(i)), i as f64 - 1.0, i as f64 + 1.0);
        if value < best.error * (1.0 - f64::EPSILON.sqrt()) {
            best = Strength { mu: mu_at(at), error: value };
        }
    }
    best
}

/// The least value in an interval, by golden sections.
fn golden(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> (f64, f64) {
    // 1 over the golden ratio.
    const SHARE: f64 = 0.618_033_988_749_894_9;
    let mut inner = [high - SHARE * (high - low), low + SHARE * (high - low)];
    let mut values = inner.map(&f);
    for _ in 0..GOLDEN_STEPS {
        if values[0] <= values[1] {
            high = inner[1];
            inner = [high - SHARE * (high - low), inner[0]];
            values = [f(inner[0]), values[0]];
        } else {
            low = inner[0];
            inner = [inner[1], low + SHARE * (high - low)];
            values = [values[1], f(inner[1])];
        }
    }
    let first = usize::from(values[1] < values[0]);
    (inner[first], values[first])
}

/// The provisional map of a strength.
fn provisional(space: &WarpSpace, mu: f64) -> Rows {
    if mu == 0.0 { space.rows } else { space.warped(space.extent() / mu) }
}
