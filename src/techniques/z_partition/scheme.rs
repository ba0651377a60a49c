//! Cascades: the depths of the view are split, each split gets maps of its own.
//!
//! Source: Zhang, Sun, Xu, Lun 2006 `[zhang2006]` (parallel-split shadow maps); Lloyd, Tuft, Yoon, Manocha 2006
//! `[lloyd2006]` (warping and partitioning); Lauritzen, Salvi, Lefohn 2010 `[lauritzen2010]` (sample distribution
//! shadow maps); theory.md 12.1. Departures:
//! - a split is a camera with nearer planes, focused, warped and fitted as any other, so what it sees of the scene bounds its
//!   map across the light too, exactly; samples decide depths only;
//! - by default every receiver is covered, seen by a sample or not: the first split begins at the near end of the receivers'
//!   body and the last ends at its far end, and a gap in the depths belongs to the split behind it (there it costs least:
//!   towards the eye the view is narrower).
//!
//! ```text
//!  eye   |--- 0 ---|------ 1 ------|----------- 2 -----------|      overlap: a map begins within the split before,
//!      near       C1              C2                        far     which its receivers' depths do not
//! ```

use std::sync::Arc;

use super::splits::{Measure, blended, equal_shares};
use crate::error::{Error, Result};
use crate::focus::{Focus, FocusedView, Samples};
use crate::note::{self, Note};
use crate::parameterization::{Selection, Value};
use crate::scene::Light;
use crate::techniques::kit::{
    Default, Kind, LightSupport, Maps, Needs, ParamSpec, Part, Settings, Spec, Technique, with_length,
};
use crate::techniques::{technique, techniques_of};

/// What the technique says of itself.
pub static SPEC: Spec = Spec {
    name: "z_partition",
    title: "Depth splits (cascades)",
    source: "Zhang, Sun, Xu, Lun 2006; Lloyd, Tuft, Yoon, Manocha 2006; Lauritzen, Salvi, Lefohn 2010",
    lights: LightSupport { directional: true, spot: true, point: true },
    params: &[
        ParamSpec {
            name: "count",
            unit: "",
            default: Default::Integer(4),
            kind: Kind::Integer { min: 1, max: MOST as i64 },
            doc: "how many splits",
        },
        ParamSpec {
            name: "splits",
            unit: "",
            default: Default::Choice("practical"),
            kind: Kind::Choice(&["uniform", "logarithmic", "practical", "min-max", "equal-log"]),
            doc: "where the depths are split: equally long, equally long in ratio, a blend of both; or from samples of what is \
                  seen, equally long in ratio between the least and the greatest depth (min-max), or with equal shares of \
                  the logarithmic depths in which anything is seen (equal-log); of an orthographic camera lengths stand for \
                  ratios and logarithms",
        },
        ParamSpec {
            name: "blend",
            unit: "",
            default: Default::Number(0.5),
            kind: Kind::Number { min: 0.0, max: 1.0 },
            doc: "share of the logarithmic scheme in the practical one; 0.5 is that of Zhang et al. 2006",
        },
        ParamSpec {
            name: "distances",
            unit: "world units",
            default: Default::Choice("none"),
            // Of an orthographic camera depths may be negative.
            kind: Kind::Numbers { words: &["none"], count: [1, MOST - 1], min: f64::MIN, max: f64::MAX },
            doc: "camera depths of the borders between splits, ascending, instead of count and splits",
        },
        ParamSpec {
            name: "range",
            unit: "",
            default: Default::Choice("auto"),
            kind: Kind::Choice(&["auto", "seen", "body", "camera"]),
            doc: "depths that are split: those of the visible surfaces that face the light (seen), of the part of the scene's \
                  box inside the camera's frustum, most of it air (body), or those between its near and far planes (camera); \
                  auto: body, or camera where stable is on",
        },
        ParamSpec {
            name: "cover",
            unit: "",
            default: Default::Choice("receivers"),
            kind: Kind::Choice(&["receivers", "samples"]),
            doc: "with splits from samples, what the maps cover: all that can be seen, or no more depths than the samples have",
        },
        ParamSpec {
            name: "overlap",
            unit: "",
            default: Default::Number(0.0),
            kind: Kind::Number { min: 0.0, max: 0.99 },
            doc: "share of a split's length by which the map of the next split begins earlier, so that it holds what is seen \
                  where both are blended",
        },
        ParamSpec {
            name: "inner",
            unit: "",
            default: Default::Choice("uniform"),
            kind: Kind::Techniques,
            doc: "the technique of each split, nearest first, separated by /; the last serves all that follow",
        },
        ParamSpec {
            name: "stable",
            unit: "",
            default: Default::Flag(false),
            kind: Kind::Flag,
            doc: "texels of uniform inner maps stand still while the camera moves; the splits depend on the camera's planes alone",
        },
    ],
};

