//! Some of the samples in the order of the picture, and boxes around runs of neighbours: of a million samples most lie so far
//! inside of what is asked for that a box answers for all of its run.

use glam::{DVec3, Vec3};

use super::picture::Picture;
use crate::simd::dispatch;

/// Samples in a run. Chosen because shorter runs cost more boxes, and longer ones have boxes that stick out more often.
pub(super) const RUN: usize = 16;

/// Largest error of a product of two f32 vectors that is formed in f32, as a share of their lengths. Derived: six roundings.
const PRODUCT_ERROR: f64 = 6.0 * f32::EPSILON as f64;

/// Some of the samples, relative to the eye.
pub(super) struct Chosen<'a> {
    points: &'a [[f32; 3]],
    normals: &'a [[f32; 3]],
    indices: &'a [u32],
    /// The picture that they come from, where there is one.
    pub picture: Option<&'a Picture>,
    /// From the eye to what positions are relative to.
    moved: DVec3,
    pub runs: Vec<Run>,
}

/// Neighbours in the picture.
pub(super) struct Run {
    first: usize,
    end: usize,
    /// Middle and half sides of a box around them, relative to the eye.
    pub middle: DVec3,
    half: DVec3,
    /// At most the least product of a normal of theirs with the way to it ([`crate::scene::Camera::way_to`]): before a
    /// perspective eye how far it lies off their planes.
    off_plane: f64,
}

