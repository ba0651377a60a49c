//! The ideal logarithmic shadow map: texels even in the logarithm of the distance from the eye.
//!
//! Source: Wimmer, Scherzer, Purgathofer 2004 `[wimmer2004]` (LiSPSM), section 4.2, for y; Lloyd, Govindaraju, Quammen,
//! Molnar, Manocha 2008 `[lloyd2008]` for x, of which the former do not speak; theory.md 11 and E.1. Departure
//! (theory.md 15.2): the paper's `s = ln(z/zn)` is not normalised, here s runs from 0 to 1 over the receivers.
//!
//! The reference point of the projective part is the eye's image itself, so under an overhead light a texel is as wide as a
//! pixel and equally long everywhere. That image must lie before the receivers as the light sees them: a light that is closer
//! to the view direction than the edge of what is seen has no such map. Where there is one, it is that of `log_psm` with
//! `warp=glpr`, unless the eye is closer to the receivers than the floor of that.
//!
//! ```text
//!   eye's image            near end (Ymin)                          far end (Ymax)      along the light: ⊗
//!        x <---- w ------------>|<----------------------------------------->|          warp axis: ->
//!        0 ............... s = 0 | |  |   |    |      |         |            s = 1     s = ln(w/w0) / ln(w1/w0)
//! ```

use super::kit::along_view::warped_along_view;
use super::kit::{
    FIT, LEAST_LAMBDA, LightSupport, MARGIN, Part, Provisional, RANGE, SLACK, Settings, Spacing, Spec, Warp, WarpSpace,
};
use crate::error::{Error, Result};
use crate::focus::{Coverage, FocusedView};
use crate::note::{Detail, Note};
use crate::scene::Light;

/// What the technique says of itself.
pub static SPEC: Spec = Spec {
    name: "log",
    title: "Ideal logarithmic shadow map: that of log_psm without its floor",
    source: "Wimmer, Scherzer, Purgathofer 2004, section 4.2; Lloyd et al. 2008",
    lights: LightSupport { directional: true, spot: false, point: false },
    params: &[RANGE, FIT, MARGIN, SLACK],
};

#[derive(Debug)]
struct Log;

/// The warp; there is nothing to set.
pub fn make(_settings: &Settings) -> Result<Box<dyn Warp>> {
    Ok(Box::new(Log))
}

impl Warp for Log {
    fn warp(&self, view: &FocusedView, part: &Part) -> Result<Provisional> {
        check(view)?;
        Ok(warped_along_view(view, part, |along, _, _| along.eye_distance()))
    }
    fn spacing(&self) -> Spacing {
        Spacing::Logarithmic
    }
}

/// Refuses a view in which the eye's image does not lie before the receivers. What is flat as the light sees it needs no warp.
fn check(view: &FocusedView) -> Result<()> {
    let (Light::Directional(light), Coverage::AsAsked) = (&view.light, view.coverage) else { return Ok(()) };
    match WarpSpace::directional(view, light.direction(), view.camera.forward()) {
        Ok(space) if space.y[0] - space.rows.y.dot(view.eye.extend(1.0)) < LEAST_LAMBDA * space.extent() => {
            Err(unsuited("the eye does not lie before all of what is seen as the light sees it"))
        }
        Err(why @ Detail::LightAlongAxis) => Err(unsuited(&Note::no_warp(&[why], &[]).reason())),
        _ => Ok(()),
    }
}

fn unsuited(reason: &str) -> Error {
    Error::UnsuitedView {
        technique: SPEC.name.into(),
        reason: reason.into(),
        fix: "turn the light away from the view direction, or take log_psm, which serves every view".into(),
    }
}
