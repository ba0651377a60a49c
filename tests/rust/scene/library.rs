//! The procedural scenes keep what they promise: closed casters, counts, shared meshes, an eye in the open, shadows in view.
//!
//! Rays are cast by brute force over all triangles here: slow, but it shares nothing with the crate's own tracer.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;
use shadowlab::scene::library::{self, LibraryScene};
use shadowlab::{Error, Mesh, Scene};

fn build(name: &str, seed: u64, params: &[(&str, f64)]) -> LibraryScene {
    let params: Vec<(String, f64)> = params.iter().map(|&(name, value)| (name.to_string(), value)).collect();
    library::build(name, seed, &params).unwrap_or_else(|e| panic!("{name} {params:?}: {e}"))
}

/// Every scene with its defaults, and with each parameter at both ends of its range.
fn defaults_and_limits() -> Vec<LibraryScene> {
    let mut scenes = Vec::new();
    for spec in library::specs() {
        scenes.push(build(spec.name, 1, &[]));
        for param in spec.params {
            // A million trees are built once, in a test of their own.
            let max = if param.name == "trees" && spec.name == "forest" { 20_000.0 } else { param.max };
            scenes.extend([param.min, max].map(|value| build(spec.name, 1, &[(param.name, value)])));
        }
    }
    scenes
}

fn corners(mesh: &Mesh, triangle: [u32; 3]) -> [DVec3; 3] {
    triangle.map(|i| mesh.positions_local()[i as usize].as_dvec3())
}

/// Directed edges whose opposite does not occur exactly as often, and edges that occur twice the same way.
fn open_edges(mesh: &Mesh) -> usize {
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    for &[a, b, c] in mesh.triangles() {
        for edge in [(a, b), (b, c), (c, a)] {
            *edges.entry(edge).or_default() += 1;
        }
    }
    edges.iter().filter(|&(&(a, b), &count)| count != 1 || edges.get(&(b, a)) != Some(&1)).count()
}

/// What rays are cast against: each mesh with the way into its local frame.
struct Solids<'a>(Vec<(&'a Mesh, DAffine3)>);

impl<'a> Solids<'a> {
    fn of(scene: &'a Scene) -> Self {
        let placed = |k| (scene.mesh_of(k), scene.world_from_local(k).inverse());
        Self((0..scene.instances().len()).map(placed).collect())
    }
}

/// Parameters along the ray, with the sign of the side that is hit: 1 where the ray enters, -1 where it leaves.
fn crossings(solids: &Solids, origin: DVec3, direction: DVec3) -> Vec<(f64, i32)> {
    let mut found = Vec::new();
    for (mesh, local_from_world) in &solids.0 {
        let o = local_from_world.transform_point3(origin);
        let d = local_from_world.transform_vector3(direction);
        let (min, max) = (mesh.bounds_local().min, mesh.bounds_local().max);
        let (t0, t1) = ((min - o) / d, (max - o) / d);
        if t0.min(t1).max_element().max(0.0) > t0.max(t1).min_element() {
            continue;
        }
        for &triangle in mesh.triangles() {
            let [a, b, c] = corners(mesh, triangle).map(|p| p - o);
            // The line passes inside where all three volumes have the same sign.
            let (u, v, w) = (d.dot(c.cross(b)), d.dot(a.cross(c)), d.dot(b.cross(a)));
            let det = u + v + w;
            let is_inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
            if is_inside && det != 0.0 {
                let t = (a * u + b * v + c * w).dot(d) / (det * d.length_squared());
                if t > 0.0 {
                    // Turned inwards and outwards is told in the mesh's own frame, mirrored or not.
                    found.push((t, if det > 0.0 { 1 } else { -1 }));
                }
            }
        }
    }
    found
}

/// How many solids hold a point: the ray's crossings summed up, where it leaves more often than it enters.
fn solids_around(solids: &Solids, p: DVec3) -> i32 {
    // An arbitrary direction, so that the ray meets no edge of the axis-aligned parts; upwards, where little is in the way.
    -crossings(solids, p, DVec3::new(0.3127, 0.8913, 0.2719)).iter().map(|&(_, sign)| sign).sum::<i32>()
}

