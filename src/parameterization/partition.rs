//! One map, and how it holds a point.

use std::ops::Range;

use glam::{DMat4, DVec3, DVec4};

use super::post_warp::PostWarp;
use super::region::Region;
use crate::note::Note;

/// How a map holds a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Held {
    /// Beside the map, behind its projection centre, or on a ray that it does not serve.
    Outside,
    /// Beyond the map's far plane, where casters may be missing.
    Beyond,
    /// All that could shade the point is in the map.
    Within,
}

/// A map's matrix as a product, `fit * warp * lift` (theory.md (0.3)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factors {
    /// Light space from world: x, y and w are the ray through a point, z is its place along the ray.
    pub lift: DMat4,
    /// Provisional clip space from light space. Rows x, y and w do not read z: they are the homography on the light's rays
    /// that makes the technique.
    pub warp: DMat4,
    /// Clip space from provisional clip space: the affine crop to receivers and casters, times a positive factor.
    pub fit: DMat4,
}

/// One map: where it projects to, and for which part of the view.
#[derive(Debug, Clone, PartialEq)]
pub struct Partition {
    /// `shadow_clip_from_world`: NDC x, y in [-1, 1] with y up, z in [0, 1] with 0 nearest the light.
    pub shadow_clip_from_world: DMat4,
    /// What it is the product of; nothing for somebody else's matrix.
    pub factors: Option<Factors>,
    /// What follows the projective part.
    pub post_warp: PostWarp,
    /// Near and far camera depth this map covers.
    pub eye_depth: [f64; 2],
    /// The rays this map serves; all of them unless the light's rays are divided.
    pub region: Region,
    /// Name of the technique that made it, "matrix" for somebody else's.
    pub technique: &'static str,
    /// Intermediate numbers by name (warp distance, lambda, sine of the light angle...), for tests and tables.
    pub values: Vec<(&'static str, f64)>,
    /// What the user should know of this map.
    pub notes: Vec<Note>,
}

impl Held {
    /// How a map holds the point that it projects to this NDC with this clip w.
    pub fn of(ndc: DVec3, w: f64) -> Self {
        // Written so that a NaN is outside.
        if !(w > 0.0 && ndc.x.abs() <= 1.0 && ndc.y.abs() <= 1.0) {
            Self::Outside
        } else if ndc.z <= 1.0 {
            Self::Within
        } else {
            Self::Beyond
        }
    }

    /// The first of some maps that a point is within; else the first that it is beyond.
    pub fn first(maps: Range<usize>, held: impl Fn(usize) -> Self) -> Option<usize> {
        let mut beyond = None;
        for k in maps {
            match held(k) {
                Self::Within => return Some(k),
                Self::Beyond => beyond = beyond.or(Some(k)),
                Self::Outside => {}
            }
        }
        beyond
    }
}

impl Partition {
    /// A map of somebody else's matrix that serves all camera depths.
    pub fn of_matrix(shadow_clip_from_world: DMat4) -> Self {
        Self {
            shadow_clip_from_world,
            factors: None,
            post_warp: PostWarp::None,
            eye_depth: [0.0, f64::INFINITY],
            region: Region::ALL,
            technique: "matrix",
            values: Vec::new(),
            notes: Vec::new(),
        }
    }
    /// NDC of a world point, and its clip w. Meaningful where w > 0.
    pub fn project(&self, p_world: DVec3) -> (DVec3, f64) {
        let clip: DVec4 = self.shadow_clip_from_world * p_world.extend(1.0);
        (self.post_warp.apply(clip.truncate() / clip.w, clip.w), clip.w)
    }
    /// How it holds a world point.
    pub fn holds(&self, p_world: DVec3) -> Held {
        if !self.region.contains(p_world) {
            return Held::Outside;
        }
        let (ndc, w) = self.project(p_world);
        Held::of(ndc, w)
    }
    /// A named intermediate number.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.values.iter().find(|(n, _)| *n == name).map(|v| v.1)
    }
}
