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
use super::measure::Measure;
use super::search::{Strength, best_strength};
use super::seen_error::SeenError;
use super::seen_flips::SeenFlips;
use crate::error::{Error, Result};
use glam::DVec3;

use crate::fit::{Tightening, receivers_room};
use crate::focus::{Coverage, FocusedView};
use crate::geometry::Rows;
use crate::note::{Detail, Note};
use crate::scene::{Light, Scene};
use crate::techniques::kit::light_projection::uniform_rows;
use crate::techniques::kit::{
    Default, FIT, Kind, LightSupport, MARGIN, Named, Needs, ParamSpec, Part, Provisional, RANGE, SLACK, Settings, Spec,
    Warp, WarpSpace, receivers_outline,
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
            default: Default::Choice("optimal"),
            kind: Kind::ChoiceOrNumber { words: &["optimal", "delta-z", "basic"], min: 0.0, max: f64::MAX },
            doc: "warp distance, from the reference point to the near end of the receivers: by a search for the least error, \
                  the uniform map included (optimal), by formula over the depth that the receivers' body spans (delta-z), by \
                  formula over the view's depth range (basic), or a length",
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
            name: "over",
            unit: "",
            default: Default::Choice("seen"),
            kind: Kind::Choice(&["seen", "body"]),
            doc: "where near=optimal measures the error: at visible surfaces (seen), or over the receivers' body with the air in \
                  it (body)",
        },
        ParamSpec {
            name: "norm",
            unit: "",
            default: Default::Choice("auto"),
            kind: Kind::Choice(&["auto", "edge", "flips", "linf", "storage", "mean"]),
            doc: "quantity that near=optimal minimises, in the image: mean width of a texel across the edges of visible \
                  shadows (edge) or share of pixels near them whose state changes within their texel (flips), both only \
                  over=seen, longest texel along the warp (linf), longest along times longest across \
                  (storage), or mean area, of a body with every octave of depth as likely (mean); auto: edge over what is \
                  seen, linf over the body",
        },
        ParamSpec {
            name: "near_weight",
            unit: "",
            default: Default::Number(1.0),
            kind: Kind::Number { min: 1e-6, max: 1e6 },
            doc: "for near=optimal: how many times an error at the near end of the receivers counts as one at their far end, \
                  a power of eye depth between",
        },
        RANGE,
        FIT,
        MARGIN,
        SLACK,
    ],
};

#[derive(Debug, Clone, Copy, PartialEq)]
enum Distance {
    DeltaZ,
    Basic,
    Length(f64),
    Optimal(Objective),
}

