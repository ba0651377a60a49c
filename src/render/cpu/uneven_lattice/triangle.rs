//! Triangles between uneven rows and columns: what a row has of them, in f64.
//!
//! A centre belongs to the triangle between whose two edges it lies, the left one included; a row at the very height of a
//! corner belongs to what is below it. An edge is evaluated from its upper end, whichever triangle asks, so of two triangles
//! that share it exactly one has the centre: there is no hole, however rows are spaced.
//!
//! All is written for one triangle and one row. Kernels have it in loops over triangles ([`tiny`](super::tiny)) or rows
//! ([`fill`](super::fill)), without a branch, so that the compiler turns it into vector instructions; every number is that of one
//! triangle and one row, bit for bit.

use super::places::Places;
use crate::render::cpu::raster::{larger, smaller};

/// The place of a corner.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Corner {
    /// Texels from the left.
    pub column: f64,
    /// Grows downwards.
    pub down: f64,
    /// NDC depth.
    pub z: f64,
}

/// A side of a triangle, from its upper end.
#[derive(Debug, Clone, Copy, Default)]
pub struct Edge {
    pub column: f64,
    pub down: f64,
    /// Columns for each unit down. Meaningless for an edge without a row.
    pub slope: f64,
}

impl Edge {
    #[inline(always)]
    fn new(upper: Corner, lower: Corner) -> Self {
        let slope = (lower.column - upper.column) / (lower.down - upper.down);
        Self { column: upper.column, down: upper.down, slope }
    }
    #[inline(always)]
    fn column_at(&self, down: f64) -> f64 {
        self.column + (down - self.down) * self.slope
    }
}

/// A triangle whose corners are in order from top to bottom. Corners at one height may come in any order: no row is between them.
#[derive(Debug, Clone, Copy, Default)]
pub struct Triangle {
    /// From the first to the last corner, from the first to the second, from the second to the last.
    pub long: Edge,
    pub upper: Edge,
    pub lower: Edge,
    /// Depth at the first corner, and what it gains per column and down.
    pub z: f64,
    pub per_column: f64,
    pub per_down: f64,
    /// Smallest and largest depth of the corners.
    pub range: [f64; 2],
}

/// What a row has of a triangle.
#[derive(Debug, Clone, Copy, Default)]
pub struct Span {
    /// The first column, and the first one after the last. Not in this order: none.
    pub from: u32,
    pub to: u32,
    /// Depth at the centre of column `from`, not held between those of the corners.
    pub z: f64,
}

impl Triangle {
    #[inline(always)]
    pub fn new(a: Corner, b: Corner, c: Corner) -> Self {
        let (bx, by, bz) = (b.column - a.column, b.down - a.down, b.z - a.z);
        let (cx, cy, cz) = (c.column - a.column, c.down - a.down, c.z - a.z);
        let inverse = (bx * cy - cx * by).recip();
        Self {
            long: Edge::new(a, c),
            upper: Edge::new(a, b),
            lower: Edge::new(b, c),
            z: a.z,
            per_column: (bz * cy - cz * by) * inverse,
            per_down: (bx * cz - cx * bz) * inverse,
            range: [least(least(a.z, b.z), c.z), most(most(a.z, b.z), c.z)],
        }
    }

    /// What a row between the first and the last corner has.
    #[inline(always)]
    pub fn span<C: Places>(&self, columns: &C, down: f64) -> Span {
        let (p, upper, lower) = (self.long.column_at(down), self.upper.column_at(down), self.lower.column_at(down));
        let q = if down < self.lower.down { upper } else { lower };
        let (from, to) = (columns.first(least(p, q)), columns.first(most(p, q)));
        let per_down = (down - self.long.down) * self.per_down;
        let z = self.z + (columns.place(from as usize) - self.long.column) * self.per_column + per_down;
        Span { from, to, z }
    }

    /// Depths of the corners, less a number.
    #[inline(always)]
    pub fn range_less(&self, less: f64) -> [f32; 2] {
        [(self.range[0] - less) as f32, (self.range[1] - less) as f32]
    }
}

/// Depth so far to the right of a span's first column, whose depth is `z`, less a number.
#[inline(always)]
pub fn depth(z: f64, per_column: f64, step: f64, less: f64) -> f32 {
    (z + step * per_column - less) as f32
}

/// A depth held between those of the corners: of a triangle much thinner than its rounding no plane is known. A NaN (of one without
/// area, which has a centre only by rounding) becomes the nearest corner's.
#[inline(always)]
pub fn held(z: f32, [least, most]: [f32; 2]) -> f32 {
    smaller(larger(z, least), most)
}

/// The smaller number, `b` where one is a NaN; one instruction.
#[inline(always)]
fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The larger number, `b` where one is a NaN; one instruction.
#[inline(always)]
fn most(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
