//! Trapezoidal shadow maps: the trapezoid around what the eye sees becomes the map, a focus depth at a chosen share of it.
//!
//! Source: Martin and Tan 2004 `[martin2004]` (trapezoidal shadow maps); theory.md 4.
//!
//! ```text
//!           top: near end      focus             base: far end
//!                 ______________|___________________
//!       q  x <  __|             |                  |      legs: from q, as steep as the body needs
//!                 |______ ______|__________________|
//!            <eta>|<-- delta -->|                  |
//!                 |<------------ lambda ---------->|      warp axis, along the centre line: ->
//! ```
//!
//! The trapezoid's homography is, up to the affine crop that the fit makes anyway, the warp with reference point q at `eta`
//! before the near end: legs through q become parallel there, and the crop to the extents puts them at x = -1 and 1. So it is
//! made, since that holds for parallel legs and bodies seen edge-on too; a test holds the paper's product of eight matrices
//! and [`square_from_quadrilateral`](crate::geometry::square_from_quadrilateral) against it.
//!
//! Departures: light space is isotropic, not the light's post-perspective space, whose scale the paper leaves open; the focus
//! depth is √(n f) unless given, on the centre line; depth is z = c / w with c along the light from the eye, hyperbolic and so
//! projective (the paper's linear depth must be written per fragment). As published, the warp does not fade as the light
//! turns along the view: with the centre ray in the middle of the body, eta goes to a third of its depth.

use super::kit::along_view::{AlongView, warped_along_view};
use super::kit::{
    Default, FIT, Kind, LightSupport, MARGIN, Named, ParamSpec, Part, Provisional, RANGE, SLACK, Settings, Spec, Warp,
};
use crate::error::Result;
use crate::focus::FocusedView;
use crate::note::{Detail, Note};
use crate::scene::Light;

/// What the technique says of itself.
pub static SPEC: Spec = Spec {
    name: "tsm",
    title: "Trapezoidal shadow map",
    source: "Martin, Tan 2004",
    lights: LightSupport { directional: true, spot: false, point: false },
    params: &[
        ParamSpec {
            name: "focus_depth",
            unit: "world units",
            default: Default::Choice("geometric"),
            kind: Kind::ChoiceOrNumber { words: &["geometric"], min: 0.0, max: f64::MAX },
            doc: "camera depth that the share is about: the geometric mean of the depths seen, or a depth",
        },
        ParamSpec {
            name: "share",
            unit: "",
            default: Default::Number(0.8),
            // Chosen because a thousandth is about a row of a map: at 0 and 1 either part would have none.
            kind: Kind::Number { min: 0.001, max: 0.999 },
            doc: "share of the map's rows that goes to what is nearer than the focus depth (the 80 % rule)",
        },
        RANGE,
        FIT,
        MARGIN,
        SLACK,
    ],
};

#[derive(Debug)]
struct Tsm {
    /// Nothing for the geometric mean.
    focus_depth: Option<f64>,
    share: f64,
}

/// The warp from checked settings.
pub fn make(settings: &Settings) -> Result<Box<dyn Warp>> {
    let share = settings.declared_number("share")?;
    Ok(Box::new(Tsm { focus_depth: settings.number("focus_depth"), share }))
}

impl Warp for Tsm {
    fn warp(&self, view: &FocusedView, part: &Part) -> Result<Provisional> {
        let mut provisional = warped_along_view(view, part, |along, values, notes| {
            let depth = self.focus_depth.unwrap_or_else(|| (view.eye_depth[0] * view.eye_depth[1]).sqrt());
            // The sine may round to a little more than 1, and the largest depth has no room for it.
            let delta = (along.space.rate * depth).min(f64::MAX) - (along.space.y[0] - along.eye_y);
            let eta = eta(along.space.extent(), delta, self.share);
            if eta == f64::INFINITY {
                let why = if delta > 0.0 { Detail::FocusHasShare } else { Detail::FocusBeforeBody };
                notes.push(Note::no_warp(&[why], &[("focus_depth", depth)]));
            }
            values.extend([("focus_depth", depth), ("delta", delta), ("xi", 2.0 * self.share - 1.0)]);
            let eta = along.space.limited(eta, notes);
            values.push(("eta", eta));
            values.extend(trapezoid(along, eta));
            eta
        });
        if let Light::Directional(light) = &view.light {
            // Step 6: the warp leaves z alone, c / w.
            let along = light.direction();
            provisional.clip_from_local.z = along.extend(-along.dot(view.eye));
        }
        Ok(provisional)
    }
}

/// The distance of q before the top line with which a body of extent `lambda` gets the `share` of its map for its first
/// `delta` (4.1); infinite where it has that share, or more, without a warp, and where the focus lies before it.
fn eta(lambda: f64, delta: f64, share: f64) -> f64 {
    // (4.1) with ξ = 2 share - 1, both sides halved.
    let room = lambda * share - delta;
    if room <= 0.0 || delta <= 0.0 { f64::INFINITY } else { lambda * delta * (1.0 - share) / room }
}

/// Top, base and area of the trapezoid whose legs run from q, `eta` before the near end, around all vertices.
fn trapezoid(along: &AlongView, eta: f64) -> [Named; 3] {
    let AlongView { view, space, .. } = along;
    let [near, far] = space.y;
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for p in view.receivers.vertices() {
        let p = p.extend(1.0);
        // The slope of the line from q, in widths at the top line: finite for parallel legs.
        let at_top = (space.rows.x.dot(p) - space.x_ref) / (1.0 + (space.rows.y.dot(p) - near) / eta);
        (low, high) = (low.min(at_top), high.max(at_top));
    }
    let top = high - low;
    let base = top * (1.0 + (far - near) / eta);
    [("top_width", top), ("base_width", base), ("trapezoid_area", 0.5 * (top + base) * (far - near))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_focus_gets_its_share_and_eta_goes_to_infinity_where_it_has_it() {
        for share in [0.3, 0.6, 0.8, 0.95] {
            for delta in [0.01, 0.2, 0.299] {
                let eta = eta(1.0, delta, share);
                // s of theory.md 5.1 at the focus.
                let s = (eta + 1.0) * (1.0 - eta / (eta + delta));
                assert!((s - share).abs() < 1e-12, "{share} {delta}: {s}");
            }
        }
        assert!(eta(10.0, 8.0 - 1e-12, 0.8) > 1e12 && eta(10.0, 8.0, 0.8) == f64::INFINITY);
        assert!(eta(10.0, 9.0, 0.8) == f64::INFINITY && eta(10.0, -1.0, 0.8) == f64::INFINITY);
    }
}
