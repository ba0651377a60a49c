//! The light at whole runs of receivers: what [`MapLookup::light`] finds, bit for bit.

use glam::DVec2;

use super::lookup::MapLookup;
use super::runs::{Compared, lit};
use super::wide_run_light::wide;
use crate::aliasing::receivers::{RUN, Receivers, Shown};
use crate::parameterization::Held;
use crate::render::{Kernel, between};
use crate::simd::dispatch;

/// Receivers of a run from which on all of it is looked up at once, instead of them one by one: estimated
/// from whole masks, which took about a sixth of the time in runs.
pub(super) const FEW: usize = 10;

impl MapLookup {
    /// The light at each receiver of a run that faces it and that the map holds, which `found.is_held` says; where it faces away the
    /// numbers mean nothing.
    pub(super) fn light_of_facing(
        &self,
        map: &[f32],
        run: &Receivers,
        shown: &[Shown; RUN],
        found: &mut Compared,
        light: &mut [f32; RUN],
    ) {
        let facing = shown.iter().filter(|shown| **shown == Shown::Facing).count();
        if self.is_common() && facing >= FEW {
            self.compare_run(run, found);
            self.light_of_run(map, found, light);
            return;
        }
        for i in (0..RUN).filter(|&i| shown[i] == Shown::Facing) {
            let p = run.point(i);
            found.is_held[i] = self.holds(p) != Held::Outside;
            if found.is_held[i] {
                light[i] = self.light(map, p, run.normal(i));
            }
        }
    }

    /// The light at each receiver of a run that has been compared, of a map that [is common](MapLookup::is_common): 1 where there
    /// is nothing to compare.
    ///
    /// # Panics
    /// Where `map` has another number of texels, and for a map that is not common: the kernels rely on both.
    pub(super) fn light_of_run(&self, map: &[f32], found: &Compared, light: &mut [f32; RUN]) {
        let [width, height] = self.size.map(|side| side as usize);
        assert!(self.is_common() && map.len() == width * height, "a lookup belongs to maps of one size");
        match self.kernels.even().0 {
            Kernel::Nearest => nearest(self, map, found, light),
            Kernel::Bilinear => bilinear(self, map, found, light),
            kernel => wide(kernel, self, map, found, light),
        }
    }
}

dispatch! {
    /// The light of one comparison each.
    fn nearest(lookup: &MapLookup, map: &[f32], found: &Compared, light: &mut [f32; RUN]) = nearest_body
}

#[inline(always)]
fn nearest_body(lookup: &MapLookup, map: &[f32], found: &Compared, light: &mut [f32; RUN]) {
    let (mut z, mut index) = ([0.0; RUN], [0; RUN]);
    for i in 0..RUN {
        let texel = DVec2::new(found.at[0][i], found.at[1][i]).floor();
        z[i] = lookup.depth_in_run(found, i, texel + 0.5);
        index[i] = lookup.index_of(texel);
    }
    if found.asks_planes {
        let w = lookup.w_of_rows(found, |i| found.at[1][i].floor() + 0.5);
        lookup.depths_on_planes(found, |i| found.at[0][i].floor() + 0.5, &w, &mut z);
    }
    for i in 0..RUN {
        // SAFETY: the index has been held to the map, whose length the caller has checked.
        let lit = unsafe { lit(map, index[i], z[i]) } as f32;
        light[i] = if found.is_compared[i] { lit } else { 1.0 };
    }
}

dispatch! {
    /// The light of the four nearest texel centres.
    fn bilinear(lookup: &MapLookup, map: &[f32], found: &Compared, light: &mut [f32; RUN]) = bilinear_body
}

#[inline(always)]
fn bilinear_body(lookup: &MapLookup, map: &[f32], found: &Compared, light: &mut [f32; RUN]) {
    const CORNERS: [DVec2; 4] = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE];
    let (mut z, mut index, mut f) = ([[0.0; RUN]; 4], [[0; RUN]; 4], [[0.0; RUN]; 2]);
    for i in 0..RUN {
        let place = DVec2::new(found.at[0][i], found.at[1][i]);
        let corner = (place - 0.5).floor();
        (f[0][i], f[1][i]) = (place - 0.5 - corner).into();
        for (k, step) in CORNERS.into_iter().enumerate() {
            z[k][i] = lookup.depth_in_run(found, i, corner + step + 0.5);
            index[k][i] = lookup.index_of(corner + step);
        }
    }
    if found.asks_planes {
        let centre = |axis: usize, step: f64| move |i: usize| (found.at[axis][i] - 0.5).floor() + step + 0.5;
        let rows = [0.0, 1.0].map(|step| lookup.w_of_rows(found, centre(1, step)));
        for (z, step) in z.iter_mut().zip(CORNERS) {
            lookup.depths_on_planes(found, centre(0, step.x), &rows[step.y as usize], z);
        }
    }
    for i in 0..RUN {
        // SAFETY: the indices have been held to the map, whose length the caller has checked.
        let lit = |k: usize| unsafe { lit(map, index[k][i], z[k][i]) };
        let mixed = between(DVec2::new(f[0][i], f[1][i]), [lit(0), lit(1), lit(2), lit(3)]);
        light[i] = if found.is_compared[i] { mixed as f32 } else { 1.0 };
    }
}
