//! The inner tests, of eight boxes against a ray or the hull of a bundle, of a box against eight rays, of four triangles
//! against a ray: portable, and for AVX2 chosen at run time.
//!
//! Triangles give the same bits in both: every operation is an IEEE addition, multiplication, division or comparison in
//! the same order, nothing is contracted. Boxes may differ in the last bits, for which they are padded: which of them are
//! entered has no say in the answer.

use super::bundle::{BUNDLE, Bundle, Hull, RayBits};
use super::packet::Packet;
use super::ray::{Line, LocalRay, SLAB_SLACK};
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
    /// Children whose boxes a ray within the hull may meet before `limit` (bits), and a lower bound of where.
    fn hull_boxes(node: &Node, hull: &Hull, limit: f32) -> (u32, [f32; WIDTH]);
    /// The rays that may meet a child's box, each before its limit.
    fn rays_in_box(node: &Node, child: usize, bundle: &Bundle, limits: &[f32; BUNDLE]) -> RayBits;
    /// The triangles the ray meets, at any t.
    fn triangles(packet: &Packet, ray: &Line) -> Meet;
    /// The triangles the ray meets or nearly meets, at any t.
    fn triangles_band(packet: &Packet, ray: &Line) -> BandMeet;
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

#[cfg(target_arch = "x86_64")]
pub use avx2::Avx2;

#[cfg(target_arch = "x86_64")]
mod avx2;

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
    use crate::trace::bundle::Each;
    use crate::trace::ray::LocalRays;
    use crate::trace::traverse::WorldRay;
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
            let world = WorldRay { origin, direction };
            let (ray, alive, _) = LocalRay::new(&DAffine3::IDENTITY, &all, &[world], &[range], band, 1);
            if alive == 0 {
                continue;
            }
            let line = ray.line(0);
            for node in &tree.nodes {
                let limit = [f32::INFINITY, 1.0][i % 2];
                let ((plain, at), (simd, simd_at)) =
                    (Portable::boxes(node, &ray, limit), Avx2::boxes(node, &ray, limit));
                differ += (plain ^ simd).count_ones();
                for i in (0..WIDTH).filter(|&i| (plain & simd) >> i & 1 != 0) {
                    // One rounding of a product, in lengths of the ray.
                    let rounding = f32::EPSILON * 3.0 * ray.inverse.map(|x| x[0].abs()).into_iter().fold(0.0, f32::max);
                    assert!((at[i] - simd_at[i]).abs() <= rounding);
                }
                boxes += plain.count_ones();
            }
            for first in (0..32).step_by(3) {
                let packet = Packet::new(&mesh, [first, (first + 1) % 32, (first + 2) % 32, NO_ITEM]);
                let (a, b) = (Portable::triangles(&packet, &line), Avx2::triangles(&packet, &line));
                assert_eq!(a.hit, b.hit);
                let at = |lane: usize, bits: u32| (bits >> lane) & 1 != 0;
                (0..LEAF).filter(|&l| at(l, a.hit)).for_each(|l| assert_eq!(a.t[l].to_bits(), b.t[l].to_bits()));
                assert!(!at(3, a.hit), "an unused lane was met");
                let (a, b) = (Portable::triangles_band(&packet, &line), Avx2::triangles_band(&packet, &line));
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

    /// A box that one ray of a bundle may meet is met by the hull and by that ray in the bundle, in both kernels.
    #[test]
    fn bundles_miss_no_box_that_one_of_their_rays_meets() {
        if !has_avx2() {
            writeln!(std::io::stderr(), "\nskipped: this processor has no AVX2").expect("standard error");
            return;
        }
        let mut state = 3u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as f64 / f64::from(1u32 << 30) - 1.0
        };
        let item = |id: u32, p: Vec3| Item { bounds: Box3 { min: p, max: p + Vec3::splat(0.05) }, id };
        let items = (0..300).map(|id| item(id, DVec3::new(random(), random(), random()).as_vec3())).collect();
        let tree = Tree::build(items, LEAF);
        let (mut met, mut spared) = (0, 0);
        for i in 0..500 {
            let reach = [1.5, 100.0][i % 2];
            let origin = reach * DVec3::new(random(), random(), random());
            let towards = DVec3::new(random(), random(), random()) - origin;
            let apart = [0.0, 1e-3, 0.3][i % 3];
            let world: [WorldRay; BUNDLE] = std::array::from_fn(|_| {
                let mut moved = || apart * DVec3::new(random(), random(), random());
                WorldRay { origin: origin + moved(), direction: towards + moved() }
            });
            let ranges = [[0.0, f64::INFINITY]; BUNDLE];
            let (rays, bits, _) = LocalRays::new(&DAffine3::IDENTITY, &tree.bounds, &world, &ranges, 0.0, 0xff);
            if bits == 0 {
                continue;
            }
            let bundle = Bundle { hull: Hull::new(&rays, bits), rays };
            let limits = [f32::INFINITY; BUNDLE];
            for node in &tree.nodes {
                let (plain, simd) = (
                    Portable::hull_boxes(node, &bundle.hull, f32::INFINITY).0,
                    Avx2::hull_boxes(node, &bundle.hull, f32::INFINITY).0,
                );
                assert_eq!(plain, simd);
                for child in 0..WIDTH {
                    let of_rays = Avx2::rays_in_box(node, child, &bundle, &limits) & bits;
                    let mut alone = 0;
                    for r in Each(bits) {
                        let (ray, alive, _) =
                            LocalRay::new(&DAffine3::IDENTITY, &tree.bounds, &[world[r]], &[ranges[r]], 0.0, 1);
                        assert_eq!(alive, 1);
                        assert_eq!(ray.line(0), bundle.rays.line(r), "a ray is another one among others");
                        alone |= ((Avx2::boxes(node, &ray, f32::INFINITY).0 >> child) & 1) << r;
                    }
                    assert_eq!(alone, of_rays);
                    assert!(alone == 0 || (simd >> child) & 1 != 0, "the hull misses a box");
                    met += alone.count_ones();
                    spared += (!simd >> child) & 1;
                }
            }
        }
        assert!(met > 1000 && spared > 1000, "{met} {spared}");
    }
}
