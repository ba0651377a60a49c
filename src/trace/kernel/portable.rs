//! The inner tests in plain Rust.

use super::exact::{self, Pass};
use super::interface::{BandMeet, Kernel, Meet};
use crate::trace::hierarchy::{LEAF, Node, Packet, WIDTH};
use crate::trace::rays::{
    BUNDLE, Bundle, DEPTH_OF_BOUND, DEPTH_OF_ERROR, Each, Hull, Line, LocalRay, LocalRays, RayBits, SLAB_SLACK,
};

/// Plain Rust.
#[derive(Debug, Clone, Copy)]
pub struct Portable;

// Comparisons as the SIMD instructions have them: the second operand where either is NaN (none is).
#[inline(always)]
fn max32(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
#[inline(always)]
fn min32(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

impl<const N: usize> BandMeet<N> {
    /// Takes in what one that is near passes.
    #[inline(always)]
    fn note(&mut self, k: usize, pass: Pass) {
        self.near |= 1 << k;
        self.hit |= u32::from(pass.is_hit) << k;
        self.inside |= u32::from(pass.is_inside) << k;
        (self.t[k], self.t_low[k], self.t_high[k]) = (pass.t, pass.t_low, pass.t_high);
    }
}

impl Kernel for Portable {
    #[inline(always)]
    fn fetch<T>(_: &T) {}
    #[inline(always)]
    fn boxes(node: &Node, ray: &LocalRay, limit: f32) -> (u32, [f32; WIDTH]) {
        let mut bits = 0;
        let mut entry = [0.0; WIDTH];
        for (i, entry) in entry.iter_mut().enumerate() {
            let first = |a: usize| node.planes[ray.first_plane[a]][i] * ray.inverse[a][0] - ray.first_offset[a][0];
            let last = |a: usize| node.planes[ray.first_plane[a] ^ 1][i] * ray.inverse[a][0] - ray.last_offset[a][0];
            *entry = max32(max32(first(0), first(1)), max32(first(2), 0.0));
            let exit = min32(min32(min32(last(0), last(1)), last(2)) * SLAB_SLACK, limit);
            bits |= u32::from(*entry <= exit) << i;
        }
        (bits, entry)
    }
    #[inline(always)]
    fn hull_boxes(node: &Node, hull: &Hull, limit: f32) -> (u32, [f32; WIDTH]) {
        let mut bits = 0;
        let mut entry = [0.0; WIDTH];
        for (i, entry) in entry.iter_mut().enumerate() {
            let both = |plane: usize, origin: f32, a: usize| {
                let away = node.planes[plane][i] - origin;
                hull.inverse[a].map(|inverse| away * inverse)
            };
            let first = |a: usize| {
                let [s, t] = both(hull.first_plane[a], hull.first_origin[a], a);
                min32(s, t)
            };
            let last = |a: usize| {
                let [s, t] = both(hull.first_plane[a] ^ 1, hull.last_origin[a], a);
                max32(s, t)
            };
            *entry = max32(max32(first(0), first(1)), max32(first(2), 0.0));
            let exit = min32(min32(min32(last(0), last(1)), last(2)) * SLAB_SLACK, limit);
            bits |= u32::from(*entry <= exit) << i;
        }
        (bits, entry)
    }
    #[inline(always)]
    fn rays_in_box(node: &Node, child: usize, bundle: &Bundle, limits: &[f32; BUNDLE]) -> RayBits {
        let planes = bundle.hull.first_plane;
        let mut bits = 0;
        for r in 0..BUNDLE {
            let first =
                |a: usize| node.planes[planes[a]][child] * bundle.rays.inverse[a][r] - bundle.rays.first_offset[a][r];
            let last = |a: usize| {
                node.planes[planes[a] ^ 1][child] * bundle.rays.inverse[a][r] - bundle.rays.last_offset[a][r]
            };
            let entry = max32(max32(first(0), first(1)), max32(first(2), 0.0));
            let exit = min32(min32(min32(last(0), last(1)), last(2)) * SLAB_SLACK, limits[r]);
            bits |= u32::from(entry <= exit) << r;
        }
        bits
    }
    #[inline(always)]
    fn rays_near<const AHEAD: bool>(packet: &Packet, rays: &LocalRays<BUNDLE>, asked: RayBits) -> [RayBits; LEAF] {
        let (rough, axes) = (&rays.rough, rays.axes());
        let way = if rays.is_backward() { -1.0 } else { 1.0 };
        std::array::from_fn(|lane| {
            let mut bits = 0;
            for r in Each(asked) {
                let [a, b, c] = [0, 1, 2].map(|vertex| {
                    let relative = |k: usize| packet.vertices[vertex][axes[k]][lane] - rough.origin[k][r];
                    let z = relative(2);
                    [relative(0) - rough.shear[0][r] * z, relative(1) - rough.shear[1][r] * z, z]
                });
                let size = |p: [f32; 3]| p[0].abs() + p[1].abs();
                let edge = |a: [f32; 3], b: [f32; 3]| b[0] * a[1] - b[1] * a[0];
                let error = rough.error[r];
                let bound = error * (size(a) + size(b) + size(c)) + 4.0 * error * error;
                let [u, v, w] = [edge(b, c), edge(c, a), edge(a, b)];
                let mut forward = min32(min32(u, v), w) >= -bound;
                let mut backward = max32(max32(u, v), w) <= bound;
                if AHEAD {
                    let depth = max32(max32(a[2].abs(), b[2].abs()), c[2].abs()) + error;
                    let slack = DEPTH_OF_ERROR * error * (u.abs() + v.abs() + w.abs()) + DEPTH_OF_BOUND * bound * depth;
                    let weighted = way * (u * a[2] + v * b[2] + w * c[2]);
                    forward &= weighted >= -slack;
                    backward &= weighted <= slack;
                }
                bits |= u32::from(forward | backward) << r;
            }
            bits
        })
    }
    #[inline(always)]
    fn rays_meet(
        packet: &Packet,
        lane: usize,
        rays: &LocalRays<BUNDLE>,
        bits: RayBits,
        t: &mut [f64; BUNDLE],
    ) -> RayBits {
        let mut hit = 0;
        for r in Each(bits) {
            if let Some(at) = exact::triangle(packet, lane, &rays.line(r)) {
                hit |= 1 << r;
                t[r] = at;
            }
        }
        hit
    }
    #[inline(always)]
    fn rays_pass(packet: &Packet, lane: usize, rays: &LocalRays<BUNDLE>, bits: RayBits) -> BandMeet<BUNDLE> {
        let mut found = BandMeet::NONE;
        for r in Each(bits) {
            if let Some(pass) = exact::triangle_band(packet, lane, &rays.line(r)) {
                found.note(r, pass);
            }
        }
        found
    }
    #[inline(always)]
    fn triangles(packet: &Packet, ray: &Line) -> Meet {
        let mut meet = Meet { hit: 0, t: [0.0; LEAF] };
        for lane in 0..LEAF {
            if let Some(t) = exact::triangle(packet, lane, ray) {
                meet.hit |= 1 << lane;
                meet.t[lane] = t;
            }
        }
        meet
    }
    #[inline(always)]
    fn triangles_band(packet: &Packet, ray: &Line) -> BandMeet<LEAF> {
        let mut meet = BandMeet::NONE;
        for lane in 0..LEAF {
            if let Some(pass) = exact::triangle_band(packet, lane, ray) {
                meet.note(lane, pass);
            }
        }
        meet
    }
}
