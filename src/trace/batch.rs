//! Many rays at once.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::hierarchy::{Inner, Tracer};
use super::kernel::Kernel;
use super::rays::{ALL, BUNDLE, Each, RayBits, WorldRays};
use super::rows::{RUN, Runs, bundles, row_of};
use super::walk::{Blocked, Closest, Stack, Stacks, Touched, first_of_ties, tie_reach, traverse_together};
use crate::error::{Error, Result};
use crate::memory::filled;
use crate::progress::Progress;

/// What a ray meets first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Where: `origin + t * direction`; infinite where the ray meets nothing.
    pub t: f64,
    /// Index of the triangle in the mesh of its instance; -1 for nothing.
    pub triangle: i32,
    /// Index of the instance; -1 for nothing.
    pub instance: i32,
}

impl Hit {
    /// Of a ray that meets nothing.
    pub const NONE: Self = Self { t: f64::INFINITY, triangle: -1, instance: -1 };
}

/// Rays of a task, at least: a fraction of a millisecond of work, so that a stop is heeded soon. Of an image, four rows at least.
const CHUNK: usize = 2048;

impl Tracer {
    /// What each ray meets first, for `t > 0`, in the order of the rays.
    ///
    /// World coordinates; directions of any length above 0. Both sides of every triangle count, its edges included, so
    /// a closed mesh has no gaps; triangles without area are never met. Of several triangles that are met together, the one
    /// of the lowest instance and then of the lowest index: all those whose planes pass through the first point, up to the
    /// rounding of f64. So of coplanar triangles the answer depends neither on rounding nor on their order.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for arrays of different lengths, a row that is not finite, a zero direction;
    /// [`Error::Interrupted`].
    pub fn first_hit(&self, origins: &[[f64; 3]], directions: &[[f64; 3]], progress: &Progress) -> Result<Vec<Hit>> {
        check_lengths(origins, directions)?;
        let rays = Rays { origins, directions, t_max: None, row: row_of(origins, directions) };
        run(rays, progress, Hit::NONE, |rays, out| first_hits(&self.inner, rays, out))
    }

    /// Whether each ray meets anything for `0 < t < t_max`, in the order of the rays.
    ///
    /// Arguments as for [`Tracer::first_hit`]; `t_max` may be infinite.
    ///
    /// # Errors
    /// As [`Tracer::first_hit`], and [`Error::InvalidArgument`] for a NaN in `t_max`.
    pub fn occluded(
        &self,
        origins: &[[f64; 3]],
        directions: &[[f64; 3]],
        t_max: &[f64],
        progress: &Progress,
    ) -> Result<Vec<bool>> {
        check_lengths(origins, directions)?;
        if t_max.len() != origins.len() {
            let expected = format!("{} values, one a ray", origins.len());
            return Err(Error::argument("t_max", expected, t_max.len(), "give one limit for each ray"));
        }
        // Shadow rays start from the same pixels, but those that see nothing are mostly left out, so that no rows are left.
        let rays = Rays { origins, directions, t_max: Some(t_max), row: None };
        run(rays, progress, false, |rays, out| blocked(&self.inner, rays, out))
    }
}

/// A run of rays.
#[derive(Clone, Copy)]
struct Rays<'a> {
    origins: &'a [[f64; 3]],
    directions: &'a [[f64; 3]],
    t_max: Option<&'a [f64]>,
    /// How many make a row of an image, where they come so.
    row: Option<usize>,
}

impl<'a> Rays<'a> {
    fn part(&self, start: usize, len: usize) -> Self {
        let range = start..start + len;
        Self {
            origins: &self.origins[range.clone()],
            directions: &self.directions[range.clone()],
            t_max: self.t_max.map(|t| &t[range]),
            row: self.row,
        }
    }
    /// The first ray that has no answer.
    fn first_bad(&self) -> Option<usize> {
        let t_max = self.t_max.unwrap_or_default();
        let rays = if all_finite(self.origins.as_flattened()) && all_finite(self.directions.as_flattened()) {
            self.directions.iter().position(|d| (d[0] == 0.0) & (d[1] == 0.0) & (d[2] == 0.0))
        } else {
            let is_finite = |row: &[f64; 3]| row.iter().all(|x| x.is_finite());
            let is_good = |i: usize| {
                is_finite(&self.origins[i]) && is_finite(&self.directions[i]) && self.directions[i] != [0.0; 3]
            };
            (0..self.origins.len()).find(|&i| !is_good(i))
        };
        let limits = t_max.iter().position(|t| t.is_nan());
        rays.into_iter().chain(limits).min()
    }
    fn error_of(&self, row: usize) -> Error {
        let (origin, direction) = (self.origins[row], self.directions[row]);
        let fix = "leave the ray out";
        if !origin.iter().all(|x| x.is_finite()) {
            return Error::argument(format!("origins[{row}]"), "three finite numbers", format!("{origin:?}"), fix);
        }
        if !direction.iter().all(|x| x.is_finite()) || direction == [0.0; 3] {
            let expected = "three finite numbers, not all zero";
            return Error::argument(format!("directions[{row}]"), expected, format!("{direction:?}"), fix);
        }
        Error::argument(format!("t_max[{row}]"), "a number", "NaN", "give infinity for a ray without end")
    }
}

