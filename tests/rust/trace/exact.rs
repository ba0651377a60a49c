//! Rays against brute force over all triangles, against cracks, and under changes of place, scale and instancing.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use shadowlab::scene::{DirectionalLight, Instance};
use shadowlab::trace::{Hit, Tracer};
use shadowlab::{Camera, Light, Mesh, Progress, Scene};

/// Error of t between two ways to compute it in f64 (here, and in a mesh's frame), relative to the sizes that enter:
/// each way rounds fewer than 64 times by 2^-53, amplified by the reciprocal of the sine of the angle to the plane, at
/// most 1 / [`GRAZING`].
const T_ERROR: f64 = 128.0 * f64::EPSILON;
/// Rays flatter to a triangle than this are left out of the comparison.
const GRAZING: f64 = 1e-3;
/// Rays that pass an edge closer than this (relative barycentric) may be given to either side.
const EDGE: f64 = 1e-9;

fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        // splitmix64
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn vector(random: &mut impl FnMut() -> f64) -> DVec3 {
    DVec3::new(random(), random(), random()) * 2.0 - 1.0
}

fn arrays(points: &[DVec3]) -> Vec<[f64; 3]> {
    points.iter().map(|p| p.to_array()).collect()
}

/// Triangles anywhere in the cube, of all sizes, some without area.
fn soup(count: usize, seed: u64) -> Arc<Mesh> {
    let mut random = random(seed);
    let mut points = Vec::new();
    for i in 0..count {
        let size = 2f64.powf(-6.0 * random());
        let p = vector(&mut random);
        let q = p + size * vector(&mut random);
        let r = match i % 50 {
            0 => p,
            1 => 0.5 * (p + q),
            _ => p + size * vector(&mut random),
        };
        points.extend([p, q, r]);
    }
    let faces: Vec<[i64; 3]> = (0..count as i64).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Arc::new(Mesh::new(&arrays(&points), &faces).unwrap())
}

fn placed(mesh: Arc<Mesh>, world_from_mesh: DAffine3) -> Scene {
    Scene::new(vec![mesh], vec![Instance { mesh: 0, world_from_mesh }]).unwrap()
}

fn world_corners(scene: &Scene, instance: usize, triangle: usize) -> [DVec3; 3] {
    let mesh = scene.mesh_of(instance);
    let map = &scene.world_from_local(instance);
    mesh.triangles()[triangle].map(|i| map.transform_point3(mesh.positions_local()[i as usize].as_dvec3()))
}

/// (t, smallest barycentric coordinate, cosine of ray and normal) by Cramer's rule.
fn meet([a, b, c]: [DVec3; 3], o: DVec3, d: DVec3) -> Option<(f64, f64, f64)> {
    let n = (b - a).cross(c - a);
    let det = -d.dot(n);
    if det == 0.0 {
        return None;
    }
    let ao = o - a;
    let dao = ao.cross(d);
    let (u, v) = ((c - a).dot(dao) / det, -(b - a).dot(dao) / det);
    Some((ao.dot(n) / det, u.min(v).min(1.0 - u - v), (det / (d.length() * n.length())).abs()))
}

fn assert_agrees_with_brute_force(scene: &Scene, rays: &[(DVec3, DVec3)]) {
    let tracer = Tracer::new(scene, &Progress::new()).unwrap();
    let (o, d): (Vec<_>, Vec<_>) = rays.iter().map(|(o, d)| (o.to_array(), d.to_array())).unzip();
    let hits = tracer.first_hit(&o, &d, &Progress::new()).unwrap();
    let extent = scene.bounds().diagonal();
    let mut compared = 0;
    for (hit, &(o, d)) in hits.iter().zip(rays) {
        let mut best = Hit { t: f64::INFINITY, triangle: -1, instance: -1 };
        let mut doubtful = false;
        for instance in 0..scene.instances().len() {
            for triangle in 0..scene.mesh_of(instance).triangles().len() {
                let Some((t, inside, cosine)) = meet(world_corners(scene, instance, triangle), o, d) else { continue };
                doubtful |= inside.abs() < EDGE || (inside > 0.0 && (cosine < GRAZING || t.abs() < EDGE));
                if inside >= 0.0 && t > 0.0 && t < best.t {
                    best = Hit { t, triangle: triangle as i32, instance: instance as i32 };
                }
            }
        }
        if doubtful {
            continue;
        }
        compared += 1;
        assert_eq!((hit.instance, hit.triangle), (best.instance, best.triangle), "{o} {d}: {hit:?} {best:?}");
        let bound = T_ERROR / GRAZING * (extent + (o - scene.origin()).length()) / d.length();
        assert!(hit.t == best.t || (hit.t - best.t).abs() <= bound, "{o} {d}: {} {}", hit.t, best.t);
    }
    assert!(compared * 10 > rays.len() * 8, "only {compared} of {} rays could be compared", rays.len());
    // The same through the other question, on either side of the hit.
    let until: Vec<f64> = hits.iter().map(|h| h.t).collect();
    assert!(!tracer.occluded(&o, &d, &until, &Progress::new()).unwrap().contains(&true));
    let beyond: Vec<f64> = until.iter().map(|t| t.next_up()).collect();
    let occluded = tracer.occluded(&o, &d, &beyond, &Progress::new()).unwrap();
    assert!(occluded.iter().zip(&hits).all(|(o, h)| *o == (h.instance >= 0)));
}

