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

use super::lanes::Lanes;
use super::simd::LANES;
use super::vertices::{SUBPIXEL, SUBPIXEL_BITS, ScreenVertex, snapped};

/// Half a pixel in grid steps.
const HALF: i32 = 1 << (SUBPIXEL_BITS - 1);

/// Largest side of a triangle's box, in grid steps, for which [`SmallSetup`] is exact in 32 bits: products of two
/// differences stay below 2^29, their sums below 2^31. 64 pixels.
pub const SMALL: i32 = 64 << SUBPIXEL_BITS;

/// The corners of [`LANES`] triangles, one a lane.
#[derive(Clone, Copy)]
pub struct Corners<L: Lanes> {
    pub x: [L::Float; 3],
    pub y: [L::Float; 3],
    pub z: [L::Float; 3],
    pub code: [L::Int; 3],
}

impl<L: Lanes> Corners<L> {
    /// The corners of a source.
    #[inline(always)]
    pub fn gather(lanes: L, source: impl CornerSource) -> Self {
        let [x0, y0, z0, c0] = lanes.turned(records(&source, 0));
        let [x1, y1, z1, c1] = lanes.turned(records(&source, 1));
        let [x2, y2, z2, c2] = lanes.turned(records(&source, 2));
        let code = [lanes.bits_of(c0), lanes.bits_of(c1), lanes.bits_of(c2)];
        Self { x: [x0, x1, x2], y: [y0, y1, y2], z: [z0, z1, z2], code }
    }
}

/// Where corners of [`LANES`] triangles come from. No closure: those are compiled for the lowest instruction set, and so large that
/// they are called.
pub trait CornerSource {
    /// Corner `k` of triangle `l`.
    fn corner(&self, l: usize, k: usize) -> &ScreenVertex;
}