/// Most splits.
const MOST: usize = 16;

#[derive(Debug, Clone, PartialEq)]
enum Rule {
    /// A share of the logarithmic scheme in the uniform one.
    Blended(f64),
    /// The logarithmic scheme between the ends of the sampled depths.
    MinMax,
    /// Equal shares of the occupied logarithmic depths.
    EqualLog,
    /// Borders between splits.
    Distances(Vec<f64>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Range {
    Camera,
    Body,
    Seen,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cover {
    Receivers,
    Samples,
}

#[derive(Debug)]
struct ZPartition {
    settings: Settings,
    count: usize,
    rule: Rule,
    range: Range,
    cover: Cover,
    overlap: f64,
    /// At least one; the last is repeated.
    inner: Vec<Box<dyn Technique>>,
}

/// Camera depths of a split.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Split {
    /// Whose receivers read its maps.
    serves: [f64; 2],
    /// What its maps are made for.
    covers: [f64; 2],
}

/// The scheme from checked settings.
pub fn make(mut settings: Settings) -> Result<Box<dyn Technique>> {
    let distances = settings.numbers("distances").to_vec();
    if let Some(w) = distances.windows(2).find(|w| w[0] >= w[1]) {
        let got = format!("{} before {}", w[0], w[1]);
        return Err(Error::argument("distances", "ascending camera depths", got, "sort them, each once"));
    }
    let rules = [
        ("uniform", Rule::Blended(0.0)),
        ("logarithmic", Rule::Blended(1.0)),
        ("practical", Rule::Blended(settings.declared_number("blend")?)),
        ("min-max", Rule::MinMax),
        ("equal-log", Rule::EqualLog),
    ];
    let rule = if distances.is_empty() { settings.meaning("splits", &rules)? } else { Rule::Distances(distances) };
    let count = match &rule {
        Rule::Distances(list) => list.len() + 1,
        _ => settings.declared_number("count")? as usize,
    };
    settings.set("count", Value::Integer(count as i64));
    let inner = techniques_of(settings.word("inner"))?;
    if inner.len() > count {
        let got = format!("{} techniques for {count} splits", inner.len());
        return Err(Error::argument("inner", "no more techniques than splits", got, "name fewer, or split into more"));
    }
    let stable = settings.flag("stable");
    let auto = if stable { Range::Camera } else { Range::Body };
    let words = [("auto", auto), ("seen", Range::Seen), ("body", Range::Body), ("camera", Range::Camera)];
    let range = settings.meaning("range", &words)?;
    let inner = if stable { stable_ones(&rule, range, inner)? } else { inner };
    let cover = settings.meaning("cover", &[("receivers", Cover::Receivers), ("samples", Cover::Samples)])?;
    let overlap = settings.declared_number("overlap")?;
    Ok(Box::new(ZPartition { settings, count, rule, range, cover, overlap, inner }))
}

/// The inner techniques with their texels held still; an error where something would move them.
fn stable_ones(rule: &Rule, range: Range, inner: Vec<Box<dyn Technique>>) -> Result<Vec<Box<dyn Technique>>> {
    if matches!(rule, Rule::MinMax | Rule::EqualLog) {
        let fix = "choose another scheme for splits, or leave stable off";
        return Err(Error::argument("splits", "depths that stand still", "depths from samples, with stable on", fix));
    }
    if range != Range::Camera {
        let fix = "set range to camera, or leave stable off";
        return Err(Error::argument("range", "camera, where stable is on", "depths that move with the camera", fix));
    }
    let held = |t: Box<dyn Technique>| {
        if t.spec().name != "uniform" {
            let fix =
                "name uniform alone, or leave stable off: a warp depends on the camera's place, so its texels move";
            return Err(Error::argument("inner", "uniform, where stable is on", t.spec().name, fix));
        }
        let mut settings: Vec<(String, Value)> =
            t.settings().into_iter().map(|(name, value)| (name.to_string(), value)).collect();
        settings.retain(|(name, _)| name != "stable");
        settings.push(("stable".to_string(), Value::Flag(true)));
        technique("uniform", &settings)
    };
    inner.into_iter().map(held).collect()
}

impl Technique for ZPartition {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }
    fn shared_settings(&self) -> Arc<[(&'static str, Value)]> {
        self.settings.shared()
    }
    fn needs(&self) -> Needs {
        let sampled = matches!(self.rule, Rule::MinMax | Rule::EqualLog) || self.range == Range::Seen;
        let own = if sampled { Needs::Surfaces } else { Needs::Nothing };
        self.inner.iter().map(|t| t.needs()).fold(own, Needs::max)
    }
    /// As far as all inner techniques do.
    fn serves(&self, light: &Light) -> Result<()> {
        self.inner.iter().try_for_each(|t| t.serves(light))
    }
    fn most_maps(&self) -> usize {
        let of = |i: usize| self.inner[i.min(self.inner.len() - 1)].most_maps();
        (0..self.count).map(of).fold(0, usize::saturating_add)
    }
    fn maps(&self, part: &Part) -> Result<Maps> {
        let mut notes = Vec::new();
        let splits = self.splits(part, &mut notes);
        let mut all = Maps { maps: Vec::with_capacity(splits.len()), selection: Selection::Depth, notes };
        for (i, split) in splits.iter().enumerate() {
            let [near, far] = split.covers;
            let camera = part.camera.with_depths(near, far)?;
            let inner = &self.inner[i.min(self.inner.len() - 1)];
            let Maps { mut maps, selection, notes } = inner.maps(&Part { camera, ..*part })?;
            let last = maps.len() - 1;
            for (k, map) in maps.iter_mut().enumerate() {
                let depths = &mut map.eye_depth;
                // Maps that divide the split by depth meet its ends; others serve all of it.
                if k == 0 || selection == Selection::Containment {
                    depths[0] = split.serves[0];
                }
                if k == last || selection == Selection::Containment {
                    depths[1] = split.serves[1];
                }
                map.values.extend([("covered_near", near), ("covered_far", far)]);
            }
            all.maps.append(&mut maps);
            all.notes.extend(notes);
        }
        Ok(all)
    }
}

impl ZPartition {
    /// The splits, nearest first, each beginning where the one before ends or behind.
    fn splits(&self, part: &Part, notes: &mut Vec<Note>) -> Vec<Split> {
        let camera = &part.camera;
        let body = || {
            let view = FocusedView::new(part.scene, camera, &part.light, Focus::SceneFit);
            view.restricted(part.scene, &part.region).eye_depth
        };
        let planes = [camera.near(), camera.far()];
        let seen = || part.samples.and_then(|samples| samples.depths(camera, &part.light, &part.region));
        let whole = match self.range {
            Range::Camera => planes,
            Range::Body => body(),
            Range::Seen => seen().unwrap_or_else(body),
        };
        let measure = Measure::of(camera);
        let by_ratio = !matches!(self.rule, Rule::Distances(_) | Rule::Blended(0.0));
        if measure == Measure::Length && by_ratio {
            notes.push(Note::new(note::Kind::EvenSplits, &[]));
        }
        let mut served = match &self.rule {
            Rule::Blended(blend) => between(&blended(whole[0], whole[1], self.count, measure.blend(*blend))),
            Rule::Distances(distances) => between(&borders(distances, whole, planes, notes)),
            Rule::MinMax | Rule::EqualLog => self.sampled(part, whole, notes),
        };
        let sampled = matches!(self.rule, Rule::MinMax | Rule::EqualLog);
        if self.cover == Cover::Samples && !sampled {
            notes.push(Note::new(note::Kind::CoverUnused, &[]));
        }
        let cover = if sampled { self.cover } else { Cover::Receivers };
        let last = served.len() - 1;
        if self.range == Range::Seen && cover == Cover::Receivers {
            // Receivers that no sample shows are served, too.
            (served[0][0], served[last][1]) = (camera.near(), camera.far());
        }
        let by_samples = part.samples.filter(|_| cover == Cover::Samples);
        let step = by_samples.map_or(0.0, Samples::rounding);
        let covered = |i: usize, [begin, end]: [f64; 2]| {
            // Towards the eye an overlap costs least: the view is narrower there.
            let length = if i == 0 { 0.0 } else { served[i - 1][1] - served[i - 1][0] };
            let begin = (begin - self.overlap * length).max(camera.near());
            match cover {
                Cover::Samples => [begin - step, end + step].map(|depth| depth.clamp(camera.near(), camera.far())),
                // Out to the planes: the body of what is seen ends before, and no rounding of a depth leaves it uncovered.
                Cover::Receivers => {
                    [if i == 0 { camera.near() } else { begin }, if i == last { camera.far() } else { end }]
                }
            }
        };
        let split =
            |(i, &serves): (usize, &[f64; 2])| Split { serves, covers: with_length(covered(i, serves), camera) };
        served.iter().enumerate().map(split).collect()
    }
    /// Splits from the depths of what is seen.
    fn sampled(&self, part: &Part, whole: [f64; 2], notes: &mut Vec<Note>) -> Vec<[f64; 2]> {
        let Part { camera, light, region, .. } = part;
        let lit = part.samples.into_iter().flat_map(|samples| samples.lit(camera, light, region));
        let depths: Vec<f64> = lit.map(|(p, _)| camera.depth_of(p)).collect();
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (near, far) = depths.iter().fold(ends, |(a, b), d| (a.min(*d), b.max(*d)));
        let measure = Measure::of(camera);
        if depths.is_empty() {
            notes.push(Note::new(note::Kind::NoLitSample, &[]));
            return between(&blended(whole[0], whole[1], self.count, measure.blend(1.0)));
        }
        let mut splits = match self.rule {
            Rule::EqualLog => equal_shares(&depths, self.count, measure),
            _ => between(&blended(near, far, self.count, measure.blend(1.0))),
        };
        match self.cover {
            Cover::Samples => {
                notes.push(Note::new(note::Kind::CoversSamples, &[("near", near), ("far", far)]));
            }
            Cover::Receivers => {
                for i in 1..splits.len() {
                    splits[i][0] = splits[i - 1][1];
                }
                let last = splits.len() - 1;
                splits[0][0] = whole[0].min(near);
                splits[last][1] = whole[1].max(far);
            }
        }
        splits
    }
}

/// The splits between borders.
fn between(borders: &[f64]) -> Vec<[f64; 2]> {
    borders.windows(2).map(|w| [w[0], w[1]]).collect()
}

/// Ends and given inner borders; those outside of the camera's planes are moved there, so that the count of maps stays.
fn borders(distances: &[f64], whole: [f64; 2], planes: [f64; 2], notes: &mut Vec<Note>) -> Vec<f64> {
    let inner = distances.iter().map(|d| {
        if !(planes[0]..=planes[1]).contains(d) {
            let values = [("border", *d), ("near", planes[0]), ("far", planes[1])];
            notes.push(Note::new(note::Kind::BorderOutside, &values));
        }
        d.clamp(planes[0], planes[1])
    });
    let inner: Vec<f64> = inner.collect();
    let (first, last) = (whole[0].min(inner[0]), whole[1].max(inner[inner.len() - 1]));
    [first].into_iter().chain(inner).chain([last]).collect()
}
