//! Triangle setup, [`LANES`] triangles at once: integer edge functions and the plane of depth.
//!
//! Source: Pineda 1988 `[pineda1988]`. The edge functions are exact integers on the
//! grid of [`SUBPIXEL_BITS`], with the top-left rule folded in, and divided by the grid's steps per pixel (rounded down,
//! which keeps their sign).
//!
//! Depth is the plane through the vertices as projected, not as rounded to the grid: that is the plane of the surface,
//! which receiver-plane bias relies on. Where rounding to the grid has more than halved or doubled the triangle (one
//! thinner than the grid) the plane is taken through the rounded vertices, whose depths at covered centres lie between the
//! vertices' by construction.

use super::simd::{LANES, transposed};
use super::vertices::{SUBPIXEL, SUBPIXEL_BITS, ScreenVertex, snapped};

/// Half a pixel in grid steps.
const HALF: i32 = 1 << (SUBPIXEL_BITS - 1);

/// Largest side of a triangle's box, in grid steps, for which [`SmallSetup`] is exact in 32 bits: products of two
/// differences stay below 2^29, their sums below 2^31. 64 pixels.
pub const SMALL: i32 = 64 << SUBPIXEL_BITS;

/// The corners of [`LANES`] triangles: `x[k][l]` belongs to vertex k of triangle l.
#[derive(Debug, Clone, Copy)]
pub struct Corners {
    pub x: [[f32; LANES]; 3],
    pub y: [[f32; LANES]; 3],
    pub z: [[f32; LANES]; 3],
    pub code: [[u32; LANES]; 3],
}

impl Corners {
    /// The corners that `vertex(l, k)` finds.
    #[inline(always)]
    pub fn gather<'a>(vertex: impl Fn(usize, usize) -> &'a ScreenVertex) -> Self {
        let zero = [[0f32; LANES]; 3];
        let mut c = Self { x: zero, y: zero, z: zero, code: [[0; LANES]; 3] };
        for k in 0..3 {
            for half in [0, 4] {
                let record = |l: usize| vertex(half + l, k).as_record();
                let [x, y, z, code] = transposed([record(0), record(1), record(2), record(3)]);
                c.x[k][half..half + 4].copy_from_slice(&x);
                c.y[k][half..half + 4].copy_from_slice(&y);
                c.z[k][half..half + 4].copy_from_slice(&z);
                c.code[k][half..half + 4].copy_from_slice(&code.map(f32::to_bits));
            }
        }
        c
    }

    /// The vertices of triangle l.
    pub fn triangle(&self, l: usize) -> [ScreenVertex; 3] {
        [0, 1, 2].map(|k| ScreenVertex { x: self.x[k][l], y: self.y[k][l], z: self.z[k][l], code: self.code[k][l] })
    }
}

/// The pixels whose centres lie in a box on the grid: first column and row, last column and row, within the image.
///
/// Centres on the left or top border count, those on the right or bottom border do not: the top-left rule gives none of
/// them to a triangle in the box.
#[inline(always)]
pub fn pixels_in_box(min: [i32; 2], max: [i32; 2], size: [u32; 2]) -> ([i32; 2], [i32; 2]) {
    let first = [0, 1].map(|k: usize| ((min[k] + HALF - 1) >> SUBPIXEL_BITS).max(0));
    let last = [0, 1].map(|k: usize| ((max[k] - HALF - 1) >> SUBPIXEL_BITS).min(size[k] as i32 - 1));
    (first, last)
}

/// The box of one triangle on the grid.
pub fn box_of(v: [ScreenVertex; 3]) -> ([i32; 2], [i32; 2]) {
    let grid = v.map(|v| [snapped(v.x), snapped(v.y)]);
    let bound = |pick: fn(i32, i32) -> i32| [0, 1].map(|c: usize| pick(pick(grid[0][c], grid[1][c]), grid[2][c]));
    (bound(i32::min), bound(i32::max))
}

