//! The boxes of a scene's instances: of each a hull that is quick to find, of all together the exact one.
//!
//! A million instances have hundreds of millions of vertices, of which a few bound the scene. Instances whose hull lies
//! within what others bound are not looked at; the box of the rest is that of their vertices, bit for bit.

use glam::{DAffine3, DVec3};
use rayon::prelude::*;

use super::Mesh;
use crate::error::Result;
use crate::geometry::Aabb;
use crate::progress::Progress;

/// Vertices between two looks at whether to go on: about a millisecond of work.
const AT_ONCE: usize = 1 << 16;

/// Roundings between a hull and the vertices in it, relative to the terms. Derived from f64: a product and three sums each
/// way, 2^-53 each, doubled.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// The hull of a placed mesh.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hull {
    /// Holds all vertices.
    pub bounds: Aabb,
    /// Axes along which it is the vertices' own extent: world coordinates that follow one local axis, which rounding keeps in
    /// order.
    exact: [bool; 3],
}

impl Hull {
    pub fn new(mesh: &Mesh, world_from_local: &DAffine3) -> Self {
        let local = mesh.bounds_local();
        let (center, half) = (local.center(), 0.5 * local.extent());
        let m = &world_from_local.matrix3;
        let middle = world_from_local.transform_point3(center);
        let (mut bounds, mut exact) = (Aabb { min: middle, max: middle }, [false; 3]);
        let corners = [local.min, local.max].map(|p| [0, 1, 2].map(|k| world_from_local.transform_point3(alone(p, k))));
        for axis in 0..3 {
            let row = m.row(axis);
            let others = row.to_array().iter().filter(|x| **x != 0.0).count();
            if others <= 1 {
                let along = row.to_array().iter().position(|x| *x != 0.0).unwrap_or(0);
                let ends = corners.map(|c| c[along][axis]);
                (bounds.min[axis], bounds.max[axis]) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
                exact[axis] = true;
                continue;
            }
            let reach = row.abs().dot(half);
            let terms = row.abs().dot(center.abs()) + reach + world_from_local.translation[axis].abs();
            bounds.min[axis] -= reach + ROUNDING * terms;
            bounds.max[axis] += reach + ROUNDING * terms;
        }
        Self { bounds, exact }
    }

    /// What of its extent is the vertices' own.
    fn known(&self) -> Aabb {
        let mut known = Aabb::EMPTY;
        for axis in (0..3).filter(|axis| self.exact[*axis]) {
            (known.min[axis], known.max[axis]) = (self.bounds.min[axis], self.bounds.max[axis]);
        }
        known
    }

    /// Whether vertices may lie outside of a box. Written so that a NaN may.
    fn may_exceed(&self, found: &Aabb) -> bool {
        (0..3).any(|axis| {
            let within = self.bounds.min[axis] >= found.min[axis] && self.bounds.max[axis] <= found.max[axis];
            !(within || self.exact[axis])
        })
    }
}

/// A point with one coordinate of another, the others 0.
fn alone(p: DVec3, axis: usize) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|k| if k == axis { p[k] } else { 0.0 }))
}