fn rays(count: usize, seed: u64, reach: f64) -> Vec<(DVec3, DVec3)> {
    let mut random = random(seed);
    (0..count)
        .map(|i| {
            let o = reach * vector(&mut random);
            let target = vector(&mut random);
            let mut d = (target - o) * 2f64.powf(20.0 * random() - 10.0);
            // Every fourth ray runs in an axis plane, every eighth along an axis.
            if i % 4 == 0 {
                d[i / 4 % 3] = 0.0;
            }
            if i % 8 == 0 {
                d[(i / 4 + 1) % 3] = -0.0;
            }
            (o, d)
        })
        .collect()
}

#[test]
fn first_hits_are_those_of_brute_force() {
    let scene = placed(soup(600, 1), DAffine3::IDENTITY);
    assert_agrees_with_brute_force(&scene, &rays(1500, 2, 2.0));
    assert_agrees_with_brute_force(&scene, &rays(300, 3, 1e6));
}

/// Rays of a camera travel in company; alone, each has to say the same to the last bit.
#[test]
fn the_company_of_other_rays_changes_no_answer() {
    let (points, faces) = icosphere(4);
    let ball = Arc::new(Mesh::new(&arrays(&points), &faces).unwrap());
    let at = |mesh, x: f64| Instance { mesh, world_from_mesh: DAffine3::from_translation(DVec3::new(x, 0.1, 0.2)) };
    let one = placed(soup(3000, 12), DAffine3::IDENTITY);
    let many = Scene::new(vec![ball, soup(500, 13)], vec![at(0, 0.0), at(1, 0.3), at(0, -1.1)]).unwrap();
    for scene in [one, many] {
        let tracer = Tracer::new(&scene, &Progress::new()).unwrap();
        for reach in [1.0, 40.0] {
            let eye = reach * DVec3::new(0.3, 1.9, 2.2);
            let fov = 1.2 / reach;
            let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, fov, 1.0, 0.01, 1e3).unwrap();
            let pixels = (0..97 * 97).map(|i| (f64::from(i % 97) + 0.5, f64::from(i / 97) + 0.5));
            let d: Vec<[f64; 3]> = pixels.map(|(x, y)| camera.pixel_ray(x, y, [97, 97]).direction.to_array()).collect();
            let o = vec![eye.to_array(); d.len()];
            let together = tracer.first_hit(&o, &d, &Progress::new()).unwrap();
            assert!(together.iter().filter(|h| h.instance >= 0).count() > 2000);
            let until: Vec<f64> = together.iter().map(|h| h.t.min(2.0 * reach)).collect();
            let blocked = tracer.occluded(&o, &d, &until, &Progress::new()).unwrap();
            for i in 0..d.len() {
                assert_eq!(tracer.first_hit(&o[i..=i], &d[i..=i], &Progress::new()).unwrap()[0], together[i]);
                let alone = tracer.occluded(&o[i..=i], &d[i..=i], &until[i..=i], &Progress::new()).unwrap()[0];
                assert_eq!(alone, blocked[i]);
            }
        }
    }
}

fn shear() -> DMat3 {
    DMat3::from_cols(DVec3::new(-1.0, 0.2, 0.0), DVec3::new(0.7, 1.0, 0.0), DVec3::new(0.0, -0.4, 1.0))
}

#[test]
fn instances_of_every_kind_agree_with_brute_force() {
    let maps = [
        DMat3::from_rotation_y(1.0),
        DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)),
        shear(),
        DMat3::from_diagonal(DVec3::splat(1e-3)),
        DMat3::from_diagonal(DVec3::new(1.0, 1e-5, 1.0)),
    ];
    let mut random = random(5);
    let instances = (0..20).map(|i| Instance {
        mesh: i % 2,
        world_from_mesh: DAffine3::from_mat3_translation(0.3 * maps[i as usize % 5], vector(&mut random)),
    });
    let scene = Scene::new(vec![soup(60, 6), soup(41, 7)], instances.collect()).unwrap();
    assert_agrees_with_brute_force(&scene, &rays(600, 8, 2.0));
}

