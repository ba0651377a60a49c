//! The exact tests in AVX2: four triangles against a ray, and a triangle against four rays at a time. The same operations in
//! the same order as in [`exact`](super::exact).

use std::arch::x86_64::*;

use super::exact::MOVED;
use super::interface::{BandMeet, Meet};
use crate::trace::hierarchy::{LEAF, Packet};
use crate::trace::rays::{BUNDLE, Line, LocalRays, RayBits};

type Vertex = [__m256d; 3];

/// Rays of a register of f64.
const FOUR: usize = 4;
const _: () = assert!(BUNDLE.is_multiple_of(FOUR));

/// Four numbers of a bundle, from `first` on, a multiple of four.
#[inline]
#[target_feature(enable = "avx2")]
fn four(x: &[f64; BUNDLE], first: usize) -> __m256d {
    debug_assert!(first + FOUR <= BUNDLE);
    // SAFETY: four f64 are readable there.
    unsafe { _mm256_loadu_pd(x.as_ptr().add(first)) }
}

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
fn meet(vertices: &[Vertex; 3], edges: &[__m256d; 3], t_per_z: __m256d) -> (u32, __m256d) {
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
    (bits, _mm256_div_pd(_mm256_mul_pd(weighted, t_per_z), area))
}

#[inline]
#[target_feature(enable = "avx2")]
pub fn triangles(packet: &Packet, ray: &Line) -> Meet {
    let vertices = [sheared(packet, ray, 0), sheared(packet, ray, 1), sheared(packet, ray, 2)];
    let [a, b, c] = &vertices;
    let (hit, t) = meet(&vertices, &[edge(b, c), edge(c, a), edge(a, b)], _mm256_set1_pd(ray.t_per_z));
    Meet { hit, t: store(t) }
}

/// What four rays or triangles pass: see [`BandMeet`].
struct Passes {
    hit: u32,
    inside: u32,
    near: u32,
    t: __m256d,
    t_low: __m256d,
    t_high: __m256d,
}

#[inline]
#[target_feature(enable = "avx2")]
fn passes(vertices: &[Vertex; 3], band: __m256d, t_per_z: __m256d) -> Option<Passes> {
    let [a, b, c] = vertices;
    let edges = [edge(b, c), edge(c, a), edge(a, b)];
    let sign = _mm256_set1_pd(-0.0);
    let margin = |a: &Vertex, b: &Vertex| {
        let along = |k: usize| _mm256_andnot_pd(sign, _mm256_sub_pd(b[k], a[k]));
        _mm256_mul_pd(_mm256_add_pd(along(0), along(1)), band)
    };
    let margins = [margin(b, c), margin(c, a), margin(a, b)];
    let [of_a, of_b, of_c] = margins;
    let minus = [_mm256_xor_pd(of_a, sign), _mm256_xor_pd(of_b, sign), _mm256_xor_pd(of_c, sign)];
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
        return None;
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
    let is_inside = _mm256_or_pd(inside_forward, inside_backward);
    let inside = _mm256_movemask_pd(is_inside) as u32;
    let (hit, t) = meet(vertices, &edges, t_per_z);
    let t_of = |v: &Vertex| _mm256_mul_pd(v[2], t_per_z);
    let (ta, tb, tc) = (t_of(a), t_of(b), t_of(c));
    let t_low = _mm256_min_pd(_mm256_min_pd(ta, tb), tc);
    let mut t_high = _mm256_max_pd(_mm256_max_pd(ta, tb), tc);
    if inside != 0 {
        let area = _mm256_add_pd(_mm256_add_pd(edges[0], edges[1]), edges[2]);
        let all = _mm256_add_pd(_mm256_add_pd(of_a, of_b), of_c);
        let share = _mm256_div_pd(all, _mm256_andnot_pd(sign, area));
        let along = _mm256_mul_pd(band, _mm256_andnot_pd(sign, t_per_z));
        let across = _mm256_mul_pd(share, _mm256_sub_pd(t_high, t_low));
        let reach = _mm256_mul_pd(_mm256_set1_pd(MOVED), _mm256_add_pd(across, along));
        let is_bound = _mm256_and_pd(is_inside, _mm256_cmp_pd::<_CMP_LT_OQ>(reach, _mm256_set1_pd(1.0)));
        t_high = _mm256_blendv_pd(t_high, _mm256_min_pd(_mm256_add_pd(t, reach), t_high), is_bound);
    }
    Some(Passes { hit, inside, near, t, t_low, t_high })
}

