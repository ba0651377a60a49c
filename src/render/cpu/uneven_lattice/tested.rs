//! Triangles with an alpha test between uneven rows and columns: only centres that exist are drawn.

use std::ops::Range;

use super::lattice::Places;
use super::texels::Texels;
use super::triangle::{EvenVertex, corners_of, spans};
use crate::render::cpu::tested_triangle::TestedTriangle;

/// Draws triangles into the rows `band` of a map, as [`fill_band`](super::triangle::fill_band); `tested` gives the test of each.
#[allow(clippy::too_many_arguments)]
pub fn fill_tested<'a, C: Places, T: Texels>(
    triangles: &[[u32; 3]],
    tested: impl Fn(usize) -> Option<TestedTriangle<'a>>,
    vertices: &[EvenVertex],
    extra: &[EvenVertex],
    rows: &[f64],
    columns: &C,
    band: Range<usize>,
    texels: &mut T,
) {
    let width = columns.count();
    let step = 2.0 / width as f64;
    for (i, indices) in triangles.iter().enumerate() {
        let test = tested(i);
        spans(corners_of(*indices, vertices, extra), rows, columns, &band, |plane, row, span| {
            let start = (row - band.start) * width;
            let z = plane.along(columns, span.start, rows[row]);
            for (i, column) in span.enumerate() {
                let x = columns.place(column) * step - 1.0;
                if test.is_none_or(|test| test.exists_at(x, rows[row])) {
                    // The numbers of a span without a test, so that texels that are kept have the same bits.
                    texels.draw(start + column..start + column + 1, |_| z(i));
                }
            }
        });
    }
}
