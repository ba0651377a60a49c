//! Some of the samples in the order of the picture, and boxes around runs of neighbours: of a million samples most lie so far
//! inside of what is asked for that a box answers for all of its run.

use glam::{DVec3, Vec3};

use super::picture::Picture;

/// Samples in a run. Chosen because shorter runs cost more boxes, and longer ones have boxes that stick out more often.
const RUN: usize = 16;

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
        let single = moved.as_vec3();
        let parallel = picture.filter(|p| p.camera.is_orthographic()).map(|p| p.camera.forward().as_vec3());
        let run = |k: usize| {
            let (first, end) = (RUN * k, (RUN * (k + 1)).min(indices.len()));
            let (mut low, mut high, mut off_plane) = (Vec3::INFINITY, Vec3::NEG_INFINITY, f32::INFINITY);
            for &i in &indices[first..end] {
                let [p, n] = [points[i as usize], normals[i as usize]].map(Vec3::from_array);
                (low, high) = (low.min(p), high.max(p));
                off_plane = off_plane.min(n.dot(parallel.unwrap_or(single + p)).abs());
            }
            let [low, high] = [low, high].map(|p| p.as_dvec3());
            let (middle, farthest) = (moved + 0.5 * (low + high), moved.abs() + low.abs().max(high.abs()));
            // By rounding a sample, or a product of it, may have a little more than its box.
            let half = 0.5 * (high - low) + 8.0 * f64::EPSILON * farthest;
            let reach = if parallel.is_some() { 1.0 } else { farthest.length() + moved.length() };
            // A NaN, of numbers beyond f32, is no bound at all.
            let off_plane = (f64::from(off_plane) - PRODUCT_ERROR * reach).max(0.0);
            Run { first, end, middle, half, off_plane }
        };
        Self { points, normals, indices, picture, moved, runs: (0..indices.len().div_ceil(RUN)).map(run).collect() }
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
    /// The samples of a run.
    pub fn of_run(&self, run: &Run) -> impl Iterator<Item = (DVec3, DVec3)> + use<'_, 'a> {
        (run.first..run.end).map(|k| self.at(k))
    }
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
