//! Scene-optimal partition: the depths of the view are divided where their maps' error at what is seen is least.
//!
//! Source: theory.md 10.8, with Zhang, Sun, Xu, Lun 2006 `[zhang2006]` for depth splits and Chong, Gortler 2007 `[chong2007]` for the map
//! of each. Eye depths are cut at quantiles of the samples at shadows' edges; for every run of the intervals between the
//! search of `scene_optimal` finds its best homography and what that costs, and dynamic programming chooses the runs.
//!
//! ```text
//!  eye  |--|-|-|--|---|----|------|-----------|     quantiles of the depths of shadows' edges
//!       |== map 0 ===|====== map 1 ===========|     runs with the least sum of their own maps' costs
//! ```

use std::sync::Arc;

use glam::DVec2;

use super::division::least_division;
use crate::error::{Error, Result};
use crate::focus::RayEdge;
use crate::geometry::convex_hull;
use crate::note::{self, Note};
use crate::parameterization::{Selection, Value};
use crate::scene::{Camera, Light};
use crate::techniques::kit::{
    Default, Holds, Kind, LightSupport, MARGIN, Maps, Needs, ParamSpec, Part, SLACK, Settings, Spec, Technique,
    with_length,
};
use crate::techniques::scene_optimal::{CAP, Cost, HELD, Problem, SUM, Shape, cost_of, least};
use crate::techniques::technique;

/// What the technique says of itself.
pub static SPEC: Spec = Spec {
    name: "optimal_partition",
    title: "Scene-optimal depth splits",
    source: "after Chong, Gortler 2007; Zhang, Sun, Xu, Lun 2006",
    lights: LightSupport { directional: true, spot: true, point: true },
    params: &[
        ParamSpec {
            name: "count",
            unit: "",
            default: Default::Choice("auto"),
            kind: Kind::ChoiceOrNumber { words: &["auto"], min: 1.0, max: INTERVALS as f64 },
            doc: "how many splits; auto takes the number, 1 to 4, whose maps have the least error where all together have the memory \
                  of one of 1024 x 1024 texels, whatever the resolution",
        },
        SUM,
        CAP,
        HELD,
        MARGIN,
        SLACK,
    ],
};

/// Intervals between quantiles. Chosen because more of them move splits by less than maps differ (theory.md 10.8).
const INTERVALS: usize = 8;

/// Splits that `count=auto` tries. Chosen because with more the error hardly falls (theory.md 10.8).
const MOST_AUTO: usize = 4;

/// Texels along each side of one map in whose memory `count=auto` compares counts. Not those asked for, so that as many maps are
/// made for any: who divides a memory among them asks for fewer texels.
const AUTO_TEXELS: u32 = 1024;

/// Depths that differ by less than this share are one. Derived from f32, in which surfaces lie: a hundred roundings.
const SAME_DEPTH: f64 = 100.0 * f32::EPSILON as f64;

/// Samples at shadows' edges that are looked at.
const MOST_EDGES: usize = 4096;

#[derive(Debug)]
struct OptimalPartition {
    settings: Settings,
    /// Nothing for the best.
    count: Option<usize>,
    cost: Cost,
    /// The technique of each split.
    inner: Box<dyn Technique>,
}

/// The scheme from checked settings.
pub fn make(settings: Settings) -> Result<Box<dyn Technique>> {
    let count = settings.number("count");
    if let Some(count) = count.filter(|count| count.fract() != 0.0) {
        let expected = format!("auto, or a whole number from 1 to {INTERVALS}");
        return Err(Error::argument("count", expected, count, "give a whole number"));
    }
    let count = count.map(|count| count as usize);
    let cost = cost_of(&settings)?;
    let same = |(name, _): &&(&str, Value)| *name != "count";
    let inner: Vec<(String, Value)> =
        settings.values().iter().filter(same).map(|(name, value)| (name.to_string(), value.clone())).collect();
    let inner = technique("scene_optimal", &inner)?;
    Ok(Box::new(OptimalPartition { settings, count, cost, inner }))
}

impl Technique for OptimalPartition {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }
    fn shared_settings(&self) -> Arc<[(&'static str, Value)]> {
        self.settings.shared()
    }
    fn needs(&self) -> Needs {
        self.inner.needs()
    }
    fn serves(&self, light: &Light) -> Result<()> {
        self.inner.serves(light)
    }
    fn most_maps(&self) -> usize {
        self.count.unwrap_or(MOST_AUTO)
    }
    fn maps(&self, part: &Part) -> Result<Maps> {
        let borders = self.borders(part)?;
        let mut notes = Vec::new();
        let made = borders.len() - 1;
        if let Some(count) = self.count.filter(|count| *count > made) {
            notes.push(Note::new(note::Kind::FewerMaps, &[("made", made as f64), ("count", count as f64)]));
        }
        let mut all = Maps { maps: Vec::with_capacity(made), selection: Selection::Depth, notes };
        for ends in borders.windows(2) {
            let [near, far] = with_length([ends[0], ends[1]], &part.camera);
            let camera = part.camera.with_depths(near, far)?;
            let Maps { mut maps, notes, .. } = self.inner.maps(&Part { camera, ..*part })?;
            for map in &mut maps {
                map.eye_depth = [ends[0], ends[1]];
                map.values.extend([("covered_near", near), ("covered_far", far)]);
            }
            all.maps.append(&mut maps);
            all.notes.extend(notes);
        }
        Ok(all)
    }
}

