//! Triangles between uneven rows and columns: their spans, row by row, in f64.
//!
//! A centre belongs to the triangle between whose two edges it lies, the left one included; a row at the very height of a
//! corner belongs to what is below it. An edge is evaluated from its upper end, whichever triangle asks, so of two triangles
//! that share it exactly one has the centre: there is no hole, however rows are spaced.

use std::ops::Range;

use super::lattice::Places;
use super::texels::Texels;
use crate::simd::dispatch;

/// Marks indices of vertices made by clipping.
pub const EXTRA: u32 = 1 << 31;

/// A projected vertex.
#[derive(Debug, Clone, Copy, Default)]
pub struct EvenVertex {
    /// Texels from the left.
    pub column: f64,
    /// Grows downwards.
    pub down: f64,
    /// NDC depth.
    pub z: f64,
    /// The first column whose centre is not left of it.
    pub first_column: u32,
    /// The first row whose centre is not above it.
    pub first_row: u32,
}

impl EvenVertex {
    /// Not to be projected as it is.
    pub const CUT: Self = Self { column: 0.0, down: 0.0, z: 0.0, first_column: 0, first_row: u32::MAX };

    /// Whether it is [`EvenVertex::CUT`].
    #[inline(always)]
    pub fn is_cut(&self) -> bool {
        self.first_row == u32::MAX
    }
}

/// The polygon that is left of a triangle while it is cut, in clip space.
#[derive(Debug, Default)]
pub struct Polygon {
    corners: Vec<[f64; 4]>,
    kept: Vec<[f64; 4]>,
}

impl Polygon {
    /// Begins with a triangle.
    pub fn start(&mut self, corners: [[f64; 4]; 3]) {
        self.corners.clear();
        self.corners.extend(corners);
    }
    /// What is left, in order; fewer than three: nothing.
    pub fn corners(&self) -> &[[f64; 4]] {
        &self.corners
    }
    /// Cuts off where a distance, linear in clip coordinates, is negative (`[sutherland1974]`). An edge is cut from
    /// its inner to its outer end, so that neighbours cut it at the same point.
    pub fn cut(&mut self, distance: impl Fn([f64; 4]) -> f64) {
        self.kept.clear();
        for (i, &current) in self.corners.iter().enumerate() {
            let next = self.corners[(i + 1) % self.corners.len()];
            let (d0, d1) = (distance(current), distance(next));
            let between = |inside: [f64; 4], outside: [f64; 4], d_in: f64, d_out: f64| {
                let t = d_in / (d_in - d_out);
                std::array::from_fn(|i| inside[i] + t * (outside[i] - inside[i]))
            };
            if d0 >= 0.0 {
                self.kept.push(current);
            }
            if d0 >= 0.0 && d1 < 0.0 {
                self.kept.push(between(current, next, d0, d1));
            } else if d0 < 0.0 && d1 >= 0.0 {
                self.kept.push(between(next, current, d1, d0));
            }
        }
        std::mem::swap(&mut self.corners, &mut self.kept);
    }
}

/// A side of a triangle, from its upper end.
#[derive(Clone, Copy)]
struct Edge {
    column: f64,
    down: f64,
    /// Columns for each unit down. Meaningless for an edge without a row.
    slope: f64,
}

impl Edge {
    #[inline(always)]
    fn new(upper: &EvenVertex, lower: &EvenVertex) -> Self {
        let slope = (lower.column - upper.column) / (lower.down - upper.down);
        Self { column: upper.column, down: upper.down, slope }
    }
    #[inline(always)]
    fn column_at(&self, down: f64) -> f64 {
        self.column + (down - self.down) * self.slope
    }
}

dispatch! {
    /// Draws triangles into the rows `band` of a map, whose texels are `texels`; `rows` are all rows' places.
    pub fn fill_band<C: Places, T: Texels>(triangles: &[[u32; 3]], vertices: &[EvenVertex], extra: &[EvenVertex], rows: &[f64], columns: &C, band: Range<usize>, texels: &mut T) = fill_all
}

