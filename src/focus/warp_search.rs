//! The warp distance with the least error: a search over the strength of the warp that knows the uniform map.
//!
//! Source: theory.md 5.2 (its option), closed_forms: every published closed form is worse than no warp for light within
//! about two thirds of the half field of view, a search never is. The error is that of [`BodyError`].
//!
//! The fit cuts a map to the instances' boxes inside the body, so what receivers span is known for a warp only once the
//! boxes were looked at. Each look bounds x / q from both sides, which cuts a polygon around all receivers, and the search runs
//! on that polygon. As it is exact for the uniform map, what it finds is never worse.
//!
//! ```text
//!      Y ^   looked at for the uniform map: |   and for warps: \ /
//!        |      |\  boxes  /|
//!        |      | \       / |       between them lies all that receivers can be
//!        |         \     /
//! ```

use glam::DVec2;

use super::body_error::{BodyError, Spread, q_at};
use super::warp::{LEAST_LAMBDA, WarpSpace};
use crate::geometry::{Aabb, Rows};

/// Smallest strength of a warp that is tried. Chosen because the error changes by at most the cube of 1 + mu.
const LEAST_MU: f64 = 1e-3;
/// Ratio of the strengths of the first scan.
const STEP: f64 = 1.6;
/// Minima of the scan that are looked at closely.
const MINIMA: usize = 3;
/// What a look may find below the search that led to it.
const SETTLED: f64 = 1e-3;
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

/// Strengths at which receivers are looked at before the search, beside the uniform map, where the fit will cut something off
/// the body: a third of a decade of warp distances apart, where a warp still differs from its neighbours.
const LOOKS: [f64; 6] = [0.3, 1.0, 3.0, 10.0, 30.0, 100.0];
/// Looks after a search, each where the last one found the least error.
const MORE_LOOKS: usize = 2;
/// Golden sections over looks alone, around the best of all those, and the interval's ratio to either side.
const LAST_LOOKS: usize = 9;
const LAST_RATIO: f64 = 1.8;
/// A rectangle, and at most one corner more for each side of each look.
const MOST_CORNERS: usize = 4 + 2 * (LOOKS.len() + MORE_LOOKS);

/// What is known of where receivers are, in the plane of eta and x: a convex polygon.
#[derive(Debug, Clone, Copy)]
struct Outline {
    corners: [DVec2; MOST_CORNERS],
    count: usize,
    eta: [f64; 2],
}

