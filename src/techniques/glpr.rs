//! Generalized linear perspective shadow maps: on the view's centre ray the error grows as depth does, as a perspective
//! shadow map's does under an overhead light, at any light angle.
//!
//! Source: Zhang, Xu, Tao, Sun 2006 `[zhang2006glpr]` (the requirement, as Zhang, Sun, Zhao, Wang 2007 `[zhang2007]`,
//! section 3, tell it); theory.md 7. The error `F(z) = ψ (z + ϕ)² / z` (6.2) is linear where ϕ = 0: the reference point
//! lies at the eye as the light sees it, Pn = Ymin (7.1).
//!
//! Departures, ours since the first source is not available: towards θ = φ, where Ymin and with it the warp distance goes to
//! 0, a least share of the body, `lambda_floor` n/f; below φ, where no warp is linear, that share over tan(π θ / (4 φ)) as
//! GMNPR has it, so that the map goes to the uniform one.

use super::kit::along_view::warped_along_view;
use super::kit::{
    Default, FIT, Kind, LightSupport, MARGIN, ParamSpec, Part, Provisional, RANGE, SLACK, Settings, Spec, Warp,
};
use crate::error::Result;
use crate::focus::FocusedView;

/// What the technique says of itself.
pub static SPEC: Spec = Spec {
    name: "glpr",
    title: "Generalized linear perspective shadow map",
    source: "Zhang, Xu, Tao, Sun 2006; after Zhang, Sun, Zhao, Wang 2007",
    lights: LightSupport { directional: true, spot: false, point: false },
    params: &[
        ParamSpec {
            name: "lambda_floor",
            unit: "near/far",
            default: Default::Number(LEAST_SHARE),
            kind: Kind::Number { min: 0.0, max: 1e12 },
            doc: "least warp distance over the body's extent along the warp axis, in units of its near depth over its far depth",
        },
        RANGE,
        FIT,
        MARGIN,
        SLACK,
    ],
};

/// The default of `lambda_floor`. Chosen (theory.md 7): above 36 degrees of light for near 1, far 100 and 60 degrees of view
/// it does nothing.
pub(super) const LEAST_SHARE: f64 = 0.1;

#[derive(Debug)]
struct Glpr {
    floor: f64,
}

/// The warp from checked settings.
pub fn make(settings: &Settings) -> Result<Box<dyn Warp>> {
    Ok(Box::new(Glpr { floor: settings.declared_number("lambda_floor")? }))
}

impl Warp for Glpr {
    fn warp(&self, view: &FocusedView, part: &Part) -> Result<Provisional> {
        Ok(warped_along_view(view, part, |along, values, _| {
            let body = along.receivers();
            let [near, far] = body.depth;
            let floor = self.floor * near / far;
            let extent = body.y[1] - body.y[0];
            values.extend([("silhouette", body.silhouette), ("lambda_floor", floor)]);
            // (7.1), Pn = Ymin, with its floor; below the silhouette as (6.3).
            if body.y[0] >= 0.0 { body.y[0].max(floor * extent) } else { along.below_silhouette(&body, floor) * extent }
        }))
    }
}
