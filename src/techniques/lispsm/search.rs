//! The warp distance with the least error: a search over the strength of the warp that knows the uniform map.
//!
//! Source: theory.md 5.2 (`near=optimal`) and 18.2: every published closed form is worse than no warp for light within
//! about two thirds of the half field of view, a search never is. The error is that of [`BodyError`].
//!
//! The fit cuts a map to the instances' boxes inside the body. What they span in a map follows from their outline, whatever
//! the warp ([`receivers_outline()`](super::receivers_outline())), so boxes are looked at once, and the search runs on numbers:
//!
//! ```text
//!      x ^       .--------.
//!        |    .-'          |     extent of x / q over the corners, of eta over its ends
//!        |     `-.________/
//!        +-----|----------|-----> eta
//! ```

use glam::DVec2;

use super::measure::{Measure, across_along_per_ndc, q_at};
use crate::fit::{MapSize, Room};
use crate::focus::FocusedView;
use crate::geometry::{Aabb, Rows};
use crate::techniques::kit::{LEAST_LAMBDA, ReceiversOutline, WarpSpace};

/// Smallest strength of a warp that is tried. Chosen because the error changes by at most the cube of 1 + mu.
const LEAST_MU: f64 = 1e-3;
/// Ratio of the strengths of the first scan.
const STEP: f64 = 1.4;
/// Minima of the scan that are looked at closely.
const MINIMA: usize = 3;
/// Steps of the golden section: brackets of two steps of the scan shrink to 1e-4 of mu.
const GOLDEN_STEPS: usize = 18;

/// Where a fit cuts more than receivers' outline, each map that is tried looks at all boxes: these beside the search's result,
/// then golden sections around the best, and the interval's ratio to either side. The last are 2 % apart.
const LOOKS: [f64; 6] = [0.3, 1.0, 3.0, 10.0, 30.0, 100.0];
const LAST_LOOKS: usize = 9;
const LAST_RATIO: f64 = 1.8;

/// A strength mu = D / Pn of a warp, 0 for none, and its error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strength {
    /// Extent of the body along the axis over the warp distance.
    pub mu: f64,
    /// Error of the map after the fit.
    pub error: f64,
}

/// Receivers in units of the search.
struct Outline<'a> {
    space: &'a WarpSpace,
    /// eta, and x from the reference point.
    corners: &'a [DVec2],
    eta: [f64; 2],
    room: Room<'a>,
}

impl Outline<'_> {
    /// What the map of a warp spans, NDC, as the fit has it.
    fn extent(&self, mu: f64) -> DVec2 {
        let over_q = self.corners.iter().map(|p| p.y / q_at(mu, p.x));
        let [low, high] = over_q.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
        let [first, last] = self.eta.map(|eta| q_at(mu, eta));
        let along = self.space.extent() * (self.eta[1] - self.eta[0]) / (first * last);
        let extent = DVec2::new(high - low, along) / across_along_per_ndc(mu);
        // Depth is nothing to the search: all that it asks for is there.
        let least = self.room.least(extent.extend(f64::INFINITY), &provisional(self.space, mu));
        extent.max(least.truncate())
    }
}

impl Strength {
    /// A strength with the error that its map will have. `extent` tells what receivers span in the NDC of a provisional map, as
    /// the fit will have it.
    pub fn of(mu: f64, space: &WarpSpace, error: &impl Measure, extent: impl Fn(&Rows) -> Aabb) -> Self {
        let ndc = extent(&provisional(space, mu)).extent().truncate();
        Self { mu, error: error.error(mu, ndc) }
    }
}

/// The strength with the least error, and the uniform map of the same space; `extent` as for [`Strength::of`], `receivers`
/// those of the space's own map.
pub fn best_strength(
    space: &WarpSpace,
    error: &impl Measure,
    receivers: ReceiversOutline,
    view: &FocusedView,
    size: &MapSize,
    extent: impl Fn(&Rows) -> Aabb,
) -> [Strength; 2] {
    let look = |mu: f64| Strength::of(mu, space, error, &extent);
    let uniform = look(0.0);
    let mut corners = receivers.corners;
    let mut eta = [f64::INFINITY, f64::NEG_INFINITY];
    for p in &mut corners {
        *p = DVec2::new((p.y - space.y[0]) / space.extent(), p.x - space.x_ref);
        eta = [eta[0].min(p.x), eta[1].max(p.x)];
    }
    let outline = Outline { space, corners: &corners, eta, room: Room::new(view, size) };
    let found = least(|mu| error.rough(mu, outline.extent(mu)), |mu| error.error(mu, outline.extent(mu)));
    let mut best = look(found.mu);
    if !receivers.is_fit {
        best = LOOKS.into_iter().map(look).fold(best, |a, b| if b.error < a.error { b } else { a });
        let around = [best.mu / LAST_RATIO, (best.mu * LAST_RATIO).min(1.0 / LEAST_LAMBDA)].map(f64::ln);
        let (log_mu, error) = golden(|log_mu| look(log_mu.exp()).error, around, LAST_LOOKS);
        if error < best.error {
            best = Strength { mu: log_mu.exp(), error };
        }
    }
    [if error.is_less(best.error, uniform.error) { best } else { uniform }, uniform]
}

/// The least value over all strengths but 0: a scan, then golden sections around its lowest minima.
fn least(rough: impl Fn(f64) -> f64, error: impl Fn(f64) -> f64) -> Strength {
    const COUNT: usize = 76;
    let mut scan = [0.0; COUNT];
    let mu_at = |i: f64| (LEAST_MU * STEP.powf(i)).min(1.0 / LEAST_LAMBDA);
    let mut mu = LEAST_MU;
    for value in &mut scan {
        *value = rough(mu);
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
    let mut best = Strength { mu: LEAST_MU, error: error(LEAST_MU) };
    for (value, i) in minima {
        if value == f64::INFINITY {
            continue;
        }
        let (at, value) = golden(|i| error(mu_at(i)), [i as f64 - 1.0, i as f64 + 1.0], GOLDEN_STEPS);
        if value < best.error {
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
