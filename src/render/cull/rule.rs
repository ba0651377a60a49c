//! The setting of what is drawn, and the reasons for which an instance is not.

use crate::names::name_of;
use crate::scene::Scene;

/// Which instances are drawn into a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Cull {
    /// All.
    None,
    /// Those that may lie in the map's volume. The map is that of [`Cull::None`], bit for bit.
    #[default]
    Volume,
    /// Of these, the ones that may shade a pixel of the picture. The mask is that of [`Cull::None`], bit for bit; the map may
    /// lack casters.
    Seen,
}

impl Cull {
    /// The names users write.
    pub const NAMES: [(&'static str, Self); 3] = [("none", Self::None), ("volume", Self::Volume), ("seen", Self::Seen)];
    /// The name users write.
    pub fn name(self) -> &'static str {
        name_of(&Self::NAMES, self)
    }
}

/// Triangles per pixel from which it pays to look for the casters that pixels see. Measured: a pixel that marks its texel takes as
/// long as eight triangles of a map, and the marks leave out half of the triangles or more.
const MANY_TRIANGLES: u64 = 20;

/// Whether maps of what a picture of `size` pixels sees are drawn sooner than whole ones.
pub fn looking_pays(scene: &Scene, size: [u32; 2]) -> bool {
    scene.triangle_count() >= MANY_TRIANGLES * u64::from(size[0]) * u64::from(size[1])
}

/// What becomes of an instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Rule {
    /// It is drawn.
    Drawn = 0,
    /// Its box lies outside of the map's volume.
    Outside = 1,
    /// Its box covers no texel that a pixel looks up.
    Unseen = 2,
    /// Its box lies behind all receivers that look up the texels it covers.
    Behind = 3,
}

impl Rule {
    /// The names users read, by code.
    pub const NAMES: [(&'static str, Self); 4] =
        [("drawn", Self::Drawn), ("outside", Self::Outside), ("unseen", Self::Unseen), ("behind", Self::Behind)];
}

/// What becomes of the instances of a scene in one map.
#[derive(Debug, Clone, PartialEq)]
pub struct Casters {
    /// One for each instance.
    pub rules: Vec<Rule>,
    /// Instances by the code of their rule.
    pub instances: [u64; Rule::NAMES.len()],
    /// Their triangles.
    pub triangles: [u64; Rule::NAMES.len()],
}

impl Casters {
    /// The counts of what becomes of each instance.
    pub fn new(scene: &Scene, rules: Vec<Rule>) -> Self {
        let (mut instances, mut triangles) = ([0; Rule::NAMES.len()], [0; Rule::NAMES.len()]);
        for (i, rule) in rules.iter().enumerate() {
            instances[*rule as usize] += 1;
            triangles[*rule as usize] += scene.mesh_of(i).triangles().len() as u64;
        }
        Self { rules, instances, triangles }
    }
}
