//! Extended perspective shadow maps.
//!
//! Source: Gusev 2007 `[gusev2007]` (XPSM); theory.md 8. Where we depart:
//! - The interval in focus begins at the near end of what is seen (Y_f = Ymin of K), so every receiver has w >= epsilon_w. The
//!   paper takes the later beginning of receivers and casters; as every instance casts, that is the same.
//! - The map is cut to the unit cube by the shared fit. The published step ignores points with w < epsilon_w and loses casters
//!   by it; it is there as `fit=published`, for study.
//!
//! ```text
//!   reference point            eye (w = 1)    near end of the receivers        along the light: ⊗
//!         x <----- 1/p ---------> |              | (w >= epsilon_w)            axis: view direction ->
//! ```

use super::kit::light_projection::uniform_rows;
use super::kit::{
    Default, FIT, Kind, LEAST_LAMBDA, LightSupport, MARGIN, ParamSpec, Part, Provisional, RANGE, SLACK, Settings, Spec,
    Warp, WarpSpace,
};
use crate::error::Result;
use crate::focus::{Coverage, FocusedView};
use crate::note::{self, Detail, Note};
use crate::scene::Light;

/// What the technique says of itself.
pub static SPEC: Spec = Spec {
    name: "xpsm",
    title: "Extended perspective shadow map",
    source: "Gusev 2007",
    lights: LightSupport { directional: true, spot: false, point: false },
    params: &[
        ParamSpec {
            name: "coefficient",
            unit: "per world unit",
            default: Default::Number(0.05),
            kind: Kind::ChoiceOrNumber { words: &["lispsm"], min: 0.0, max: f64::MAX },
            doc: "strength of the warp: over the sine between light and view, the inverse distance of the reference point \
                  behind the eye. A number is right for one scale of the world; lispsm takes that of the ideal light space \
                  perspective map, 1 / sqrt(near far), right at any scale",
        },
        ParamSpec {
            name: "epsilon_w",
            unit: "",
            default: Default::Number(0.1),
            kind: Kind::Number { min: 0.0, max: 1.0 },
            doc: "least w of what is seen, where w is 1 at the eye: bounds the warp of what is seen aside or behind the eye",
        },
        ParamSpec {
            name: "min_sin",
            unit: "",
            default: Default::Number(0.1),
            kind: Kind::Number { min: 0.0, max: 1.0 },
            doc: "below this sine between light and view the map is uniform",
        },
        RANGE,
        ParamSpec {
            kind: Kind::Choice(&["shadow", "seen", "exact", "receivers", "intersection", "none", "published"]),
            doc: "what the map must hold: visible receivers in shadow and their neighbours, as outside a map all is lit \
                  (shadow); all visible receivers (seen); or, without samples, the boxes of all instances in the view and \
                  the casters above them (exact), the same with all casters' depth (receivers), only where anything is \
                  cast on anything (intersection), all that the view's body holds (none), or as published, which loses \
                  casters: corners with w above epsilon_w (published)",
            ..FIT
        },
        MARGIN,
        SLACK,
    ],
};

#[derive(Debug)]
struct Xpsm {
    /// In 1 over world units; nothing for the one of the ideal LiSPSM.
    coefficient: Option<f64>,
    epsilon_w: f64,
    min_sin: f64,
}

/// The warp from checked settings.
pub fn make(settings: &Settings) -> Result<Box<dyn Warp>> {
    Ok(Box::new(Xpsm {
        coefficient: settings.number("coefficient"),
        epsilon_w: settings.declared_number("epsilon_w")?,
        min_sin: settings.declared_number("min_sin")?,
    }))
}

impl Warp for Xpsm {
    fn warp(&self, view: &FocusedView, part: &Part) -> Result<Provisional> {
        let mut values = Vec::with_capacity(8);
        let mut notes = Vec::new();
        let light = match &view.light {
            Light::Directional(l) if view.coverage == Coverage::AsAsked => l,
            // Refused before, or nothing is seen.
            _ => return Ok(Provisional { clip_from_local: uniform_rows(view, part.scene, &mut notes), values, notes }),
        };
        let forward = view.camera.forward();
        let space = WarpSpace::directional(view, light.direction(), forward);
        let space = match space {
            Ok(space) if space.rate >= self.min_sin => space,
            other => {
                notes.push(match other {
                    Ok(space) => Note::no_warp(&[Detail::BelowMinSine], &[("sine", space.rate)]),
                    Err(reason) => Note::no_warp(&[reason], &[]),
                });
                values.push(("kappa", other.map_or(0.0, |space| space.rate)));
                return Ok(Provisional { clip_from_local: uniform_rows(view, part.scene, &mut notes), values, notes });
            }
        };
        // Depth is told from the eye before it is divided, too.
        let space = WarpSpace { z_ref: space.rows.z.dot(view.eye.extend(1.0)), ..space };
        let strength = self.strength(&space, view, &mut notes);
        // The reference point lies 1/p behind the eye: Pn = 1/p + Ymin (theory.md 8). Infinite for p = 0, which is uniform.
        let y_eye = space.rows.y.dot(view.eye.extend(1.0));
        let distance = space.limited(strength.recip() + (space.y[0] - y_eye), &mut notes);
        values.extend([("p", strength), ("kappa", space.rate), ("y_min", space.y[0] - y_eye)]);
        values.extend([("warp_distance", distance), ("lambda", distance / space.extent()), ("depth", space.extent())]);
        let warped = space.warped(distance);
        // w = 1 + p Y, 1 at the eye: that is what epsilon_w is told in.
        let w_eye = warped.w.dot(view.eye.extend(1.0));
        Ok(Provisional { clip_from_local: warped.scaled(w_eye.recip()), values, notes })
    }
}

impl Xpsm {
    /// The paper's p (8.1), so that w = 1 + p Y with Y from the eye: the coefficient over the sine, as far as w stays
    /// above its least at the near end.
    fn strength(&self, space: &WarpSpace, view: &FocusedView, notes: &mut Vec<Note>) -> f64 {
        let [near, far] = view.eye_depth;
        let coefficient = self.coefficient.unwrap_or_else(|| 1.0 / (near.sqrt() * far.sqrt()));
        let p = coefficient / space.rate;
        let [y_near, y_far] = space.y.map(|y| y - space.rows.y.dot(view.eye.extend(1.0)));
        let focused = if y_near < 0.0 { (1.0 - self.epsilon_w) / -y_near } else { f64::INFINITY };
        // Nearer to the eye than that, the reference point and the eye are one up to half of the digits.
        let apart = (LEAST_LAMBDA * y_near.abs().max(y_far.abs())).recip();
        let most = focused.min(apart);
        if p > most {
            notes.push(Note::new(note::Kind::WarpWeakened, &[("given", p), ("most", most)]));
        }
        p.min(most)
    }
}