impl Outline {
    /// All within a rectangle.
    fn new(eta: [f64; 2], x: [f64; 2]) -> Self {
        let mut corners = [DVec2::ZERO; MOST_CORNERS];
        let all = [(eta[0], x[0]), (eta[1], x[0]), (eta[1], x[1]), (eta[0], x[1])];
        for (corner, (eta, x)) in corners.iter_mut().zip(all) {
            *corner = DVec2::new(eta, x);
        }
        Self { corners, count: 4, eta }
    }
    /// Cut to x / q in a range at a strength.
    fn cut(&mut self, mu: f64, x: [f64; 2]) {
        self.cut_where(|p| x[1] * q_at(mu, p.x) - p.y);
        self.cut_where(|p| p.y - x[0] * q_at(mu, p.x));
    }
    /// Cut to where an affine function is not negative; whole where rounding would leave nothing.
    fn cut_where(&mut self, inside: impl Fn(DVec2) -> f64) {
        let mut cut = Self { count: 0, ..*self };
        for i in 0..self.count {
            let (a, b) = (self.corners[i], self.corners[(i + 1) % self.count]);
            let (at_a, at_b) = (inside(a), inside(b));
            let crossed = (at_a < 0.0) != (at_b < 0.0);
            let kept = [(at_a >= 0.0).then_some(a), crossed.then(|| a.lerp(b, at_a / (at_a - at_b)))];
            for p in kept.into_iter().flatten() {
                let Some(room) = cut.corners.get_mut(cut.count) else { return };
                *room = p;
                cut.count += 1;
            }
        }
        if cut.count > 0 {
            *self = cut;
        }
    }
    /// The range of x / q.
    fn range(&self, mu: f64) -> [f64; 2] {
        let over_q = self.corners[..self.count].iter().map(|p| p.y / q_at(mu, p.x));
        over_q.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    }
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
    let look = |mu: f64| -> (Strength, [f64; 2], [f64; 2]) {
        let ndc = extent(&provisional(space, mu));
        let spread = error.spread_of(mu, ndc.extent().truncate());
        let strength = Strength { mu, error: error.error(mu, &error.largest(mu), &spread) };
        // x / q from x / w, as in `spread_of`.
        let scale = (1.0 + mu) / (1.0 + 0.5 * mu);
        let shift = if mu == 0.0 { space.x_ref } else { 0.0 };
        (strength, [ndc.min.x, ndc.max.x].map(|x| (x - shift) * scale), [ndc.min.y, ndc.max.y])
    };
    let (uniform, x, y) = look(0.0);
    let mut outline = Outline::new(y.map(|y| (y - space.y[0]) / space.extent()), x);
    let mut best = uniform;
    let tight = {
        // Nothing was cut off the body: no look shows more than its vertices.
        let body = error.largest(0.0).x;
        let less = (body[1] - body[0]) - (x[1] - x[0]) + (1.0 - (outline.eta[1] - outline.eta[0])) * space.extent();
        less > f64::EPSILON.sqrt() * space.extent()
    };
    for mu in LOOKS.into_iter().filter(|_| tight) {
        let (found, x, _) = look(mu);
        outline.cut(mu, x);
        best = if found.error < best.error { found } else { best };
    }
    for _ in 0..=MORE_LOOKS {
        let bounded = |mu: f64| -> f64 {
            let largest = error.largest(mu);
            error.error(mu, &largest, &spread(space.extent(), mu, largest.x, &outline, resolution))
        };
        let found = least(bounded, best);
        if found.mu == best.mu {
            break;
        }
        let (is, x, _) = look(found.mu);
        best = if is.error < best.error { is } else { best };
        if found.error <= is.error * (1.0 + SETTLED) {
            break;
        }
        outline.cut(found.mu, x);
    }
    if tight && best.mu > 0.0 {
        let around = [best.mu / LAST_RATIO, (best.mu * LAST_RATIO).min(1.0 / LEAST_LAMBDA)].map(f64::ln);
        let (at, least) = golden(|log| look(log.exp()).0.error, around, LAST_LOOKS);
        if least < best.error {
            best = Strength { mu: at.exp(), error: least };
        }
    }
    [best, uniform]
}

/// What receivers span at most in the map of a warp: that of the body, and what is known of them.
fn spread(extent: f64, mu: f64, body: [f64; 2], outline: &Outline, resolution: u32) -> Spread {
    let [low, high] = outline.range(mu);
    let across = (high.min(body[1]) - low.max(body[0])).max(0.0);
    let [first, last] = outline.eta.map(|eta| q_at(mu, eta));
    let along = extent * (outline.eta[1] - outline.eta[0]) / (first * last);
    // The fit gives a body in the plane of the light one texel across (NDC x is across, NDC y along / (1 + mu), up to a common
    // factor).
    let texels = f64::from(resolution);
    Spread { across: across.max(along / ((1.0 + mu) * texels)), along: along.max(across * (1.0 + mu) / texels) }
}

/// The least value over all strengths, unless `known` is less: a scan, then golden sections around its lowest minima.
fn least(error: impl Fn(f64) -> f64, known: Strength) -> Strength {
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
        let before = if i == 0 { f64::INFINITY } else { scan[i - 1] };
        let after = if i + 1 < COUNT { scan[i + 1] } else { f64::INFINITY };
        if scan[i] <= before && scan[i] <= after && scan[i] < minima[MINIMA - 1].0 {
            minima[MINIMA - 1] = (scan[i], i);
            minima.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
    }
    let mut best = known;
    for (value, i) in minima {
        if value == f64::INFINITY {
            continue;
        }
        let (at, value) = golden(|i| error(mu_at(i)), [i as f64 - 1.0, i as f64 + 1.0], GOLDEN_STEPS);
        if value < best.error * (1.0 - f64::EPSILON.sqrt()) {
            best = Strength { mu: mu_at(at), error: value };
        }
    }
    best
}

/// The least value in an interval, by golden sections.
fn golden(f: impl Fn(f64) -> f64, [mut low, mut high]: [f64; 2], steps: usize) -> (f64, f64) {
    // 1 over the golden ratio.
    const SHARE: f64 = 0.618_033_988_749_894_9;
    let mut inner = [high - SHARE * (high - low), low + SHARE * (high - low)];
    let mut values = inner.map(&f);
    for _ in 0..steps {
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
