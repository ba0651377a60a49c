//! The result of a technique: plain data that renderers, analysis and users see.

use std::ops::Range;

use glam::{DMat4, DVec3, DVec4};

use crate::error::{Error, Result};
use crate::note::Note;

/// The value of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A real number.
    Number(f64),
    /// A whole number.
    Integer(i64),
    /// On or off.
    Flag(bool),
    /// One of a few words, or the text of one or several techniques.
    Choice(String),
    /// A list of numbers.
    Numbers(Vec<f64>),
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(x) => write!(f, "{x}"),
            Self::Integer(i) => write!(f, "{i}"),
            Self::Flag(b) => write!(f, "{b}"),
            Self::Choice(word) => write!(f, "{word:?}"),
            Self::Numbers(list) => {
                let texts: Vec<String> = list.iter().map(f64::to_string).collect();
                write!(f, "({})", texts.join(", "))
            }
        }
    }
}

/// What happens to map coordinates after the projective part.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum PostWarp {
    /// Nothing.
    #[default]
    None,
    /// NDC y is replaced by `scale * ln(w) + offset`, w the clip w that the matrix gives (11.1). As w is constant
    /// along a light ray, rays stay points; x and z are those of the projective part. Planes are no planes any more.
    Log {
        /// NDC y per unit of ln w.
        scale: f64,
        /// NDC y where w = 1.
        offset: f64,
    },
}

/// The part of the light's rays that a map serves: where up to eight linear functionals of (p, 1) are not negative.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Region {
    functionals: [DVec4; Self::MOST],
    count: usize,
}

/// How a receiver finds its map, where there are several.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Selection {
    /// The first map whose depth range does not end before the receiver's camera depth, and which holds it.
    #[default]
    Depth,
    /// The first map that holds the receiver, whatever its camera depth.
    Containment,
}

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

/// A technique's settings turned into matrices for one scene, camera and light.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameterization {
    /// Name of the technique, or "matrix" for somebody else's.
    pub technique: String,
    /// The technique's parameters as used.
    pub settings: Vec<(&'static str, Value)>,
    /// The maps, nearest first. At least one.
    pub partitions: Vec<Partition>,
    /// How a receiver finds its map.
    pub selection: Selection,
    /// Texels along x and y the fit (border, snapping) was made for.
    pub resolution: [u32; 2],
    /// Texels at each side that no receiver maps to.
    pub border_texels: u32,
    /// What the user should know of all maps, or of some of them: those of the maps are gathered here.
    pub notes: Vec<Note>,
}

impl Region {
    /// Most functionals.
    pub const MOST: usize = 8;
    /// What counts as on a border, relative to the terms of a functional. Derived from f64: the roundings of coefficients, of a
    /// change of origin, of the point and of the sum, 2^-53 each. A point on the border between two maps must not fall
    /// between them.
    const ROUNDING: f64 = 16.0 * f64::EPSILON;
    /// All rays.
    pub const ALL: Self = Self { functionals: [DVec4::ZERO; Self::MOST], count: 0 };

    /// Where all of these, at most [`Region::MOST`], are not negative.
    ///
    /// # Panics
    /// For more.
    pub fn new(functionals: &[DVec4]) -> Self {
        let mut region = Self { count: functionals.len(), ..Self::ALL };
        region.functionals[..functionals.len()].copy_from_slice(functionals);
        region
    }
    /// The functionals of (p, 1).
    pub fn functionals(&self) -> &[DVec4] {
        &self.functionals[..self.count]
    }
    /// The same for points told relative to `origin`.
    pub fn relative_to(&self, origin: DVec3) -> Self {
        let moved = |f: DVec4| f.truncate().extend(f.dot(origin.extend(1.0)));
        Self { functionals: self.functionals.map(moved), ..*self }
    }
    /// Whether a point lies in it or, up to rounding, on its border.
    pub fn contains(&self, p: DVec3) -> bool {
        let p4 = p.extend(1.0);
        self.functionals().iter().all(|f| f.dot(p4) >= -Self::ROUNDING * f.abs().dot(p4.abs()))
    }
    /// Where both are; nothing where that takes more functionals than a region has.
    pub fn and(&self, other: &Self) -> Option<Self> {
        let all = [self.functionals(), other.functionals()].concat();
        (all.len() <= Self::MOST).then(|| Self::new(&all))
    }
}

