//! Comparisons of whole runs of receivers: what [`MapLookup::holds`] and [`MapLookup::compare_at`] find, bit for bit.
//!
//! The comparison of a receiver is one function, [`MapLookup::compared`]. Here it stands in a loop over the receivers of a run,
//! with the parts in use as constants, so that it has no branch and the compiler turns it into vector instructions. It is f64
//! as for one receiver, the same operations in the same order: nothing is undecided, and no bound of errors is needed.

use glam::DVec2;

use super::lookup::MapLookup;
use super::parts::{Case, Common, Parts};
use super::warped::{Even, Logarithm, WarpedRun};
use crate::aliasing::receivers::{RUN, Receivers};
use crate::parameterization::{Held, PostWarp, Region};
use crate::simd::dispatch;

/// How receivers of a run are compared: [`super::Reference`], axis by axis.
pub(super) struct Compared {
    /// Whether the map holds it. Where it does not, and where it is not compared, the numbers mean nothing.
    pub(super) is_held: [bool; RUN],
    /// Whether it is compared; else it is lit without a look at the map.
    pub(super) is_compared: [bool; RUN],
    /// Where in the map, texels.
    pub(super) at: [[f64; RUN]; 2],
    /// Biased depth, but for the part that each texel has of its own.
    pub(super) z: [f64; RUN],
    /// How depth on the receiver's plane changes with each texel, and how much it may.
    per_texel: [[f64; RUN]; 2],
    pub(super) limit: [f64; RUN],
    /// Whether each texel asks where its ray meets the receiver's plane; of such maps alone the following is known: positions, normals,
    /// and depths without bias.
    pub(super) asks_planes: bool,
    pub(super) p: [[f64; RUN]; 3],
    pub(super) normal: [[f64; RUN]; 3],
    pub(super) unbiased: [f64; RUN],
}

impl Compared {
    pub(super) const NONE: Self = Self {
        is_held: [false; RUN],
        is_compared: [false; RUN],
        at: [[0.0; RUN]; 2],
        z: [0.0; RUN],
        per_texel: [[0.0; RUN]; 2],
        limit: [0.0; RUN],
        asks_planes: false,
        p: [[0.0; RUN]; 3],
        normal: [[0.0; RUN]; 3],
        unbiased: [0.0; RUN],
    };
}

impl MapLookup {
    /// How the map holds each receiver of a run: [`MapLookup::holds`].
    pub(super) fn holds_run(&self, run: &Receivers, held: &mut [Held; RUN]) {
        match &self.post_warp {
            PostWarp::None => hold(&Even, self, run, held),
            &PostWarp::Log { scale, offset } => {
                hold(&Logarithm::new(self.rows[3], scale, offset, run), self, run, held)
            }
            PostWarp::Rectilinear(_) => (0..RUN).for_each(|i| held[i] = self.holds(run.point(i))),
        }
    }

    /// Whether its parts are those of a [`Common`] case, so that whole runs are looked up at once.
    pub(super) fn is_common(&self) -> bool {
        /// Texels whose numbers, and sides, fit into the integers of the kernels.
        const MOST: u64 = i32::MAX as u64;
        let [width, height] = self.size.map(u64::from);
        let is_countable = width > 0 && height > 0 && width <= MOST / height;
        let Parts { is_linear, is_in_pixels, normal, factor, units, .. } = self.parts;
        let is_known = matches!(self.post_warp, PostWarp::None | PostWarp::Log { .. });
        is_countable && is_known && !(is_linear || is_in_pixels || normal || factor || units)
    }

    /// How each receiver of a run is compared, of a map that [is common](MapLookup::is_common).
    pub(super) fn compare_run(&self, run: &Receivers, found: &mut Compared) {
        match &self.post_warp {
            &PostWarp::Log { scale, offset } => {
                self.compare_warped(&Logarithm::new(self.rows[3], scale, offset, run), run, found);
                found.asks_planes = self.bias.plane != 0.0;
                (found.p, found.normal) = (run.p, run.n);
            }
            _ => {
                self.compare_warped(&Even, run, found);
                found.asks_planes = false;
            }
        }
    }

