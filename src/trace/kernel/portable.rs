//! The inner tests in plain Rust.

use super::interface::{BandMeet, Kernel, Meet};
use crate::trace::hierarchy::{LEAF, Node, Packet, WIDTH};
use crate::trace::rays::{BUNDLE, Bundle, Hull, Line, LocalRay, RayBits, SLAB_SLACK};

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

/// A vertex of each triangle in sheared coordinates: the ray is the z axis.
struct Sheared {
    x: [f64; LEAF],
    y: [f64; LEAF],
    z: [f64; LEAF],
}

impl Portable {
    #[inline(always)]
    fn sheared(packet: &Packet, ray: &Line, vertex: usize) -> Sheared {
        let v = &packet.vertices[vertex];
        let z: [f64; LEAF] = std::array::from_fn(|i| f64::from(v[ray.axes[2]][i]) - ray.origin[2]);
        Sheared {
            x: std::array::from_fn(|i| (f64::from(v[ray.axes[0]][i]) - ray.origin[0]) - ray.shear[0] * z[i]),
            y: std::array::from_fn(|i| (f64::from(v[ray.axes[1]][i]) - ray.origin[1]) - ray.shear[1] * z[i]),
            z,
        }
    }
    /// The edge function of the edge a to b: twice the signed area with the ray. Exactly antisymmetric, and its sign is
    /// never wrong, only zero at worst: rounding is monotonous. So triangles that share an edge leave no gap.
    #[inline(always)]
    fn edge(a: &Sheared, b: &Sheared) -> [f64; LEAF] {
        std::array::from_fn(|i| b.x[i] * a.y[i] - b.y[i] * a.x[i])
    }
    /// The band's width times a bound on the edge's length.
    #[inline(always)]
    fn margin(a: &Sheared, b: &Sheared, band: f64) -> [f64; LEAF] {
        std::array::from_fn(|i| ((b.x[i] - a.x[i]).abs() + (b.y[i] - a.y[i]).abs()) * band)
    }
}

impl Kernel for Portable {
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
    fn triangles(packet: &Packet, ray: &Line) -> Meet {
        let [a, b, c] = [0, 1, 2].map(|v| Self::sheared(packet, ray, v));
        let (u, v, w) = (Self::edge(&b, &c), Self::edge(&c, &a), Self::edge(&a, &b));
        let mut meet = Meet { hit: 0, t: [0.0; LEAF] };
        for i in 0..LEAF {
            let area = (u[i] + v[i]) + w[i];
            let forward = u[i] >= 0.0 && v[i] >= 0.0 && w[i] >= 0.0;
            let backward = u[i] <= 0.0 && v[i] <= 0.0 && w[i] <= 0.0;
            meet.t[i] = ((u[i] * a.z[i] + v[i] * b.z[i]) + w[i] * c.z[i]) * ray.t_per_z / area;
            meet.hit |= u32::from((forward || backward) && area != 0.0) << i;
        }
        meet
    }
    #[inline(always)]
    fn triangles_band(packet: &Packet, ray: &Line) -> BandMeet {
        let [a, b, c] = [0, 1, 2].map(|v| Self::sheared(packet, ray, v));
        let edges = [Self::edge(&b, &c), Self::edge(&c, &a), Self::edge(&a, &b)];
        let band = ray.band;
        let margins = [Self::margin(&b, &c, band), Self::margin(&c, &a, band), Self::margin(&a, &b, band)];
        let Meet { hit, t } = Self::triangles(packet, ray);
        let (mut inside, mut near) = (0, 0);
        for i in 0..LEAF {
            let all = |test: &dyn Fn(f64, f64) -> bool| (0..3).all(|k| test(edges[k][i], margins[k][i]));
            inside |= u32::from(all(&|e, m| e > m) || all(&|e, m| e < -m)) << i;
            near |= u32::from(all(&|e, m| e >= -m) || all(&|e, m| e <= m)) << i;
        }
        let at = |z: [f64; 3]| z.map(|z| z * ray.t_per_z);
        let t_of: [[f64; 3]; LEAF] = std::array::from_fn(|i| at([a.z[i], b.z[i], c.z[i]]));
        BandMeet {
            hit,
            inside,
            near,
            t,
            t_low: t_of.map(|t| t[0].min(t[1]).min(t[2])),
            t_high: t_of.map(|t| t[0].max(t[1]).max(t[2])),
        }
    }
}
