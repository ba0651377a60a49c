//! Light space perspective shadow maps.
//!
//! Source: Wimmer, Scherzer, Purgathofer 2004 `[wimmer2004]` (LiSPSM); Scherzer 2005 `[scherzer2005]`, Wimmer and
//! Scherzer 2006 `[wimmer2006]` (robust shadow maps: middle vector); theory.md 5; the search for the least error is
//! ours (theory.md 18.2). Departures (theory.md 16): the warp is anchored at the near end of the receivers' body; depth
//! comes from the shared fit; in the warp distance Δz is the eye depth that the body spans along the warp axis (the
//! paper's own section 4.4; the later paper's equation 1 lacks the sine, theory.md 15.3).
//!
//! ```text
//!   reference point                near end (Ymin)                    far end (Ymax)      along the light: ⊗
//!         x <----- Pn ----------------> |<------------ D ------------------> |            warp axis: ->
//! ```

use super::body_error::{BodyError, ErrorMeasure, ErrorNorm};
use super::receivers_outline::receivers_outline;
use super::search::{Strength, best_strength};
use crate::error::Result;
use crate::fit::{Tightening, receivers_room};
use crate::focus::{Coverage, FocusedView};
use crate::geometry::Rows;
use crate::note::{Detail, Note};
use crate::scene::{Light, Scene};
use crate::techniques::kit::light_projection::{spot_depth_range, uniform_rows};
use crate::techniques::kit::{
    Default, FIT, Kind, LightSupport, Named, ParamSpec, Part, Provisional, Settings, Spec, Warp, WarpSpace,
};

/// What the technique says of itself.
pub static SPEC: Spec = Spec {
    name: "lispsm",
    title: "Light space perspective shadow map",
    source: "Wimmer, Scherzer, Purgathofer 2004; Wimmer, Scherzer 2006",
    lights: LightSupport { directional: true, spot: true, point: true },
    params: &[
        ParamSpec {
            name: "near",
            unit: "world units",
            default: Default::Choice("delta-z"),
            kind: Kind::ChoiceOrNumber { words: &["delta-z", "basic", "optimal"], min: 0.0, max: f64::MAX },
            doc: "warp distance, from the reference point to the near end of the receivers: by formula over the depth the \
                  body spans (delta-z), by formula over the view's depth range (basic), by a search for the least error over \
                  the body, the uniform map included (optimal), or a length",
        },
        ParamSpec {
            name: "near_factor",
            unit: "",
            default: Default::Number(1.0),
            kind: Kind::Number { min: 1e-6, max: 1e12 },
            doc: "multiplies the warp distance, the optimal one as well; the larger, the weaker the warp",
        },
        ParamSpec {
            name: "axis",
            unit: "",
            default: Default::Choice("view"),
            kind: Kind::Choice(&["view", "middle"]),
            doc: "warp along the view direction, or along the middle of the casters' body as the eye sees it",
        },
        ParamSpec {
            name: "norm",
            unit: "",
            default: Default::Choice("linf"),
            kind: Kind::Choice(&["linf", "storage", "mean"]),
            doc: "what near=optimal makes small, in the image, over the receivers' body: a texel's largest length along the \
                  warp axis (linf), that times its largest length across (storage), or its mean area over the pixels, every \
                  octave of depth as likely (mean); the body has the air before the eye, too, so the least of storage and \
                  mean can be a stronger warp than the picture wants",
        },
        ParamSpec {
            name: "near_weight",
            unit: "",
            default: Default::Number(1.0),
            kind: Kind::Number { min: 1e-6, max: 1e6 },
            doc: "for near=optimal: how many times an error at the near end of the receivers counts as one at their far end, \
                  a power of eye depth between",
        },
        FIT,
    ],
};

