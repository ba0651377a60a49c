//! Generalized minimum-norm perspective shadow maps: equal errors at both ends of the view's centre ray, at any light angle.
//!
//! Source: Zhang, Sun, Zhao, Wang 2007 `[zhang2007]`, generalized minimum-norm perspective shadow maps (λ of eq. 4, 7,
//! 8 and of LiSPSM, eq. 9); theory.md 6, with the errata of theory.md 15.1. On the centre ray the error is (6.2)
//!
//! ```text
//!   F(z) = ψ (z + ϕ)² / z,    ϕ = (Pn - Ymin) / κ,    least at z = ϕ,    F(n) = F(f)  <=>  ϕ = √(n f)
//! ```
//!
//! Departures: the paper knows only the camera's whole frustum, with the light in the plane of view and up. Here both
//! azimuth and body are any (6.4): while the eye lies before the body as the light sees it (θ ≥ φ), the distance
//! is κ √(n f) + Ymin, which is the formula there without its differences of large numbers; below, the paper's λ with the
//! body's own silhouette angle φ. With `body=frustum` the same formulas see the frustum, which is what the paper prints,
//! and the reference point stays where the frustum puts it. A body wholly on one side of the centre ray can keep θ ≥ φ, and
//! its warp, down to θ = 0.

use super::kit::along_view::warped_along_view;
use super::kit::{
    Default, FIT, Kind, LightSupport, MARGIN, ParamSpec, Part, Provisional, RANGE, SLACK, Settings, Spec, Warp,
};
use crate::error::Result;
use crate::focus::FocusedView;

/// What the technique says of itself.
pub static SPEC: Spec = Spec {
    name: "gmnpr",
    title: "Generalized minimum-norm perspective shadow map",
    source: "Zhang, Sun, Zhao, Wang 2007",
    lights: LightSupport { directional: true, spot: false, point: false },
    params: &[
        ParamSpec {
            name: "lambda",
            unit: "depths of the body",
            default: Default::Choice("gmnpr"),
            kind: Kind::ChoiceOrNumber { words: &["gmnpr", "lispsm", "lispsm-delta-z"], min: 0.0, max: f64::MAX },
            doc: "warp distance over the body's extent along the warp axis: equal errors on the centre ray (gmnpr), \
                  LiSPSM's n_opt over the sine of the light angle, LiSPSM's over the depth the body spans, or a number",
        },
        ParamSpec {
            name: "body",
            unit: "",
            default: Default::Choice("clipped"),
            kind: Kind::Choice(&["clipped", "frustum"]),
            doc: "what the warp is derived from: what is seen of the scene, or the camera's whole frustum as published",
        },
        RANGE,
        FIT,
        MARGIN,
        SLACK,
    ],
};

#[derive(Debug, Clone, Copy, PartialEq)]
enum Lambda {
    Gmnpr,
    Lispsm,
    LispsmDeltaZ,
    Number(f64),
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Body {
    Clipped,
    Frustum,
}

#[derive(Debug)]
struct Gmnpr {
    lambda: Lambda,
    body: Body,
}

/// The warp from checked settings.
pub fn make(settings: &Settings) -> Result<Box<dyn Warp>> {
    let words = [("gmnpr", Lambda::Gmnpr), ("lispsm", Lambda::Lispsm), ("lispsm-delta-z", Lambda::LispsmDeltaZ)];
    let lambda = match settings.number("lambda") {
        Some(number) => Lambda::Number(number),
        None => settings.meaning("lambda", &words)?,
    };
    let body = settings.meaning("body", &[("clipped", Body::Clipped), ("frustum", Body::Frustum)])?;
    Ok(Box::new(Gmnpr { lambda, body }))
}

impl Warp for Gmnpr {
    fn warp(&self, view: &FocusedView, part: &Part) -> Result<Provisional> {
        Ok(warped_along_view(view, part, |along, values, _| {
            let body = match self.body {
                Body::Clipped => along.receivers(),
                Body::Frustum => along.frustum(),
            };
            let extent = body.y[1] - body.y[0];
            let [near, far] = body.depth;
            let distance = match self.lambda {
                Lambda::Gmnpr => along.equal_ends_distance(&body),
                Lambda::Lispsm => along.space.equal_error_distance(near, far),
                Lambda::LispsmDeltaZ => along.space.equal_error_distance(near, near + along.space.rate * extent),
                Lambda::Number(lambda) => lambda * extent,
            };
            values.push(("silhouette", body.silhouette));
            if self.body == Body::Frustum {
                // Finite also where the largest number stands for no warp.
                values.push(("lambda_frustum", (distance / extent).min(f64::MAX)));
            }
            along.distance_of(&body, distance)
        }))
    }
}
