//! Triangles that a ray meets together: of coplanar ones the answer must not be a matter of rounding.
//!
//! Where two triangles lie in one plane, which of both computed distances is the smaller changes from ray to ray. So all
//! whose planes pass through the first point, as far as double precision can tell, are met together; the lowest
//! instance and then the lowest triangle is the answer, whatever the order in which they are visited.

use glam::DVec3;

use super::one_ray::{Stack, traverse_one};
use super::visitors::Visitor;
use crate::trace::hierarchy::{Face, Inner};
use crate::trace::kernel::{Kernel, Pass};
use crate::trace::rays::{Shared, WorldRay, WorldRays, largest_of};

/// f64 roundings of a point on a ray relative to the distance of its origin: position, direction (4), t (8).
const RAY_ERROR: f64 = 16.0 * (f64::EPSILON / 2.0);
/// Both triangles, and the point where the first is met: three errors of at most the one that is derived.
const ERRORS: f64 = 3.0;
/// How far along the ray a tie is looked for, in units of the error across a plane: triangles seen at less than the
/// inverse of it, in radians, may be told apart by rounding.
const OBLIQUE: f64 = (1u32 << 20) as f64;

/// Bound on what separates coplanar triangles after rounding, across their plane, world units; the origin of the ray is so far from
/// the scene's.
#[inline(always)]
fn rounding(scene: &Inner, distance: f64) -> f64 {
    let of_ray = RAY_ERROR * distance;
    ERRORS * if scene.surface_error > of_ray { scene.surface_error } else { of_ray }
}

/// Rays whose speeds differ by more have each a tie of its own.
const MOST_APART: f64 = 1024.0;

/// How much farther along each ray a triangle may be met that ties with the first, in units of t: at least as far, of rays that are
/// alike as far as for the slowest and farthest of them, which takes one division. [`first_of_ties`] then finds that there is none.
#[inline(always)]
pub fn tie_reach<const N: usize>(scene: &Inner, rays: &WorldRays<N>) -> [f64; N] {
    // Not lengths, so that the square of a tiny direction does not underflow.
    let (distance, speed) = (largest_of(&rays.origin), largest_of(&rays.direction));
    let (mut farthest, mut slowest, mut fastest) = (distance[0], speed[0], speed[0]);
    for r in 1..N {
        farthest = if distance[r] > farthest { distance[r] } else { farthest };
        slowest = if speed[r] < slowest { speed[r] } else { slowest };
        fastest = if speed[r] > fastest { speed[r] } else { fastest };
    }
    let mut reach = [OBLIQUE * rounding(scene, farthest) / slowest; N];
    if fastest > MOST_APART * slowest {
        for r in 0..N {
            reach[r] = OBLIQUE * rounding(scene, distance[r]) / speed[r];
        }
    }
    reach
}

/// All hits from one t to another.
#[derive(Clone)]
struct Gathered {
    range: [f64; 2],
    hits: Vec<(f64, Face)>,
}

impl Visitor for Gathered {
    const IN_ORDER: bool = false;
    const AHEAD: bool = false;
    const NEARLY: bool = false;
    const SHARED: Shared = Shared::Nothing;

    fn range(&self) -> [f64; 2] {
        self.range
    }
    fn band(&self) -> f64 {
        0.0
    }
    fn see(&mut self, face: Face, Pass { t, .. }: Pass) -> bool {
        if (self.range[0]..=self.range[1]).contains(&t) {
            self.hits.push((t, face));
        }
        false
    }
}

/// The face to name of those that tie with the first, `first` at `t`; the others lie before `t_max`.
#[cold]
#[inline(never)]
pub fn first_of_ties<K: Kernel>(
    scene: &Inner,
    ray: &WorldRay,
    (t, first): (f64, Face),
    t_max: f64,
    stack: &mut Stack,
) -> Face {
    let [reach] = tie_reach(scene, &WorldRays::from([*ray]));
    let mut gathered = Gathered { range: [t, t + reach], hits: Vec::new() };
    traverse_one::<K, _>(scene, ray, &mut gathered, stack);
    let point = ray.origin + t * ray.direction;
    let rounding = rounding(scene, ray.origin.abs().max_element());
    let ties = |&(at, face): &(f64, Face)| {
        let corners = scene.corners(face.0, face.1);
        at == t || (at < t_max && unit_normal(&corners).is_some_and(|n| n.dot(point - corners[0]).abs() <= rounding))
    };
    let found = gathered.hits.iter().filter(|hit| ties(hit)).map(|&(_, face)| face).min();
    found.map_or(first, |face| face.min(first))
}

/// None for a triangle whose area vanishes in f64.
fn unit_normal([a, b, c]: &[DVec3; 3]) -> Option<DVec3> {
    let (ab, ac) = (*b - *a, *c - *a);
    let scale = ab.abs().max(ac.abs()).max_element();
    (ab / scale).cross(ac / scale).try_normalize()
}
