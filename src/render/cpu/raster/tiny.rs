//! The pixels that tiny triangles cover, found for [`LANES`] triangles side by side and listed band by band.
//!
//! ```text
//!   lanes       t0 t1 t2 t3 t4 t5 t6 t7     one pixel of each box
//!   covered      0  1  1  0  0  1  0  0
//!   appended    t1 t2 t5  .  .  .  .  .     the list is three longer; what lies behind is written over
//! ```
//! No branch depends on whether a pixel is covered: half of them are, so every other such branch would be guessed wrongly.

use super::bins::{Bands, Bin, Bins};
use super::cover::Grid;
use super::fragments::Room;
use super::lanes::Lanes;
use super::simd::LANES;
use super::triangle_setup::SmallSetup;

/// Largest box, in pixel centres along each side, of triangles that become fragments: at most ten of them, 120 bytes.
/// Chosen by measurement (instructions on a scene of 440,000 triangles at 1024 and 2048 texels).
pub const TINY: i32 = 4;
/// Most fragments that a group of triangles adds to a band, and the lanes behind the last.
const MOST: usize = (TINY * TINY) as usize * LANES + LANES;

/// The triangles of a group that become fragments.
#[derive(Clone, Copy)]
pub struct Tiny<'a, L: Lanes> {
    pub setup: &'a SmallSetup<L>,
    /// First column and row, last column and row of each box.
    pub boxes: &'a [L::Int; 4],
    /// A bit for each triangle that counts.
    pub taken: u32,
    /// Scene-wide numbers.
    pub number: &'a [u32; LANES],
    /// Whether fragments bear numbers.
    pub numbered: bool,
    /// The tiles of the image.
    pub grid: Grid,
}

/// A bit for each triangle whose box has more than so many columns, or rows.
type MoreThan = [u32; TINY as usize];

impl<L: Lanes> Tiny<'_, L> {
    /// Adds the fragments to the bands of an image of so many columns.
    #[inline(always)]
    pub fn emit(&self, lanes: L, width: u32, layout: Bands, bins: &mut Bins) {
        debug_assert!(layout.rows() >= TINY as usize, "a box lies in two bands at most");
        let [left, top, right, bottom] = *self.boxes;
        let spans = (self.more_than(lanes, left, right), self.more_than(lanes, top, bottom));
        let (first, end) = (lanes.shifted(top, layout.log2_rows), lanes.shifted(bottom, layout.log2_rows));
        let bands_of = lanes.to_ints(first);
        // Of the whole group: neighbours lie side by side.
        let (first_column, last_column) = (lanes.least_of(left), lanes.most_of(right));
        let last = width as i32 - 1;
        let touched = self.grid.columns(first_column.min(last), last_column.clamp(0, last));
        let mut rest = self.taken;
        while rest != 0 {
            let band = bands_of[rest.trailing_zeros() as usize % LANES];
            let here = lanes.signs(lanes.equal(first, lanes.int(band))) & rest;
            let crossing = here & !lanes.signs(lanes.equal(end, lanes.int(band)));
            rest &= !here;
            for (band, here) in [(band, here), (band + 1, crossing)] {
                if here != 0 {
                    let out = bins.room_for(band as usize);
                    out.columns |= touched;
                    self.emit_to(lanes, layout, band, &spans, here, crossing, out);
                }
            }
        }
    }

    #[inline(always)]
    fn more_than(&self, lanes: L, first: L::Int, last: L::Int) -> MoreThan {
        let span = lanes.sub(last, first);
        let two = !lanes.signs(lanes.sub(span, lanes.int(1))) & self.taken;
        let three = !lanes.signs(lanes.sub(span, lanes.int(2))) & self.taken;
        let four = !lanes.signs(lanes.sub(span, lanes.int(3))) & self.taken;
        [self.taken, two, three, four]
    }

    /// Adds the fragments that the triangles `here` have in one band, where some of them are `crossing` into another.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    fn emit_to(
        &self,
        lanes: L,
        layout: Bands,
        band: i32,
        (columns, rows): &(MoreThan, MoreThan),
        here: u32,
        crossing: u32,
        out: &mut Bin,
    ) {
        let s = self.setup;
        let out = &mut out.fragments;
        let Room { at: at_room, z: z_room, id: mut id_room } = out.room::<MOST>(self.numbered);
        let id = lanes.unsigned(self.number);
        let (down, right) = (lanes.int(layout.stride as i32), lanes.int(1));
        let mut row_in_band = lanes.sub(self.boxes[1], lanes.int(band << layout.log2_rows));
        let mut at_row = lanes.add(lanes.mul(row_in_band, down), self.boxes[0]);
        let mut edge_row = s.edge;
        let [mut z_row, z_x, z_y] = s.z;
        let mut count = 0;
        for row in rows {
            let mut in_row = row & here;
            if in_row == 0 {
                break;
            }
            if crossing != 0 {
                let left = lanes.sub(lanes.int(layout.rows() as i32 - 1), row_in_band);
                in_row &= !lanes.signs(lanes.or(row_in_band, left));
                row_in_band = lanes.add(row_in_band, lanes.int(1));
            }
            let (mut edge, mut z, mut at) = (edge_row, z_row, at_row);
            for column in columns {
                let pixels = column & in_row;
                if pixels == 0 {
                    break;
                }
                let covered = !lanes.signs(lanes.or(lanes.or(edge[0], edge[1]), edge[2])) & pixels;
                let order = lanes.order(covered);
                let held = lanes.clamp(z, s.z_range[0], s.z_range[1]);
                lanes.put_ints(lanes.ordered_ints(at, order), lanes_of(at_room, count));
                lanes.put_floats(lanes.ordered_floats(held, order), lanes_of(z_room, count));
                if let Some(id_room) = &mut id_room {
                    lanes.put_ints(lanes.ordered_ints(id, order), lanes_of(id_room, count));
                }
                count += covered.count_ones() as usize;
                edge = lanes.add_three(edge, s.step_x);
                z = lanes.add_floats(z, z_x);
                at = lanes.add(at, right);
            }
            edge_row = lanes.add_three(edge_row, s.step_y);
            z_row = lanes.add_floats(z_row, z_y);
            at_row = lanes.add(at_row, down);
        }
        // SAFETY: `count` values have been written at the beginning of each part of the room.
        unsafe { out.lengthen(count, self.numbered) };
    }
}

/// Room for [`LANES`] values behind those of so many pixels, which are not all that a group can have.
#[inline(always)]
fn lanes_of<T>(room: &mut [T; MOST], count: usize) -> &mut [T; LANES] {
    const PIXELS: usize = MOST - LANES;
    const { assert!(PIXELS.is_power_of_two()) };
    debug_assert!(count < PIXELS);
    room[count % PIXELS..].first_chunk_mut().expect("room for a group")
}
