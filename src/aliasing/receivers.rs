//! Receivers of an image in runs of [`RUN`] pixels, axis by axis: kernels are loops without branches over a run, which the
//! compiler turns into vector instructions.

use glam::DVec3;

use crate::image::Surfaces;
use crate::scene::Light;
use crate::simd::dispatch;

/// Pixels of a run: 3 KiB of positions and normals, so that a kernel's numbers stay in the smallest first cache in use.
pub const RUN: usize = 64;

/// What a pixel shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// No surface.
    Nothing,
    /// A surface that the light does not reach: turned away from it, or outside of its cone or range.
    Averted,
    /// A surface that light arrives at where nothing is in the way: [`Light::illuminates`].
    Facing,
}

/// Positions relative to the origin, and normals, of the pixels of a run. Numbers behind the last pixel are of no account.
#[derive(Debug, Clone)]
pub struct Receivers {
    /// x, y and z of each position.
    pub p: [[f64; RUN]; 3],
    /// x, y and z of each normal.
    pub n: [[f64; RUN]; 3],
}

impl Receivers {
    /// A run yet to be read.
    pub const NONE: Self = Self { p: [[0.0; RUN]; 3], n: [[0.0; RUN]; 3] };

    /// Reads the pixels from `first` on, at most [`RUN`] of them.
    pub fn read(&mut self, surfaces: &Surfaces, first: usize, count: usize) {
        let pixels = first..first + count;
        spread(&surfaces.position[pixels.clone()], &surfaces.normal[pixels], self);
    }
    /// What each of the pixels that have been read shows; nothing behind the last.
    pub fn shown(&self, surfaces: &Surfaces, light: &Light, first: usize, count: usize) -> [Shown; RUN] {
        let mut shown = [Shown::Nothing; RUN];
        tell(self, &surfaces.triangle[first..first + count], surfaces.origin, light, &mut shown);
        shown
    }
    /// The position of a pixel, relative to the origin.
    #[inline(always)]
    pub fn point(&self, i: usize) -> DVec3 {
        DVec3::new(self.p[0][i], self.p[1][i], self.p[2][i])
    }
    /// Its normal.
    #[inline(always)]
    pub fn normal(&self, i: usize) -> DVec3 {
        DVec3::new(self.n[0][i], self.n[1][i], self.n[2][i])
    }
}

dispatch! {
    /// Positions and normals, axis by axis.
    fn spread(position: &[[f32; 3]], normal: &[[f32; 3]], run: &mut Receivers) = spread_body
}

#[inline(always)]
fn spread_body(position: &[[f32; 3]], normal: &[[f32; 3]], run: &mut Receivers) {
    for (i, (p, n)) in position.iter().zip(normal).enumerate().take(RUN) {
        for axis in 0..3 {
            run.p[axis][i] = f64::from(p[axis]);
            run.n[axis][i] = f64::from(n[axis]);
        }
    }
}

dispatch! {
    /// What the pixels with these triangles show.
    fn tell(run: &Receivers, triangle: &[i32], origin: DVec3, light: &Light, shown: &mut [Shown; RUN]) = tell_body
}

#[inline(always)]
fn tell_body(run: &Receivers, triangle: &[i32], origin: DVec3, light: &Light, shown: &mut [Shown; RUN]) {
    match light {
        Light::Directional(l) => tell_by(triangle, shown, |i| l.illuminates(run.normal(i))),
        Light::Spot(l) => tell_by(triangle, shown, |i| l.illuminates(origin + run.point(i), run.normal(i))),
        Light::Point(l) => tell_by(triangle, shown, |i| l.illuminates(origin + run.point(i), run.normal(i))),
    }
}

#[inline(always)]
fn tell_by(triangle: &[i32], shown: &mut [Shown; RUN], illuminates: impl Fn(usize) -> bool) {
    for (i, (triangle, shown)) in triangle.iter().zip(shown).enumerate().take(RUN) {
        let lit = if illuminates(i) { Shown::Facing } else { Shown::Averted };
        *shown = if *triangle >= 0 { lit } else { Shown::Nothing };
    }
}