impl<'a> Chosen<'a> {
    /// The samples of these indices among points and normals, told from `moved` off the eye.
    pub fn new(
        [points, normals]: [&'a [[f32; 3]]; 2],
        indices: &'a [u32],
        picture: Option<&'a Picture>,
        moved: DVec3,
    ) -> Self {
        let parallel = picture.filter(|p| p.camera.is_orthographic()).map(|p| p.camera.forward().as_vec3());
        let mut chosen = Self { points, normals, indices, picture, moved, runs: Vec::new() };
        let mut runs = Vec::with_capacity(indices.len().div_ceil(RUN));
        find_runs(&chosen, parallel, &mut runs);
        chosen.runs = runs;
        chosen
    }
    /// How many there are.
    pub fn len(&self) -> usize {
        self.indices.len()
    }
    /// At least how far they lie from what positions are relative to.
    pub fn farthest_from_origin(&self) -> f64 {
        let far = |run: &Run| ((run.middle - self.moved).abs() + run.half).length_squared();
        self.runs.iter().map(far).fold(0.0, f64::max).sqrt()
    }
    /// Position, relative to the eye, and normal.
    #[inline(always)]
    pub fn at(&self, k: usize) -> (DVec3, DVec3) {
        let i = self.indices[k] as usize;
        let double = |v: [f32; 3]| Vec3::from_array(v).as_dvec3();
        (self.moved + double(self.points[i]), double(self.normals[i]))
    }
    /// At most so many of them, evenly chosen.
    pub fn some(&self, count: usize) -> impl Iterator<Item = (DVec3, DVec3)> + use<'_, 'a> {
        (0..self.len()).step_by(self.len().div_ceil(count).max(1)).map(|k| self.at(k))
    }
    /// Points and normals of at most a run, axis by axis; what is missing repeats the first.
    #[inline(always)]
    fn axis_by_axis(&self, indices: &[u32]) -> ([[f32; RUN]; 3], [[f32; RUN]; 3]) {
        let (mut p, mut n) = ([[0.0; RUN]; 3], [[0.0; RUN]; 3]);
        for j in 0..RUN {
            let i = *indices.get(j).unwrap_or(&indices[0]) as usize;
            let (point, normal) = (self.points[i], self.normals[i]);
            for axis in 0..3 {
                p[axis][j] = point[axis];
                n[axis][j] = normal[axis];
            }
        }
        (p, n)
    }
    /// Positions, relative to the eye, and normals of a run, axis by axis: [`Chosen::at`].
    #[inline(always)]
    pub fn side_by_side(&self, run: &Run) -> ([[f64; RUN]; 3], [[f64; RUN]; 3]) {
        let (single, normals) = self.axis_by_axis(&self.indices[run.first..run.end]);
        let (moved, mut p, mut n) = (self.moved.to_array(), [[0.0; RUN]; 3], [[0.0; RUN]; 3]);
        for axis in 0..3 {
            for j in 0..RUN {
                p[axis][j] = moved[axis] + f64::from(single[axis][j]);
                n[axis][j] = f64::from(normals[axis][j]);
            }
        }
        (p, n)
    }
    /// The samples of a run.
    pub fn of_run(&self, run: &Run) -> impl Iterator<Item = (DVec3, DVec3)> + use<'_, 'a> {
        (run.first..run.end).map(|k| self.at(k))
    }
}

dispatch! {
    /// The runs of some samples, seen along parallel rays where a direction is given.
    fn find_runs(chosen: &Chosen, parallel: Option<Vec3>, runs: &mut Vec<Run>) = find_runs_body
}

#[inline(always)]
fn find_runs_body(chosen: &Chosen, parallel: Option<Vec3>, runs: &mut Vec<Run>) {
    let (moved, single) = (chosen.moved, chosen.moved.as_vec3());
    let way = single.to_array();
    for (k, indices) in chosen.indices.chunks(RUN).enumerate() {
        let (p, n) = chosen.axis_by_axis(indices);
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for axis in 0..3 {
            low[axis] = most(&p[axis], |a, b| a < b);
            high[axis] = most(&p[axis], |a, b| a > b);
        }
        let mut off_planes = [0.0; RUN];
        for j in 0..RUN {
            let product = match parallel {
                None => n[0][j] * (way[0] + p[0][j]) + n[1][j] * (way[1] + p[1][j]) + n[2][j] * (way[2] + p[2][j]),
                Some(forward) => n[0][j] * forward.x + n[1][j] * forward.y + n[2][j] * forward.z,
            };
            off_planes[j] = product.abs();
        }
        let off_plane = most(&off_planes, |a, b| a < b);
        let [low, high] = [low, high].map(|p| Vec3::from_array(p).as_dvec3());
        let (middle, farthest) = (moved + 0.5 * (low + high), moved.abs() + low.abs().max(high.abs()));
        // By rounding a sample, or a product of it, may have a little more than its box.
        let half = 0.5 * (high - low) + 8.0 * f64::EPSILON * farthest;
        let reach = if parallel.is_some() { 1.0 } else { farthest.length() + moved.length() };
        // A NaN, of numbers beyond f32, is no bound at all.
        let off_plane = (f64::from(off_plane) - PRODUCT_ERROR * reach).max(0.0);
        runs.push(Run { first: RUN * k, end: RUN * k + indices.len(), middle, half, off_plane });
    }
}

/// The number that is before all others, in halves, as vector instructions do it; a NaN where there is one.
#[inline(always)]
fn most(x: &[f32; RUN], is_before: impl Fn(f32, f32) -> bool) -> f32 {
    const { assert!(RUN == 16) };
    let (mut eight, mut four) = ([0.0; 8], [0.0; 4]);
    let first = |a: f32, b: f32| if is_before(a, b) | a.is_nan() { a } else { b };
    for i in 0..8 {
        eight[i] = first(x[i], x[i + 8]);
    }
    for i in 0..4 {
        four[i] = first(eight[i], eight[i + 4]);
    }
    first(first(four[0], four[2]), first(four[1], four[3]))
}

impl Run {
    /// Samples in it.
    pub fn len(&self) -> usize {
        self.end - self.first
    }
    /// The least and the most of a product with an axis.
    #[inline(always)]
    pub fn range(&self, axis: DVec3) -> [f64; 2] {
        let (middle, half) = (axis.dot(self.middle), axis.abs().dot(self.half));
        [middle - half, middle + half]
    }
    /// Camera depths of their pixels, out to the corners, at the least and at the most.
    pub fn depths(&self, picture: &Picture) -> [f64; 2] {
        picture.depths_within(self.range(picture.camera.forward()), self.off_plane)
    }
    /// How far a corner of a pixel of theirs lies from its sample at the most.
    #[inline(always)]
    pub fn reach(&self, picture: &Picture) -> f64 {
        picture.reach_within(self.range(picture.camera.forward())[1], self.off_plane)
    }
}