/// Corners on the grid and the boxes around them.
#[derive(Debug, Clone, Copy)]
pub struct SnappedBox {
    x: [[i32; LANES]; 3],
    y: [[i32; LANES]; 3],
    /// Smallest x and y, largest x and y.
    bounds: [[i32; LANES]; 4],
}

/// Corners on the grid, and the pixels in their boxes.
#[derive(Debug, Clone, Copy)]
pub struct BoxPixels {
    x: [[i32; LANES]; 3],
    y: [[i32; LANES]; 3],
    /// First column and row, last column and row.
    pub at: [[i32; LANES]; 4],
    /// Whether [`SmallSetup`] can hold the triangle.
    pub small: [bool; LANES],
}

#[inline(always)]
pub fn snapped_box(c: &Corners) -> SnappedBox {
    let zero = [[0i32; LANES]; 3];
    let mut s = SnappedBox { x: zero, y: zero, bounds: [[0; LANES]; 4] };
    for l in 0..LANES {
        for k in 0..3 {
            s.x[k][l] = snapped(c.x[k][l]);
            s.y[k][l] = snapped(c.y[k][l]);
        }
        s.bounds[0][l] = s.x[0][l].min(s.x[1][l]).min(s.x[2][l]);
        s.bounds[1][l] = s.y[0][l].min(s.y[1][l]).min(s.y[2][l]);
        s.bounds[2][l] = s.x[0][l].max(s.x[1][l]).max(s.x[2][l]);
        s.bounds[3][l] = s.y[0][l].max(s.y[1][l]).max(s.y[2][l]);
    }
    s
}

impl SnappedBox {
    #[inline(always)]
    pub fn pixels(&self, size: [u32; 2]) -> BoxPixels {
        let mut p = BoxPixels { x: self.x, y: self.y, at: [[0; LANES]; 4], small: [false; LANES] };
        for l in 0..LANES {
            let [x0, y0, x1, y1] = [self.bounds[0][l], self.bounds[1][l], self.bounds[2][l], self.bounds[3][l]];
            let (first, last) = pixels_in_box([x0, y0], [x1, y1], size);
            p.at[0][l] = first[0];
            p.at[1][l] = first[1];
            p.at[2][l] = last[0];
            p.at[3][l] = last[1];
            p.small[l] = (x1 - x0 <= SMALL) & (y1 - y0 <= SMALL);
        }
        p
    }
}

/// Setups of [`LANES`] small triangles, one a lane. Lanes with a larger one hold nonsense.
#[derive(Debug, Clone, Copy)]
pub struct SmallSetup {
    /// What each edge function (divided by 256) gains per pixel to the right.
    pub step_x: [[i32; LANES]; 3],
    /// What it gains per row down.
    pub step_y: [[i32; LANES]; 3],
    /// Its value at the first pixel of the box: a pixel is covered where no edge function is negative. Without area there
    /// is no such pixel.
    pub edge: [[i32; LANES]; 3],
    /// Depth at the first pixel of the box, and what it gains per pixel to the right and per row down.
    pub z: [[f32; LANES]; 3],
    /// Smallest and largest depth of the vertices.
    pub z_range: [[f32; LANES]; 2],
}

