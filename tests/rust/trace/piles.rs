//! Piles of coplanar and equal triangles: answers depend neither on the order of triangles and instances nor on rounding.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec2, DVec3, swizzles::Vec3Swizzles};
use shadowlab::scene::{DirectionalLight, Instance, PointLight};
use shadowlab::trace::{Hit, Tracer};
use shadowlab::{Camera, Light, Mesh, Progress, Scene};

use crate::support::views::Random;

/// Rays that pass an edge nearer than this, in units of the pile, may be given to either side.
const EDGE: f64 = 1e-9;

type Corners = [DVec3; 3];

fn shuffled<T: Clone>(all: &[T], random: &mut Random) -> Vec<T> {
    let mut all = all.to_vec();
    for i in (1..all.len()).rev() {
        all.swap(i, random.below(i + 1));
    }
    all
}

fn mesh(triangles: &[Corners]) -> Arc<Mesh> {
    let points: Vec<[f64; 3]> = triangles.as_flattened().iter().map(|p| p.to_array()).collect();
    let faces: Vec<[i64; 3]> = (0..triangles.len() as i64).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Arc::new(Mesh::new(&points, &faces).unwrap())
}

fn placed(meshes: Vec<Arc<Mesh>>, instances: &[(u32, DAffine3)]) -> Scene {
    let instances = instances.iter().map(|&(mesh, world_from_mesh)| Instance { mesh, world_from_mesh }).collect();
    Scene::new(meshes, instances).unwrap()
}

/// Triangulations of squares in the plane y = 0 that overlap: across both diagonals, fans about points inside, turned
/// corners, both windings, and some of them many times over.
fn pile() -> Vec<Corners> {
    let p = |x: f64, z: f64| DVec3::new(x, 0.0, z);
    let square = [p(-1.0, -1.0), p(1.0, -1.0), p(1.0, 1.0), p(-1.0, 1.0)];
    let [a, b, c, d] = square;
    let mut all = vec![[a, b, c], [a, c, d], [b, d, a], [d, b, c]];
    for middle in [p(0.1, 0.3), p(-0.75, 0.6), p(0.0, 0.0)] {
        all.extend((0..4).map(|k| [square[k], middle, square[(k + 1) % 4]]));
    }
    let small: Vec<Corners> = all.iter().map(|t| t.map(|q| 0.5 * q + p(0.3, 0.2))).collect();
    all.extend(small);
    let again: Vec<Corners> = all.iter().take(6).map(|&[a, b, c]| [b, c, a]).collect();
    all.extend(again.iter().cycle().take(6 * 20));
    all
}

/// The least distance to an edge, negative outside.
fn inside(t: &Corners, q: DVec2) -> f64 {
    let p = t.map(|p| p.xz());
    let turn = (p[1] - p[0]).perp_dot(p[2] - p[0]).signum();
    let side = |k: usize| turn * (p[(k + 1) % 3] - p[k]).normalize().perp_dot(q - p[k]);
    side(0).min(side(1)).min(side(2))
}

/// Rays from all over the place to points of the square, and where in it they go.
fn rays(count: usize, map: &DAffine3, random: &mut Random) -> Vec<(DVec3, DVec3, DVec2)> {
    (0..count)
        .map(|i| {
            let to = DVec2::new(random.between(-0.999, 0.999), random.between(-0.999, 0.999));
            // Also along the plane, up to a thousandth.
            let height = [3.0, 1.0, 0.05, 0.003][i % 4];
            let from = DVec3::new(random.between(-3.0, 3.0), height, random.between(-3.0, 3.0));
            let (from, to_world) = (map.transform_point3(from), map.transform_point3(DVec3::new(to.x, 0.0, to.y)));
            (from, (to_world - from) * 2f64.powi((i % 20) as i32 - 10), to)
        })
        .collect()
}