fn run<'a, T: Copy + Send + Sync>(
    rays: Rays<'a>,
    progress: &Progress,
    nothing: T,
    work: impl Fn(Rays<'a>, &mut [T]) + Sync,
) -> Result<Vec<T>> {
    let count = rays.origins.len();
    let mut out = Vec::with_capacity(count);
    progress.set_total(count as u64);
    // Rays are checked where they are traced, on all cores and while they are in the cache. The first bad row is told
    // however the work is divided: only chunks behind a bad row are left out.
    let bad = AtomicUsize::new(usize::MAX);
    // Whole rows of squares.
    let size = rays.row.map_or(CHUNK, |row| CHUNK.next_multiple_of(RUN * row));
    let chunks = out.spare_capacity_mut()[..count].par_chunks_mut(size);
    chunks.enumerate().try_for_each(|(chunk, out)| {
        progress.check()?;
        let first = chunk * size;
        let rays = rays.part(first, out.len());
        // Memory is first touched here, on all cores.
        let out = filled(out, nothing);
        if first < bad.load(Ordering::Relaxed) {
            match rays.first_bad() {
                Some(row) => {
                    bad.fetch_min(first + row, Ordering::Relaxed);
                }
                None => work(rays, out),
            }
        }
        progress.advance(out.len() as u64);
        Ok(())
    })?;
    // Also for no ray at all.
    progress.check()?;
    match bad.into_inner() {
        usize::MAX => {}
        row => return Err(rays.error_of(row)),
    }
    // SAFETY: every chunk was filled.
    unsafe { out.set_len(count) };
    Ok(out)
}

/// Whether all are finite, eight at a time and without branches: zero times a number is zero, and of infinities and NaN it is
/// not a number.
fn all_finite(x: &[f64]) -> bool {
    let (eights, rest) = x.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for eight in eights {
        for (sum, x) in sums.iter_mut().zip(eight) {
            *sum += x * 0.0;
        }
    }
    sums.iter().chain(rest).all(|x| x * 0.0 == 0.0)
}

fn check_lengths(origins: &[[f64; 3]], directions: &[[f64; 3]]) -> Result<()> {
    if origins.len() != directions.len() {
        let expected = format!("{} rows, one for each origin", origins.len());
        return Err(Error::argument("directions", expected, directions.len(), "give one direction for each origin"));
    }
    Ok(())
}

/// A bundle of rays, and which of them are there; one that the rays do not fill is in a row, and repeats its last.
#[inline(always)]
fn bundle(rays: &Rays, runs: Runs, scene_origin: DVec3) -> (WorldRays<BUNDLE>, RayBits) {
    let (count, scene_origin) = (rays.origins.len(), scene_origin.to_array());
    let mut world = WorldRays::UNSET;
    let mut set = |first: usize, origins: &[[f64; 3]; RUN], directions: &[[f64; 3]; RUN]| {
        for k in 0..RUN {
            for a in 0..3 {
                world.origin[a][first + k] = origins[k][a] - scene_origin[a];
                world.direction[a][first + k] = directions[k][a];
            }
        }
    };
    for first in (0..BUNDLE).step_by(RUN) {
        let at = runs.index(first).min(count);
        match (rays.origins[at..].first_chunk(), rays.directions[at..].first_chunk()) {
            (Some(origins), Some(directions)) => set(first, origins, directions),
            _ => {
                let repeated = |of: &[[f64; 3]]| std::array::from_fn(|k| of[(at + k).min(count - 1)]);
                set(first, &repeated(rays.origins), &repeated(rays.directions));
            }
        }
    }
    (world, ALL >> BUNDLE.saturating_sub(count - runs.first))
}

#[inline(always)]
fn first_hits_with<K: Kernel>(scene: &Inner, rays: Rays, out: &mut [Hit]) {
    let (mut stacks, mut stack) = (Stacks::default(), Stack::new());
    let nothing = Closest::<false>::new(0.0, f64::INFINITY, 0.0);
    for runs in bundles(out.len(), rays.row) {
        let (world, bits) = bundle(&rays, runs, scene.scene.origin());
        let mut closest = [nothing; BUNDLE];
        for (closest, tie) in closest.iter_mut().zip(tie_reach(scene, &world)) {
            *closest = nothing.with_ties(tie);
        }
        traverse_together::<K, _>(scene, &world, bits, &mut closest, &mut stacks);
        for r in Each(bits) {
            let Closest { t, face: Some(first), is_tied, .. } = closest[r] else { continue };
            let (instance, triangle) = if is_tied {
                first_of_ties::<K>(scene, &world.get(r), (t, first), f64::INFINITY, &mut stack)
            } else {
                first
            };
            out[runs.index(r)] = Hit { t, triangle: triangle as i32, instance: instance as i32 };
        }
    }
}

#[inline(always)]
fn blocked_with<K: Kernel>(scene: &Inner, rays: Rays, out: &mut [bool]) {
    let mut stacks = Stacks::default();
    for (i, out) in out.chunks_mut(BUNDLE).enumerate() {
        let (world, bits) = bundle(&rays, Runs::in_a_row(i * BUNDLE), scene.scene.origin());
        let free = Blocked { t_max: f64::INFINITY, except: None, touched: Touched::NONE };
        let mut blocked = [free; BUNDLE];
        for (blocked, t_max) in blocked.iter_mut().zip(rays.t_max.unwrap_or_default().iter().skip(i * BUNDLE)) {
            blocked.t_max = *t_max;
        }
        let ended = traverse_together::<K, _>(scene, &world, bits, &mut blocked, &mut stacks);
        for (r, out) in out.iter_mut().enumerate() {
            *out = (ended >> r) & 1 != 0;
        }
    }
}

super::kernel::dispatched! {
    fn first_hits(scene: &Inner, rays: Rays<'_>, out: &mut [Hit]) = first_hits_with;
    fn blocked(scene: &Inner, rays: Rays<'_>, out: &mut [bool]) = blocked_with;
}
