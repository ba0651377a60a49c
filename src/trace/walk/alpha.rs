//! Alpha tests on a ray's way: triangles that are met where they do not exist are not met.
//!
//! A ray that may move within a band meets texture coordinates within a rectangle. Where all of that exists, a tested triangle
//! is like any other; where nothing does, it is not there; else the ray passes it as it passes an edge.

use glam::DVec2;

use crate::scene::Presence;
use crate::trace::hierarchy::{Packet, TracedMesh};
use crate::trace::kernel::Pass;
use crate::trace::rays::Line;

/// Whether a triangle exists where a ray meets it.
#[cold]
#[inline(never)]
pub fn exists(mesh: &TracedMesh, packet: &Packet, lane: usize, ray: &Line) -> bool {
    mesh.mesh.alpha_test().is_none_or(|test| test.exists(Coordinates::new(mesh, packet, lane, ray).uv))
}

/// What is left of a triangle that a ray meets or nearly meets: nothing where nothing within its band exists; where parts of it
/// exist the ray is no longer inside.
#[cold]
#[inline(never)]
pub fn sifted(mesh: &TracedMesh, packet: &Packet, lane: usize, pass: Pass, ray: &Line) -> Option<Pass> {
    let Some(test) = mesh.mesh.alpha_test() else { return Some(pass) };
    let Coordinates { uv, reach } = Coordinates::new(mesh, packet, lane, ray);
    match test.presence(uv, reach) {
        Presence::Full => Some(pass),
        Presence::Empty => None,
        Presence::Mixed => Some(Pass { is_hit: pass.is_hit && test.exists(uv), is_inside: false, ..pass }),
    }
}

/// The texture coordinates that a ray meets, and how far they change within its band.
struct Coordinates {
    uv: DVec2,
    reach: DVec2,
}

impl Coordinates {
    fn new(mesh: &TracedMesh, packet: &Packet, lane: usize, ray: &Line) -> Self {
        let triangle = mesh.mesh.triangles()[packet.triangles[lane] as usize];
        let corners = mesh.mesh.alpha_test().map_or([DVec2::ZERO; 3], |test| test.corners(triangle));
        // In sheared coordinates, as the kernels have them: the ray is the z axis.
        let p: [DVec2; 3] = std::array::from_fn(|k| {
            let at = |axis: usize| f64::from(packet.vertices[k][ray.axes[axis]][lane]) - ray.origin[axis];
            DVec2::new(at(0) - ray.shear[0] * at(2), at(1) - ray.shear[1] * at(2))
        });
        let edge = |a: DVec2, b: DVec2| b.x * a.y - b.y * a.x;
        let weights = [edge(p[1], p[2]), edge(p[2], p[0]), edge(p[0], p[1])];
        let area = weights[0] + weights[1] + weights[2];
        // A ray within the band of an edge may pass outside.
        let [a, b, c] = weights.map(|weight| (weight / area).max(0.0));
        let uv = (corners[0] * a + corners[1] * b + corners[2] * c) / (a + b + c);
        // The weight of a corner changes by as much as the ray moves times the edge that is opposite.
        let mut reach = DVec2::ZERO;
        for k in 0..3 {
            let opposite = (p[(k + 2) % 3] - p[(k + 1) % 3]).abs();
            reach += (corners[k] - uv).abs() * ((opposite.x + opposite.y) * ray.band / area.abs());
        }
        Self { uv, reach }
    }
}
