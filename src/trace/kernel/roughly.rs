//! The rough test against the exact ones: whatever rays and triangles it is given, it leaves out no ray that they keep. And the
//! exact tests of a bundle against those of one ray: the same bits. And what is told of rays beside one.

use glam::{DAffine3, DVec3, Vec3};

use super::{Kernel, Portable, exact};
use crate::trace::hierarchy::{Box3, LEAF, NO_ITEM, Packet};
use crate::trace::rays::{ALL, BUNDLE, Each, LocalRay, LocalRays, RayBits, Shared, WorldRay};

struct Random(u64);

impl Random {
    /// Between -1 and 1.
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as f64 / f64::from(1u32 << 30) - 1.0
    }
    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.number(), self.number(), self.number())
    }
}

/// Corners of a triangle near the middle: ordinary ones of many sizes, slivers, degenerate ones, and such that lie along axes.
fn triangle(random: &mut Random, case: usize) -> [DVec3; 3] {
    let size = [1.0, 0.1, 3e-3, 1e-5, 1e-7][case % 5];
    let a = 0.5 * random.vector();
    let (ab, ac) = (size * random.vector(), size * random.vector());
    match (case / 5) % 6 {
        0 | 1 => [a, a + ab, a + ac],
        2 => [a, a + ab, a + 0.3 * ab + 1e-6 * ac],
        3 => [a, a + ab, a + 2.0 * ab],
        4 => [a, a, a + ab],
        _ => [a.with_y(0.25), (a + ab).with_y(0.25), (a + ac).with_y(0.25)],
    }
}

/// Rays at such a triangle: at its inside, its corners and its edges exactly, past it by a hair, along its plane, and past it.
fn ray(random: &mut Random, [a, b, c]: [DVec3; 3], aim: usize, origin: DVec3) -> WorldRay {
    let share = 0.5 + 0.5 * random.number();
    let inside = a.lerp(b, share).lerp(c, 0.5 + 0.5 * random.number());
    let target = match aim {
        0 => inside,
        1 => a,
        2 => a.lerp(b, share),
        3 => a + 1e-7 * random.vector(),
        4 => inside + (b - a) * 1e-6 + 1e-9 * random.vector(),
        5 => a + 4.0 * (b - c),
        _ => inside + 0.2 * random.vector(),
    };
    // Along the plane, from a point in it.
    let origin = if aim == 6 { b + 2.0 * (b - a) } else { origin };
    WorldRay { origin, direction: target - origin }
}

/// What is told of a pass: where the triangle is met only where it is.
pub fn told(pass: exact::Pass) -> (bool, bool, u64, f64, f64) {
    let t = if pass.is_hit { pass.t } else { 0.0 };
    (pass.is_hit, pass.is_inside, t.to_bits(), pass.t_low, pass.t_high)
}

/// Bits of the rays that the exact tests keep.
fn kept(packet: &Packet, lane: usize, rays: &LocalRays<BUNDLE>) -> RayBits {
    let is_kept = |r: usize| {
        let line = rays.line(r);
        exact::triangle(packet, lane, &line).is_some() || exact::triangle_band(packet, lane, &line).is_some()
    };
    Each(rays.together).filter(|&r| is_kept(r)).fold(0, |bits, r| bits | 1 << r)
}