/// The best map of a run of intervals.
struct Best {
    problem: Problem,
    shape: Shape,
    /// Pixels at edges.
    weight: f64,
}

impl OptimalPartition {
    /// The ends of the splits' depths, ascending, from the camera's near to its far plane.
    fn borders(&self, part: &Part) -> Result<Vec<f64>> {
        let camera = &part.camera;
        let whole = vec![camera.near(), camera.far()];
        let seen = part.samples.and_then(|s| s.ray_edges(camera, &part.light, &part.region, MOST_EDGES));
        let Some((_, edges)) = seen.filter(|_| self.count != Some(1)) else { return Ok(whole) };
        let borders = quantiles(&edges, camera);
        let hulls = borders.windows(2).map(|ends| self.hull(part, [ends[0], ends[1]]));
        let hulls = hulls.collect::<Result<Vec<_>>>()?;
        let intervals = hulls.len();
        let auto = |count: usize| DVec2::splat(f64::from(AUTO_TEXELS) / (count as f64).sqrt());
        let texels = self.count.map_or(auto(1), |_| part.size.receivers_texels());
        let best = |first: usize, end: usize| {
            let within = |edge: &&RayEdge| {
                // The first and last reach to the camera's planes.
                (first == 0 || edge.depth > borders[first]) && (end == intervals || edge.depth <= borders[end])
            };
            let edges: Vec<&RayEdge> = edges.iter().filter(within).collect();
            let mut hull: Vec<DVec2> = hulls[first..end].concat();
            convex_hull(&mut hull, &mut Vec::new());
            let problem = Problem::of_edges(&hull, edges.iter().copied(), texels, self.cost)?;
            let (shape, _) = least(&problem, &[])?;
            Some(Best { problem, shape, weight: edges.iter().map(|edge| edge.weight).sum() })
        };
        // Of runs from `first` to `end`; where nothing is to be held, or no edge is seen, no error.
        let runs: Vec<Vec<Option<Best>>> =
            (0..intervals).map(|first| (first + 1..=intervals).map(|end| best(first, end)).collect()).collect();
        let divided = |count: usize, texels: DVec2| {
            least_division(intervals, count, |first, end| {
                let run = runs[first][end - first - 1].as_ref();
                run.map_or(0.0, |best| best.weight * best.problem.value_with(&best.shape, texels))
            })
        };
        let ends = match self.count {
            Some(count) => divided(count, texels).0,
            None => {
                let tried = (1..=MOST_AUTO.min(intervals)).map(|count| divided(count, auto(count)));
                tried.min_by(|a, b| a.1.total_cmp(&b.1)).map_or_else(Vec::new, |(ends, _)| ends)
            }
        };
        Ok([0].iter().chain(&ends).map(|&i| borders[i]).collect())
    }
    /// Corners of what the maps of a run hold of an interval of depths, in the coordinates of the light's rays.
    fn hull(&self, part: &Part, ends: [f64; 2]) -> Result<Vec<DVec2>> {
        let [near, far] = with_length(ends, &part.camera);
        let camera = part.camera.with_depths(near, far)?;
        let outline = part.samples.and_then(|samples| match self.settings.holds() {
            Holds::Shadow => samples.shaded_outline(&camera, &part.light, &part.region),
            Holds::Seen | Holds::Body => samples.outline(&camera, &part.light, &part.region),
        });
        Ok(outline.map_or_else(Vec::new, |outline| outline.corners))
    }
}

/// Depths between which there are equal shares of the edges, from the camera's near to its far plane; fewer where depths are the
/// same.
fn quantiles(edges: &[RayEdge], camera: &Camera) -> Vec<f64> {
    let mut depths: Vec<(f64, f64)> = edges.iter().map(|edge| (edge.depth, edge.weight)).collect();
    depths.sort_by(|a, b| a.0.total_cmp(&b.0));
    let all: f64 = depths.iter().map(|(_, weight)| weight).sum();
    let mut borders = vec![camera.near()];
    let mut sum = 0.0;
    for pair in depths.windows(2) {
        let ([depth, next], weight) = ([pair[0].0, pair[1].0], pair[0].1);
        sum += weight;
        let is_due = sum >= all * borders.len() as f64 / INTERVALS as f64;
        let (middle, last) = (0.5 * (depth + next), borders[borders.len() - 1]);
        if is_due && next - depth > SAME_DEPTH * camera.distance_at(next) && last < middle && middle < camera.far() {
            borders.push(middle);
        }
    }
    borders.truncate(INTERVALS);
    borders.push(camera.far());
    borders
}
