//! Vertices on the screen: projection, outcodes, the fixed-point grid.
//!
//! Source: the rasterisation rules common to Vulkan, Direct3D 11 and OpenGL: viewport transform in f32, then coordinates
//! rounded to 8 sub-pixel bits.

use glam::{DMat4, Vec3};

use super::simd::{LANES, dispatch};

/// Sub-pixel bits of the fixed-point grid: what Direct3D 11 demands and graphics hardware has.
pub const SUBPIXEL_BITS: u32 = 8;
/// Grid steps in a pixel.
pub const SUBPIXEL: f32 = (1 << SUBPIXEL_BITS) as f32;
/// Largest distance from pixel 0 in pixels that the fixed-point edge functions are proven for (see `fill_large`).
const GUARD_PIXELS: f64 = 32768.0;

/// Beyond the left, right, bottom, top, near, far plane of the clip volume.
pub const OUTSIDE: u32 = 0b11_1111;
/// Not to be divided by w as it is: before the near plane, w too small, or beyond the guard band.
pub const CLIP: u32 = 1 << 6;

/// A projected vertex; x (right) and y (down) in grid steps, not rounded yet. Zero apart from `code` where that says
/// [`CLIP`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C, align(16))]
pub struct ScreenVertex {
    pub x: f32,
    pub y: f32,
    /// NDC depth.
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
}

impl Viewport {
    /// The viewport of an image of `size` pixels, drawn into memory of `drawn_size` pixels from the same corner.
    pub fn new(size: [u32; 2], drawn_size: [u32; 2]) -> Self {
        let half = size.map(|n| 0.5 * f64::from(n));
        Self {
            size: drawn_size,
            scale: [half[0] as f32 * SUBPIXEL, half[1] as f32 * -SUBPIXEL],
            offset: half.map(|h| h as f32 * SUBPIXEL),
            guard: half.map(|h| ((GUARD_PIXELS - h) / h) as f32),
        }
    }

    /// The grid position and depth of a clip-space point with w > 0.
    pub fn project(&self, [x, y, z, w]: [f32; 4]) -> [f32; 3] {
        let inverse_w = 1.0 / w;
        [x * inverse_w * self.scale[0] + self.offset[0], y * inverse_w * self.scale[1] + self.offset[1], z * inverse_w]
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

/// `clip_from_local` in f32, column-major, scaled by a power of two so that its largest element is in [1, 2).
///
/// A projective map keeps its meaning under any positive scale; a power of two costs no digit, and a matrix of any
/// magnitude then fits into f32, where clip coordinates of a mesh (local coordinates at most 1) stay below 8.
pub fn single_precision(clip_from_local: &DMat4) -> [[f32; 4]; 4] {
    let columns = clip_from_local.to_cols_array_2d();
    let largest = columns.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        // Nothing has w > 0 under it, so nothing is drawn.
        return [[0.0; 4]; 4];
    }
    let exponent = largest.log2().floor() as i32;
    // In two steps: one power of two alone may leave the range of f64.
    let (first, second) = (2f64.powi(-exponent / 2), 2f64.powi(-(exponent - exponent / 2)));
    columns.map(|c| c.map(|x| (x * first * second) as f32))
}

/// Clip coordinates of a vertex.
#[inline(always)]
pub fn clip_position(clip_from_local: &[[f32; 4]; 4], p: Vec3) -> [f32; 4] {
    let [c0, c1, c2, c3] = clip_from_local;
    std::array::from_fn(|i| p.x.mul_add(c0[i], p.y.mul_add(c1[i], p.z.mul_add(c2[i], c3[i]))))
}

dispatch! {
    /// Projects vertices, `out` as long as `positions`.
    pub fn project_all(m: &[[f32; 4]; 4], viewport: &Viewport, positions: &[Vec3], out: &mut [ScreenVertex]) = project_all_body
}

#[inline(always)]
fn project_all_body(m: &[[f32; 4]; 4], viewport: &Viewport, positions: &[Vec3], out: &mut [ScreenVertex]) {
    let (blocks, rest) = positions.as_chunks::<LANES>();
    let (out_blocks, out_rest) = out.as_chunks_mut::<LANES>();
    for (p, o) in blocks.iter().zip(out_blocks) {
        *o = project_block(m, viewport, p);
    }
    if !rest.is_empty() {
        let mut padded = [Vec3::ZERO; LANES];
        padded[..rest.len()].copy_from_slice(rest);
        out_rest.copy_from_slice(&project_block(m, viewport, &padded)[..rest.len()]);
    }
}

#[inline(always)]
fn project_block(m: &[[f32; 4]; 4], viewport: &Viewport, p: &[Vec3; LANES]) -> [ScreenVertex; LANES] {
    let mut clip = [[0f32; LANES]; 4];
    for l in 0..LANES {
        for (row, c) in clip.iter_mut().zip(clip_position(m, p[l])) {
            row[l] = c;
        }
    }
    let [x, y, z, w] = clip;
    let mut code = [0u32; LANES];
    let mut screen = [[0f32; LANES]; 3];
    for l in 0..LANES {
        let (x, y, z, w) = (x[l], y[l], z[l], w[l]);
        let bit = |condition: bool, bit: u32| u32::from(condition) << bit;
        let guarded = (x.abs() <= viewport.guard[0] * w)
            & (y.abs() <= viewport.guard[1] * w)
            & (z >= 0.0)
            // The smallest w whose inverse is finite.
            & (w >= f32::MIN_POSITIVE);
        code[l] = bit(x < -w, 0)
            | bit(x > w, 1)
            | bit(y < -w, 2)
            | bit(y > w, 3)
            | bit(z < 0.0, 4)
            | bit(z > w, 5)
            | bit(!guarded, 6);
        for (s, v) in screen.iter_mut().zip(viewport.project([x, y, z, w])) {
            s[l] = if guarded { v } else { 0.0 };
        }
    }
    std::array::from_fn(|l| ScreenVertex { x: screen[0][l], y: screen[1][l], z: screen[2][l], code: code[l] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_instruction_sets_project_the_same_bits() {
        let m = single_precision(&glam::dcamera::rh::proj::directx::perspective(1.0, 1.3, 0.1, 30.0));
        let viewport = Viewport::new([640, 480], [640, 480]);
        let positions: Vec<Vec3> = (0..1003)
            .map(|i| Vec3::new((i as f32 * 0.37).sin(), (i as f32 * 0.71).cos(), -1.0 + (i as f32 * 0.11).sin() * 1.1))
            .collect();
        let (mut best, mut plain) = (vec![ScreenVertex::default(); 1003], vec![ScreenVertex::default(); 1003]);
        project_all(&m, &viewport, &positions, &mut best);
        project_all_body(&m, &viewport, &positions, &mut plain);
        assert_eq!(best, plain);
        assert!(best.iter().any(|v| v.code & CLIP != 0) && best.iter().any(|v| v.code == 0));
    }

    #[test]
    fn matrices_of_any_magnitude_become_the_same() {
        let m = glam::dcamera::rh::proj::directx::perspective(1.0, 1.3, 0.1, 30.0);
        for exponent in [-1000, -30, 1, 900] {
            assert_eq!(single_precision(&(m * 2f64.powi(exponent))), single_precision(&m));
        }
        assert_eq!(single_precision(&DMat4::ZERO), [[0.0; 4]; 4]);
    }
}