#[inline(always)]
fn records<S: CornerSource>(source: &S, k: usize) -> [&[f32; 4]; LANES] {
    [
        source.corner(0, k).as_record(),
        source.corner(1, k).as_record(),
        source.corner(2, k).as_record(),
        source.corner(3, k).as_record(),
        source.corner(4, k).as_record(),
        source.corner(5, k).as_record(),
        source.corner(6, k).as_record(),
        source.corner(7, k).as_record(),
    ]
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

/// Corners on the grid, and the pixels in their boxes.
#[derive(Clone, Copy)]
pub struct Boxes<L: Lanes> {
    x: [L::Int; 3],
    y: [L::Int; 3],
    /// First column and row, last column and row: [`pixels_in_box`].
    pub at: [L::Int; 4],
    /// Negative where the triangle is too large for [`SmallSetup`].
    pub large: L::Int,
}

impl<L: Lanes> Boxes<L> {
    #[inline(always)]
    pub fn new(lanes: L, c: &Corners<L>, size: [u32; 2]) -> Self {
        let x = [lanes.snapped(c.x[0]), lanes.snapped(c.x[1]), lanes.snapped(c.x[2])];
        let y = [lanes.snapped(c.y[0]), lanes.snapped(c.y[1]), lanes.snapped(c.y[2])];
        let (left, right) = (lanes.least(lanes.least(x[0], x[1]), x[2]), lanes.most(lanes.most(x[0], x[1]), x[2]));
        let (top, bottom) = (lanes.least(lanes.least(y[0], y[1]), y[2]), lanes.most(lanes.most(y[0], y[1]), y[2]));
        let wide = lanes.less(lanes.int(SMALL), lanes.sub(right, left));
        let high = lanes.less(lanes.int(SMALL), lanes.sub(bottom, top));
        let at = [
            Self::first(lanes, left),
            Self::first(lanes, top),
            Self::last(lanes, right, size[0]),
            Self::last(lanes, bottom, size[1]),
        ];
        Self { x, y, at, large: lanes.or(wide, high) }
    }
    #[inline(always)]
    fn first(lanes: L, least: L::Int) -> L::Int {
        lanes.most(lanes.shifted(lanes.add(least, lanes.int(HALF - 1)), SUBPIXEL_BITS), lanes.int(0))
    }
    #[inline(always)]
    fn last(lanes: L, most: L::Int, size: u32) -> L::Int {
        let pixel = lanes.shifted(lanes.add(most, lanes.int(-HALF - 1)), SUBPIXEL_BITS);
        lanes.least(pixel, lanes.int(size as i32 - 1))
    }
}

/// Setups of [`LANES`] small triangles, one a lane. Lanes with a larger one hold nonsense.
#[derive(Clone, Copy)]
pub struct SmallSetup<L: Lanes> {
    /// What each edge function (divided by 256) gains per pixel to the right.
    pub step_x: [L::Int; 3],
    /// What it gains per row down.
    pub step_y: [L::Int; 3],
    /// Its value at the first pixel of the box: a pixel is covered where no edge function is negative. Without area there
    /// is no such pixel.
    pub edge: [L::Int; 3],
    /// Depth at the first pixel of the box, and what it gains per pixel to the right and per row down.
    pub z: [L::Float; 3],
    /// Smallest and largest depth of the vertices.
    pub z_range: [L::Float; 2],
}

impl<L: Lanes> SmallSetup<L> {
    /// The setups, told relative to the first pixel of each box with its column rounded down to a multiple of `ALIGN`.
    #[inline(always)]
    pub fn new<const ALIGN: i32>(lanes: L, c: &Corners<L>, boxes: &Boxes<L>) -> Self {
        let ([x0, x1, x2], [y0, y1, y2]) = (boxes.x, boxes.y);
        // Wrapping: for lanes with a large triangle.
        let (dx1, dy1, dx2, dy2) = (lanes.sub(x1, x0), lanes.sub(y1, y0), lanes.sub(x2, x0), lanes.sub(y2, y0));
        let area = lanes.sub(lanes.mul(dx1, dy2), lanes.mul(dx2, dy1));
        // All ones where the triangle turns the other way; (n ^ flip) - flip is then -n.
        let flip = lanes.shifted(area, 31);
        // The centre of the first pixel.
        let (half, pixel) = (lanes.int(HALF), lanes.int(1 << SUBPIXEL_BITS));
        let px = lanes.add(lanes.mul(lanes.and(boxes.at[0], lanes.int(-ALIGN)), pixel), half);
        let py = lanes.add(lanes.mul(boxes.at[1], pixel), half);
        let centre = [px, py];
        let (a0, b0, e0) = edge(lanes, [x0, y0], [x1, y1], flip, centre);
        let (a1, b1, e1) = edge(lanes, [x1, y1], [x2, y2], flip, centre);
        let (a2, b2, e2) = edge(lanes, [x2, y2], [x0, y0], flip, centre);
        let plane = DepthPlane::new(lanes, c, boxes, lanes.rounded(area));
        let subpixel = lanes.float(SUBPIXEL);
        Self {
            step_x: [a0, a1, a2],
            step_y: [b0, b1, b2],
            edge: [e0, e1, e2],
            z: [
                plane.at(lanes, lanes.rounded(px), lanes.rounded(py)),
                lanes.mul_floats(plane.per_x, subpixel),
                lanes.mul_floats(plane.per_y, subpixel),
            ],
            z_range: [
                lanes.smaller(lanes.smaller(c.z[0], c.z[1]), c.z[2]),
                lanes.larger(lanes.larger(c.z[0], c.z[1]), c.z[2]),
            ],
        }
    }

    /// The same lane by lane.
    #[inline(always)]
    pub fn rows(&self, lanes: L) -> SetupRows {
        SetupRows {
            step_x: lanes.three_rows(self.step_x),
            step_y: lanes.three_rows(self.step_y),
            edge: lanes.three_rows(self.edge),
            z: [lanes.to_floats(self.z[0]), lanes.to_floats(self.z[1]), lanes.to_floats(self.z[2])],
            z_range: [lanes.to_floats(self.z_range[0]), lanes.to_floats(self.z_range[1])],
        }
    }
}

/// The steps of an edge function from one corner to the next, and its value at a pixel's centre; `flip` says which way a triangle
/// turns.
#[inline(always)]
fn edge<L: Lanes>(
    lanes: L,
    [x, y]: [L::Int; 2],
    [next_x, next_y]: [L::Int; 2],
    flip: L::Int,
    [px, py]: [L::Int; 2],
) -> (L::Int, L::Int, L::Int) {
    // Inside is where a (p_x - x) + b (p_y - y) > 0, with y down.
    let a = lanes.sub(lanes.xor(lanes.sub(y, next_y), flip), flip);
    let b = lanes.sub(lanes.xor(lanes.sub(next_x, x), flip), flip);
    // A left edge has the inside to its right; a top edge is level with the inside below.
    let zero = lanes.int(0);
    let top = lanes.and(lanes.equal(a, zero), lanes.less(zero, b));
    let top_left = lanes.or(lanes.less(zero, a), top);
    let e = lanes.add(lanes.mul(a, lanes.sub(px, x)), lanes.mul(b, lanes.sub(py, y)));
    // Less 1 where it is neither; all ones are -1.
    let e = lanes.sub(lanes.add(e, lanes.int(-1)), top_left);
    (a, b, lanes.shifted(e, SUBPIXEL_BITS))
}

/// [`SmallSetup`] in memory: `step_x[k][l]` is that of edge k of triangle l.
#[derive(Debug, Clone, Copy)]
pub struct SetupRows {
    pub step_x: [[i32; LANES]; 3],
    pub step_y: [[i32; LANES]; 3],
    pub edge: [[i32; LANES]; 3],
    pub z: [[f32; LANES]; 3],
    pub z_range: [[f32; LANES]; 2],
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

/// Depths as affine functions on the grid.
struct DepthPlane<L: Lanes> {
    x: L::Float,
    y: L::Float,
    z: L::Float,
    per_x: L::Float,
    per_y: L::Float,
}

impl<L: Lanes> DepthPlane<L> {
    /// The planes through the exact vertices, unless rounding to the grid has changed the area too much.
    #[inline(always)]
    fn new(lanes: L, c: &Corners<L>, boxes: &Boxes<L>, area: L::Float) -> Self {
        let ([x0, x1, x2], [y0, y1, y2], [z0, z1, z2]) = (c.x, c.y, c.z);
        let (dx1, dy1) = (lanes.sub_floats(x1, x0), lanes.sub_floats(y1, y0));
        let (dx2, dy2) = (lanes.sub_floats(x2, x0), lanes.sub_floats(y2, y0));
        let exact = lanes.cross([dx1, dy1], [dx2, dy2]);
        // Between a half and the double, in the same sense.
        let (product, square) = (lanes.mul_floats(exact, area), lanes.mul_floats(area, area));
        let half_at_least = lanes.at_most(lanes.mul_floats(lanes.float(0.5), square), product);
        let double_at_most = lanes.at_most(product, lanes.mul_floats(lanes.float(2.0), square));
        let thick = lanes.and(half_at_least, double_at_most);
        let [x0, x1, x2] = lanes.pick_three(thick, c.x, boxes.x);
        let [y0, y1, y2] = lanes.pick_three(thick, c.y, boxes.y);
        let (dx1, dy1) = (lanes.sub_floats(x1, x0), lanes.sub_floats(y1, y0));
        let (dx2, dy2) = (lanes.sub_floats(x2, x0), lanes.sub_floats(y2, y0));
        let inverse = lanes.div_floats(lanes.float(1.0), lanes.pick(thick, exact, area));
        let (dz1, dz2) = (lanes.sub_floats(z1, z0), lanes.sub_floats(z2, z0));
        Self {
            x: x0,
            y: y0,
            z: z0,
            per_x: lanes.mul_floats(lanes.cross([dz1, dy1], [dz2, dy2]), inverse),
            per_y: lanes.mul_floats(lanes.cross([dx1, dz1], [dx2, dz2]), inverse),
        }
    }

    #[inline(always)]
    fn at(&self, lanes: L, x: L::Float, y: L::Float) -> L::Float {
        let across = lanes.mul_floats(self.per_x, lanes.sub_floats(x, self.x));
        let down = lanes.mul_floats(self.per_y, lanes.sub_floats(y, self.y));
        lanes.add_floats(self.z, lanes.add_floats(across, down))
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
