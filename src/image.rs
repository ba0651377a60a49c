//! Images as plain arrays with sizes: row 0 at the top, layer after layer.

use glam::DVec3;

/// Shadow maps: depth in [0, 1], 1 where no caster is; `layers * height * width` values.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthMaps {
    /// One layer a partition.
    pub layers: u32,
    /// Width and height in texels.
    pub size: [u32; 2],
    /// Layer-major, then rows from the top.
    pub data: Vec<f32>,
}

/// What a camera sees: one record a pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct GBuffer {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The world point that positions are relative to.
    pub origin: DVec3,
    /// NDC depth in [0, 1]; 1 where nothing is.
    pub depth: Vec<f32>,
    /// World position minus `origin`; zero where nothing is.
    pub position: Vec<[f32; 3]>,
    /// Unit geometric normal of the triangle, world space, on the side that faces the eye; zero where nothing is.
    pub normal: Vec<[f32; 3]>,
    /// Index of the triangle in the mesh of its instance; -1 where nothing is.
    pub triangle: Vec<i32>,
    /// Index of the instance; -1 where nothing is.
    pub instance: Vec<i32>,
}

/// The light that arrives at each pixel: 1 lit, 0 in shadow, between under a filter; NaN where nothing is.
#[derive(Debug, Clone, PartialEq)]
pub struct ShadowMask {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Rows from the top.
    pub data: Vec<f32>,
    /// Index of the map that was consulted; [`ShadowMask::NO_MAP`] where none was: where nothing is, where the surface
    /// faces away from the light or is beyond its cone or range, and where no map holds the point, which is lit then.
    pub partition: Vec<i16>,
}

impl ShadowMask {
    /// No map was consulted.
    pub const NO_MAP: i16 = -1;
}

/// What rays say of each pixel: [`TruthMask::LIT`] and so on.
#[derive(Debug, Clone, PartialEq)]
pub struct TruthMask {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Rows from the top.
    pub data: Vec<i8>,
}

impl TruthMask {
    /// Light arrives.
    pub const LIT: i8 = 1;
    /// Something is in the way, or the surface faces away from the light.
    pub const SHADOW: i8 = 0;
    /// The answer changes with the numerical offset of the ray.
    pub const UNDECIDED: i8 = -1;
    /// The pixel shows nothing.
    pub const NOTHING: i8 = -2;
}
