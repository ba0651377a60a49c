//! Triangles with an alpha test between uneven rows and columns: only centres that exist are drawn.

use std::ops::Range;

use super::lattice::Places;
use super::triangle::{EvenVertex, corners_of, spans};
use crate::render::cpu::tested_triangle::TestedTriangle;

/// Draws triangles into the rows `band` of a map, as [`fill_band`](super::triangle::fill_band); `tested` gives the test of each.
#[allow(clippy::too_many_arguments)]
pub fn fill_tested<'a, C: Places>(
    triangles: &[[u32; 3]],
    tested: impl Fn(usize) -> Option<TestedTriangle<'a>>,
    vertices: &[EvenVertex],
    extra: &[EvenVertex],
    rows: &[f64],
    columns: &C,
    band: Range<usize>,
    depth: &mut [f32],
) {
    let width = columns.count();
    let step = 2.0 / width as f64;
    // What a span would have been without a test, so that texels that are kept have the same bits.
    let mut drawn: Vec<f32> = Vec::new();
    for (i, indices) in triangles.iter().enumerate() {
        let test = tested(i);
        spans(corners_of(*indices, vertices, extra), rows, columns, &band, |plane, row, span| {
            let start = (row - band.start) * width;
            let (texels, from) = (&mut depth[start + span.start..start + span.end], span.start);
            drawn.clear();
            drawn.extend_from_slice(texels);
            plane.draw(&mut drawn, columns, from, rows[row]);
            for (column, (texel, drawn)) in span.zip(texels.iter_mut().zip(&drawn)) {
                let x = columns.place(column) * step - 1.0;
                if test.is_none_or(|test| test.exists_at(x, rows[row])) {
                    *texel = *drawn;
                }
            }
        });
    }
}