impl SmallSetup {
    /// The setups, told relative to the first pixel of each box with its column rounded down to a multiple of `ALIGN`.
    #[inline(always)]
    pub fn new<const ALIGN: i32>(c: &Corners, pixels: &BoxPixels) -> Self {
        let mut s = Self {
            step_x: [[0; LANES]; 3],
            step_y: [[0; LANES]; 3],
            edge: [[0; LANES]; 3],
            z: [[0.0; LANES]; 3],
            z_range: [[0.0; LANES]; 2],
        };
        for l in 0..LANES {
            let (x, y) =
                ([pixels.x[0][l], pixels.x[1][l], pixels.x[2][l]], [pixels.y[0][l], pixels.y[1][l], pixels.y[2][l]]);
            // Wrapping: for lanes with a large triangle.
            let (dx1, dy1) = (x[1].wrapping_sub(x[0]), y[1].wrapping_sub(y[0]));
            let (dx2, dy2) = (x[2].wrapping_sub(x[0]), y[2].wrapping_sub(y[0]));
            let area = dx1.wrapping_mul(dy2).wrapping_sub(dx2.wrapping_mul(dy1));
            // All ones where the triangle turns the other way; (n ^ flip) - flip is then -n.
            let flip = area >> 31;
            // The centre of the first pixel.
            let px = ((pixels.at[0][l] & -ALIGN) << SUBPIXEL_BITS) + HALF;
            let py = (pixels.at[1][l] << SUBPIXEL_BITS) + HALF;
            for k in 0..3 {
                let n = if k == 2 { 0 } else { k + 1 };
                // Inside is where a (x - x_k) + b (y - y_k) > 0, with y down.
                let a = (y[k].wrapping_sub(y[n]) ^ flip).wrapping_sub(flip);
                let b = (x[n].wrapping_sub(x[k]) ^ flip).wrapping_sub(flip);
                // A left edge has the inside to its right; a top edge is level with the inside below.
                let top_left = (a > 0) | ((a == 0) & (b > 0));
                let e = a.wrapping_mul(px.wrapping_sub(x[k])).wrapping_add(b.wrapping_mul(py.wrapping_sub(y[k])));
                s.edge[k][l] = e.wrapping_sub(i32::from(!top_left)) >> SUBPIXEL_BITS;
                s.step_x[k][l] = a;
                s.step_y[k][l] = b;
            }
            let plane = DepthPlane::new(
                [c.x[0][l], c.x[1][l], c.x[2][l]],
                [c.y[0][l], c.y[1][l], c.y[2][l]],
                [c.z[0][l], c.z[1][l], c.z[2][l]],
                [x[0] as f32, x[1] as f32, x[2] as f32],
                [y[0] as f32, y[1] as f32, y[2] as f32],
                area as f32,
            );
            s.z[0][l] = plane.at(px as f32, py as f32);
            s.z[1][l] = plane.per_x * SUBPIXEL;
            s.z[2][l] = plane.per_y * SUBPIXEL;
            s.z_range[0][l] = smaller(smaller(c.z[0][l], c.z[1][l]), c.z[2][l]);
            s.z_range[1][l] = larger(larger(c.z[0][l], c.z[1][l]), c.z[2][l]);
        }
        s
    }
}

/// The smaller of two numbers that are no NaN, in one instruction.
#[inline(always)]
pub fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger of two numbers that are no NaN, in one instruction.
#[inline(always)]
pub fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Depth as an affine function on the grid.
struct DepthPlane {
    x: f32,
    y: f32,
    z: f32,
    per_x: f32,
    per_y: f32,
}

impl DepthPlane {
    /// The plane through the exact vertices, unless rounding to the grid has changed the area too much.
    #[inline(always)]
    fn new(xf: [f32; 3], yf: [f32; 3], z: [f32; 3], xi: [f32; 3], yi: [f32; 3], area_i: f32) -> Self {
        let exact = (xf[1] - xf[0]) * (yf[2] - yf[0]) - (xf[2] - xf[0]) * (yf[1] - yf[0]);
        // Between a half and the double, in the same sense.
        let (product, square) = (exact * area_i, area_i * area_i);
        let thick = (product >= 0.5 * square) & (product <= 2.0 * square);
        let pick = |f: f32, i: f32| if thick { f } else { i };
        let (x0, y0) = (pick(xf[0], xi[0]), pick(yf[0], yi[0]));
        let (dx1, dy1) = (pick(xf[1], xi[1]) - x0, pick(yf[1], yi[1]) - y0);
        let (dx2, dy2) = (pick(xf[2], xi[2]) - x0, pick(yf[2], yi[2]) - y0);
        let inverse = 1.0 / pick(exact, area_i);
        let (dz1, dz2) = (z[1] - z[0], z[2] - z[0]);
        Self {
            x: x0,
            y: y0,
            z: z[0],
            per_x: (dz1 * dy2 - dz2 * dy1) * inverse,
            per_y: (dx1 * dz2 - dx2 * dz1) * inverse,
        }
    }

