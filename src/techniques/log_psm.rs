//! Logarithmic perspective shadow maps: a perspective warp, and after it the logarithm of its w.
//!
//! Source: Lloyd, Govindaraju, Quammen, Molnar, Manocha 2008 `[lloyd2008]` (LogPSM); theory.md 11. Of a perspective
//! along the view the error on the centre ray is (11.2)
//!
//! ```text
//!   F_log(z) = (z + ϕ)/z · ln((λ+1)/λ) / tan φ,      ϕ = (Pn - Ymin) / κ,  λ = Pn / D
//! ```
//!
//! constant where ϕ = 0: where the reference point lies at the eye as the light sees it, which is GLPR's choice and the
//! default. x/w and depth are the perspective's.
//!
//! Departures (theory.md 11): GLPR's least share of the body holds while θ comes down to φ, the angle of the outermost
//! receiver; below, where the eye lies among the receivers as the light sees it, GMNPR's distance is taken, so at φ the map
//! changes at once (Lloyd's thesis shapes the way from one to the other; its constants are for another parameter).

use super::glpr::LEAST_SHARE;
use super::kit::along_view::warped_along_view;
use super::kit::{
    Default, FIT, Kind, LightSupport, MARGIN, ParamSpec, Part, Provisional, RANGE, SLACK, Settings, Spacing, Spec, Warp,
};
use crate::error::Result;
use crate::focus::FocusedView;

/// What the technique says of itself.
pub static SPEC: Spec = Spec {
    name: "log_psm",
    title: "Logarithmic perspective shadow map",
    source: "Lloyd, Govindaraju, Quammen, Molnar, Manocha 2008",
    lights: LightSupport { directional: true, spot: false, point: false },
    params: &[
        ParamSpec {
            name: "warp",
            unit: "",
            default: Default::Choice("glpr"),
            kind: Kind::Choice(&["glpr", "gmnpr", "lispsm"]),
            doc: "the perspective before the logarithm: from the eye, which is the map of log but for a floor, or \
                  GMNPR's where the eye lies among the receivers (glpr); GMNPR's at every angle (gmnpr); LiSPSM's over the depth the body spans (lispsm)",
        },
        RANGE,
        FIT,
        MARGIN,
        SLACK,
    ],
};

#[derive(Debug, Clone, Copy, PartialEq)]
enum Perspective {
    Glpr,
    Gmnpr,
    Lispsm,
}

#[derive(Debug)]
struct LogPsm {
    perspective: Perspective,
}

/// The warp from checked settings.
pub fn make(settings: &Settings) -> Result<Box<dyn Warp>> {
    let perspective = settings.meaning(
        "warp",
        &[("glpr", Perspective::Glpr), ("gmnpr", Perspective::Gmnpr), ("lispsm", Perspective::Lispsm)],
    )?;
    Ok(Box::new(LogPsm { perspective }))
}

impl Warp for LogPsm {
    fn warp(&self, view: &FocusedView, part: &Part) -> Result<Provisional> {
        Ok(warped_along_view(view, part, |along, values, _| {
            let body = along.receivers();
            values.push(("silhouette", body.silhouette));
            let [near, far] = body.depth;
            match self.perspective {
                // (7.1) with GLPR's floor, else (6.4) or (5.2).
                Perspective::Glpr if body.y[0] >= 0.0 => {
                    body.y[0].max(LEAST_SHARE * near / far * (body.y[1] - body.y[0]))
                }
                Perspective::Glpr | Perspective::Gmnpr => along.equal_ends_distance(&body),
                Perspective::Lispsm => {
                    let [near, far] = along.space.line();
                    along.space.equal_error_distance(near, far)
                }
            }
        }))
    }
    fn spacing(&self) -> Spacing {
        Spacing::Logarithmic
    }
}
