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

impl GBuffer {
    /// Of a pixel: depth, triangle, instance, position, normal.
    pub const BYTES: usize = 3 * 4 + 2 * size_of::<[f32; 3]>();
}

/// The part of a G-buffer that says where its surfaces are, borrowed.
#[derive(Debug, Clone, Copy)]
pub struct Surfaces<'a> {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The world point that positions are relative to.
    pub origin: DVec3,
    /// World position minus `origin`.
    pub position: &'a [[f32; 3]],
    /// Unit normals on the side of the eye.
    pub normal: &'a [[f32; 3]],
    /// -1 where nothing is.
    pub triangle: &'a [i32],
    /// -1 where nothing is.
    pub instance: &'a [i32],
}

impl GBuffer {
    /// Where its surfaces are.
    pub fn surfaces(&self) -> Surfaces<'_> {
        let Self { size, origin, position, normal, triangle, instance, .. } = self;
        Surfaces { size: *size, origin: *origin, position, normal, triangle, instance }
    }
}

impl Surfaces<'_> {
    /// Position relative to the origin and normal of a pixel, in f64; nothing where it shows nothing.
    pub fn receiver(&self, pixel: usize) -> Option<(DVec3, DVec3)> {
        let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        (self.triangle[pixel] >= 0).then(|| (vector(self.position[pixel]), vector(self.normal[pixel])))
    }
}

/// What a texel of the shadow map looks like in the image at each pixel; see `aliasing::texel`. NaN where `map` is negative.
#[derive(Debug, Clone, PartialEq)]
pub struct Footprint {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// [`Footprint::PLANES`] images one after the other, rows from the top: one block of memory, which is cheap to get.
    pub planes: Vec<f32>,
    /// Index of the map that serves the pixel, or one of [`Footprint::NO_MAP`], `AVERTED`, `NOTHING`.
    pub map: Vec<i16>,
}

impl Footprint {
    /// d(pixel x) / d(texel x), the first of four planes: d(pixel x, y) / d(texel x, y), rows first, both with y down.
    pub const JACOBIAN: usize = 0;
    /// Longest extent of a texel, pixels: the larger singular value of the Jacobian.
    pub const MAJOR: usize = 4;
    /// Area of a texel on the surface that halves the angle between eye and light, square pixels: error of perspective alone.
    /// Times the projection it is the area of a texel, and over the major extent that is the minor one.
    pub const PERSPECTIVE: usize = 5;
    /// Length, pixels, of one texel along the map's x, and in the next plane along its y, on that surface.
    pub const PERSPECTIVE_TS: usize = 6;
    /// cos of the angle between normal and eye over cos of that between normal and light: what the surface's slope adds.
    pub const PROJECTION: usize = 8;
    /// Camera depth, world units.
    pub const DEPTH: usize = 9;
    /// How many planes there are.
    pub const PLANES: usize = 10;
    /// Of a pixel.
    pub const BYTES: usize = Self::PLANES * size_of::<f32>() + size_of::<i16>();

    /// One of the planes.
    pub fn plane(&self, k: usize) -> &[f32] {
        let pixels = self.map.len();
        &self.planes[k * pixels..(k + 1) * pixels]
    }
    /// No map holds the point, or the map is singular there; it is lit without a look at any.
    pub const NO_MAP: i16 = -1;
    /// The surface faces away from the light, or is beyond its cone or range.
    pub const AVERTED: i16 = -2;
    /// The pixel shows nothing.
    pub const NOTHING: i16 = -3;
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
    /// The light counts as arriving from this share on.
    pub const LIT_FROM: f32 = 0.5;
}

/// At which pixels each of several lights arrives, a bit per light: bit `i % 32` of picture `i / 32` is 1 where light `i` does,
/// and 0 where it does not and where nothing is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ShadowStates {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Picture after picture, then rows from the top.
    pub data: Vec<u32>,
}

impl ShadowStates {
    /// How many lights a picture has room for.
    pub const PER_PICTURE: usize = u32::BITS as usize;

    /// How many pictures take so many lights.
    pub fn pictures(lights: usize) -> usize {
        lights.div_ceil(Self::PER_PICTURE)
    }
    /// The pixels of the picture that says of a light whether it arrives, and the bit that does.
    pub fn of_light(&mut self, light: usize) -> (&mut [u32], u32) {
        let pixels = self.size[0] as usize * self.size[1] as usize;
        let picture = light / Self::PER_PICTURE;
        (&mut self.data[picture * pixels..(picture + 1) * pixels], (light % Self::PER_PICTURE) as u32)
    }
    /// Sets the states of a light to those of its mask, in pictures where it arrives nowhere yet.
    pub fn set(&mut self, light: usize, mask: &ShadowMask) {
        let (states, bit) = self.of_light(light);
        for (states, light) in states.iter_mut().zip(&mask.data) {
            *states |= u32::from(*light >= ShadowMask::LIT_FROM) << bit;
        }
    }
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

    /// The state of a pixel at which so much of the light arrives; NaN where it shows nothing.
    pub fn of_light(share: f32) -> i8 {
        match share {
            x if x.is_nan() => Self::NOTHING,
            x if x >= ShadowMask::LIT_FROM => Self::LIT,
            _ => Self::SHADOW,
        }
    }
    /// Whether a state says that light arrives or does not.
    pub fn is_decided(state: i8) -> bool {
        state == Self::LIT || state == Self::SHADOW
    }
}
