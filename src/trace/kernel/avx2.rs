//! The inner tests in AVX2.

use std::arch::x86_64::*;

use super::interface::{BandMeet, Kernel, Meet};
use crate::trace::hierarchy::{LEAF, Node, Packet, WIDTH};
use crate::trace::rays::{BUNDLE, Bundle, Hull, Line, LocalRay, LocalRays, RayBits, SLAB_SLACK};

/// AVX2. Only to be used below a function with that target feature, on a processor that has it.
#[derive(Debug, Clone, Copy)]
pub struct Avx2;

type Vertex = [__m256d; 3];

#[inline]
#[target_feature(enable = "avx2")]
fn store(x: __m256d) -> [f64; 4] {
    let mut out = [0.0; 4];
    // SAFETY: four f64 are writable.
    unsafe { _mm256_storeu_pd(out.as_mut_ptr(), x) };
    out
}
#[inline]
#[target_feature(enable = "avx2")]
fn widened(x: &[f32; LEAF]) -> __m256d {
    // SAFETY: four f32 are readable.
    _mm256_cvtps_pd(unsafe { _mm_loadu_ps(x.as_ptr()) })
}
#[inline]
#[target_feature(enable = "avx2")]
fn sheared(packet: &Packet, ray: &Line, vertex: usize) -> Vertex {
    let v = &packet.vertices[vertex];
    let relative = |axis: usize| _mm256_sub_pd(widened(&v[ray.axes[axis]]), _mm256_set1_pd(ray.origin[axis]));
    let z = relative(2);
    let straight = |axis: usize| _mm256_sub_pd(relative(axis), _mm256_mul_pd(_mm256_set1_pd(ray.shear[axis]), z));
    [straight(0), straight(1), z]
}
#[inline]
#[target_feature(enable = "avx2")]
fn edge(a: &Vertex, b: &Vertex) -> __m256d {
    _mm256_sub_pd(_mm256_mul_pd(b[0], a[1]), _mm256_mul_pd(b[1], a[0]))
}
#[inline]
#[target_feature(enable = "avx2")]
fn all3(a: __m256d, b: __m256d, c: __m256d) -> __m256d {
    _mm256_and_pd(a, _mm256_and_pd(b, c))
}
#[inline]
#[target_feature(enable = "avx2")]
fn meet(vertices: &[Vertex; 3], edges: &[__m256d; 3], ray: &Line) -> (u32, __m256d) {
    let zero = _mm256_setzero_pd();
    let [u, v, w] = *edges;
    let area = _mm256_add_pd(_mm256_add_pd(u, v), w);
    let forward = all3(
        _mm256_cmp_pd::<_CMP_GE_OQ>(u, zero),
        _mm256_cmp_pd::<_CMP_GE_OQ>(v, zero),
        _mm256_cmp_pd::<_CMP_GE_OQ>(w, zero),
    );
    let backward = all3(
        _mm256_cmp_pd::<_CMP_LE_OQ>(u, zero),
        _mm256_cmp_pd::<_CMP_LE_OQ>(v, zero),
        _mm256_cmp_pd::<_CMP_LE_OQ>(w, zero),
    );
    let hit = _mm256_and_pd(_mm256_or_pd(forward, backward), _mm256_cmp_pd::<_CMP_NEQ_UQ>(area, zero));
    let bits = _mm256_movemask_pd(hit) as u32;
    if bits == 0 {
        return (0, zero);
    }
    let [a, b, c] = vertices;
    let weighted = _mm256_add_pd(_mm256_add_pd(_mm256_mul_pd(u, a[2]), _mm256_mul_pd(v, b[2])), _mm256_mul_pd(w, c[2]));
    (bits, _mm256_div_pd(_mm256_mul_pd(weighted, _mm256_set1_pd(ray.t_per_z)), area))
}
#[inline]
#[target_feature(enable = "avx2,fma")]
fn boxes(node: &Node, ray: &LocalRay, limit: f32) -> (u32, [f32; WIDTH]) {
    let slab = |plane: usize, inverse: f32, offset: f32| {
        // SAFETY: eight f32, aligned to 32 bytes by Node; a plane's index is below 6.
        let planes = unsafe { _mm256_load_ps(node.planes.get_unchecked(plane).as_ptr()) };
        _mm256_fmsub_ps(planes, _mm256_set1_ps(inverse), _mm256_set1_ps(offset))
    };
    let first = |a: usize| slab(ray.first_plane[a], ray.inverse[a][0], ray.first_offset[a][0]);
    let last = |a: usize| slab(ray.first_plane[a] ^ 1, ray.inverse[a][0], ray.last_offset[a][0]);
    let entry = _mm256_max_ps(_mm256_max_ps(first(0), first(1)), _mm256_max_ps(first(2), _mm256_setzero_ps()));
    let exit = _mm256_min_ps(_mm256_min_ps(last(0), last(1)), last(2));
    let exit = _mm256_min_ps(_mm256_mul_ps(exit, _mm256_set1_ps(SLAB_SLACK)), _mm256_set1_ps(limit));
    let mut out = [0.0; WIDTH];
    // SAFETY: eight f32 are writable.
    unsafe { _mm256_storeu_ps(out.as_mut_ptr(), entry) };
    (_mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(entry, exit)) as u32, out)
}
#[inline]
#[target_feature(enable = "avx2")]
fn hull_boxes(node: &Node, hull: &Hull, limit: f32) -> (u32, [f32; WIDTH]) {
    let both = |plane: usize, origin: f32, a: usize| {
        // SAFETY: eight f32, aligned to 32 bytes by Node; a plane's index is below 6.
        let planes = unsafe { _mm256_load_ps(node.planes.get_unchecked(plane).as_ptr()) };
        let away = _mm256_sub_ps(planes, _mm256_set1_ps(origin));
        hull.inverse[a].map(|inverse| _mm256_mul_ps(away, _mm256_set1_ps(inverse)))
    };
    let first = |a: usize| {
        let [s, t] = both(hull.first_plane[a], hull.first_origin[a], a);
        _mm256_min_ps(s, t)
    };
    let last = |a: usize| {
        let [s, t] = both(hull.first_plane[a] ^ 1, hull.last_origin[a], a);
        _mm256_max_ps(s, t)
    };
    let entry = _mm256_max_ps(_mm256_max_ps(first(0), first(1)), _mm256_max_ps(first(2), _mm256_setzero_ps()));
    let exit = _mm256_min_ps(_mm256_min_ps(last(0), last(1)), last(2));
    let exit = _mm256_min_ps(_mm256_mul_ps(exit, _mm256_set1_ps(SLAB_SLACK)), _mm256_set1_ps(limit));
    let mut out = [0.0; WIDTH];
    // SAFETY: eight f32 are writable.
    unsafe { _mm256_storeu_ps(out.as_mut_ptr(), entry) };
    (_mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(entry, exit)) as u32, out)
}
#[inline]
#[target_feature(enable = "avx2,fma")]
fn rays_in_box(node: &Node, child: usize, bundle: &Bundle, limits: &[f32; BUNDLE]) -> RayBits {
    let child = child % WIDTH;
    let slab = |plane: usize, inverse: &[f32; BUNDLE], offset: &[f32; BUNDLE]| {
        // SAFETY: a plane's index is below 6; a bundle's arrays are aligned to 32 bytes.
        unsafe {
            let plane = _mm256_set1_ps(node.planes.get_unchecked(plane)[child]);
            _mm256_fmsub_ps(plane, _mm256_load_ps(inverse.as_ptr()), _mm256_load_ps(offset.as_ptr()))
        }
    };
    let first = |a: usize| slab(bundle.hull.first_plane[a], &bundle.rays.inverse[a], &bundle.rays.first_offset[a]);
    let last = |a: usize| slab(bundle.hull.first_plane[a] ^ 1, &bundle.rays.inverse[a], &bundle.rays.last_offset[a]);
    let entry = _mm256_max_ps(_mm256_max_ps(first(0), first(1)), _mm256_max_ps(first(2), _mm256_setzero_ps()));
    let exit = _mm256_min_ps(_mm256_min_ps(last(0), last(1)), last(2));
    // SAFETY: eight f32 are readable.
    let limits = unsafe { _mm256_loadu_ps(limits.as_ptr()) };
    let exit = _mm256_min_ps(_mm256_mul_ps(exit, _mm256_set1_ps(SLAB_SLACK)), limits);
    _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(entry, exit)) as u32
}
#[inline]
#[target_feature(enable = "avx2,fma")]
fn rays_near(packet: &Packet, rays: &LocalRays<BUNDLE>) -> [RayBits; LEAF] {
    let (rough, axes) = (&rays.rough, rays.axes().map(|axis| axis % 3));
    // SAFETY: eight f32, aligned to 32 bytes by Rough.
    let load = |x: &[f32; BUNDLE]| unsafe { _mm256_load_ps(x.as_ptr()) };
    let origin = [load(&rough.origin[0]), load(&rough.origin[1]), load(&rough.origin[2])];
    let shear = [load(&rough.shear[0]), load(&rough.shear[1])];
    let error = load(&rough.error);
    let least = _mm256_mul_ps(_mm256_mul_ps(error, error), _mm256_set1_ps(4.0));
    let sign = _mm256_set1_ps(-0.0);
    let sheared = |vertex: usize, lane: usize| {
        let v = &packet.vertices[vertex];
        let relative = |k: usize| _mm256_sub_ps(_mm256_set1_ps(v[axes[k]][lane]), origin[k]);
        let z = relative(2);
        [_mm256_fnmadd_ps(shear[0], z, relative(0)), _mm256_fnmadd_ps(shear[1], z, relative(1))]
    };
    let size = |p: &[__m256; 2]| _mm256_add_ps(_mm256_andnot_ps(sign, p[0]), _mm256_andnot_ps(sign, p[1]));
    let edge = |a: &[__m256; 2], b: &[__m256; 2]| _mm256_fmsub_ps(b[0], a[1], _mm256_mul_ps(b[1], a[0]));
    let mut near = [0; LEAF];
    for (lane, near) in near.iter_mut().enumerate() {
        let [a, b, c] = [sheared(0, lane), sheared(1, lane), sheared(2, lane)];
        let sizes = _mm256_add_ps(_mm256_add_ps(size(&a), size(&b)), size(&c));
        let bound = _mm256_fmadd_ps(error, sizes, least);
        let (u, v, w) = (edge(&b, &c), edge(&c, &a), edge(&a, &b));
        let lowest = _mm256_min_ps(_mm256_min_ps(u, v), w);
        let highest = _mm256_max_ps(_mm256_max_ps(u, v), w);
        let forward = _mm256_cmp_ps::<_CMP_GE_OQ>(lowest, _mm256_xor_ps(bound, sign));
        let backward = _mm256_cmp_ps::<_CMP_LE_OQ>(highest, bound);
        *near = _mm256_movemask_ps(_mm256_or_ps(forward, backward)) as u32;
    }
    near
}
#[inline]
#[target_feature(enable = "avx2")]
fn triangles(packet: &Packet, ray: &Line) -> Meet {
    let vertices = [sheared(packet, ray, 0), sheared(packet, ray, 1), sheared(packet, ray, 2)];
    let [a, b, c] = &vertices;
    let (hit, t) = meet(&vertices, &[edge(b, c), edge(c, a), edge(a, b)], ray);
    Meet { hit, t: store(t) }
}
#[inline]
#[target_feature(enable = "avx2")]
fn triangles_band(packet: &Packet, ray: &Line) -> BandMeet {
    let vertices = [sheared(packet, ray, 0), sheared(packet, ray, 1), sheared(packet, ray, 2)];
    let [a, b, c] = &vertices;
    let edges = [edge(b, c), edge(c, a), edge(a, b)];
    let sign = _mm256_set1_pd(-0.0);
    let band = _mm256_set1_pd(ray.band);
    let margin = |a: &Vertex, b: &Vertex| {
        let along = |k: usize| _mm256_andnot_pd(sign, _mm256_sub_pd(b[k], a[k]));
        _mm256_mul_pd(_mm256_add_pd(along(0), along(1)), band)
    };
    let margins = [margin(b, c), margin(c, a), margin(a, b)];
    let minus = margins.map(|m| _mm256_xor_pd(m, sign));
    let near_forward = all3(
        _mm256_cmp_pd::<_CMP_GE_OQ>(edges[0], minus[0]),
        _mm256_cmp_pd::<_CMP_GE_OQ>(edges[1], minus[1]),
        _mm256_cmp_pd::<_CMP_GE_OQ>(edges[2], minus[2]),
    );
    let near_backward = all3(
        _mm256_cmp_pd::<_CMP_LE_OQ>(edges[0], margins[0]),
        _mm256_cmp_pd::<_CMP_LE_OQ>(edges[1], margins[1]),
        _mm256_cmp_pd::<_CMP_LE_OQ>(edges[2], margins[2]),
    );
    let near = _mm256_movemask_pd(_mm256_or_pd(near_forward, near_backward)) as u32;
    if near == 0 {
        let none = [0.0; LEAF];
        return BandMeet { hit: 0, inside: 0, near: 0, t: none, t_low: none, t_high: none };
    }
    let inside_forward = all3(
        _mm256_cmp_pd::<_CMP_GT_OQ>(edges[0], margins[0]),
        _mm256_cmp_pd::<_CMP_GT_OQ>(edges[1], margins[1]),
        _mm256_cmp_pd::<_CMP_GT_OQ>(edges[2], margins[2]),
    );
    let inside_backward = all3(
        _mm256_cmp_pd::<_CMP_LT_OQ>(edges[0], minus[0]),
        _mm256_cmp_pd::<_CMP_LT_OQ>(edges[1], minus[1]),
        _mm256_cmp_pd::<_CMP_LT_OQ>(edges[2], minus[2]),
    );
    let inside = _mm256_movemask_pd(_mm256_or_pd(inside_forward, inside_backward)) as u32;
    let (hit, t) = meet(&vertices, &edges, ray);
    let t_of = |v: &Vertex| _mm256_mul_pd(v[2], _mm256_set1_pd(ray.t_per_z));
    let (ta, tb, tc) = (t_of(a), t_of(b), t_of(c));
    BandMeet {
        hit,
        inside,
        near,
        t: store(t),
        t_low: store(_mm256_min_pd(_mm256_min_pd(ta, tb), tc)),
        t_high: store(_mm256_max_pd(_mm256_max_pd(ta, tb), tc)),
    }
}

