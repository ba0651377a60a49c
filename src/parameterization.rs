//! The result of a technique: plain data that renderers, analysis and users see.

use glam::{DMat4, DVec3, DVec4};

/// The value of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A real number.
    Number(f64),
    /// A whole number.
    Integer(i64),
    /// On or off.
    Flag(bool),
    /// One of a few words.
    Choice(String),
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(x) => write!(f, "{x}"),
            Self::Integer(i) => write!(f, "{i}"),
            Self::Flag(b) => write!(f, "{b}"),
            Self::Choice(word) => write!(f, "{word:?}"),
        }
    }
}

/// What happens to map coordinates after the projective part.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum PostWarp {
    /// Nothing.
    #[default]
    None,
}

/// One map: where it projects to, and for which camera depths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Partition {
    /// `shadow_clip_from_world`: NDC x, y in [-1, 1] with y up, z in [0, 1] with 0 nearest the light.
    pub shadow_clip_from_world: DMat4,
    /// What follows the projective part.
    pub post_warp: PostWarp,
    /// Near and far camera depth this map serves.
    pub eye_depth: [f64; 2],
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
    /// Texels along each side the fit (border, snapping) was made for.
    pub resolution: u32,
    /// Texels at each side that no receiver maps to.
    pub border_texels: u32,
    /// Intermediate numbers by name (warp distance, lambda, sine of the light angle...), for tests and tables.
    pub values: Vec<(&'static str, f64)>,
    /// What the user should know: no warp because the light is parallel to the view, nothing in view, and so on.
    pub notes: Vec<String>,
}

impl Partition {
    /// NDC of a world point, and its clip w. Meaningful where w > 0.
    pub fn project(&self, p_world: DVec3) -> (DVec3, f64) {
        let clip: DVec4 = self.shadow_clip_from_world * p_world.extend(1.0);
        (clip.truncate() / clip.w, clip.w)
    }
}

impl Parameterization {
    /// A named intermediate number.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.values.iter().find(|(n, _)| *n == name).map(|v| v.1)
    }
}
