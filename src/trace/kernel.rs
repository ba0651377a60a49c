//! The two inner tests, eight boxes and four triangles at a time: portable, and for AVX2 chosen at run time.
//!
//! Triangles give the same bits in both: every operation is an IEEE addition, multiplication, division or comparison in
//! the same order, nothing is contracted. Boxes may differ in the last bits, for which they are padded: which of them are
//! entered has no say in the answer.

use super::packet::Packet;
use super::ray::{LocalRay, SLAB_SLACK};
use super::tree::{LEAF, Node, WIDTH};

/// Which lanes a ray meets, edges included, and where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Meet {
    /// Bit per lane.
    pub hit: u32,
    pub t: [f64; LEAF],
}

/// As [`Meet`], told apart by how near the edges the ray passes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BandMeet {
    /// Edges included, as in [`Meet`].
    pub hit: u32,
    /// Inside by more than the ray's band.
    pub inside: u32,
    /// Inside, or outside by no more than the band.
    pub near: u32,
    pub t: [f64; LEAF],
    /// Bounds on t over the triangle, whatever the displacement.
    pub t_low: [f64; LEAF],
    pub t_high: [f64; LEAF],
}

/// A set of instructions.
pub trait Kernel: Copy {
    /// Children whose boxes the ray may meet before `limit` (bits), and where it enters them.
    fn boxes(node: &Node, ray: &LocalRay, limit: f32) -> (u32, [f32; WIDTH]);
    /// The triangles the ray meets, at any t.
    fn triangles(packet: &Packet, ray: &LocalRay) -> Meet;
    /// The triangles the ray meets or nearly meets, at any t.
    fn triangles_band(packet: &Packet, ray: &LocalRay) -> BandMeet;
}

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
    fn sheared(packet: &Packet, ray: &LocalRay, vertex: usize) -> Sheared {
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
            let first = |a: usize| node.planes[ray.first_plane[a]][i] * ray.inverse[a] - ray.first_offset[a];
            let last = |a: usize| node.planes[ray.first_plane[a] ^ 1][i] * ray.inverse[a] - ray.last_offset[a];
            *entry = max32(max32(first(0), first(1)), max32(first(2), 0.0));
            let exit = min32(min32(min32(last(0), last(1)), last(2)) * SLAB_SLACK, limit);
            bits |= u32::from(*entry <= exit) << i;
        }
        (bits, entry)
    }
    #[inline(always)]
    fn triangles(packet: &Packet, ray: &LocalRay) -> Meet {
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
    fn triangles_band(packet: &Packet, ray: &LocalRay) -> BandMeet {
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

#[cfg(target_arch = "x86_64")]
pub use avx2::Avx2;

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::*;

    use super::{BandMeet, Kernel, LEAF, LocalRay, Meet, Node, Packet, SLAB_SLACK, WIDTH};

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
    fn sheared(packet: &Packet, ray: &LocalRay, vertex: usize) -> Vertex {
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
    fn meet(vertices: &[Vertex; 3], edges: &[__m256d; 3], ray: &LocalRay) -> (u32, __m256d) {
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
        let weighted =
            _mm256_add_pd(_mm256_add_pd(_mm256_mul_pd(u, a[2]), _mm256_mul_pd(v, b[2])), _mm256_mul_pd(w, c[2]));
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
        let first = |a: usize| slab(ray.first_plane[a], ray.inverse[a], ray.first_offset[a]);
        let last = |a: usize| slab(ray.first_plane[a] ^ 1, ray.inverse[a], ray.last_offset[a]);
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
    fn triangles(packet: &Packet, ray: &LocalRay) -> Meet {
        let vertices = [sheared(packet, ray, 0), sheared(packet, ray, 1), sheared(packet, ray, 2)];
        let [a, b, c] = &vertices;
        let (hit, t) = meet(&vertices, &[edge(b, c), edge(c, a), edge(a, b)], ray);
        Meet { hit, t: store(t) }
    }
    #[inline]
    #[target_feature(enable = "avx2")]
    fn triangles_band(packet: &Packet, ray: &LocalRay) -> BandMeet {
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
        fn triangles(packet: &Packet, ray: &LocalRay) -> Meet {
            // SAFETY: see the type.
            unsafe { triangles(packet, ray) }
        }
        #[inline(always)]
        fn triangles_band(packet: &Packet, ray: &LocalRay) -> BandMeet {
            // SAFETY: see the type.
            unsafe { triangles_band(packet, ray) }
        }
    }
}

/// Defines functions that run their generic body with the best kernel of this processor, the whole body compiled for it.
macro_rules! dispatched {
    ($(fn $name:ident($($arg:ident: $type:ty),*) $(-> $out:ty)? = $body:ident;)*) => {$(
        fn $name($($arg: $type),*) $(-> $out)? {
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
                fn with_avx2($($arg: $type),*) $(-> $out)? {
                    $body::<$crate::trace::kernel::Avx2>($($arg),*)
                }
                if $crate::trace::kernel::has_avx2() {
                    // SAFETY: the processor has the features, just asked.
                    return unsafe { with_avx2($($arg),*) };
                }
            }
            $body::<$crate::trace::kernel::Portable>($($arg),*)
        }
    )*};
}
pub(super) use dispatched;

/// Whether this processor runs [`Avx2`]. The standard library remembers the answer.
#[cfg(target_arch = "x86_64")]
pub fn has_avx2() -> bool {
    use std::arch::is_x86_feature_detected as has;
    has!("avx2") && has!("fma") && has!("bmi1") && has!("bmi2") && has!("lzcnt") && has!("popcnt")
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use std::io::Write;

    use glam::{DAffine3, DVec3, Vec3};

    use super::*;
    use crate::scene::Mesh;
    use crate::trace::tree::{Box3, Item, NO_ITEM, Tree};

    /// Both kernels give the same bits, for rays through, beside and exactly at what they test.
    #[test]
    fn kernels_agree_to_the_bit() {
        if !has_avx2() {
            // Not eprintln: the test harness swallows what it prints in tests that pass, and skips are counted.
            writeln!(std::io::stderr(), "\nskipped: this processor has no AVX2").expect("standard error");
            return;
        }
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as f64 / f64::from(1u32 << 30) - 1.0
        };
        let points: Vec<[f64; 3]> = (0..96).map(|_| [random(), random(), random()]).collect();
        let faces: Vec<[i64; 3]> = (0..32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = Mesh::new(&points, &faces).unwrap();
        let p = mesh.positions_local();
        let item = |(i, t): (usize, &[u32; 3])| Item {
            bounds: t.iter().fold(Box3::EMPTY, |b, &v| b.with_point(p[v as usize])),
            id: i as u32,
        };
        let tree = Tree::build(mesh.triangles().iter().enumerate().map(item).collect(), LEAF);
        let all = Box3 { min: Vec3::NEG_ONE, max: Vec3::ONE };
        let (mut boxes, mut differ, mut hits, mut nears) = (0, 0, 0, 0);
        for i in 0..2000 {
            let origin = 2.0 * DVec3::new(random(), random(), random());
            let target = if i % 2 == 0 { p[i % 96].as_dvec3() } else { DVec3::new(random(), random(), random()) };
            let direction = target - origin;
            let band = [0.0, 1e-6, 1e-2][i % 3];
            let range = [0.0, f64::INFINITY];
            let Some(ray) = LocalRay::new(&DAffine3::IDENTITY, &all, origin, direction, range, band) else { continue };
            for node in &tree.nodes {
                let limit = [f32::INFINITY, 1.0][i % 2];
                let ((plain, at), (simd, simd_at)) =
                    (Portable::boxes(node, &ray, limit), Avx2::boxes(node, &ray, limit));
                differ += (plain ^ simd).count_ones();
                for i in (0..WIDTH).filter(|&i| (plain & simd) >> i & 1 != 0) {
                    // One rounding of a product, in lengths of the ray.
                    let rounding = f32::EPSILON * 3.0 * ray.inverse.map(f32::abs).into_iter().fold(0.0, f32::max);
                    assert!((at[i] - simd_at[i]).abs() <= rounding);
                }
                boxes += plain.count_ones();
            }
            for first in (0..32).step_by(3) {
                let packet = Packet::new(&mesh, [first, (first + 1) % 32, (first + 2) % 32, NO_ITEM]);
                let (a, b) = (Portable::triangles(&packet, &ray), Avx2::triangles(&packet, &ray));
                assert_eq!(a.hit, b.hit);
                let at = |lane: usize, bits: u32| (bits >> lane) & 1 != 0;
                (0..LEAF).filter(|&l| at(l, a.hit)).for_each(|l| assert_eq!(a.t[l].to_bits(), b.t[l].to_bits()));
                assert!(!at(3, a.hit), "an unused lane was met");
                let (a, b) = (Portable::triangles_band(&packet, &ray), Avx2::triangles_band(&packet, &ray));
                assert_eq!((a.inside, a.near), (b.inside, b.near));
                assert!(a.inside & !a.near == 0 && a.hit & !a.near == 0);
                if a.near != 0 {
                    assert_eq!((a.hit, a.t_low, a.t_high), (b.hit, b.t_low, b.t_high));
                }
                hits += a.hit.count_ones();
                nears += (a.near & !a.inside).count_ones();
            }
        }
        assert!(differ * 1000 <= boxes, "{differ} of {boxes} boxes");
        assert!(boxes > 1000 && hits > 1000 && nears > 1000, "{boxes} {hits} {nears}");
    }
}