#[test]
fn a_flattened_instance_is_met_in_its_plane() {
    // Exactly flat, and flatter than an inverse in f64 could tell.
    for thickness in [0.0, 1e-14] {
        let flatten = DMat3::from_diagonal(DVec3::new(1.0, thickness, 0.5));
        let scene = placed(soup(60, 6), DAffine3::from_mat3(DMat3::from_rotation_z(0.5) * flatten));
        let tracer = Tracer::new(&scene, &Progress::new()).unwrap();
        let normal = DMat3::from_rotation_z(0.5) * DVec3::Y;
        let mut met = 0;
        for (o, d) in rays(2000, 9, 2.0) {
            let slope = d.normalize().dot(normal).abs();
            let hit = tracer.first_hit(&[o.to_array()], &[d.to_array()], &Progress::new()).unwrap()[0];
            if slope < GRAZING {
                continue;
            }
            let expected = (0..60).any(|triangle| {
                let corners = world_corners(&scene, 0, triangle).map(|p| p - normal * normal.dot(p));
                meet(corners, o, d).is_some_and(|(t, inside, _)| t > 0.0 && inside > 1e-4)
            });
            assert!(hit.instance == 0 || !expected, "{o} {d} goes through");
            if hit.instance == 0 {
                met += 1;
                // Baked vertices are rounded to f32 in a frame of size 1 to 2; slivers tilt by more, but stay in.
                let height = (o + hit.t * d).dot(normal).abs();
                assert!(height <= 4.0 * f64::from(f32::EPSILON), "{height}");
            }
        }
        assert!(met > 50, "{met}");
    }
}

/// An icosphere with 20 * 4^levels triangles.
fn icosphere(levels: u32) -> (Vec<DVec3>, Vec<[i64; 3]>) {
    let g = (1.0 + 5f64.sqrt()) / 2.0;
    let mut points: Vec<DVec3> = [[0.0, 1.0, g], [0.0, -1.0, g], [0.0, 1.0, -g], [0.0, -1.0, -g]]
        .iter()
        .flat_map(|p| [[p[0], p[1], p[2]], [p[1], p[2], p[0]], [p[2], p[0], p[1]]])
        .map(|p| DVec3::from_array(p).normalize())
        .collect();
    let near = |a: usize, b: usize| points[a].distance(points[b]) < 1.1;
    let mut faces: Vec<[i64; 3]> = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            faces.extend(
                (b + 1..12).filter(|&c| near(a, b) && near(b, c) && near(a, c)).map(|c| [a, b, c].map(|i| i as i64)),
            );
        }
    }
    assert_eq!(faces.len(), 20);
    for _ in 0..levels {
        let mut middle = HashMap::new();
        let mut next = Vec::new();
        for &[a, b, c] in &faces {
            let mut half = |i: i64, j: i64| {
                *middle.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    points.push((points[i as usize] + points[j as usize]).normalize());
                    points.len() as i64 - 1
                })
            };
            let (ab, bc, ca) = (half(a, b), half(b, c), half(c, a));
            next.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        faces = next;
    }
    (points, faces)
}

#[test]
fn a_closed_mesh_has_no_gaps() {
    let (points, faces) = icosphere(3);
    let mesh = Arc::new(Mesh::new(&arrays(&points), &faces).unwrap());
    let mut random = random(11);
    for map in [DMat3::IDENTITY, shear() * DMat3::from_rotation_x(0.3)] {
        let scene = placed(mesh.clone(), DAffine3::from_mat3(map));
        let tracer = Tracer::new(&scene, &Progress::new()).unwrap();
        let leaks = |origins: &[[f64; 3]], directions: &[[f64; 3]]| {
            let hits = tracer.first_hit(origins, directions, &Progress::new()).unwrap();
            hits.iter().filter(|h| h.instance < 0).count()
        };
        let (mut origins, mut directions) = (Vec::new(), Vec::new());
        // From inside, at vertices, middles of edges and points of edges, as exactly as f64 can aim.
        for i in 0..100_000 {
            let corners = world_corners(&scene, 0, i % faces.len());
            let (a, b) = (corners[i / 3 % 3], corners[(i / 3 + 1) % 3]);
            let aim = match i % 3 {
                0 => a,
                1 => 0.5 * (a + b),
                _ => a.lerp(b, random()),
            };
            let o = 0.4 * vector(&mut random);
            origins.push(o.to_array());
            directions.push(((aim - o) * 2f64.powi((i % 40) as i32 - 20)).to_array());
        }
        assert_eq!(leaks(&origins, &directions), 0, "rays leaked out");
        // The same lines from far outside: each passes the inner point, so it has to be met on the way in.
        for (o, d) in origins.iter_mut().zip(&directions) {
            *o = (DVec3::from_array(*o) - 1e4 * DVec3::from_array(*d).normalize()).to_array();
        }
        assert_eq!(leaks(&origins, &directions), 0, "rays leaked in");
    }
}