/// The box of all vertices of the instances with these hulls; `placed` gives the mesh of one and where it is.
pub(super) fn bounds_of<'a>(
    hulls: &[Hull],
    placed: impl Fn(usize) -> (&'a Mesh, DAffine3) + Sync,
    progress: &Progress,
) -> Result<Aabb> {
    let exact = |i: usize| {
        let (mesh, world_from_local) = placed(i);
        let mut bounds = Aabb::EMPTY;
        for points in mesh.positions_local().chunks(AT_ONCE) {
            progress.check()?;
            let points = points.iter().map(|p| world_from_local.transform_point3(p.as_dvec3()));
            bounds = bounds.union(Aabb::from_points(points));
        }
        Ok(bounds)
    };
    let empty = || Aabb::EMPTY;
    let mut found = hulls.par_iter().map(Hull::known).reduce(empty, Aabb::union);
    // The instances that reach out farthest bound most of the rest. Each is looked at once: often one reaches farthest all around.
    let mut farthest = Vec::new();
    for axis in 0..3 {
        progress.check()?;
        let key = |i: &usize, sign: f64| {
            let b = &hulls[*i].bounds;
            if sign < 0.0 { -b.min[axis] } else { b.max[axis] }
        };
        for sign in [-1.0, 1.0] {
            farthest.extend((0..hulls.len()).into_par_iter().max_by(|a, b| key(a, sign).total_cmp(&key(b, sign))));
        }
    }
    farthest.sort_unstable();
    farthest.dedup();
    for &i in &farthest {
        if hulls[i].may_exceed(&found) {
            found = found.union(exact(i)?);
        }
    }
    progress.check()?;
    let rest = hulls.par_iter().enumerate().filter(|(i, hull)| !farthest.contains(i) && hull.may_exceed(&found));
    let rest = rest.map(|(i, _)| exact(i)).try_reduce(empty, |a, b| Ok(a.union(b)))?;
    Ok(found.union(rest))
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;

    /// A mesh without symmetry.
    fn mesh() -> Mesh {
        let points: Vec<[f64; 3]> = (0..60)
            .map(|i| {
                let t = f64::from(i);
                [(t * 1.7).sin() * 1.3, (t * 0.9).cos() + 0.01 * t, (t * 2.3).sin() * (t * 0.2).cos()]
            })
            .collect();
        let faces: Vec<[i64; 3]> = (0..58).map(|i| [i, i + 1, i + 2]).collect();
        Mesh::new(&points, &faces).unwrap()
    }

    fn places(count: usize) -> Vec<DAffine3> {
        let place = |i: usize| {
            let t = i as f64;
            let turn = DMat3::from_rotation_y(t) * DMat3::from_diagonal(DVec3::new(1.0, 1.0 + 0.1 * t.sin(), 1.0));
            let linear = if i.is_multiple_of(5) { turn * DMat3::from_rotation_x(t) } else { turn };
            // Most stand on one level, far from the world's origin.
            let height = if i.is_multiple_of(7) { (t * 0.3).sin() } else { 0.0 };
            DAffine3::from_mat3_translation(linear, DVec3::new(5e6 + 40.0 * (t * 0.11).sin(), height, t * 0.01 - 3e5))
        };
        (0..count).map(place).collect()
    }

    #[test]
    fn the_box_of_all_is_that_of_their_vertices_bit_for_bit() {
        let mesh = mesh();
        for count in [1, 2, 10, 500] {
            let places = places(count);
            let hulls: Vec<Hull> = places.iter().map(|m| Hull::new(&mesh, m)).collect();
            let found = bounds_of(&hulls, |i| (&mesh, places[i]), &Progress::new()).unwrap();
            let all =
                places.iter().flat_map(|m| mesh.positions_local().iter().map(|p| m.transform_point3(p.as_dvec3())));
            assert_eq!(found, Aabb::from_points(all), "{count}");
            for (hull, place) in hulls.iter().zip(&places) {
                let own =
                    Aabb::from_points(mesh.positions_local().iter().map(|p| place.transform_point3(p.as_dvec3())));
                assert!(own.min.cmpge(hull.bounds.min).all() && own.max.cmple(hull.bounds.max).all());
                for axis in (0..3).filter(|axis| hull.exact[*axis]) {
                    assert_eq!((own.min[axis], own.max[axis]), (hull.bounds.min[axis], hull.bounds.max[axis]));
                }
            }
        }
    }

    #[test]
    fn few_instances_are_looked_at() {
        let mesh = mesh();
        let places = places(2000);
        let hulls: Vec<Hull> = places.iter().map(|m| Hull::new(&mesh, m)).collect();
        let looked = std::sync::atomic::AtomicUsize::new(0);
        let placed = |i: usize| {
            looked.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            (&mesh, places[i])
        };
        bounds_of(&hulls, placed, &Progress::new()).unwrap();
        let looked = looked.into_inner();
        assert!(looked < 200, "{looked} of 2000");
    }
}
