//! Triangle setup, [`LANES`] triangles at once: integer edge functions and the plane of depth.
//!
//! Source: J. Pineda, A parallel algorithm for polygon rasterization (1988). The edge functions are exact integers on the
//! grid of [`SUBPIXEL_BITS`], with the top-left rule folded in, and divided by the grid's steps per pixel (rounded down,
//! which keeps their sign).
//!
//! Depth is the plane through the vertices as projected, not as rounded to the grid: that is the plane of the surface,
//! which receiver-plane bias relies on. Where rounding to the grid has more than halved or doubled the triangle (one
//! thinner than the grid) the plane is taken through the rounded vertices, whose depths at covered centres lie between the
//! vertices' by construction.

use super::binning::{pixels_in_box, snapped};
use super::screen::{SUBPIXEL, SUBPIXEL_BITS, ScreenVertex};
use super::simd::LANES;

/// Largest side of a triangle's box, in grid steps, for which [`SmallSetup`] is exact in 32 bits: products of two
/// differences stay below 2^29, their sums below 2^31. 64 pixels.
const SMALL: i32 = 64 << SUBPIXEL_BITS;

/// Setups of [`LANES`] small triangles, one a lane.
#[derive(Debug, Clone, Copy)]
pub struct SmallSetup {
    /// What each edge function (divided by 256) gains per pixel to the right.
    pub step_x: [[i32; LANES]; 3],
    /// What it gains per row down.
    pub step_y: [[i32; LANES]; 3],
    /// Its value at the first pixel of the box.
    pub edge: [[i32; LANES]; 3],
    /// Depth at the first pixel of the box, and what it gains per pixel to the right and per row down.
    pub z: [[f32; LANES]; 3],
    /// Smallest and largest depth of the vertices.
    pub z_range: [[f32; LANES]; 2],
    /// First and last column and row of the box: x0, y0, x1, y1.
    pub pixels: [[i32; LANES]; 4],
    /// 0 for a triangle without area, 1 for one set up here, 2 for one too large.
    pub kind: [u32; LANES],
}

/// `x0` of the box is rounded down to a multiple of this many pixels.
const ALIGN: i32 = LANES as i32;

impl SmallSetup {
    /// The setups of some triangles: `v[k][l]` is vertex k of triangle l.
    #[inline(always)]
    pub fn new(v: &[[ScreenVertex; LANES]; 3], size: [u32; 2]) -> Self {
        let mut s = Self {
            step_x: [[0; LANES]; 3],
            step_y: [[0; LANES]; 3],
            edge: [[0; LANES]; 3],
            z: [[0.0; LANES]; 3],
            z_range: [[0.0; LANES]; 2],
            pixels: [[0; LANES]; 4],
            kind: [0; LANES],
        };
        // Transposed first, so that the loop below is free of shuffles.
        let mut xf = [[0f32; LANES]; 3];
        let mut yf = [[0f32; LANES]; 3];
        let mut zf = [[0f32; LANES]; 3];
        for k in 0..3 {
            for l in 0..LANES {
                xf[k][l] = v[k][l].x;
                yf[k][l] = v[k][l].y;
                zf[k][l] = v[k][l].z;
            }
        }
        for l in 0..LANES {
            let x = [snapped(xf[0][l]), snapped(xf[1][l]), snapped(xf[2][l])];
            let y = [snapped(yf[0][l]), snapped(yf[1][l]), snapped(yf[2][l])];
            let min = [x[0].min(x[1]).min(x[2]), y[0].min(y[1]).min(y[2])];
            let max = [x[0].max(x[1]).max(x[2]), y[0].max(y[1]).max(y[2])];
            let (first, last) = pixels_in_box(min, max, size);
            let first = [first[0] & -ALIGN, first[1]];
            let large = (max[0] - min[0] > SMALL) | (max[1] - min[1] > SMALL);
            // Wrapping: lanes with a large triangle compute nonsense that nobody reads.
            let (dx1, dy1) = (x[1].wrapping_sub(x[0]), y[1].wrapping_sub(y[0]));
            let (dx2, dy2) = (x[2].wrapping_sub(x[0]), y[2].wrapping_sub(y[0]));
            let area = dx1.wrapping_mul(dy2).wrapping_sub(dx2.wrapping_mul(dy1));
            s.kind[l] = if large { 2 } else { u32::from(area != 0) };
            let sign = if area < 0 { -1 } else { 1 };
            // The centre of the first pixel.
            let px = (first[0] << SUBPIXEL_BITS) + (1 << (SUBPIXEL_BITS - 1));
            let py = (first[1] << SUBPIXEL_BITS) + (1 << (SUBPIXEL_BITS - 1));
            for k in 0..3 {
                let n = if k == 2 { 0 } else { k + 1 };
                // Inside is where a (x - x_k) + b (y - y_k) > 0, with y down.
                let a = sign * (y[k].wrapping_sub(y[n]));
                let b = sign * (x[n].wrapping_sub(x[k]));
                // A left edge has the inside to its right; a top edge is level with the inside below.
                let top_left = (a > 0) | ((a == 0) & (b > 0));
                let e = a.wrapping_mul(px.wrapping_sub(x[k])).wrapping_add(b.wrapping_mul(py.wrapping_sub(y[k])));
                s.edge[k][l] = e.wrapping_sub(i32::from(!top_left)) >> SUBPIXEL_BITS;
                s.step_x[k][l] = a;
                s.step_y[k][l] = b;
            }
            let plane = depth_plane(
                [xf[0][l], xf[1][l], xf[2][l]],
                [yf[0][l], yf[1][l], yf[2][l]],
                [zf[0][l], zf[1][l], zf[2][l]],
                [x[0] as f32, x[1] as f32, x[2] as f32],
                [y[0] as f32, y[1] as f32, y[2] as f32],
                area as f32,
            );
            s.z[0][l] = plane.at(px as f32, py as f32);
            s.z[1][l] = plane.per_x * SUBPIXEL;
            s.z[2][l] = plane.per_y * SUBPIXEL;
            s.z_range[0][l] = zf[0][l].min(zf[1][l]).min(zf[2][l]);
            s.z_range[1][l] = zf[0][l].max(zf[1][l]).max(zf[2][l]);
            s.pixels[0][l] = first[0];
            s.pixels[1][l] = first[1];
            s.pixels[2][l] = last[0];
            s.pixels[3][l] = last[1];
        }
        s
    }
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
    #[inline(always)]
    fn at(&self, x: f32, y: f32) -> f32 {
        self.z + (self.per_x * (x - self.x) + self.per_y * (y - self.y))
    }
}