/// Ground, a wall, and an icosphere, seen under a sun.
fn yard_mask(map: &DAffine3, is_instanced: bool) -> Vec<i8> {
    let (mut points, mut faces) = icosphere(2);
    let first = points.len() as i64;
    points.extend([[-4.0, -1.0, -4.0], [4.0, -1.0, -4.0], [4.0, -1.0, 4.0], [-4.0, -1.0, 4.0]].map(DVec3::from_array));
    points.extend([[1.5, -1.0, -2.0], [2.0, -1.0, 2.0], [2.0, 1.0, 2.0], [1.5, 1.0, -2.0]].map(DVec3::from_array));
    faces.extend([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]].map(|t: [i64; 3]| t.map(|i| i + first)));
    if !is_instanced {
        points.iter_mut().for_each(|p| *p = map.transform_point3(*p));
    }
    let mesh = Arc::new(Mesh::new(&arrays(&points), &faces).unwrap());
    let scene = placed(mesh, if is_instanced { *map } else { DAffine3::IDENTITY });
    let size = map.transform_vector3(DVec3::X).length();
    let p = |x, y, z| map.transform_point3(DVec3::new(x, y, z));
    let up = map.transform_vector3(DVec3::Y);
    let camera = Camera::look_at(p(5.0, 3.0, 6.0), p(0.3, -0.4, 0.1), up, 0.9, 1.0, 0.1 * size, 50.0 * size).unwrap();
    // No facet is exactly edge-on to it: there the answer is a matter of rounding, and rightly undecided.
    let direction = map.transform_vector3(DVec3::new(-0.6, -0.8, 0.23));
    let light = Light::Directional(DirectionalLight::new(direction).unwrap());
    let tracer = Tracer::new(&scene, &Progress::new()).unwrap();
    tracer.shadow_mask(&camera, &light, [160, 160], &Progress::new()).unwrap().data
}

#[test]
fn the_answer_is_the_same_at_every_place_and_scale_instanced_or_baked() {
    let reference = yard_mask(&DAffine3::IDENTITY, false);
    for value in [-2, 0, 1] {
        assert!(reference.iter().filter(|&&v| v == value).count() > 500, "the scene shows too little of {value}");
    }
    let maps = [
        ("utm", DAffine3::from_translation(DVec3::new(512_345.0, 35.0, 4_987_654.0))),
        ("tiny", DAffine3::from_scale(DVec3::splat(1e-6))),
        ("huge", DAffine3::from_scale(DVec3::splat(1e9))),
        ("turned", DAffine3::from_mat3(DMat3::from_rotation_y(0.4) * DMat3::from_rotation_x(0.2))),
    ];
    for (name, map) in maps {
        for is_instanced in [false, true] {
            let mask = yard_mask(&map, is_instanced);
            // Vertices rounded to f32 in a turned frame move edges by 1e-7 of the scene; a pixel is 1e-2 of it.
            let differ = mask.iter().zip(&reference).filter(|(a, b)| a != b).count();
            assert!(differ <= 3, "{name}, instanced {is_instanced}: {differ} pixels differ");
        }
    }
}

#[test]
fn equal_triangles_are_told_apart_by_instance_and_index() {
    let floor = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    let mesh = Arc::new(Mesh::new(&floor, &[[0, 1, 2]; 9]).unwrap());
    let scene = Scene::new(vec![mesh], vec![Instance { mesh: 0, world_from_mesh: DAffine3::IDENTITY }; 5]).unwrap();
    let tracer = Tracer::new(&scene, &Progress::new()).unwrap();
    let hit = tracer.first_hit(&[[0.2, 1.0, 0.2]], &[[0.0, -2.0, 0.0]], &Progress::new()).unwrap()[0];
    assert_eq!(hit, Hit { t: 0.5, triangle: 0, instance: 0 });
}
