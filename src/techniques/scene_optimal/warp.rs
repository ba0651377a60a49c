//! Scene-optimized shadow maps: the homography with the least error at what is seen.
//!
//! Source: Chong, Gortler 2007 `[chong2007]` for the idea, which takes any homography of the light's rays; theory.md 10.2
//! and 10.3 for the four parameters, the objectives and the cap. Departures: shadows' edges are in the picture what counts,
//! not the squares of texels over all samples; the search finds the optimum where the published one stalls (theory.md 10.1);
//! what the map must hold is `fit`'s choice, as of every technique.

use glam::{DMat3, DVec2, DVec3};

use super::flips::Flips;
use super::kernel::Sample;
use super::objective::{Cost, Objective};
use super::problem::{Problem, Shape};
use super::published::{ITERATIONS, Published};
use super::search::least;
use crate::error::{Error, Result};
use crate::fit::Tightening;
use crate::focus::{Coverage, FocusedView, RayEdge};
use crate::geometry::Rows;
use crate::parameterization::Value;
use crate::techniques::kit::light_projection::uniform_rows;
use crate::techniques::kit::{
    Default, FIT, Kind, LightSupport, MARGIN, Named, Needs, ParamSpec, Part, Provisional, RANGE, SLACK, Settings, Spec,
    Warp, receivers_outline,
};
use crate::techniques::{lispsm, plane_optimal, uniform};

/// What the technique says of itself.
pub static SPEC: Spec = Spec {
    name: "scene_optimal",
    title: "Scene-optimized shadow map",
    source: "after Chong, Gortler 2007",
    lights: LightSupport { directional: true, spot: true, point: true },
    params: &[
        ParamSpec {
            name: "search",
            unit: "",
            default: Default::Choice("full"),
            kind: Kind::Choice(&["full", "published"]),
            doc: "over all homographies for the least of the objective (full), or the paper's: algorithm 1 on the sum of \
                  squares, three iterations (published)",
        },
        ParamSpec {
            name: "objective",
            unit: "",
            default: Default::Choice("edge"),
            kind: Kind::Choice(&["edge", "l1", "l2", "area", "flips"]),
            doc: "what the search makes small, on average over samples at the edges of visible shadows: the width of a texel \
                  across the edge in the image (edge), its longest extent (l1), the sum of its sides' squares (l2, the \
                  paper's), or its area (area); or the share of pixels whose shadow state changes within their texel, over \
                  receivers near edges, begun at the best map for edge (flips)",
        },
        CAP,
        RANGE,
        HELD,
        MARGIN,
        SLACK,
    ],
};

/// What is summed without a picture of the states: a parameter of schemes of such maps.
pub const SUM: ParamSpec = ParamSpec {
    name: "objective",
    unit: "",
    default: Default::Choice("edge"),
    kind: Kind::Choice(&["edge", "l1", "l2", "area"]),
    doc: "what is made small, as in scene_optimal: the width of a texel across the edge in the image (edge), its longest \
          extent (l1), the sum of its sides' squares (l2), or its area (area)",
};

/// Where lengths stop to count. The default is chosen by leaving scenes out (docs/defaults.md).
pub const CAP: ParamSpec = ParamSpec {
    name: "cap",
    unit: "pixels",
    default: Default::Number(16.0),
    kind: Kind::ChoiceOrNumber { words: &["none"], min: 0.5, max: 1e6 },
    doc: "width at which one sample stops to count, for edge and l1, so that none rules the sum",
};

/// What the map must hold: as [`FIT`] of all warps, but by samples alone, for which the homography is made.
pub const HELD: ParamSpec = ParamSpec {
    kind: Kind::Choice(&["shadow", "seen"]),
    doc: "what the map must hold: visible receivers in shadow and their neighbours, as outside a map all is lit (shadow), or \
          all visible receivers (seen)",
    ..FIT
};

/// Samples of a search, at the most.
const MOST_EDGES: usize = 4096;