fn hits(scene: &Scene, rays: &[(DVec3, DVec3, DVec2)]) -> Vec<Hit> {
    let tracer = Tracer::new(scene, &Progress::new()).unwrap();
    let origins: Vec<[f64; 3]> = rays.iter().map(|r| r.0.to_array()).collect();
    let directions: Vec<[f64; 3]> = rays.iter().map(|r| r.1.to_array()).collect();
    let hits = tracer.first_hit(&origins, &directions, &Progress::new()).unwrap();
    let mut alone = tracer.one_by_one();
    for (ray, hit) in rays.iter().zip(&hits).step_by(7) {
        assert_eq!(alone.first_hit(ray.0, ray.1, f64::INFINITY), *hit);
    }
    hits
}

/// Turns and mirrors in f64: what is coplanar in a mesh stays so.
fn maps() -> [DAffine3; 4] {
    let turn = DMat3::from_rotation_x(0.6) * DMat3::from_rotation_z(-0.4);
    [
        DAffine3::IDENTITY,
        DAffine3::from_mat3_translation(turn, DVec3::new(0.3, -0.2, 0.7)),
        DAffine3::from_mat3_translation(turn * 1e4, DVec3::new(3e5, 1e4, -2e6)),
        DAffine3::from_mat3(turn * DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 2.0))),
    ]
}

#[test]
fn of_coplanar_triangles_the_lowest_number_is_met_in_every_order() {
    let mut random = Random(17);
    for map in maps() {
        let all = pile();
        let rays = rays(4000, &map, &mut random);
        let ordered = hits(&placed(vec![mesh(&all)], &[(0, map)]), &rays);
        for _ in 0..3 {
            let moved = shuffled(&all, &mut random);
            let found = hits(&placed(vec![mesh(&moved)], &[(0, map)]), &rays);
            for ((ray, hit), first) in rays.iter().zip(&found).zip(&ordered) {
                assert_eq!(hit.t.to_bits(), first.t.to_bits());
                let known: Vec<f64> = moved.iter().map(|t| inside(t, ray.2)).collect();
                if known.iter().any(|d| d.abs() < EDGE) {
                    continue;
                }
                let lowest = known.iter().position(|&d| d > 0.0).unwrap();
                assert_eq!(hit.triangle, lowest as i32);
            }
        }
    }
}

#[test]
fn of_coplanar_instances_the_lowest_is_met() {
    let mut random = Random(18);
    // One mesh beside itself, mirrored, turned about its normal, halved, and in a mesh of other size.
    let quarter = DMat3::from_rotation_y(0.5 * std::f64::consts::PI);
    let own = [
        DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0))),
        DAffine3::IDENTITY,
        DAffine3::from_mat3(quarter),
        DAffine3::from_mat3(DMat3::from_rotation_y(0.3)),
        DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0))),
        DAffine3::from_scale(DVec3::splat(1.25)),
    ];
    let all = pile();
    for map in maps() {
        let rays = rays(3000, &map, &mut random);
        for shift in 0..own.len() {
            let places: Vec<(u32, DAffine3)> =
                (0..own.len()).map(|i| (0, map * own[(i + shift) % own.len()])).collect();
            let found = hits(&placed(vec![mesh(&all)], &places), &rays);
            for (ray, hit) in rays.iter().zip(&found) {
                let local = |i: usize| {
                    let own = own[(i + shift) % own.len()];
                    own.inverse().transform_point3(DVec3::new(ray.2.x, 0.0, ray.2.y)).xz()
                };
                let nearest = |i: usize| all.iter().map(|t| inside(t, local(i)).abs()).fold(f64::INFINITY, f64::min);
                if (0..own.len()).any(|i| nearest(i) < EDGE) {
                    continue;
                }
                let met = |i: &usize| all.iter().any(|t| inside(t, local(*i)) > 0.0);
                let lowest = (0..own.len()).find(met).unwrap();
                assert_eq!(hit.instance, lowest as i32, "{ray:?}");
                let triangle = all.iter().position(|t| inside(t, local(lowest)) > 0.0).unwrap();
                assert_eq!(hit.triangle, triangle as i32, "{ray:?}");
            }
        }
    }
}