    fn compare_warped<W: WarpedRun>(&self, warped: &W, run: &Receivers, out: &mut Compared) {
        let parts = self.parts;
        match (parts.is_placed, parts.takes_plane, parts.is_limited) {
            (false, false, _) => compare(Common::<false, false, false>, warped, self, run, out),
            (false, true, false) => compare(Common::<false, true, false>, warped, self, run, out),
            (false, true, true) => compare(Common::<false, true, true>, warped, self, run, out),
            (true, false, _) => compare(Common::<true, false, false>, warped, self, run, out),
            (true, true, false) => compare(Common::<true, true, false>, warped, self, run, out),
            (true, true, true) => compare(Common::<true, true, true>, warped, self, run, out),
        }
    }
}

dispatch! {
    /// How a map holds receivers.
    fn hold<W: WarpedRun>(warped: &W, lookup: &MapLookup, run: &Receivers, held: &mut [Held; RUN]) = hold_body
}

#[inline(always)]
fn hold_body<W: WarpedRun>(warped: &W, lookup: &MapLookup, run: &Receivers, held: &mut [Held; RUN]) {
    for i in 0..RUN {
        held[i] = lookup.holds_by(warped.at(i), run.point(i));
    }
    for functional in lookup.region.functionals() {
        for i in 0..RUN {
            held[i] = if Region::is_on_side(*functional, run.point(i)) { held[i] } else { Held::Outside };
        }
    }
}

dispatch! {
    /// The comparisons of a run.
    fn compare<C: Case, W: WarpedRun>(case: C, warped: &W, lookup: &MapLookup, run: &Receivers, found: &mut Compared) = compare_body
}

#[inline(always)]
fn compare_body<C: Case, W: WarpedRun>(_: C, warped: &W, lookup: &MapLookup, run: &Receivers, found: &mut Compared) {
    for i in 0..RUN {
        let p = run.point(i);
        let (is_compared, reference) = lookup.compared(C::PARTS, warped.at(i), p, run.normal(i));
        found.is_held[i] = lookup.holds_by(warped.at(i), p) != Held::Outside;
        found.is_compared[i] = is_compared;
        (found.at[0][i], found.at[1][i]) = reference.p_texel.into();
        found.z[i] = reference.z;
        (found.per_texel[0][i], found.per_texel[1][i]) = reference.plane.per_texel.into();
        found.limit[i] = reference.limit;
        found.unbiased[i] = reference.unbiased;
    }
    for functional in lookup.region.functionals() {
        for i in 0..RUN {
            found.is_held[i] &= Region::is_on_side(*functional, run.point(i));
        }
    }
}

impl MapLookup {
    /// The depth that a texel with this centre is compared with, [`MapLookup::depth_at`] of a common case.
    #[inline(always)]
    pub(super) fn depth_in_run(&self, found: &Compared, i: usize, centre: DVec2) -> f64 {
        let texels = centre - DVec2::new(found.at[0][i], found.at[1][i]);
        let change = DVec2::new(found.per_texel[0][i], found.per_texel[1][i]).dot(texels);
        self.depth_beside(found.z[i], change, found.limit[i])
    }

    /// Columns and rows of texels, held to the map whatever the numbers are, as an index.
    #[inline(always)]
    pub(super) fn index_of(&self, texel: DVec2) -> u32 {
        let held = |x: f64, side: u32| {
            // A NaN is 0.
            let x = x.max(0.0).min(f64::from(side - 1));
            // SAFETY: it is a number from 0 to below 2^31, as `is_common` has seen to.
            unsafe { x.to_int_unchecked::<i32>() as u32 }
        };
        held(texel.y, self.size[1]) * self.size[0] + held(texel.x, self.size[0])
    }
}

/// 1 where what a texel holds is at least as deep, else 0.
///
/// # Safety
/// The index comes from [`MapLookup::index_of`], the map has as many texels as that says.
#[inline(always)]
pub(super) unsafe fn lit(map: &[f32], index: u32, z: f64) -> f64 {
    // SAFETY: as the caller promises.
    let stored = unsafe { *map.get_unchecked(index as usize) };
    if f64::from(stored) >= z { 1.0 } else { 0.0 }
}
