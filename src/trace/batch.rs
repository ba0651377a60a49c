//! Many rays at once.

use glam::DVec3;
use rayon::prelude::*;

use super::kernel::Kernel;
use super::tracer::{Inner, Tracer};
use super::traverse::{Blocked, Closest, Stack, WorldRay, traverse};
use crate::error::{Error, Result};
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

/// Rays of a task: about a millisecond of work, so that a stop is heeded soon.
const CHUNK: usize = 2048;

impl Tracer {
    /// What each ray meets first, for `t > 0`, in the order of the rays.
    ///
    /// World coordinates; directions of any length above 0. Both sides of every triangle count, its edges included, so
    /// a closed mesh has no gaps; triangles without area are never met. Of several triangles at the same t, the one of
    /// the lowest instance and then of the lowest index.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for arrays of different lengths, a row that is not finite, a zero direction;
    /// [`Error::Interrupted`].
    pub fn first_hit(&self, origins: &[[f64; 3]], directions: &[[f64; 3]], progress: &Progress) -> Result<Vec<Hit>> {
        check_rays(origins, directions)?;
        let rays = Rays { origins, directions, t_max: None };
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
        check_rays(origins, directions)?;
        if t_max.len() != origins.len() {
            let expected = format!("{} values, one a ray", origins.len());
            return Err(Error::argument("t_max", expected, t_max.len(), "give one limit for each ray"));
        }
        if let Some(row) = t_max.iter().position(|t| t.is_nan()) {
            let fix = "give infinity for a ray without end";
            return Err(Error::argument(format!("t_max[{row}]"), "a number", "NaN", fix));
        }
        let rays = Rays { origins, directions, t_max: Some(t_max) };
        run(rays, progress, false, |rays, out| blocked(&self.inner, rays, out))
    }
}

/// A run of rays.
#[derive(Clone, Copy)]
struct Rays<'a> {
    origins: &'a [[f64; 3]],
    directions: &'a [[f64; 3]],
    t_max: Option<&'a [f64]>,
}

impl<'a> Rays<'a> {
    fn part(&self, start: usize, len: usize) -> Self {
        let range = start..start + len;
        Self {
            origins: &self.origins[range.clone()],
            directions: &self.directions[range.clone()],
            t_max: self.t_max.map(|t| &t[range]),
        }
    }
    /// Relative to the scene's origin.
    fn ray(&self, i: usize, scene_origin: DVec3) -> WorldRay {
        WorldRay {
            origin: DVec3::from_array(self.origins[i]) - scene_origin,
            direction: DVec3::from_array(self.directions[i]),
        }
    }
}

fn run<'a, T: Copy + Send>(
    rays: Rays<'a>,
    progress: &Progress,
    nothing: T,
    work: impl Fn(Rays<'a>, &mut [T]) + Sync,
) -> Result<Vec<T>> {
    let mut out = vec![nothing; rays.origins.len()];
    progress.set_total(out.len() as u64);
    out.par_chunks_mut(CHUNK).enumerate().try_for_each(|(chunk, out)| {
        progress.check()?;
        work(rays.part(chunk * CHUNK, out.len()), out);
        progress.advance(out.len() as u64);
        Ok(())
    })?;
    // Also for no ray at all.
    progress.check()?;
    Ok(out)
}

fn check_rays(origins: &[[f64; 3]], directions: &[[f64; 3]]) -> Result<()> {
    if origins.len() != directions.len() {
        let expected = format!("{} rows, one for each origin", origins.len());
        return Err(Error::argument("directions", expected, directions.len(), "give one direction for each origin"));
    }
    let finite = |row: &[f64; 3]| row.iter().all(|x| x.is_finite());
    for (row, (origin, direction)) in origins.iter().zip(directions).enumerate() {
        if !finite(origin) {
            let fix = "leave the ray out";
            return Err(Error::argument(format!("origins[{row}]"), "three finite numbers", format!("{origin:?}"), fix));
        }
        if !finite(direction) || *direction == [0.0; 3] {
            let expected = "three finite numbers, not all zero";
            let fix = "leave the ray out";
            return Err(Error::argument(format!("directions[{row}]"), expected, format!("{direction:?}"), fix));
        }
    }
    Ok(())
}

#[inline(always)]
fn first_hits_with<K: Kernel>(scene: &Inner, rays: Rays, out: &mut [Hit]) {
    let origin = scene.scene.origin();
    let mut stack = Stack::new();
    for (i, out) in out.iter_mut().enumerate() {
        let mut closest = Closest::<false>::new(0.0, f64::INFINITY, 0.0);
        traverse::<K, _>(scene, &rays.ray(i, origin), &mut closest, &mut stack);
        if let Some((instance, triangle)) = closest.face {
            *out = Hit { t: closest.t, triangle: triangle as i32, instance: instance as i32 };
        }
    }
}

#[inline(always)]
fn blocked_with<K: Kernel>(scene: &Inner, rays: Rays, out: &mut [bool]) {
    let origin = scene.scene.origin();
    let mut stack = Stack::new();
    for (i, out) in out.iter_mut().enumerate() {
        let t_max = rays.t_max.map_or(f64::INFINITY, |t| t[i]);
        let mut blocked = Blocked { t_min: 0.0, t_max, except: None };
        *out = traverse::<K, _>(scene, &rays.ray(i, origin), &mut blocked, &mut stack);
    }
}

super::kernel::dispatched! {
    fn first_hits(scene: &Inner, rays: Rays<'_>, out: &mut [Hit]) = first_hits_with;
    fn blocked(scene: &Inner, rays: Rays<'_>, out: &mut [bool]) = blocked_with;
}