/// Fewer samples than this make no map for what is seen.
const LEAST_SAMPLES: usize = 3;

/// Names of the errors of the published search, before its first step and after each that it accepts.
const STEP_ERRORS: [&str; ITERATIONS + 1] = ["error_step_0", "error_step_1", "error_step_2", "error_step_3"];

#[derive(Debug)]
struct SceneOptimal {
    cost: Cost,
    search: Search,
    tightening: Tightening,
}

/// How the homography is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Search {
    /// The least of the cost over all homographies.
    Full,
    /// From there on the least of flips.
    Flips,
    /// Algorithm 1 of the paper.
    Published,
}

/// The sum over samples that settings name; for flips, that of the edges' widths.
pub fn cost_of(settings: &Settings) -> Result<Cost> {
    let objectives = [
        ("edge", Objective::Edge),
        ("l1", Objective::L1),
        ("l2", Objective::L2),
        ("area", Objective::Area),
        ("flips", Objective::Edge),
    ];
    let cap = settings.number("cap").unwrap_or(f64::INFINITY);
    Ok(Cost { objective: settings.meaning("objective", &objectives)?, cap })
}

/// The warp from checked settings.
pub fn make(settings: &Settings) -> Result<Box<dyn Warp>> {
    let search = match settings.meaning("search", &[("full", Search::Full), ("published", Search::Published)])? {
        Search::Full if settings.word("objective") == "flips" => Search::Flips,
        search => search,
    };
    let cost = match search {
        Search::Published => Cost { objective: Objective::L2, cap: f64::INFINITY },
        _ => cost_of(settings)?,
    };
    Ok(Box::new(SceneOptimal { cost, search, tightening: settings.tightening()? }))
}

impl Warp for SceneOptimal {
    fn needs(&self) -> Needs {
        Needs::Shadows
    }
    fn warp(&self, view: &FocusedView, part: &Part) -> Result<Provisional> {
        let (mut values, mut notes) = (Vec::new(), Vec::new());
        let upright = uniform_rows(view, part.scene, &mut notes);
        if let Some(samples) = part.samples.filter(|s| s.len() < LEAST_SAMPLES) {
            return Err(Error::UnsuitedView {
                technique: SPEC.name.into(),
                reason: format!("fewer than three visible points are known ({})", samples.len()),
                fix: "turn the camera to what receives shadows, or give more samples".into(),
            });
        }
        let found = match view.coverage {
            Coverage::NothingSeen => None,
            Coverage::AsAsked => self.optimum(view, part, &upright, &mut values),
        };
        Ok(Provisional { clip_from_local: found.unwrap_or(upright), values, notes })
    }
}