/// What a search makes small, and where.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Objective {
    /// The width of texels across visible shadows' edges.
    Edge,
    /// Changes of state within a texel.
    Flips,
    /// A norm over visible surfaces.
    Seen(ErrorMeasure),
    /// A norm over the receivers' body.
    Body(ErrorMeasure),
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
    let over_seen = settings.meaning("over", &[("seen", true), ("body", false)])?;
    let by_norm = |norm: ErrorNorm| {
        let measure = ErrorMeasure { norm, near_weight: settings.declared_number("near_weight")? };
        Ok(if over_seen { Objective::Seen(measure) } else { Objective::Body(measure) })
    };
    let objective = match (settings.word("norm"), over_seen) {
        ("edge" | "auto", true) => Objective::Edge,
        ("flips", true) => Objective::Flips,
        (norm @ ("edge" | "flips"), false) => {
            let fix = "set over=seen, or take linf, storage or mean";
            return Err(Error::argument("norm", "a norm over the body, with over=body", norm, fix));
        }
        ("storage", _) => by_norm(ErrorNorm::Storage)?,
        ("mean", _) => by_norm(ErrorNorm::Mean)?,
        _ => by_norm(ErrorNorm::Linf)?,
    };
    let formulas =
        [("delta-z", Distance::DeltaZ), ("basic", Distance::Basic), ("optimal", Distance::Optimal(objective))];
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
    fn needs(&self) -> Needs {
        match self.distance {
            Distance::Optimal(Objective::Edge | Objective::Flips) => Needs::Shadows,
            Distance::Optimal(Objective::Seen(_)) => Needs::Surfaces,
            _ => Needs::Nothing,
        }
    }
    fn warp(&self, view: &FocusedView, part: &Part) -> Result<Provisional> {
        let scene = part.scene;
        let mut values = Vec::with_capacity(8);
        let mut notes = Vec::new();
        let clip_from_local = match self.warp_space(view, scene, &mut notes) {
            Some(Ok(space)) => {
                let (distance, rows) = match &self.distance {
                    Distance::Optimal(objective) => self.optimum(objective, &space, view, part, &mut values),
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

/// Samples of a search, at the most.
const MOST_EDGES: usize = 2048;

/// Receivers of a search for the fewest changes of state.
const MOST_FLIPS: usize = 2048;

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
        let towards = match self.axis {
            Axis::View => view.camera.forward(),
            Axis::Middle => view.middle_vector(view.casters().vertices()),
        };
        WarpSpace::of(view, scene, towards, notes)
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
        objective: &Objective,
        space: &WarpSpace,
        view: &FocusedView,
        part: &Part,
        values: &mut Vec<Named>,
    ) -> (Option<f64>, Rows) {
        let at_edges = || {
            let samples = part.samples?;
            let (rays, edges) = samples.ray_edges(&part.camera, &part.light, &part.region, MOST_EDGES)?;
            (!edges.is_empty()).then_some((rays, edges))
        };
        match objective {
            Objective::Edge => match at_edges() {
                Some((rays, edges)) => {
                    let measure = |space: &WarpSpace| SeenError::new(space, &rays, &edges, &part.size);
                    self.optimum_of(measure, space, view, part, values)
                }
                // Nothing is seen that a map could be wrong at.
                None => {
                    let linf = ErrorMeasure { norm: ErrorNorm::Linf, near_weight: 1.0 };
                    self.optimum_of(|space: &WarpSpace| BodyError::new(view, space, &linf), space, view, part, values)
                }
            },
            Objective::Flips => {
                let found = part.samples.and_then(|samples| {
                    let (picture, shadows) = (samples.picture.as_ref()?, samples.shadows.as_ref()?);
                    let (rays, flips) = samples.ray_flips(&part.camera, &part.light, &part.region, MOST_FLIPS)?;
                    (!flips.is_empty()).then_some((rays, flips, picture, shadows))
                });
                match found {
                    Some((rays, flips, picture, shadows)) => {
                        let measure =
                            |space: &WarpSpace| SeenFlips::new(space, &rays, &flips, &part.size, picture, shadows);
                        self.optimum_of(measure, space, view, part, values)
                    }
                    None => self.optimum(&Objective::Edge, space, view, part, values),
                }
            }
            Objective::Body(measure) => {
                self.optimum_of(|space: &WarpSpace| BodyError::new(view, space, measure), space, view, part, values)
            }
            Objective::Seen(measure) => {
                let points: Vec<DVec3> = part.samples.map_or_else(Vec::new, |samples| {
                    samples.spread(&part.camera, &part.light, &part.region, MOST_EDGES)
                });
                let over = |space: &WarpSpace| BodyError::over(view, space, measure, &points);
                self.optimum_of(over, space, view, part, values)
            }
        }
    }
    fn optimum_of<M: Measure>(
        &self,
        measure: impl Fn(&WarpSpace) -> M,
        space: &WarpSpace,
        view: &FocusedView,
        part: &Part,
        values: &mut Vec<Named>,
    ) -> (Option<f64>, Rows) {
        let extent = |rows: &Rows| receivers_room(rows, view, part.scene, &part.size, self.tightening);
        let error = measure(space);
        let receivers = receivers_outline(&space.rows, view, part.scene, self.tightening);
        let [best, unwarped] = best_strength(space, &error, receivers, view, &part.size, extent);
        // The uniform technique's own map: a spot's is not turned, nor is one along the view where the axis is another.
        let upright = uniform_rows(view, part.scene, &mut Vec::new());
        let turned = space.unwarped(&upright, view);
        let uniform =
            if turned.rows == space.rows { unwarped } else { Strength::of(0.0, &turned, &measure(&turned), extent) };
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
