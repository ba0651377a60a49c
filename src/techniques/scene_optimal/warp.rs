//! Scene-optimized shadow maps: the homography with the least error at what is seen.
//!
//! Source: Chong, Gortler 2007 `[chong2007]` for the idea, which takes any homography of the light's rays; theory.md 10.2
//! and 10.3 for the four parameters, the objectives and the cap. Departures: shadows' edges are in the picture what counts,
//! not the squares of texels over all samples; the search finds the optimum where the published one stalls (theory.md 10.1);
//! what the map must hold is `fit`'s choice, as of every technique.

use glam::{DMat3, DVec2, DVec3};

use super::objective::{Cost, Objective};
use super::problem::{Problem, Sample, Shape};
use super::published::Published;
use super::search::least;
use crate::error::{Error, Result};
use crate::fit::Tightening;
use crate::focus::{Coverage, FocusedView, RayEdge};
use crate::geometry::Rows;
use crate::techniques::kit::light_projection::uniform_rows;
use crate::techniques::kit::{
    CAP_PX, Default, FIT, Kind, LightSupport, MARGIN, Named, Needs, ParamSpec, Part, Provisional, RANGE, SLACK,
    Settings, Spec, Warp, WarpSpace, receivers_outline,
};

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
            kind: Kind::Choice(&["edge", "l1", "l2", "area"]),
            doc: "what the search makes small, on average over samples at the edges of visible shadows: the width of a texel \
                  across the edge in the image (edge), its longest extent (l1), the sum of its sides' squares (l2, the \
                  paper's), or its area (area)",
        },
        ParamSpec {
            name: "cap",
            unit: "pixels",
            default: Default::Number(CAP_PX),
            kind: Kind::ChoiceOrNumber { words: &["none"], min: 0.5, max: 1e6 },
            doc: "width at which one sample stops to count, for edge and l1, so that none rules the sum",
        },
        RANGE,
        HELD,
        MARGIN,
        SLACK,
    ],
};

/// What the map must hold: as [`FIT`] of all warps, but by samples alone, for which the homography is made.
const HELD: ParamSpec = ParamSpec {
    kind: Kind::Choice(&["shadow", "seen"]),
    doc: "what the map must hold: visible receivers in shadow and their neighbours, as outside a map all is lit (shadow), or \
          all visible receivers (seen)",
    ..FIT
};

/// Samples of a search, at the most.
const MOST_EDGES: usize = 4096;

/// Fewer samples than this make no map for what is seen.
const LEAST_SAMPLES: usize = 3;

#[derive(Debug)]
struct SceneOptimal {
    cost: Cost,
    is_published: bool,
    tightening: Tightening,
}

/// The warp from checked settings.
pub fn make(settings: &Settings) -> Result<Box<dyn Warp>> {
    let objective = settings.meaning(
        "objective",
        &[("edge", Objective::Edge), ("l1", Objective::L1), ("l2", Objective::L2), ("area", Objective::Area)],
    )?;
    let cap = settings.number("cap").unwrap_or(f64::INFINITY);
    let is_published = settings.meaning("search", &[("full", false), ("published", true)])?;
    Ok(Box::new(SceneOptimal { cost: Cost { objective, cap }, is_published, tightening: settings.tightening()? }))
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
        let outline = receivers_outline(&rays.rows(&DMat3::IDENTITY), view, part.scene, self.tightening);
        let sample = |edge: &RayEdge, rows: [DVec2; 2]| Sample { y: edge.ray, rows, weight: edge.weight };
        let both = |edge: &RayEdge| sample(edge, [edge.pixel.row(0), edge.pixel.row(1)]);
        let hull = &outline.corners;
        let cost = if self.is_published { Cost { objective: Objective::L2, cap: f64::INFINITY } } else { self.cost };
        let told = |edge: &RayEdge| match cost.objective {
            Objective::Edge => sample(edge, [edge.across, DVec2::ZERO]),
            _ => both(edge),
        };
        let problem = Problem::new(hull, edges.iter().map(told), part.size.receivers_texels(), cost)?;
        let shape_of = |rows: &Rows| problem.shape_of(&rays.homography(rows));
        let error_of = |shape: Shape| problem.value(&shape, usize::MAX);
        let (homography, error) = if self.is_published {
            let found = published(hull, edges.iter().map(both), view.spot().is_some())?;
            (found, problem.shape_of(&found).map(error_of))
        } else {
            let starts: Vec<Shape> = Self::starts(view, part, upright).iter().filter_map(shape_of).collect();
            let (shape, error) = least(&problem, &starts)?;
            (problem.homography(&shape), Some(error))
        };
        // Squares have no mean where a sample shows no texel of the published map.
        let errors = [("error", error), ("error_uniform", shape_of(upright).map(error_of))];
        values.extend(errors.into_iter().filter_map(|(name, e)| Some((name, e.filter(|e| e.is_finite())?))));
        Some(rays.rows(&homography))
    }
    /// Maps that are known.
    fn starts(view: &FocusedView, part: &Part, upright: &Rows) -> Vec<Rows> {
        let mut starts = vec![*upright];
        // `uniform_rows` has recorded the notes on the spot's depths already; discard the duplicates.
        let space = WarpSpace::of(view, part.scene, view.camera.forward(), &view.receivers, &mut Vec::new());
        if let Some(Ok(space)) = space {
            let [near, far] = space.line();
            starts.push(space.rows);
            starts.extend(
                [0.1, 0.3, 1.0, 3.0, 10.0].map(|factor| space.warped(factor * space.equal_error_distance(near, far))),
            );
        }
        starts
    }
}

/// The homography of rays that the published search ends with. Rays are told to it from the samples' mean in units of their extent,
/// of a placed light as they are.
fn published(hull: &[DVec2], samples: impl Iterator<Item = Sample>, is_placed: bool) -> Option<DMat3> {
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
    let (found, _) = Published { hull, samples }.search(first)?;
    let told = DMat3::from_cols(DVec3::X / unit, DVec3::Y / unit, (-middle / unit).extend(1.0));
    // As light sees it: x and y turn as those of the rays.
    Some(DMat3::from_diagonal(DVec3::new(found.determinant().signum(), 1.0, 1.0)) * found * told)
}