#[inline]
#[target_feature(enable = "avx2")]
pub fn triangles_band(packet: &Packet, ray: &Line) -> BandMeet<LEAF> {
    let vertices = [sheared(packet, ray, 0), sheared(packet, ray, 1), sheared(packet, ray, 2)];
    match passes(&vertices, _mm256_set1_pd(ray.band), _mm256_set1_pd(ray.t_per_z)) {
        Some(Passes { hit, inside, near, t, t_low, t_high }) => {
            BandMeet { hit, inside, near, t: store(t), t_low: store(t_low), t_high: store(t_high) }
        }
        None => BandMeet::NONE,
    }
}

/// A triangle's vertices, axes permuted as those of the rays: `[vertex][axis]`, four times the same.
#[inline]
#[target_feature(enable = "avx2")]
fn spread(packet: &Packet, lane: usize, rays: &LocalRays<BUNDLE>) -> [Vertex; 3] {
    let [x, y, z] = rays.axes();
    let axes = [x % 3, y % 3, z % 3];
    let at = |v: &[[f32; LEAF]; 3], k: usize| _mm256_cvtps_pd(_mm_set1_ps(v[axes[k]][lane % LEAF]));
    let [a, b, c] = &packet.vertices;
    [[at(a, 0), at(a, 1), at(a, 2)], [at(b, 0), at(b, 1), at(b, 2)], [at(c, 0), at(c, 1), at(c, 2)]]
}

/// The triangle in the sheared coordinates of four rays, from `first` on, as [`sheared`] has them of one.
#[inline]
#[target_feature(enable = "avx2")]
fn sheared_by(triangle: &[Vertex; 3], rays: &LocalRays<BUNDLE>, first: usize) -> [Vertex; 3] {
    let origin = [four(&rays.origin[0], first), four(&rays.origin[1], first), four(&rays.origin[2], first)];
    let shear = [four(&rays.shear[0], first), four(&rays.shear[1], first)];
    let of = |v: &Vertex| {
        let z = _mm256_sub_pd(v[2], origin[2]);
        let straight = |k: usize| _mm256_sub_pd(_mm256_sub_pd(v[k], origin[k]), _mm256_mul_pd(shear[k], z));
        [straight(0), straight(1), z]
    };
    let [a, b, c] = triangle;
    [of(a), of(b), of(c)]
}

#[inline]
#[target_feature(enable = "avx2")]
pub fn rays_meet(
    packet: &Packet,
    lane: usize,
    rays: &LocalRays<BUNDLE>,
    bits: RayBits,
    t: &mut [f64; BUNDLE],
) -> RayBits {
    let triangle = spread(packet, lane, rays);
    let mut hit = 0;
    for first in (0..BUNDLE).step_by(FOUR) {
        if (bits >> first) & 0b1111 == 0 {
            continue;
        }
        let vertices = sheared_by(&triangle, rays, first);
        let [a, b, c] = &vertices;
        let (found, at) = meet(&vertices, &[edge(b, c), edge(c, a), edge(a, b)], four(&rays.t_per_z, first));
        hit |= found << first;
        // SAFETY: four f64 are writable from there.
        unsafe { _mm256_storeu_pd(t.as_mut_ptr().add(first), at) };
    }
    hit & bits
}

#[inline]
#[target_feature(enable = "avx2")]
pub fn rays_pass(packet: &Packet, lane: usize, rays: &LocalRays<BUNDLE>, bits: RayBits) -> BandMeet<BUNDLE> {
    let triangle = spread(packet, lane, rays);
    let band = _mm256_set1_pd(rays.band);
    let mut found = BandMeet::NONE;
    for first in (0..BUNDLE).step_by(FOUR) {
        if (bits >> first) & 0b1111 == 0 {
            continue;
        }
        let vertices = sheared_by(&triangle, rays, first);
        if let Some(passes) = passes(&vertices, band, four(&rays.t_per_z, first)) {
            found.hit |= passes.hit << first;
            found.inside |= passes.inside << first;
            found.near |= passes.near << first;
            // SAFETY: four f64 are writable from there.
            unsafe {
                _mm256_storeu_pd(found.t.as_mut_ptr().add(first), passes.t);
                _mm256_storeu_pd(found.t_low.as_mut_ptr().add(first), passes.t_low);
                _mm256_storeu_pd(found.t_high.as_mut_ptr().add(first), passes.t_high);
            }
        }
    }
    found.near &= bits;
    found
}