#[inline(always)]
fn fill_all<C: Places, T: Texels>(
    triangles: &[[u32; 3]],
    vertices: &[EvenVertex],
    extra: &[EvenVertex],
    rows: &[f64],
    columns: &C,
    band: Range<usize>,
    texels: &mut T,
) {
    let width = columns.count();
    for indices in triangles {
        spans(corners_of(*indices, vertices, extra), rows, columns, &band, |plane, row, span| {
            let (start, from) = ((row - band.start) * width, span.start);
            texels.draw(start + from..start + span.end, plane.along(columns, from, rows[row]));
        });
    }
}

/// The corners of a listed triangle.
#[inline(always)]
pub fn corners_of<'a>(indices: [u32; 3], vertices: &'a [EvenVertex], extra: &'a [EvenVertex]) -> [&'a EvenVertex; 3] {
    indices.map(|i| if i & EXTRA == 0 { &vertices[i as usize] } else { &extra[(i & !EXTRA) as usize] })
}

/// Calls `each` with the depth of a triangle, and each row of a band in which it has columns, with these.
#[inline(always)]
pub fn spans<C: Places>(
    corners: [&EvenVertex; 3],
    rows: &[f64],
    columns: &C,
    band: &Range<usize>,
    mut each: impl FnMut(&DepthPlane, usize, Range<usize>),
) {
    let [mut a, mut b, mut c] = corners;
    // From top to bottom. Corners at one height may come in any order: no row is between them.
    if b.down < a.down {
        (a, b) = (b, a);
    }
    if c.down < b.down {
        (b, c) = (c, b);
    }
    if b.down < a.down {
        (a, b) = (b, a);
    }
    let (first, last) = (band.start.max(a.first_row as usize), band.end.min(c.first_row as usize));
    if first >= last {
        return;
    }
    let (long, upper, lower) = (Edge::new(a, c), Edge::new(a, b), Edge::new(b, c));
    let plane = DepthPlane::new(a, b, c);
    for row in first..last {
        let down = rows[row];
        let short = if row < b.first_row as usize { &upper } else { &lower };
        let (p, q) = (long.column_at(down), short.column_at(down));
        let (from, to) = (columns.first(p.min(q)), columns.first(p.max(q)));
        if from < to {
            each(&plane, row, from..to);
        }
    }
}

/// Depth as an affine function of the place, held between the corners' depths: of a triangle much thinner than its rounding no
/// plane is known.
pub struct DepthPlane {
    column: f64,
    down: f64,
    z: f64,
    per_column: f64,
    per_down: f64,
    range: [f64; 2],
}

impl DepthPlane {
    #[inline(always)]
    fn new(a: &EvenVertex, b: &EvenVertex, c: &EvenVertex) -> Self {
        let (bx, by, bz) = (b.column - a.column, b.down - a.down, b.z - a.z);
        let (cx, cy, cz) = (c.column - a.column, c.down - a.down, c.z - a.z);
        let inverse = (bx * cy - cx * by).recip();
        Self {
            column: a.column,
            down: a.down,
            z: a.z,
            per_column: (bz * cy - cz * by) * inverse,
            per_down: (bx * cz - cx * bz) * inverse,
            range: [a.z.min(b.z).min(c.z), a.z.max(b.z).max(c.z)],
        }
    }
    /// The depths of a row's texels from column `from` on.
    #[inline(always)]
    pub fn along<C: Places>(&self, columns: &C, from: usize, down: f64) -> impl Fn(usize) -> f64 {
        let per_down = (down - self.down) * self.per_down;
        let first = self.z + (columns.place(from) - self.column) * self.per_column + per_down;
        let (step, per_column, [least, most]) = (columns.steps(from), self.per_column, self.range);
        // max and min make a NaN (a triangle without area, which has a centre only by rounding) the nearest corner's depth.
        move |i| (first + step(i) * per_column).max(least).min(most)
    }
}
