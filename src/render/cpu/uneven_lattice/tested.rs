//! Triangles with an alpha test between uneven rows and columns: only centres that exist are drawn.

use super::fill::{Filling, less_of};
use super::lists::List;
use super::places::Places;
use crate::render::cpu::raster::{Fragment, Pixels};
use crate::render::cpu::tested_triangle::TestedTriangle;

/// Draws listed triangles into a band, as [`fill`](super::fill::fill); `tested` gives the test of a triangle by its number.
///
/// Depths are the numbers of a triangle without a test, so texels that are kept have the same bits.
pub fn fill_tested<'a, C: Places, P: Pixels>(
    work: &Filling<C>,
    list: &List,
    tested: impl Fn(usize) -> Option<TestedTriangle<'a>>,
    pixels: &mut P,
) {
    let step = 2.0 / work.columns.count() as f64;
    for (indices, number) in list.triangles.iter().zip(&list.numbers) {
        let test = tested(*number as usize);
        work.for_each_texel(*indices, less_of::<P>(), |row, column, z| {
            let x = work.columns.place(column) * step - 1.0;
            if test.is_none_or(|test| test.exists_at(x, work.rows[row])) {
                let at = ((row - work.area.first_row as usize) * work.area.stride + column) as u32;
                pixels.draw_fragment(&Fragment { at, z, id: 0 });
            }
        });
    }
}