/// (depth, lit) of the pixels of a small picture; nothing where the ray meets nothing.
fn look(shown: &LibraryScene, size: [u32; 2]) -> Vec<Option<(f64, bool)>> {
    let (camera, solids) = (&shown.camera, &Solids::of(&shown.scene));
    let nearest = |hits: Vec<(f64, i32)>| hits.into_iter().map(|(t, _)| t).reduce(f64::min);
    (0..size[0] * size[1])
        .into_par_iter()
        .map(|k| {
            let (x, y) = (f64::from(k % size[0]) + 0.5, f64::from(k / size[0]) + 0.5);
            let ray = camera.pixel_ray(x, y, size).direction;
            let z = nearest(crossings(solids, camera.eye(), ray))?;
            // Stepped back by a millionth, far above the rounding and far below any detail.
            let p = camera.eye() + ray * (z * (1.0 - 1e-6));
            let to_light = shown.light.to_light(p);
            let reach = if shown.light.kind() == "directional" { f64::INFINITY } else { 1.0 };
            let blocked = nearest(crossings(solids, p, to_light)).is_some_and(|t| t < reach);
            Some((z, shown.light.reaches(p) && !blocked))
        })
        .collect()
}

#[test]
fn the_specs_are_sound() {
    assert_eq!(library::names(), ["courtyard", "robots", "ceiling", "skylight", "dueling", "forest", "statues"]);
    for spec in library::specs() {
        assert!(!spec.title.is_empty() && !spec.shows.is_empty());
        for (k, param) in spec.params.iter().enumerate() {
            assert!(param.min <= param.default && param.default <= param.max, "{}.{}", spec.name, param.name);
            assert!(!param.doc.is_empty() && spec.params[..k].iter().all(|p| p.name != param.name));
            if param.whole {
                assert!([param.min, param.default, param.max].iter().all(|x| x.fract() == 0.0));
            }
        }
    }
}

#[test]
fn every_mesh_is_closed_and_faces_outwards() {
    for shown in defaults_and_limits() {
        for (k, mesh) in shown.scene.meshes().iter().enumerate() {
            assert_eq!(open_edges(mesh), 0, "{} mesh {k}", shown.name);
            let volume: f64 =
                mesh.triangles().iter().map(|&t| corners(mesh, t)).map(|[a, b, c]| a.dot(b.cross(c))).sum();
            assert!(volume > 0.0, "{} mesh {k} is inside out: {volume}", shown.name);
            let flat = mesh
                .triangles()
                .iter()
                .map(|&t| corners(mesh, t))
                .filter(|[a, b, c]| (*b - *a).cross(*c - *a).length() == 0.0);
            assert_eq!(flat.count(), 0, "{} mesh {k} has triangles without area", shown.name);
        }
    }
}

#[test]
fn an_opened_mesh_is_noticed() {
    let closed = build("robots", 1, &[]).scene.meshes()[0].clone();
    let vertices: Vec<[f64; 3]> = closed.positions_local().iter().map(|p| p.as_dvec3().to_array()).collect();
    let faces: Vec<[i64; 3]> = closed.triangles().iter().map(|t| t.map(i64::from)).collect();
    assert_eq!(open_edges(&Mesh::new(&vertices, &faces).unwrap()), 0);
    assert_eq!(open_edges(&Mesh::new(&vertices, &faces[1..]).unwrap()), 3);
    let mut turned = faces;
    turned[0].swap(0, 1);
    assert_ne!(open_edges(&Mesh::new(&vertices, &turned).unwrap()), 0);
}