impl SceneOptimal {
    /// The rows of the best homography; nothing where no sample tells one map from another.
    fn optimum(&self, view: &FocusedView, part: &Part, upright: &Rows, values: &mut Vec<Named>) -> Option<Rows> {
        let (rays, edges) = part
            .samples?
            .ray_edges(&part.camera, &part.light, &part.region, MOST_EDGES)
            .filter(|(_, e)| !e.is_empty())?;
        let hull = receivers_outline(&rays.rows(&DMat3::IDENTITY), view, part.scene, self.tightening).corners;
        let both = |edge: &RayEdge| {
            let rows = [edge.pixel.row(0), edge.pixel.row(1)];
            Sample { y: edge.ray, rows, weight: edge.weight }
        };
        let problem = Problem::of_edges(&hull, edges.iter(), part.size.receivers_texels(), self.cost)?;
        let shape_of = |rows: &Rows| problem.shape_of(&rays.homography(rows));
        let published = published(&hull, edges.iter().map(both), view.spot().is_some()).unwrap_or_default();
        let uniform = shape_of(upright);
        let least = || {
            let known = Self::known(view, part).into_iter().filter_map(|rows| shape_of(&rows));
            let last = published.last().and_then(|found| problem.shape_of(found));
            least(&problem, &known.chain(uniform).chain(last).collect::<Vec<_>>())
        };
        // Squares have no mean where a sample shows no texel of the published map.
        let finite = |(name, e): (&'static str, Option<f64>)| Some((name, e.filter(|e| e.is_finite())?));
        let error = |shape: Shape| problem.value(&shape, usize::MAX);
        let (homography, errors) = match self.search {
            Search::Published => {
                let errors: Vec<_> = published.iter().map(|found| problem.shape_of(found).map(error)).collect();
                values.extend(STEP_ERRORS.into_iter().zip(errors.iter().copied()).filter_map(finite));
                (*published.last()?, [*errors.last()?, uniform.map(error)])
            }
            Search::Full => {
                let (shape, least) = least()?;
                (problem.homography(&shape), [Some(least), uniform.map(error)])
            }
            Search::Flips => {
                let (shape, value) = least()?;
                // Samples without a picture of the states have no flips.
                let walked = Flips::of(part, &hull).and_then(|flips| {
                    let (shape, share) = flips.least(&problem, uniform.into_iter().chain([shape]))?;
                    Some((shape, [Some(share), uniform.map(|shape| flips.share(&problem.homography(&shape)))]))
                });
                let (shape, errors) = walked.unwrap_or((shape, [Some(value), uniform.map(error)]));
                (problem.homography(&shape), errors)
            }
        };
        values.extend(["error", "error_uniform"].into_iter().zip(errors).filter_map(finite));
        Some(rays.rows(&homography))
    }
    /// Maps that are known: those of the techniques whose families hold the best that closed forms give.
    fn known(view: &FocusedView, part: &Part) -> Vec<Rows> {
        let rectangle = [("turn".to_string(), Value::Choice("rectangle".to_string()))];
        let of = |spec: &Spec, make: fn(&Settings) -> Result<Box<dyn Warp>>, settings: &[_]| {
            make(&spec.resolve(settings)?)?.warp(view, part)
        };
        let made = [
            of(&uniform::SPEC, uniform::make, &rectangle),
            of(&lispsm::SPEC, lispsm::make, &[]),
            of(&plane_optimal::SPEC, plane_optimal::make, &[]),
        ];
        // What cannot serve the view is no start.
        made.into_iter().flatten().map(|made| made.clip_from_local).collect()
    }
}

/// The homographies of rays that the published search accepts, in order. Rays are told to it from the samples' mean in units
/// of their extent, of a placed light as they are.
fn published(hull: &[DVec2], samples: impl Iterator<Item = Sample>, is_placed: bool) -> Option<Vec<DMat3>> {
    let mut samples: Vec<Sample> = samples.collect();
    let (mut middle, mut unit) = (DVec2::ZERO, 1.0);
    if !is_placed {
        middle = samples.iter().map(|s| s.y).sum::<DVec2>() / samples.len() as f64;
        unit = samples.iter().map(|s| (s.y - middle).abs().max_element()).fold(0.0, f64::max);
    }
    if !(unit > 0.0) {
        return None;
    }
    let hull = hull.iter().map(|y| (*y - middle) / unit).collect();
    for s in &mut samples {
        (s.y, s.rows) = ((s.y - middle) / unit, s.rows.map(|row| row * unit));
    }
    let first = match is_placed {
        true => samples.iter().map(|s| s.y.extend(1.0).normalize()).sum(),
        false => DVec3::Z,
    };
    let steps = Published { hull, samples }.search(first)?;
    let told = DMat3::from_cols(DVec3::X / unit, DVec3::Y / unit, (-middle / unit).extend(1.0));
    // As light sees it: x and y turn as those of the rays.
    let turned = |found: DMat3| DMat3::from_diagonal(DVec3::new(found.determinant().signum(), 1.0, 1.0)) * found * told;
    Some(steps.iter().map(|step| turned(step.homography)).collect())
}