/// The plane of depth, through the exact vertices unless rounding to the grid has changed the area too much.
#[inline(always)]
fn depth_plane(xf: [f32; 3], yf: [f32; 3], z: [f32; 3], xi: [f32; 3], yi: [f32; 3], area_i: f32) -> DepthPlane {
    let exact = (xf[1] - xf[0]) * (yf[2] - yf[0]) - (xf[2] - xf[0]) * (yf[1] - yf[0]);
    // Between a half and the double, in the same sense.
    let thick = (exact * area_i >= 0.5 * area_i * area_i) & (exact * area_i <= 2.0 * area_i * area_i);
    let pick = |f: f32, i: f32| if thick { f } else { i };
    let (x0, y0) = (pick(xf[0], xi[0]), pick(yf[0], yi[0]));
    let (dx1, dy1) = (pick(xf[1], xi[1]) - x0, pick(yf[1], yi[1]) - y0);
    let (dx2, dy2) = (pick(xf[2], xi[2]) - x0, pick(yf[2], yi[2]) - y0);
    let inverse = 1.0 / pick(exact, area_i);
    let (dz1, dz2) = (z[1] - z[0], z[2] - z[0]);
    DepthPlane {
        x: x0,
        y: y0,
        z: z[0],
        per_x: (dz1 * dy2 - dz2 * dy1) * inverse,
        per_y: (dx1 * dz2 - dx2 * dz1) * inverse,
    }
}

/// The setup of one triangle of any size within the guard band, in 64 bits.
#[derive(Debug, Clone, Copy)]
pub struct LargeSetup {
    /// a, b and value of each edge function at the centre of pixel (0, 0), divided by 256.
    pub edges: [[i64; 3]; 3],
    /// Depth at the centre of pixel (0, 0), and what it gains per pixel to the right and per row down.
    pub z: [f64; 3],
    pub z_range: [f32; 2],
    /// x0, y0, x1, y1 of the box, both ends within.
    pub pixels: [i32; 4],
}

impl LargeSetup {
    /// The setup, or nothing for a triangle without area.
    pub fn new(v: [ScreenVertex; 3], size: [u32; 2]) -> Option<Self> {
        let (x, y) = (v.map(|v| snapped(v.x)), v.map(|v| snapped(v.y)));
        let (min, max) = ([x, y].map(|c| c.into_iter().min()), [x, y].map(|c| c.into_iter().max()));
        let (first, last) = pixels_in_box(min.map(Option::unwrap_or_default), max.map(Option::unwrap_or_default), size);
        let (xl, yl) = (x.map(i64::from), y.map(i64::from));
        let area = (xl[1] - xl[0]) * (yl[2] - yl[0]) - (xl[2] - xl[0]) * (yl[1] - yl[0]);
        if area == 0 {
            return None;
        }
        const CENTRE: i64 = 1 << (SUBPIXEL_BITS - 1);
        let edges = [0, 1, 2].map(|k| {
            let n = (k + 1) % 3;
            let (a, b) = (area.signum() * (yl[k] - yl[n]), area.signum() * (xl[n] - xl[k]));
            let top_left = a > 0 || (a == 0 && b > 0);
            let e = a * (CENTRE - xl[k]) + b * (CENTRE - yl[k]) - i64::from(!top_left);
            [a, b, e >> SUBPIXEL_BITS]
        });
        let exact = v.map(|v| [f64::from(v.x), f64::from(v.y)]);
        let cross =
            |p: [[f64; 2]; 3]| (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[2][0] - p[0][0]) * (p[1][1] - p[0][1]);
        let ratio = cross(exact) / area as f64;
        let rounded = [0, 1, 2].map(|k| [f64::from(x[k]), f64::from(y[k])]);
        let p = if (0.5..=2.0).contains(&ratio) { exact } else { rounded };
        let z = v.map(|v| f64::from(v.z));
        let per = |c: usize| {
            let d = |k: usize| p[k][1 - c] - p[0][1 - c];
            let sign = if c == 0 { 1.0 } else { -1.0 };
            sign * ((z[1] - z[0]) * d(2) - (z[2] - z[0]) * d(1)) / cross(p)
        };
        let (per_x, per_y) = (per(0), per(1));
        let at_first = z[0] + per_x * (CENTRE as f64 - p[0][0]) + per_y * (CENTRE as f64 - p[0][1]);
        let z_range = v.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |r, v| [r[0].min(v.z), r[1].max(v.z)]);
        let scale = f64::from(SUBPIXEL);
        Some(Self {
            edges,
            z: [at_first, per_x * scale, per_y * scale],
            z_range,
            pixels: [first[0], first[1], last[0], last[1]],
        })
    }
}
