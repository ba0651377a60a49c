//! Many rays at once.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::hierarchy::{Inner, Tracer};
use super::kernel::Kernel;
use super::nearby::{MOST, Nearby, Order};
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
    /// Whether a ray has an answer.
    fn is_good(&self, ray: usize) -> bool {
        let is_finite = |row: &[f64; 3]| row.iter().all(|x| x.is_finite());
        let direction = &self.directions[ray];
        let has_limit = self.t_max.is_none_or(|t| !t[ray].is_nan());
        is_finite(&self.origins[ray]) && is_finite(direction) && *direction != [0.0; 3] && has_limit
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
    work: impl Fn(Rays<'a>, &mut [T]) -> bool + Sync,
) -> Result<Vec<T>> {
    let count = rays.origins.len();
    let mut out = Vec::with_capacity(count);
    progress.set_total(count as u64);
    // Rays are checked where they are traced, bundle by bundle, on all cores. The first bad row is told however the work is
    // divided: only chunks behind a bad row are left out.
    let bad = AtomicUsize::new(usize::MAX);
    let size = match (rays.t_max, rays.row) {
        // Of shadow rays, which start from the same pixels, those that see nothing are mostly left out, so that no rows are left.
        (Some(_), _) => MOST,
        // Whole rows of squares.
        (None, Some(row)) => CHUNK.next_multiple_of(RUN * row),
        (None, None) => CHUNK,
    };
    let chunks = out.spare_capacity_mut()[..count].par_chunks_mut(size);
    chunks.enumerate().try_for_each(|(chunk, out)| {
        progress.check()?;
        let first = chunk * size;
        let rays = rays.part(first, out.len());
        // Memory is first touched here, on all cores.
        let out = filled(out, nothing);
        if first < bad.load(Ordering::Relaxed)
            && !work(rays, out)
            && let Some(row) = (0..out.len()).find(|&i| !rays.is_good(i))
        {
            bad.fetch_min(first + row, Ordering::Relaxed);
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

fn check_lengths(origins: &[[f64; 3]], directions: &[[f64; 3]]) -> Result<()> {
    if origins.len() != directions.len() {
        let expected = format!("{} rows, one for each origin", origins.len());
        return Err(Error::argument("directions", expected, directions.len(), "give one direction for each origin"));
    }
    Ok(())
}

/// Takes up a bundle of rays; one that the rays do not fill repeats the last. The rays that are there; none where not all of them
/// have an answer.
#[inline(always)]
fn fill(world: &mut WorldRays<BUNDLE>, rays: &Rays, runs: Runs, scene_origin: DVec3) -> Option<RayBits> {
    let (count, scene_origin) = (rays.origins.len(), scene_origin.to_array());
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
    let bits = ALL >> BUNDLE.saturating_sub(count - runs.first);
    (is_sound(world) || are_good(rays, bits, |r| runs.index(r))).then_some(bits)
}

/// Takes up a bundle of rays that lie apart. The rays that are there; none where not all of them have an answer.
#[inline(always)]
fn gather(world: &mut WorldRays<BUNDLE>, rays: &Rays, some: Nearby, scene_origin: DVec3) -> Option<RayBits> {
    let scene_origin = scene_origin.to_array();
    for r in 0..BUNDLE {
        let (origin, direction) = (&rays.origins[some.index(r)], &rays.directions[some.index(r)]);
        for a in 0..3 {
            world.origin[a][r] = origin[a] - scene_origin[a];
            world.direction[a][r] = direction[a];
        }
    }
    let bits = some.bits();
    (is_sound(world) || are_good(rays, bits, |r| some.index(r))).then_some(bits)
}

/// Whether all rays of a bundle are numbers with a direction, as far as can be told at once.
#[inline(always)]
fn is_sound(world: &WorldRays<BUNDLE>) -> bool {
    // Zero times a number is zero, of either sign, and of infinities and NaN it is not a number; side by side, without branches.
    let mut wrong = 0;
    let ([u, v, w], [x, y, z]) = (&world.origin, &world.direction);
    for r in 0..BUNDLE {
        let sum = ((u[r] * 0.0 + v[r] * 0.0) + w[r] * 0.0) + ((x[r] * 0.0 + y[r] * 0.0) + z[r] * 0.0);
        wrong |= (sum.to_bits() << 1) | u64::from((x[r] == 0.0) & (y[r] == 0.0) & (z[r] == 0.0));
    }
    wrong == 0
}

/// Whether each of some rays has an answer. Those whose way from the scene's origin is longer than f64 tells have one, too.
#[cold]
#[inline(never)]
fn are_good(rays: &Rays, bits: RayBits, index: impl Fn(usize) -> usize) -> bool {
    Each(bits).all(|r| rays.is_good(index(r)))
}

#[inline(always)]
fn first_hits_with<K: Kernel>(scene: &Inner, rays: Rays, out: &mut [Hit]) -> bool {
    let (mut stacks, mut stack, mut world) = (Stacks::default(), Stack::new(), WorldRays::UNSET);
    let nothing = Closest::<false>::new(0.0, f64::INFINITY, 0.0);
    for runs in bundles(out.len(), rays.row) {
        let Some(bits) = fill(&mut world, &rays, runs, scene.scene.origin()) else { return false };
        let ties = tie_reach(scene, &world);
        let mut closest = [nothing; BUNDLE];
        for r in 0..BUNDLE {
            closest[r].note_ties(ties[r]);
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
    true
}

#[inline(always)]
fn blocked_with<K: Kernel>(scene: &Inner, rays: Rays, out: &mut [bool]) -> bool {
    let (mut stacks, mut world) = (Stacks::default(), WorldRays::UNSET);
    let t_max = rays.t_max.unwrap_or_default();
    if t_max.iter().any(|t| t.is_nan()) {
        return false;
    }
    for some in Order::new(rays.origins, rays.directions).bundles() {
        let Some(bits) = gather(&mut world, &rays, some, scene.scene.origin()) else { return false };
        let mut blocked = [Blocked { t_max: f64::INFINITY, except: None, touched: Touched::NONE }; BUNDLE];
        for r in Each(bits) {
            blocked[r].t_max = t_max[some.index(r)];
        }
        let ended = traverse_together::<K, _>(scene, &world, bits, &mut blocked, &mut stacks);
        for r in Each(bits) {
            out[some.index(r)] = (ended >> r) & 1 != 0;
        }
    }
    true
}

super::kernel::dispatched! {
    fn first_hits(scene: &Inner, rays: Rays<'_>, out: &mut [Hit]) -> bool = first_hits_with;
    fn blocked(scene: &Inner, rays: Rays<'_>, out: &mut [bool]) -> bool = blocked_with;
}
