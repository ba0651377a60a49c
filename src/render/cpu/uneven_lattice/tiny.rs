//! The texels of tiny triangles, found for many of them side by side and listed band by band.
//!
//! ```text
//!   lanes      t0 t1 t2 t3 t4 t5 t6 t7     a row of each, which has so many columns
//!   columns     0  2  1  0  3  0  0  1
//!   appended   t1 t2 t4 t7  .  .  .  .     the first of them; what lies behind is written over
//!              t1 t4  .  .  .  .  .  .     the second
//! ```
//! No branch depends on how many texels one triangle has: nearly every such branch would be guessed wrongly.

use super::lists::Bin;
use super::places::Places;
use super::triangle::{Corner, Edge, Triangle, depth};
use crate::render::cpu::raster::{Bands, LANES, Lanes, with_lanes};

/// Triangles side by side.
const GROUP: usize = 32;
/// Most rows, and columns, of a tiny triangle: about ten texels, 80 bytes. Chosen by measurement.
pub const TINY: u32 = 4;

/// A group of tiny triangles.
#[derive(Debug, Default)]
pub struct Tiny {
    /// Of each corner, from top to bottom, its column, how far down it is, and its depth.
    corners: [[[f64; GROUP]; 3]; 3],
    /// The first row, and the first one after the last.
    first: [u32; GROUP],
    end: [u32; GROUP],
    count: usize,
    /// Rows of the highest.
    high: u32,
}

/// A map that tiny triangles are drawn into.
#[derive(Debug)]
pub struct Target<'a, C> {
    /// Places of the rows, with infinities behind.
    pub rows: &'a [f64],
    pub columns: &'a C,
    pub bands: Bands,
    /// What depths that are kept are less than those of the map.
    pub less: f64,
}

impl Tiny {
    /// Adds a triangle from its first row to the one before `end`; whether that makes the group full.
    #[inline(always)]
    pub fn push(&mut self, corners: [Corner; 3], first: u32, end: u32) -> bool {
        let l = self.count % GROUP;
        for (rows, corner) in self.corners.iter_mut().zip(corners) {
            (rows[0][l], rows[1][l], rows[2][l]) = (corner.column, corner.down, corner.z);
        }
        (self.first[l], self.end[l]) = (first, end);
        self.high = self.high.max(end - first);
        self.count = l + 1;
        self.count == GROUP
    }

    /// Leaves the texels of the group to bands.
    pub fn emit<C: Places>(&mut self, target: &Target<C>, bins: &mut [Bin]) {
        emit(self, target, bins);
        self.clear();
    }

    /// Forgets the group, and with it rows that the next map may lack.
    pub fn clear(&mut self) {
        (self.count, self.high, self.first) = (0, 0, [0; GROUP]);
    }

    #[inline(always)]
    fn corner(&self, k: usize, l: usize) -> Corner {
        let [column, down, z] = &self.corners[k];
        Corner { column: column[l], down: down[l], z: z[l] }
    }
}

/// What is found once for a triangle: fields of [`Triangle`].
#[derive(Default)]
struct Setup {
    slopes: [[f64; GROUP]; 3],
    per_column: [f64; GROUP],
    per_down: [f64; GROUP],
    range: [[f32; GROUP]; 2],
}

with_lanes! {
    fn emit<C: Places>(tiny: &Tiny, target: &Target<C>, bins: &mut [Bin]) = emit_with
}

#[inline(always)]
pub fn emit_with<L: Lanes, C: Places>(lanes: L, tiny: &Tiny, target: &Target<C>, bins: &mut [Bin]) {
    let mut setup = Setup::default();
    for l in 0..GROUP {
        let t = Triangle::new(tiny.corner(0, l), tiny.corner(1, l), tiny.corner(2, l));
        (setup.slopes[0][l], setup.slopes[1][l], setup.slopes[2][l]) = (t.long.slope, t.upper.slope, t.lower.slope);
        (setup.per_column[l], setup.per_down[l]) = (t.per_column, t.per_down);
        [setup.range[0][l], setup.range[1][l]] = t.range_less(target.less);
    }
    for k in 0..tiny.high {
        let mut downs = [0.0; GROUP];
        for l in 0..GROUP {
            downs[l] = target.rows[(tiny.first[l] + k) as usize];
        }
        let mut row = Row { from: [0; GROUP], count: [0; GROUP], z: [0.0; GROUP] };
        for l in 0..GROUP {
            let [long, upper, lower] = [setup.slopes[0][l], setup.slopes[1][l], setup.slopes[2][l]];
            let ([a_column, a_down, a_z], [b_column, b_down, _]) = (&tiny.corners[0], &tiny.corners[1]);
            let triangle = Triangle {
                long: Edge { column: a_column[l], down: a_down[l], slope: long },
                upper: Edge { column: a_column[l], down: a_down[l], slope: upper },
                lower: Edge { column: b_column[l], down: b_down[l], slope: lower },
                z: a_z[l],
                per_column: setup.per_column[l],
                per_down: setup.per_down[l],
                range: [0.0; 2],
            };
            let span = triangle.span(target.columns, downs[l]);
            let columns = span.to as i32 - span.from as i32;
            row.count[l] = if tiny.first[l] + k < tiny.end[l] { columns } else { 0 };
            (row.from[l], row.z[l]) = (span.from, span.z);
        }
        for first in (0..tiny.count).step_by(LANES) {
            emit_row(lanes, tiny, target, bins, &setup, k, &row, first);
        }
    }
}

