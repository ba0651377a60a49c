//! Triangles into one band of a map: some rows side by side, then their texels, side by side, too.

use std::hint::select_unpredictable;
use std::ops::Range;

use super::lists::{EXTRA, List};
use super::places::Places;
use super::triangle::{Span, Triangle, depth, held};
use super::vertex::EvenVertex;
use crate::render::cpu::raster::{BandArea, Fragment, LANES, Lanes, Pixels, with_lanes};

/// Rows that are looked at side by side.
const ROWS: usize = 8;

/// Triangles of a batch, and the rows of a map that they are drawn into.
#[derive(Debug)]
pub struct Filling<'a, C> {
    pub vertices: &'a [EvenVertex],
    pub extra: &'a [EvenVertex],
    /// Places of all rows, with infinities behind.
    pub rows: &'a [f64],
    pub columns: &'a C,
    pub area: BandArea,
}

/// Corners from top to bottom, and the rows of a band between the first and the last.
struct Part<'a> {
    corners: [&'a EvenVertex; 3],
    rows: Range<usize>,
}

impl<C: Places> Filling<'_, C> {
    /// What a listed triangle has in the band.
    #[inline(always)]
    fn part(&self, indices: [u32; 3]) -> Part<'_> {
        let corner = |i: u32| {
            if i & EXTRA == 0 { &self.vertices[i as usize] } else { &self.extra[(i & !EXTRA) as usize] }
        };
        let corners = from_top([corner(indices[0]), corner(indices[1]), corner(indices[2])]);
        let (first, rows) = (self.area.first_row as usize, self.area.rows as usize);
        let rows = first.max(corners[0].first_row as usize)..(first + rows).min(corners[2].first_row as usize);
        Part { corners, rows }
    }

    /// What some rows have of a triangle; those behind the last one mean nothing.
    #[inline(always)]
    fn spans(&self, triangle: &Triangle, first: usize) -> [Span; ROWS] {
        let rows: &[f64; ROWS] = self.rows[first..].first_chunk().expect("infinities behind the last row");
        let (mut from, mut to, mut z) = ([0; ROWS], [0; ROWS], [0.0; ROWS]);
        for k in 0..ROWS {
            let span = triangle.span(self.columns, rows[k]);
            (from[k], to[k], z[k]) = (span.from, span.to, span.z);
        }
        let mut spans = [Span::default(); ROWS];
        for k in 0..ROWS {
            spans[k] = Span { from: from[k], to: to[k], z: z[k] };
        }
        spans
    }

    /// Calls `each` with each texel of a listed triangle in the band: its row, its column, its depth less a number.
    pub fn for_each_texel(&self, indices: [u32; 3], less: f64, mut each: impl FnMut(usize, usize, f32)) {
        let Part { corners, rows } = self.part(indices);
        if rows.is_empty() {
            return;
        }
        let triangle = triangle_of(corners);
        for row in rows {
            let span = triangle.span(self.columns, self.rows[row]);
            let step = self.columns.steps(span.from as usize);
            for column in span.from..span.to {
                let z = depth(span.z, triangle.per_column, step(column - span.from), less);
                each(row, column as usize, held(z, triangle.range_less(less)));
            }
        }
    }
}

#[inline(always)]
fn triangle_of([a, b, c]: [&EvenVertex; 3]) -> Triangle {
    Triangle::new(a.corner, b.corner, c.corner)
}

/// Corners from top to bottom, found without a branch: nearly every one would be guessed wrongly.
#[inline(always)]
pub fn from_top([a, b, c]: [&EvenVertex; 3]) -> [&EvenVertex; 3] {
    let [a, b] = upper_first(a, b);
    let [b, c] = upper_first(b, c);
    let [a, b] = upper_first(a, b);
    [a, b, c]
}

#[inline(always)]
fn upper_first<'a>(a: &'a EvenVertex, b: &'a EvenVertex) -> [&'a EvenVertex; 2] {
    let is_lower = b.corner.down < a.corner.down;
    [select_unpredictable(is_lower, b, a), select_unpredictable(is_lower, a, b)]
}

with_lanes! {
    /// Draws listed triangles into a band, whose texels are `pixels`.
    pub fn fill<C: Places, P: Pixels>(work: &Filling<C>, list: &List, pixels: &mut P) = fill_with
}

#[inline(always)]
pub fn fill_with<L: Lanes, C: Places, P: Pixels>(lanes: L, work: &Filling<C>, list: &List, pixels: &mut P) {
    let less = less_of::<P>();
    let BandArea { stride, first_row, rows, .. } = work.area;
    let texels = rows as usize * stride;
    for indices in &list.triangles {
        let Part { corners, rows } = work.part(*indices);
        if rows.is_empty() {
            continue;
        }
        let triangle = triangle_of(corners);
        let [least, most] = triangle.range_less(less);
        let range = [lanes.float(least), lanes.float(most)];
        let mut first = rows.start;
        while first < rows.end {
            let spans = work.spans(&triangle, first);
            for (span, row) in spans.iter().zip(first..rows.end) {
                if span.from < span.to {
                    let at = (row - first_row as usize) * stride + span.from as usize;
                    draw_span(lanes, work, &triangle, range, span, at, texels, pixels);
                }
            }
            first += ROWS;
        }
    }
}

/// What depths that are kept are less than those of a map.
pub fn less_of<P: Pixels>() -> f64 {
    1.0 - f64::from(P::FAR)
}

/// Draws a row of a triangle whose first texel is `at`, into so many texels.
#[allow(clippy::too_many_arguments)]
#[inline(always)]
fn draw_span<L: Lanes, C: Places, P: Pixels>(
    lanes: L,
    work: &Filling<C>,
    triangle: &Triangle,
    [least, most]: [L::Float; 2],
    span: &Span,
    at: usize,
    texels: usize,
    pixels: &mut P,
) {
    let less = less_of::<P>();
    let step = work.columns.steps(span.from as usize);
    let count = span.to - span.from;
    let each = lanes.ints([0, 1, 2, 3, 4, 5, 6, 7]);
    let mut i = 0;
    while i < count {
        let mut z = [0.0; LANES];
        for l in 0..LANES {
            z[l] = depth(span.z, triangle.per_column, step(i + l as u32), less);
        }
        let z = lanes.clamp(lanes.floats(z), least, most);
        let (at, rest) = (at + i as usize, (count - i) as i32);
        if at + LANES <= texels {
            // Beyond the end of a row lies the next, and nothing of it changes.
            pixels.draw(lanes, at, z, lanes.less(lanes.int(rest - 1), each), 0);
        } else {
            let z = lanes.to_floats(z);
            for l in 0..LANES.min(rest as usize) {
                pixels.draw_fragment(&Fragment { at: (at + l) as u32, z: z[l], id: 0 });
            }
        }
        i += LANES as u32;
    }
}
