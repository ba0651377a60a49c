//! Vertices on the screen: the viewport, outcodes, the fixed-point grid.
//!
//! Source: the rasterisation rules common to Vulkan, Direct3D 11 and OpenGL: viewport transform in f32, then coordinates
//! rounded to 8 sub-pixel bits.

/// Sub-pixel bits of the fixed-point grid: what Direct3D 11 demands and graphics hardware has.
pub const SUBPIXEL_BITS: u32 = 8;
/// Grid steps in a pixel.
pub const SUBPIXEL: f32 = (1 << SUBPIXEL_BITS) as f32;
/// Largest distance from pixel 0 in pixels that the fixed-point edge functions are proven for (see `fill_large`).
const GUARD_PIXELS: f64 = 32768.0;
/// From the near plane to the largest z / w that needs no clipping: depth beyond the far plane (1) is told to 2^-24 at least,
/// and pixels of it are dropped one by one.
pub const FAR_GUARD: f32 = 2.0;
/// Beyond the left, right, bottom, top, near, far plane of the clip volume.
pub const OUTSIDE: u32 = 0b11_1111;
/// Not to be divided by w as it is: before the near plane, far beyond the far plane, w too small, or beyond the guard band.
pub const CLIP: u32 = 1 << 6;

/// A projected vertex; x (right) and y (down) in grid steps, not rounded yet. Zero apart from `code` where that says
/// [`CLIP`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C, align(16))]
pub struct ScreenVertex {
    pub x: f32,
    pub y: f32,
    /// Depth, z / w.
    pub z: f32,
    /// Bits of [`OUTSIDE`] and [`CLIP`].
    pub code: u32,
}

impl ScreenVertex {
    /// Its four words, the last one the bits of `code`.
    #[inline(always)]
    pub fn as_record(&self) -> &[f32; 4] {
        // SAFETY: four words in this order (`repr(C)`), and every pattern of bits is a float.
        unsafe { &*std::ptr::from_ref(self).cast() }
    }
}

/// From clip space to the fixed-point grid.
#[derive(Debug, Clone, Copy)]
pub struct Viewport {
    /// Pixels that may be drawn.
    pub size: [u32; 2],
    scale: [f32; 2],
    offset: [f32; 2],
    /// Largest |x| / w and |y| / w that need no clipping.
    pub guard: [f32; 2],
    /// z / w of the near plane; that of the far plane is 1 more.
    pub near: f32,
}

impl Viewport {
    /// The viewport of an image of `size` pixels, drawn into memory of `drawn_size` pixels from the same corner, with z / w of
    /// 1 below `far` to `far`.
    pub fn new(size: [u32; 2], drawn_size: [u32; 2], far: f32) -> Self {
        let half = size.map(|n| 0.5 * f64::from(n));
        Self {
            size: drawn_size,
            scale: [half[0] as f32 * SUBPIXEL, half[1] as f32 * -SUBPIXEL],
            offset: half.map(|h| h as f32 * SUBPIXEL),
            guard: half.map(|h| ((GUARD_PIXELS - h) / h) as f32),
            near: far - 1.0,
        }
    }

    /// Columns and rows of the image, which may be narrower than what is drawn.
    pub fn image_size(&self) -> [f64; 2] {
        self.offset.map(|half| 2.0 * f64::from(half / SUBPIXEL))
    }

    /// The planes of the clip volume a point is beyond.
    #[inline(always)]
    pub fn outcode(&self, [x, y, z, w]: [f64; 4]) -> u32 {
        let bit = |condition: bool, bit: u32| u32::from(condition) << bit;
        let near = f64::from(self.near);
        bit(x < -w, 0)
            | bit(x > w, 1)
            | bit(y < -w, 2)
            | bit(y > w, 3)
            | bit(z < near * w, 4)
            | bit(z > (near + 1.0) * w, 5)
    }

    /// The grid position and depth of a clip-space point with w > 0.
    pub fn project(&self, [x, y, z, w]: [f32; 4]) -> [f32; 3] {
        let inverse_w = 1.0 / w;
        [x * inverse_w * self.scale[0] + self.offset[0], y * inverse_w * self.scale[1] + self.offset[1], z * inverse_w]
    }

    /// The same in f64.
    pub fn project_exactly(&self, [x, y, z, w]: [f64; 4]) -> [f64; 3] {
        let [sx, sy, ox, oy] = [self.scale[0], self.scale[1], self.offset[0], self.offset[1]].map(f64::from);
        [x / w * sx + ox, y / w * sy + oy, z / w]
    }
}

/// A coordinate of a vertex without [`CLIP`] rounded to the grid, halves to even.
#[inline(always)]
pub fn snapped(x: f32) -> i32 {
    debug_assert!(x.abs() <= 2.0 * GUARD_PIXELS as f32 * SUBPIXEL, "{x} is beyond the guard band");
    // SAFETY: such vertices lie within the guard band, whose grid coordinates are below 2^24, and are no NaN: both
    // `project_block` and `clip::projected` see to it. The checked cast costs eight instructions a lane.
    unsafe { x.round_ties_even().to_int_unchecked() }
}