#[derive(Debug, Clone, Copy, PartialEq)]
enum Distance {
    DeltaZ,
    Basic,
    Length(f64),
    Optimal(ErrorMeasure),
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Axis {
    View,
    Middle,
}

#[derive(Debug)]
struct Lispsm {
    distance: Distance,
    factor: f64,
    axis: Axis,
    tightening: Tightening,
}

/// The warp from checked settings.
pub fn make(settings: &Settings) -> Result<Box<dyn Warp>> {
    let norms = [("linf", ErrorNorm::Linf), ("storage", ErrorNorm::Storage), ("mean", ErrorNorm::Mean)];
    let measure =
        ErrorMeasure { norm: settings.meaning("norm", &norms)?, near_weight: settings.declared_number("near_weight")? };
    let formulas = [("delta-z", Distance::DeltaZ), ("basic", Distance::Basic), ("optimal", Distance::Optimal(measure))];
    let distance = match settings.number("near") {
        Some(length) => Distance::Length(length),
        None => settings.meaning("near", &formulas)?,
    };
    let factor = settings.declared_number("near_factor")?;
    let axis = settings.meaning("axis", &[("view", Axis::View), ("middle", Axis::Middle)])?;
    let tightening = settings.tightening()?;
    Ok(Box::new(Lispsm { distance, factor, axis, tightening }))
}

impl Warp for Lispsm {
    fn warp(&self, view: &FocusedView, part: &Part) -> Result<Provisional> {
        let scene = part.scene;
        let mut values = Vec::with_capacity(8);
        let mut notes = Vec::new();
        let clip_from_local = match self.warp_space(view, scene, &mut notes) {
            Some(Ok(space)) => {
                let (distance, rows) = match &self.distance {
                    Distance::Optimal(measure) => self.optimum(measure, &space, view, part, &mut values),
                    formula => {
                        let distance = self.warp_distance(formula, &space, view, &mut notes);
                        (Some(distance), space.warped(distance))
                    }
                };
                match distance {
                    Some(distance) => {
                        values.push(("warp_distance", distance));
                        values.push(("lambda", distance / space.extent()));
                    }
                    None => notes.push(Note::no_warp(&[Detail::NoLessError], &[])),
                }
                values.push(("kappa", space.rate));
                if let Light::Directional(l) = &view.light {
                    values.push(("gamma", view.camera.forward().angle_between(l.direction())));
                }
                values.push(("depth", space.extent()));
                values.push(("y_min", space.y[0]));
                rows
            }
            Some(Err(reason)) => {
                values.push(("kappa", 0.0));
                notes.push(Note::no_warp(&[reason], &[]));
                // `warp_space` has recorded the notes on the spot's depths already; discard the duplicates.
                uniform_rows(view, scene, &mut Vec::new())
            }
            None => uniform_rows(view, scene, &mut notes),
        };
        Ok(Provisional { clip_from_local, values, notes })
    }
}

impl Lispsm {
    /// Where the warp acts; nothing where nothing is seen.
    fn warp_space(
        &self,
        view: &FocusedView,
        scene: &Scene,
        notes: &mut Vec<Note>,
    ) -> Option<std::result::Result<WarpSpace, Detail>> {
        if view.coverage == Coverage::NothingSeen {
            return None;
        }
        let casters = view.casters();
        let towards = match self.axis {
            Axis::View => view.camera.forward(),
            Axis::Middle => view.middle_vector(casters.vertices()),
        };
        match (&view.light, view.spot()) {
            (Light::Directional(l), _) => Some(WarpSpace::directional(view, l.direction(), towards, &casters)),
            (_, Some(spot)) => {
                let depths = spot_depth_range(&spot, view, scene, notes);
                Some(WarpSpace::spot(view, &spot, depths, towards))
            }
            _ => None,
        }
    }
    /// The distance from the reference point to the near end, in units of the warp space's y (5.2).
    fn warp_distance(&self, formula: &Distance, space: &WarpSpace, view: &FocusedView, notes: &mut Vec<Note>) -> f64 {
        let [near, far] = match formula {
            Distance::Basic => view.eye_depth,
            _ => space.line(),
        };
        let distance = match formula {
            Distance::Length(length) => length * space.per_length,
            _ => space.equal_error_distance(near, far),
        };
        space.limited(self.factor * distance, notes)
    }
    /// The warp distance with the least error and its map; the uniform map alone where none has less.
    fn optimum(
        &self,
        measure: &ErrorMeasure,
        space: &WarpSpace,
        view: &FocusedView,
        part: &Part,
        values: &mut Vec<Named>,
    ) -> (Option<f64>, Rows) {
        let extent = |rows: &Rows| receivers_room(rows, view, part.scene, &part.size, self.tightening);
        let error = BodyError::new(view, space, measure);
        let receivers = receivers_outline(&space.rows, view, part.scene, self.tightening);
        let [best, unwarped] = best_strength(space, &error, receivers, view, &part.size, extent);
        // The uniform technique's own map: a spot's is not turned, nor is one along the view where the axis is another.
        let upright = uniform_rows(view, part.scene, &mut Vec::new());
        let turned = space.unwarped(&upright, view);
        let uniform = if turned.rows == space.rows {
            unwarped
        } else {
            Strength::of(0.0, &turned, &BodyError::new(view, &turned, measure), extent)
        };
        if best.mu > 0.0 && error.is_less(best.error, uniform.error) {
            let distance = space.limited(self.factor * space.extent() / best.mu, &mut Vec::new());
            let is_best = self.factor == 1.0;
            let made = if is_best { best } else { Strength::of(space.extent() / distance, space, &error, extent) };
            // A factor may have made it worse than no warp.
            if error.is_less(made.error, uniform.error) {
                values.extend([("error", made.error), ("error_uniform", uniform.error)]);
                return (Some(distance), space.warped(distance));
            }
        }
        let least = uniform.error.min(unwarped.error);
        values.extend([("error", least), ("error_uniform", uniform.error)]);
        (None, if unwarped.error < uniform.error { space.rows } else { upright })
    }
}