#[test]
fn counts_are_the_promised_ones_whatever_the_seed() {
    for seed in [0, 1, 2, u64::MAX] {
        let count = |name: &str| build(name, seed, &[]).scene.triangle_count();
        assert!((200_000..=450_000).contains(&count("courtyard")), "{}", count("courtyard"));
        assert!((10_000..=12_000).contains(&count("robots")), "{}", count("robots"));
        assert!((21_000..=25_000).contains(&count("ceiling")), "{}", count("ceiling"));
        assert!((20_000..=100_000).contains(&count("skylight")), "{}", count("skylight"));
        assert!((20_000..=200_000).contains(&count("dueling")), "{}", count("dueling"));
        assert!((3_000_000..=9_000_000).contains(&count("forest")), "{}", count("forest"));
        // As many as the scene that the scene-optimized shadow maps were measured in.
        assert!((443_000..=445_000).contains(&count("statues")), "{}", count("statues"));
    }
}

#[test]
fn the_same_seed_gives_the_same_scene_and_another_seed_another() {
    let content = |name: &str, seed: u64| {
        let scene = build(name, seed, &[]).scene;
        let meshes: Vec<(Vec<Vec3>, Vec<[u32; 3]>)> =
            scene.meshes().iter().map(|m| (m.positions_local().to_vec(), m.triangles().to_vec())).collect();
        (meshes, scene.instances().to_vec())
    };
    for name in library::names() {
        assert!(content(name, 5) == content(name, 5), "{name}");
        assert!(content(name, 5) != content(name, 6), "{name}");
    }
}

#[test]
fn repeated_geometry_is_shared() {
    for name in library::names() {
        let scene = build(name, 1, &[]).scene;
        let unique: u64 = scene.meshes().iter().map(|m| m.triangles().len() as u64).sum();
        let used: std::collections::HashSet<u32> = scene.instances().iter().map(|i| i.mesh).collect();
        assert_eq!(used.len(), scene.meshes().len(), "{name}: a mesh that nobody places");
        assert!(scene.triangle_count() > unique, "{name}");
    }
    let forest = build("forest", 1, &[]).scene;
    let unique: u64 = forest.meshes().iter().map(|m| m.triangles().len() as u64).sum();
    assert!(20 * unique < forest.triangle_count(), "{unique} of {}", forest.triangle_count());
}

#[test]
fn bounds_are_finite_and_the_eye_is_in_the_open() {
    let seeds = (2..8).flat_map(|seed| library::names().into_iter().map(move |name| build(name, seed, &[])));
    for shown in defaults_and_limits().into_iter().chain(seeds) {
        let bounds = shown.scene.bounds();
        assert!(bounds.min.is_finite() && bounds.max.is_finite() && bounds.extent().min_element() > 0.0);
        let (eye, solids) = (shown.camera.eye(), Solids::of(&shown.scene));
        assert_eq!(solids_around(&solids, eye), 0, "{}: the eye is inside a solid", shown.name);
        // The test itself: a point a little below the first surface under the eye is inside.
        let first = crossings(&solids, eye, DVec3::NEG_Y).into_iter().map(|(t, _)| t).reduce(f64::min);
        let depth = first.expect("ground below the eye") + 1e-6 * bounds.extent().y;
        let below = eye + DVec3::NEG_Y * depth;
        assert!(solids_around(&solids, below) > 0, "{}", shown.name);
    }
}

#[test]
fn the_view_shows_shadows_and_light_between_near_and_far() {
    for name in library::names() {
        for seed in [1, 2] {
            let shown = build(name, seed, &[]);
            let pixels = look(&shown, [24, 14]);
            let hits: Vec<(f64, bool)> = pixels.iter().flatten().copied().collect();
            let (hit, lit) = (hits.len() as f64, hits.iter().filter(|h| h.1).count() as f64);
            assert!(hit > 0.55 * pixels.len() as f64, "{name} {seed}: only {hit} pixels show something");
            assert!((0.2..0.85).contains(&(lit / hit)), "{name} {seed}: {lit} of {hit} pixels are lit");
            let (near, far) = hits.iter().fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), h| (a.min(h.0), b.max(h.0)));
            let camera = &shown.camera;
            assert!(2.0 * camera.near() < near && far < camera.far(), "{name} {seed}: {near} to {far}");
            assert!(camera.far() < 30.0 * far, "{name} {seed}: far {}", camera.far());
        }
    }
}