impl PostWarp {
    /// NDC after this, of NDC and w before it (11.1).
    pub fn apply(&self, ndc: DVec3, w: f64) -> DVec3 {
        match *self {
            Self::None => ndc,
            Self::Log { scale, offset } => DVec3::new(ndc.x, scale * w.ln() + offset, ndc.z),
        }
    }
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

impl Parameterization {
    /// Somebody else's maps.
    pub fn of_partitions(partitions: Vec<Partition>, resolution: [u32; 2]) -> Self {
        Self {
            technique: "matrix".into(),
            settings: Vec::new(),
            partitions,
            selection: Selection::Depth,
            resolution,
            border_texels: 0,
            notes: Vec::new(),
        }
    }
    /// The map in which a receiver at a world point and camera depth is looked up; nothing where no map holds it.
    pub fn choose(&self, p_world: DVec3, eye_depth: f64) -> Option<usize> {
        let maps = self.first_map(eye_depth)..self.partitions.len();
        Held::first(maps, |k| self.partitions[k].holds(p_world))
    }
    /// The first map that may serve a camera depth: under [`Selection::Depth`] the first that does not end before it; those
    /// that end where the last does have no end.
    pub fn first_map(&self, eye_depth: f64) -> usize {
        let Some(last) = self.partitions.last() else { return 0 };
        let reaches = |p: &Partition| eye_depth <= p.eye_depth[1] || p.eye_depth[1] >= last.eye_depth[1];
        match self.selection {
            Selection::Containment => 0,
            Selection::Depth => self.partitions.iter().position(reaches).unwrap_or(self.partitions.len() - 1),
        }
    }
    /// The same maps for points told relative to `origin`: what it does there, [`Parameterization::choose`] included.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a matrix that is not finite.
    pub fn relative_to(&self, origin: DVec3) -> Result<Self> {
        let mut moved = self.clone();
        for partition in &mut moved.partitions {
            partition.shadow_clip_from_world *= DMat4::from_translation(origin);
            if let Some(factors) = &mut partition.factors {
                factors.lift *= DMat4::from_translation(origin);
            }
            partition.region = partition.region.relative_to(origin);
            if !partition.shadow_clip_from_world.is_finite() {
                let fix = "check where the matrix comes from";
                return Err(Error::argument(
                    "shadow_clip_from_world",
                    "16 finite numbers",
                    "a NaN or an infinity",
                    fix,
                ));
            }
        }
        Ok(moved)
    }
    /// A named intermediate number of the first map that has it.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.partitions.iter().find_map(|p| p.value(name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A map of the square of half side `half` around the origin, for depths 0 to 1.
    fn square(half: f64, ends: f64) -> Partition {
        let matrix = DMat4::from_scale(DVec3::new(1.0 / half, 1.0 / half, 1.0));
        Partition { eye_depth: [0.0, ends], ..Partition::of_matrix(matrix) }
    }

    #[test]
    fn a_receiver_finds_the_first_map_from_its_depth_that_holds_it() {
        let mut p =
            Parameterization::of_partitions(vec![square(1.0, 1.0), square(2.0, 2.0), square(4.0, 3.0)], [64; 2]);
        let at = |x: f64, z: f64| DVec3::new(x, 0.0, z);
        assert_eq!(p.choose(at(0.5, 0.5), 0.5), Some(0));
        assert_eq!(p.choose(at(0.5, 0.5), 1.0), Some(0), "the end is part of the range");
        assert_eq!(p.choose(at(0.5, 0.5), 1.5), Some(1));
        assert_eq!(p.choose(at(0.5, 0.5), 9.0), Some(2), "the last map has no end");
        assert_eq!(p.choose(at(0.5, 0.5), f64::NAN), Some(2));
        assert_eq!(p.choose(at(1.5, 0.5), 0.5), Some(1), "the first does not hold it");
        assert_eq!(p.choose(at(5.0, 0.5), 0.5), None);
        assert_eq!(p.choose(at(f64::NAN, 0.5), 0.5), None);
        assert_eq!(p.choose(at(0.5, -0.5), 0.5), Some(0), "before the near plane is no reason");
        // Beyond the far plane of the first, a later one may know more.
        p.partitions[1].shadow_clip_from_world *= DMat4::from_scale(DVec3::new(1.0, 1.0, 0.25));
        assert_eq!(p.choose(at(0.5, 2.0), 0.5), Some(1));
        assert_eq!(p.choose(at(0.5, 5.0), 0.5), Some(0), "beyond all of them");
        p.selection = Selection::Containment;
        assert_eq!(p.choose(at(0.5, 0.5), 9.0), Some(0));
        p.partitions[0].region = Region::new(&[DVec4::new(-1.0, 0.0, 0.0, 0.0)]);
        assert_eq!(p.choose(at(0.5, 0.5), 0.0), Some(1), "outside of its region");
        assert_eq!(p.choose(at(0.0, 0.5), 0.0), Some(0), "the border belongs to it");
        // The farthest maps of two faces: none of them is the end of the other.
        p.selection = Selection::Depth;
        p.partitions[1] = square(4.0, 3.0);
        p.partitions[2] = square(2.0, 3.0);
        assert_eq!(p.choose(at(3.5, 0.5), 3.1), Some(1));
        assert_eq!(Parameterization::of_partitions(vec![], [1; 2]).choose(DVec3::ZERO, 0.0), None);
    }

    #[test]
    fn points_behind_the_projection_centre_are_in_no_map() {
        let behind = DMat4::from_cols(DVec4::X, DVec4::Y, DVec4::Z, -DVec4::W);
        let p = Parameterization::of_partitions(vec![Partition::of_matrix(behind)], [64; 2]);
        assert_eq!(p.choose(DVec3::ZERO, 0.0), None);
        let mut log = Partition::of_matrix(behind);
        log.post_warp = PostWarp::Log { scale: 1.0, offset: 0.0 };
        assert_eq!(log.holds(DVec3::ZERO), Held::Outside);
    }
}