/// What a row of each triangle has: so many columns from one on, and the depth of that. None where there are fewer than one.
struct Row {
    from: [u32; GROUP],
    count: [i32; GROUP],
    z: [f64; GROUP],
}

/// Lists what row `k` of the [`LANES`] triangles from one on has.
#[allow(clippy::too_many_arguments)]
#[inline(always)]
fn emit_row<L: Lanes, C: Places>(
    lanes: L,
    tiny: &Tiny,
    target: &Target<C>,
    bins: &mut [Bin],
    setup: &Setup,
    k: u32,
    row: &Row,
    first: usize,
) {
    let Target { columns, bands, less, .. } = *target;
    let count = lanes.ints(*part(&row.count, first));
    let ended = first + LANES > tiny.count;
    let mut rest = lanes.signs(lanes.less(lanes.int(0), count));
    rest &= if ended { (1 << (tiny.count - first)) - 1 } else { u32::MAX };
    if rest == 0 {
        return;
    }
    let down = lanes.add(lanes.unsigned(part(&tiny.first, first)), lanes.int(k as i32));
    let band = lanes.shifted(down, bands.log2_rows);
    let row_in_band = lanes.and(down, lanes.int(bands.rows() as i32 - 1));
    let from = lanes.unsigned(part(&row.from, first));
    let at_first = lanes.add(lanes.mul(row_in_band, lanes.int(bands.stride as i32)), from);
    let range = [lanes.floats(*part(&setup.range[0], first)), lanes.floats(*part(&setup.range[1], first))];
    let (z_first, per_column) = (part(&row.z, first), part(&setup.per_column, first));
    let (froms, counts) = (part(&row.from, first), part(&row.count, first));
    let (most, bands_of) = (lanes.most_of(count), lanes.to_ints(band));
    while rest != 0 {
        // Neighbours lie side by side.
        let this = bands_of[rest.trailing_zeros() as usize % LANES];
        let here = lanes.signs(lanes.equal(band, lanes.int(this))) & rest;
        rest &= !here;
        let fragments = &mut bins[this as usize].fragments;
        let (places, depths) = fragments.room_of((most as usize + 1) * LANES);
        let mut listed = 0;
        for i in 0..most {
            let has = lanes.signs(lanes.less(lanes.int(i), count)) & here;
            let mut z = [0.0; LANES];
            for l in 0..LANES {
                // Not beyond what there is of columns.
                let step = columns.steps(froms[l] as usize)(i.min(counts[l].max(0)) as u32);
                z[l] = depth(z_first[l], per_column[l], step, less);
            }
            let z = lanes.clamp(lanes.floats(z), range[0], range[1]);
            let order = lanes.order(has);
            let at = lanes.add(at_first, lanes.int(i));
            lanes.put_ints(lanes.ordered_ints(at, order), group_from(places, listed));
            lanes.put_floats(lanes.ordered_floats(z, order), group_from(depths, listed));
            listed += has.count_ones() as usize;
        }
        // SAFETY: so many have been written, one by one behind each other.
        unsafe { fragments.lengthen(listed, false) };
    }
}

/// Room for [`LANES`] values from index `at`.
#[inline(always)]
fn group_from<T>(room: &mut [T], at: usize) -> &mut [T; LANES] {
    room[at..].first_chunk_mut().expect("room for a group")
}

#[inline(always)]
fn part<T>(of: &[T; GROUP], first: usize) -> &[T; LANES] {
    of[first..].first_chunk().expect("a group is whole parts")
}