#[test]
fn the_courtyard_reaches_from_near_to_far() {
    let depths: Vec<f64> = look(&build("courtyard", 1, &[]), [48, 27]).into_iter().flatten().map(|h| h.0).collect();
    assert!(depths.iter().any(|&z| z < 1.6) && depths.iter().any(|&z| z > 60.0));
}

#[test]
fn trees_stand_on_the_terrain() {
    let trees = 300;
    let scene = build("forest", 3, &[("trees", f64::from(trees))]).scene;
    // The terrain is the first instance, at its own place; trees follow.
    let terrain = Scene::new(vec![scene.meshes()[0].clone()], vec![scene.instances()[0]]).unwrap();
    let terrain = Solids::of(&terrain);
    let top = scene.bounds().max.y + 1.0;
    // Heights are rounded to 24 bits of the terrain's half extent of 500 m: 3e-5 m.
    const ROUNDING: f64 = 1e-4;
    scene.instances()[1..].par_iter().for_each(|instance| {
        let foot = instance.world_from_mesh.translation;
        let from = DVec3::new(foot.x, top, foot.z);
        let ground = crossings(&terrain, from, DVec3::NEG_Y).into_iter().map(|(t, _)| top - t).reduce(f64::max);
        let ground = ground.expect("a tree beyond the border of the terrain");
        assert!((foot.y - ground).abs() < ROUNDING, "a foot at {foot}, the ground at {ground}");
        let up = instance.world_from_mesh.matrix3.y_axis;
        assert!(up.x == 0.0 && up.y > 0.0 && up.z == 0.0, "a tree that leans: {up}");
    });
    assert!(scene.instances().len() > trees as usize);
}

#[test]
fn a_million_trees_are_placed_in_reasonable_time() {
    let start = Instant::now();
    let forest = build("forest", 1, &[("trees", 1e6)]).scene;
    assert!(forest.instances().len() > 1_000_000 && forest.triangle_count() > 300_000_000);
    // Seconds in an unoptimized build on a busy machine; only a mistake in the order of growth takes minutes.
    assert!(start.elapsed() < Duration::from_secs(120), "{:?}", start.elapsed());
}

#[test]
fn skylight_has_a_spot_light_on_request() {
    let shown = build("skylight", 1, &[("spot", 1.0)]);
    assert_eq!((shown.light.kind(), build("skylight", 1, &[]).light.kind()), ("spot", "directional"));
    let hits: Vec<(f64, bool)> = look(&shown, [32, 18]).into_iter().flatten().collect();
    let lit = hits.iter().filter(|h| h.1).count() as f64 / hits.len() as f64;
    assert!((0.1..0.85).contains(&lit), "{lit}");
}

#[test]
fn wrong_names_and_values_say_what_is_right() {
    let error = |name: &str, params: &[(&str, f64)]| {
        let params: Vec<(String, f64)> = params.iter().map(|&(name, value)| (name.to_string(), value)).collect();
        library::build(name, 1, &params).map(|s| s.name).unwrap_err()
    };
    let unknown = error("castle", &[]);
    assert!(matches!(&unknown, Error::UnknownName { valid, .. } if *valid == library::names()));
    assert!(unknown.to_string().contains("castle") && unknown.to_string().contains("courtyard"));
    let unknown = error("forest", &[("leaves", 1.0)]);
    assert!(matches!(&unknown, Error::UnknownName { valid, .. } if valid[0] == "trees"), "{unknown}");
    for value in [0.0, -1.0, 1_000_001.0, 2.5, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let text = error("forest", &[("trees", value)]).to_string();
        assert!(text.contains("trees: expected a whole number from 1 to 1000000"), "{text}");
    }
    assert!(error("skylight", &[("swell", 0.7)]).to_string().contains("a number from 0 to 0.6, got 0.7"));
    let twice = error("robots", &[("robots", 3.0), ("robots", 4.0)]);
    assert!(matches!(&twice, Error::InvalidArgument { .. }) && twice.to_string().contains("once"));
}