fn leaves_out_no_ray<K: Kernel>() {
    let mut random = Random(7);
    let bounds = Box3 { min: Vec3::NEG_ONE, max: Vec3::ONE };
    let (mut met, mut spared, mut asked) = (0, 0, 0);
    let (mut ahead_met, mut behind, mut left_behind) = (0, 0, 0);
    for case in 0..12_000 {
        // As a packet has them, the last lane unused.
        let corners = [0, 1, 2, 0].map(|k| triangle(&mut random, case / 3 + k).map(|p| p.as_vec3().as_dvec3()));
        let mut packet = Packet { vertices: [[[0.0; LEAF]; 3]; 3], triangles: [0, 1, 2, NO_ITEM] };
        for (lane, corners) in corners.iter().enumerate() {
            for vertex in 0..3 {
                let p = if lane == 3 { corners[0] } else { corners[vertex] };
                (0..3).for_each(|axis| packet.vertices[vertex][axis][lane] = p[axis] as f32);
            }
        }
        // On a surface, near, where rays are not yet moved to the box, and far beyond what single precision resolves.
        let far = [0.5, 3.0, 15.0, 40.0, 1e3, 1e7, 1e11][case % 7];
        let origin = if case % 11 == 0 { corners[0][0] } else { far * random.vector() };
        let band = [0.0, 1e-7, 1e-3, 0.1][case % 4];
        let world: [WorldRay; BUNDLE] = std::array::from_fn(|r| {
            let origin = if case % 2 == 0 { origin } else { origin + 1e-3 * random.vector() };
            let ray = ray(&mut random, corners[r % 3], (case + r) % 8, origin);
            // Some have it behind them.
            WorldRay { direction: if case % 5 == 4 { -ray.direction } else { ray.direction }, ..ray }
        });
        let mut rays = LocalRays::NONE;
        rays.fill(
            &DAffine3::IDENTITY,
            &bounds,
            &world.into(),
            Shared::Nothing,
            |_| [0.0, f64::INFINITY],
            band,
            ALL,
            true,
        );
        let near = K::rays_near::<false>(&packet, &rays, ALL);
        let ahead = K::rays_near::<true>(&packet, &rays, ALL);
        // Where the band is narrow and the origin is near, the test is of use.
        let is_narrow = band <= 1e-7 && far < 16.0;
        for lane in 0..LEAF {
            let mut t = [0.0; BUNDLE];
            let hit = K::rays_meet(&packet, lane, &rays, rays.together, &mut t);
            let passed = K::rays_pass(&packet, lane, &rays, rays.together);
            for r in Each(rays.together) {
                let (line, is_in) = (rays.line(r), |bits: RayBits| (bits >> r) & 1 != 0);
                let one = exact::triangle(&packet, lane, &line);
                assert_eq!(one.map(f64::to_bits), is_in(hit).then(|| t[r].to_bits()));
                let pass = exact::triangle_band(&packet, lane, &line);
                assert_eq!(pass.map(told), is_in(passed.near).then(|| told(passed.of(r))));
                let Some(t) = one else { continue };
                // Rays are moved to the box, in which all of a tree's triangles lie; some of these reach beyond it.
                let at = world[r].origin + t * world[r].direction;
                let is_ahead = t > 0.0 && at.abs().max_element() <= 1.0;
                assert!(!is_ahead || is_in(ahead[lane]), "case {case}, lane {lane}: left out; {rays:?} {packet:?}");
                ahead_met += u32::from(is_ahead);
                if t < 0.0 && is_narrow {
                    behind += 1;
                    left_behind += u32::from(!is_in(ahead[lane]));
                }
            }
            assert_eq!((hit | passed.near) & !rays.together, 0);
            assert_eq!(ahead[lane] & !near[lane], 0);
            let kept = kept(&packet, lane, &rays);
            assert_eq!(kept & !near[lane], 0, "case {case}, lane {lane}: left out; {rays:?} {packet:?}");
            met += kept.count_ones();
            if is_narrow {
                asked += (rays.together & !kept).count_ones();
                spared += (rays.together & !kept & !near[lane]).count_ones();
            }
        }
    }
    assert!(
        ahead_met > 10_000 && behind > 1000 && left_behind * 10 > behind * 3,
        "{ahead_met} {left_behind} of {behind}"
    );
    assert!(met > 10_000 && asked > 10_000 && spared * 10 > asked * 4, "{met} {spared} of {asked}");
}

/// Rays beside one that passes inside a triangle, as far off as shading moves them.
#[test]
fn rays_beside_one_meet_a_triangle_no_farther_than_is_told() {
    let mut random = Random(11);
    let bounds = Box3 { min: Vec3::NEG_ONE, max: Vec3::ONE };
    let (mut told, mut narrowed, mut behind, mut asked) = (0, 0, 0, 0);
    for case in 0..30_000 {
        let corners = triangle(&mut random, case).map(|p| p.as_vec3().as_dvec3());
        let mut packet = Packet { vertices: [[[0.0; LEAF]; 3]; 3], triangles: [0, NO_ITEM, NO_ITEM, NO_ITEM] };
        for vertex in 0..3 {
            (0..3).for_each(|axis| packet.vertices[vertex][axis][0] = corners[vertex][axis] as f32);
        }
        let band = [1e-7, 1e-5, 1e-3][case % 3];
        let line = |origin: DVec3, direction: DVec3| {
            let rays = [WorldRay { origin, direction }].into();
            let mut ray = LocalRay::NONE;
            ray.fill(&DAffine3::IDENTITY, &bounds, &rays, Shared::Nothing, |_| [-1e9, 1e9], band, 1, false);
            ray.line(0)
        };
        let origin = 2.0 * random.vector();
        let target = corners[0].lerp(corners[1], random.number().abs()).lerp(corners[2], random.number().abs());
        let direction = (target - origin) * [1.0, -1.0, -0.3, 7.0][case % 4];
        let axis = (0..3).max_by(|a, b| direction[*a].abs().total_cmp(&direction[*b].abs())).unwrap();
        let farthest = corners.map(|p| (p[axis] - origin[axis]) / direction[axis]).into_iter().fold(f64::MIN, f64::max);
        let Some(pass) = exact::triangle_band(&packet, 0, &line(origin, direction)) else { continue };
        if !pass.is_inside {
            continue;
        }
        told += 1;
        if pass.t_high >= farthest * (1.0 - 1e-12 * farthest.signum()) {
            continue;
        }
        narrowed += 1;
        for _ in 0..8 {
            let start = origin + random.vector().normalize() * (1.42 * band);
            if let Some(t) = exact::triangle(&packet, 0, &line(start, direction)) {
                asked += 1;
                assert!(t <= pass.t_high, "case {case}: {t} {pass:?}");
            }
            if pass.t_high < 0.0
                && let Some(t) = exact::triangle(&packet, 0, &line(start, origin + direction - start))
            {
                behind += 1;
                assert!(t < 0.0, "case {case}: {t} {pass:?}");
            }
        }
    }
    assert!(narrowed * 2 > told && asked > 10_000 && behind > 3000, "{narrowed} of {told}, {asked}, {behind}");
}

#[test]
fn the_portable_rough_test_leaves_out_no_ray() {
    leaves_out_no_ray::<Portable>();
}

#[cfg(target_arch = "x86_64")]
#[test]
fn the_rough_test_in_avx2_leaves_out_no_ray() {
    use std::io::Write;

    if !super::has_avx2() {
        writeln!(std::io::stderr(), "\nskipped: this processor has no AVX2").expect("standard error");
        return;
    }
    leaves_out_no_ray::<super::Avx2>();
}