    #[inline(always)]
    fn at(&self, x: f32, y: f32) -> f32 {
        self.z + (self.per_x * (x - self.x) + self.per_y * (y - self.y))
    }
}

/// An edge function on pixels: value at the centre of pixel (0, 0) and steps to the right and down, divided by 256.
#[derive(Debug, Clone, Copy, Default)]
pub struct Edge {
    pub step_x: i32,
    pub step_y: i32,
    pub value: i64,
}

/// The setup of one triangle of any size within the guard band, in 64 bits.
#[derive(Debug, Clone, Copy)]
pub struct LargeSetup {
    pub edges: [Edge; 3],
    /// Depth at the centre of pixel (0, 0), and what it gains per pixel to the right and per row down.
    pub z: [f64; 3],
    pub z_range: [f32; 2],
    /// First column and row, last column and row.
    pub pixels: [u16; 4],
    /// Scene-wide number of the triangle.
    pub id: u32,
}

impl LargeSetup {
    /// The setup, or nothing for a triangle without area or pixels. `exact` are grid positions and depths in f64.
    pub fn new(v: [ScreenVertex; 3], exact: [[f64; 3]; 3], size: [u32; 2], id: u32) -> Option<Self> {
        let (min, max) = box_of(v);
        let (first, last) = pixels_in_box(min, max, size);
        let (x, y) = (v.map(|v| i64::from(snapped(v.x))), v.map(|v| i64::from(snapped(v.y))));
        let area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
        if area == 0 || first[0] > last[0] || first[1] > last[1] {
            return None;
        }
        let centre = i64::from(HALF);
        let edges = [0, 1, 2].map(|k: usize| {
            let n = (k + 1) % 3;
            let (a, b) = (area.signum() * (y[k] - y[n]), area.signum() * (x[n] - x[k]));
            let top_left = a > 0 || (a == 0 && b > 0);
            let e = a * (centre - x[k]) + b * (centre - y[k]) - i64::from(!top_left);
            // Differences of coordinates below 2^24 fit.
            Edge { step_x: a as i32, step_y: b as i32, value: e >> SUBPIXEL_BITS }
        });
        let cross =
            |p: [[f64; 2]; 3]| (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[2][0] - p[0][0]) * (p[1][1] - p[0][1]);
        let unrounded = exact.map(|[x, y, _]| [x, y]);
        let rounded = [0, 1, 2].map(|k: usize| [x[k] as f64, y[k] as f64]);
        let p = if (0.5..=2.0).contains(&(cross(unrounded) / area as f64)) { unrounded } else { rounded };
        let z = exact.map(|[_, _, z]| z);
        let rise = |c: usize| (z[1] - z[0]) * (p[2][c] - p[0][c]) - (z[2] - z[0]) * (p[1][c] - p[0][c]);
        let (per_x, per_y) = (rise(1) / cross(p), -rise(0) / cross(p));
        let centre = f64::from(HALF);
        let scale = f64::from(SUBPIXEL);
        let z_range = [z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2])];
        Some(Self {
            edges,
            z: [z[0] + per_x * (centre - p[0][0]) + per_y * (centre - p[0][1]), per_x * scale, per_y * scale],
            z_range: z_range.map(|z| z as f32),
            // Within an image, whose sides are at most 16384.
            pixels: [first[0], first[1], last[0], last[1]].map(|n| n as u16),
            id,
        })
    }
}
