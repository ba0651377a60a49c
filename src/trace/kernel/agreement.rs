//! The portable tests and those in AVX2 against each other, and bundles against single rays.

use std::io::Write;

use glam::{DAffine3, DVec3, Vec3};

use super::roughly::told;
use super::{Avx2, Kernel, Portable, exact, has_avx2};
use crate::progress::Progress;
use crate::scene::Mesh;
use crate::trace::hierarchy::{Box3, Item, LEAF, NO_ITEM, Packet, Tree, WIDTH};
use crate::trace::rays::{ALL, BUNDLE, Bundle, Each, Hull, LocalRay, LocalRays, Shared, WorldRay, WorldRays};

/// The range of every ray.
const EVERYWHERE: fn(usize) -> [f64; 2] = |_| [0.0, f64::INFINITY];

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
    let item = |(i, t): (usize, &[u32; 3])| {
        Item::new(t.iter().fold(Box3::EMPTY, |b, &v| b.with_point(p[v as usize])), i as u32)
    };
    let items = mesh.triangles().iter().enumerate().map(item).collect();
    let tree = Tree::build::<LEAF>(items, &Progress::new()).unwrap();
    let all = Box3 { min: Vec3::NEG_ONE, max: Vec3::ONE };
    let (mut boxes, mut differ, mut hits, mut nears) = (0, 0, 0, 0);
    for i in 0..2000 {
        let origin = 2.0 * DVec3::new(random(), random(), random());
        let target = if i % 2 == 0 { p[i % 96].as_dvec3() } else { DVec3::new(random(), random(), random()) };
        let direction = target - origin;
        let band = [0.0, 1e-6, 1e-2][i % 3];
        let world = WorldRays::from([WorldRay { origin, direction }]);
        let mut ray = LocalRay::NONE;
        ray.fill(&DAffine3::IDENTITY, &all, &world, Shared::Nothing, EVERYWHERE, band, 1, false);
        if ray.together == 0 {
            continue;
        }
        let line = ray.line(0);
        for node in &tree.nodes {
            let limit = [f32::INFINITY, 1.0][i % 2];
            let ((plain, at), (simd, simd_at)) = (Portable::boxes(node, &ray, limit), Avx2::boxes(node, &ray, limit));
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
            for lane in 0..LEAF {
                let one = exact::triangle(&packet, lane, &line);
                assert_eq!(one.map(f64::to_bits), at(lane, b.hit).then(|| b.t[lane].to_bits()));
            }
            let (a, b) = (Portable::triangles_band(&packet, &line), Avx2::triangles_band(&packet, &line));
            assert_eq!((a.inside, a.near), (b.inside, b.near));
            assert!(a.inside & !a.near == 0 && a.hit & !a.near == 0);
            assert_eq!(a.hit & a.near, b.hit & b.near);
            for lane in 0..LEAF {
                let expected = at(lane, b.near).then(|| b.of(lane));
                let one = exact::triangle_band(&packet, lane, &line);
                assert_eq!(one, at(lane, a.near).then(|| a.of(lane)));
                assert_eq!(one.map(told), expected.map(told));
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
    let item = |id: u32, p: Vec3| Item::new(Box3 { min: p, max: p + Vec3::splat(0.05) }, id);
    let items = (0..300).map(|id| item(id, DVec3::new(random(), random(), random()).as_vec3())).collect();
    let tree = Tree::build::<LEAF>(items, &Progress::new()).unwrap();
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
        let mut rays = LocalRays::NONE;
        rays.fill(&DAffine3::IDENTITY, &tree.bounds, &world.into(), Shared::Nothing, EVERYWHERE, 0.0, ALL, false);
        let bits = rays.together;
        if bits == 0 {
            continue;
        }
        let bundle = Bundle { hull: Hull::new(&rays, bits), rays: &rays };
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
                    let mut ray = LocalRay::NONE;
                    ray.fill(
                        &DAffine3::IDENTITY,
                        &tree.bounds,
                        &[world[r]].into(),
                        Shared::Nothing,
                        EVERYWHERE,
                        0.0,
                        1,
                        false,
                    );
                    assert_eq!(ray.together, 1);
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
