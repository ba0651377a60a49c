//! The inner tests in AVX2: those in single precision, of boxes and rough ones of triangles; the exact ones are in
//! [`avx2_exact`](super::avx2_exact).
//!
//! Arrays are written out and not mapped: a closure here has the target features, the library's loop that calls it has not, so
//! it stays a call for every element.

use std::arch::x86_64::*;

use super::avx2_exact::{rays_meet, rays_pass, triangles, triangles_band};
use super::interface::{BandMeet, Kernel, Meet};
use crate::trace::hierarchy::{LEAF, Node, Packet, WIDTH};
use crate::trace::rays::{
    BUNDLE, Bundle, DEPTH_OF_BOUND, DEPTH_OF_ERROR, Hull, Line, LocalRay, LocalRays, RayBits, SLAB_SLACK,
};

/// AVX2. Only to be used below a function with that target feature, on a processor that has it.
#[derive(Debug, Clone, Copy)]
pub struct Avx2;

/// Bytes that come into the cache together.
const CACHE_LINE: usize = 64;
/// Rays of a register.
const EIGHT: usize = 8;
const _: () = assert!(BUNDLE.is_multiple_of(EIGHT));

/// Eight numbers of a bundle, from `first` on, a multiple of eight.
#[inline]
#[target_feature(enable = "avx2")]
fn eight(x: &[f32; BUNDLE], first: usize) -> __m256 {
    debug_assert!(first + EIGHT <= BUNDLE);
    // SAFETY: eight f32 are readable there.
    unsafe { _mm256_loadu_ps(x.as_ptr().add(first)) }
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
        let [least, most] = hull.inverse[a];
        [_mm256_mul_ps(away, _mm256_set1_ps(least)), _mm256_mul_ps(away, _mm256_set1_ps(most))]
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
    let mut bits = 0;
    for first in (0..BUNDLE).step_by(EIGHT) {
        let slab = |plane: usize, inverse: &[f32; BUNDLE], offset: &[f32; BUNDLE]| {
            // SAFETY: a plane's index is below 6.
            let plane = _mm256_set1_ps(unsafe { node.planes.get_unchecked(plane)[child] });
            _mm256_fmsub_ps(plane, eight(inverse, first), eight(offset, first))
        };
        let enter = |a: usize| slab(bundle.hull.first_plane[a], &bundle.rays.inverse[a], &bundle.rays.first_offset[a]);
        let leave =
            |a: usize| slab(bundle.hull.first_plane[a] ^ 1, &bundle.rays.inverse[a], &bundle.rays.last_offset[a]);
        let entry = _mm256_max_ps(_mm256_max_ps(enter(0), enter(1)), _mm256_max_ps(enter(2), _mm256_setzero_ps()));
        let exit = _mm256_min_ps(_mm256_min_ps(leave(0), leave(1)), leave(2));
        let exit = _mm256_min_ps(_mm256_mul_ps(exit, _mm256_set1_ps(SLAB_SLACK)), eight(limits, first));
        bits |= (_mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(entry, exit)) as u32) << first;
    }
    bits
}
#[inline]
#[target_feature(enable = "avx2,fma")]
fn rays_near<const AHEAD: bool>(packet: &Packet, rays: &LocalRays<BUNDLE>, bits: RayBits) -> [RayBits; LEAF] {
    let (rough, [x, y, z]) = (&rays.rough, rays.axes());
    let axes = [x % 3, y % 3, z % 3];
    let sign = _mm256_set1_ps(-0.0);
    let way = if rays.is_backward() { sign } else { _mm256_setzero_ps() };
    let size = |p: &[__m256; 3]| _mm256_add_ps(_mm256_andnot_ps(sign, p[0]), _mm256_andnot_ps(sign, p[1]));
    let edge = |a: &[__m256; 3], b: &[__m256; 3]| _mm256_fmsub_ps(b[0], a[1], _mm256_mul_ps(b[1], a[0]));
    let mut near = [0; LEAF];
    for first in (0..BUNDLE).step_by(EIGHT) {
        if (bits >> first) & 0xff == 0 {
            continue;
        }
        let origin = [eight(&rough.origin[0], first), eight(&rough.origin[1], first), eight(&rough.origin[2], first)];
        let shear = [eight(&rough.shear[0], first), eight(&rough.shear[1], first)];
        let error = eight(&rough.error, first);
        let least = _mm256_mul_ps(_mm256_mul_ps(error, error), _mm256_set1_ps(4.0));
        let sheared = |vertex: usize, lane: usize| {
            let v = &packet.vertices[vertex];
            let relative = |k: usize| _mm256_sub_ps(_mm256_set1_ps(v[axes[k]][lane]), origin[k]);
            let z = relative(2);
            [_mm256_fnmadd_ps(shear[0], z, relative(0)), _mm256_fnmadd_ps(shear[1], z, relative(1)), z]
        };
        for (lane, near) in near.iter_mut().enumerate() {
            let [a, b, c] = [sheared(0, lane), sheared(1, lane), sheared(2, lane)];
            let sizes = _mm256_add_ps(_mm256_add_ps(size(&a), size(&b)), size(&c));
            let bound = _mm256_fmadd_ps(error, sizes, least);
            let (u, v, w) = (edge(&b, &c), edge(&c, &a), edge(&a, &b));
            let lowest = _mm256_min_ps(_mm256_min_ps(u, v), w);
            let highest = _mm256_max_ps(_mm256_max_ps(u, v), w);
            let mut forward = _mm256_cmp_ps::<_CMP_GE_OQ>(lowest, _mm256_xor_ps(bound, sign));
            let mut backward = _mm256_cmp_ps::<_CMP_LE_OQ>(highest, bound);
            if AHEAD {
                let abs = |x: __m256| _mm256_andnot_ps(sign, x);
                let depth = _mm256_max_ps(_mm256_max_ps(abs(a[2]), abs(b[2])), abs(c[2]));
                let all = _mm256_add_ps(_mm256_add_ps(abs(u), abs(v)), abs(w));
                let of_bound =
                    _mm256_mul_ps(_mm256_mul_ps(_mm256_set1_ps(DEPTH_OF_BOUND), bound), _mm256_add_ps(depth, error));
                let slack = _mm256_fmadd_ps(_mm256_mul_ps(_mm256_set1_ps(DEPTH_OF_ERROR), error), all, of_bound);
                let weighted = _mm256_fmadd_ps(u, a[2], _mm256_fmadd_ps(v, b[2], _mm256_mul_ps(w, c[2])));
                let weighted = _mm256_xor_ps(weighted, way);
                let is_ahead = _mm256_cmp_ps::<_CMP_GE_OQ>(weighted, _mm256_xor_ps(slack, sign));
                forward = _mm256_and_ps(forward, is_ahead);
                backward = _mm256_and_ps(backward, _mm256_cmp_ps::<_CMP_LE_OQ>(weighted, slack));
            }
            *near |= ((_mm256_movemask_ps(_mm256_or_ps(forward, backward)) as u32) << first) & bits;
        }
    }
    near
}