impl Kernel for Avx2 {
    #[inline(always)]
    fn boxes(node: &Node, ray: &LocalRay, limit: f32) -> (u32, [f32; WIDTH]) {
        // SAFETY: see the type.
        unsafe { boxes(node, ray, limit) }
    }
    #[inline(always)]
    fn hull_boxes(node: &Node, hull: &Hull, limit: f32) -> (u32, [f32; WIDTH]) {
        // SAFETY: see the type.
        unsafe { hull_boxes(node, hull, limit) }
    }
    #[inline(always)]
    fn rays_in_box(node: &Node, child: usize, bundle: &Bundle, limits: &[f32; BUNDLE]) -> RayBits {
        // SAFETY: see the type.
        unsafe { rays_in_box(node, child, bundle, limits) }
    }
    #[inline(always)]
    fn rays_near(packet: &Packet, rays: &LocalRays<BUNDLE>) -> [RayBits; LEAF] {
        // SAFETY: see the type.
        unsafe { rays_near(packet, rays) }
    }
    #[inline(always)]
    fn triangles(packet: &Packet, ray: &Line) -> Meet {
        // SAFETY: see the type.
        unsafe { triangles(packet, ray) }
    }
    #[inline(always)]
    fn triangles_band(packet: &Packet, ray: &Line) -> BandMeet {
        // SAFETY: see the type.
        unsafe { triangles_band(packet, ray) }
    }
}