/// A pile on the floor, one aslant, crossing quads, and loose triangles; some twice, some a hundred times.
fn heap(random: &mut Random) -> Vec<Corners> {
    let mut all = pile();
    let tilt = DMat3::from_rotation_x(0.8) * DMat3::from_rotation_z(0.5);
    let aslant: Vec<Corners> = all.iter().step_by(9).map(|t| t.map(|p| tilt * p + DVec3::new(0.2, 0.4, 0.1))).collect();
    all.extend(&aslant);
    for _ in 0..60 {
        let at = random.direction() * random.unit();
        all.push([0, 1, 2].map(|_| at + random.direction() * 0.3));
    }
    let loose = all[all.len() - 60..].to_vec();
    all.extend(&loose);
    all.extend(loose[..3].iter().cycle().take(300));
    all
}

#[test]
fn masks_and_occlusion_do_not_depend_on_the_order() {
    let mut random = Random(19);
    let all = heap(&mut random);
    let half: Vec<Corners> = all.iter().map(|t| t.map(|p| 0.7 * p + DVec3::new(0.4, 0.0, -0.3))).collect();
    let camera = Camera::look_at(DVec3::new(0.5, 1.9, 2.4), DVec3::ZERO, DVec3::Y, 0.9, 1.0, 0.1, 50.0).unwrap();
    let lights = [
        Light::Directional(DirectionalLight::new(DVec3::new(0.3, -1.0, 0.2)).unwrap()),
        Light::Point(PointLight::new(DVec3::new(0.3, 2.0, -0.6), 50.0).unwrap()),
        // On the floor.
        Light::Point(PointLight::new(DVec3::new(0.1, 0.0, 0.3), 50.0).unwrap()),
    ];
    let mirrored = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)));
    let crossing = DAffine3::from_mat3(DMat3::from_rotation_z(0.3));
    let answers = |first: &[Corners], second: &[Corners], order: &[usize]| {
        let places = [(0, DAffine3::IDENTITY), (1, mirrored), (0, crossing), (1, crossing), (0, mirrored)];
        let places: Vec<(u32, DAffine3)> = order.iter().map(|&i| places[i]).collect();
        let scene = placed(vec![mesh(first), mesh(second)], &places);
        let tracer = Tracer::new(&scene, &Progress::new()).unwrap();
        let masks = lights.map(|l| tracer.shadow_mask(&camera, &l, [64, 64], &Progress::new()).unwrap().data);
        let mut random = Random(23);
        let rays = rays(2000, &DAffine3::IDENTITY, &mut random);
        let [origins, directions] = [0, 1].map(|k| -> Vec<[f64; 3]> {
            rays.iter().map(|r| if k == 0 { r.0.to_array() } else { r.1.to_array() }).collect()
        });
        let limits: Vec<f64> = (0..rays.len()).map(|i| 2f64.powi((i % 20) as i32 - 10).recip() * 0.9).collect();
        let blocked = tracer.occluded(&origins, &directions, &limits, &Progress::new()).unwrap();
        let t: Vec<u64> = hits(&scene, &rays).iter().map(|h| h.t.to_bits()).collect();
        (masks, blocked, t)
    };
    let reference = answers(&all, &half, &[0, 1, 2, 3, 4]);
    for mask in &reference.0[..2] {
        for value in [0, 1] {
            assert!(mask.iter().filter(|&&v| v == value).count() > 150, "too little of {value}");
        }
        assert!(mask.iter().filter(|&&v| v == -1).count() < 100);
    }
    assert!(reference.1.iter().any(|&b| b) && reference.1.iter().any(|&b| !b));
    for _ in 0..4 {
        let (first, second) = (shuffled(&all, &mut random), shuffled(&half, &mut random));
        let order = shuffled(&[0, 1, 2, 3, 4], &mut random);
        let found = answers(&first, &second, &order);
        assert!(found == reference, "another order, another answer");
    }
    // Twice and a hundred times over: the same surfaces.
    for copies in [2, 100] {
        let many: Vec<Corners> = all.iter().cycle().take(copies * all.len()).copied().collect();
        let found = answers(&many, &half, &[0, 1, 2, 3, 4]);
        assert!(found == reference, "{copies} times over, another answer");
    }
}