impl Kernel for Avx2 {
    #[inline(always)]
    fn fetch<T>(place: &T) {
        let place = std::ptr::from_ref(place).cast::<i8>();
        for line in (0..size_of::<T>()).step_by(CACHE_LINE) {
            // SAFETY: within what is referred to.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(place.add(line)) };
        }
    }
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
    fn rays_near<const AHEAD: bool>(packet: &Packet, rays: &LocalRays<BUNDLE>, bits: RayBits) -> [RayBits; LEAF] {
        // SAFETY: see the type.
        unsafe { rays_near::<AHEAD>(packet, rays, bits) }
    }
    #[inline(always)]
    fn rays_meet(
        packet: &Packet,
        lane: usize,
        rays: &LocalRays<BUNDLE>,
        bits: RayBits,
        t: &mut [f64; BUNDLE],
    ) -> RayBits {
        // SAFETY: see the type.
        unsafe { rays_meet(packet, lane, rays, bits, t) }
    }
    #[inline(always)]
    fn rays_pass(packet: &Packet, lane: usize, rays: &LocalRays<BUNDLE>, bits: RayBits) -> BandMeet<BUNDLE> {
        // SAFETY: see the type.
        unsafe { rays_pass(packet, lane, rays, bits) }
    }
    #[inline(always)]
    fn triangles(packet: &Packet, ray: &Line) -> Meet {
        // SAFETY: see the type.
        unsafe { triangles(packet, ray) }
    }
    #[inline(always)]
    fn triangles_band(packet: &Packet, ray: &Line) -> BandMeet<LEAF> {
        // SAFETY: see the type.
        unsafe { triangles_band(packet, ray) }
    }
}
