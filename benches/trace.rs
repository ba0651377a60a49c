//! Truth: hierarchy build, primary rays, shadow rays and the whole mask at 1024 x 1024, on a generated scene of 437,712
//! triangles (rolling ground under 49 knobbly statues), as one mesh and as 50 instances of two meshes.
//!
//! `cargo bench --no-default-features --bench trace`

use std::f64::consts::{PI, TAU};
use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use glam::{DAffine3, DVec3};
use shadowlab::scene::{DirectionalLight, Instance};
use shadowlab::trace::{Hit, Tracer};
use shadowlab::{Camera, Light, Mesh, Progress, Scene};

const SIZE: u32 = 1024;

type Arrays = (Vec<[f64; 3]>, Vec<[i64; 3]>);

/// A grid of quads, `map` takes (0..=1, 0..=1) to space.
fn patch(nu: i64, nv: i64, map: impl Fn(f64, f64) -> DVec3) -> Arrays {
    let at = |i: i64, j: i64| map(i as f64 / nu as f64, j as f64 / nv as f64).to_array();
    let vertices = (0..=nu).flat_map(|i| (0..=nv).map(move |j| (i, j))).map(|(i, j)| at(i, j)).collect();
    let quad = |i: i64, j: i64| {
        let a = i * (nv + 1) + j;
        let b = a + nv + 1;
        [[a, a + 1, b], [b, a + 1, b + 1]]
    };
    let faces = (0..nu).flat_map(|i| (0..nv).flat_map(move |j| quad(i, j))).collect();
    (vertices, faces)
}

fn hill(x: f64, z: f64) -> f64 {
    0.3 * (0.9 * x).sin() * (0.7 * z).cos() + 0.04 * (5.0 * x).cos() * (4.0 * z + x).sin()
}

fn ground() -> Arrays {
    patch(330, 330, |u, v| {
        let (x, z) = (20.0 * u - 10.0, 20.0 * v - 10.0);
        DVec3::new(x, hill(x, z), z)
    })
}

fn statue() -> Arrays {
    patch(66, 34, |u, v| {
        let (turn, tilt) = (TAU * u, PI * v);
        let radius = 0.5 + 0.06 * (7.0 * turn).sin() * (9.0 * tilt).sin() + 0.1 * (3.0 * tilt).cos();
        radius * DVec3::new(tilt.sin() * turn.cos(), 2.0 * tilt.cos(), tilt.sin() * turn.sin())
    })
}

fn places() -> impl Iterator<Item = DVec3> {
    (0..49).map(|i| {
        let (x, z) = (f64::from(i % 7) * 2.6 - 7.8, f64::from(i / 7) * 2.6 - 7.8);
        DVec3::new(x, hill(x, z) + 0.9, z)
    })
}

fn one_mesh() -> Scene {
    let (mut vertices, mut faces) = ground();
    let (points, triangles) = statue();
    for place in places() {
        let first = vertices.len() as i64;
        vertices.extend(points.iter().map(|&p| (DVec3::from_array(p) + place).to_array()));
        faces.extend(triangles.iter().map(|t| t.map(|i| i + first)));
    }
    Scene::from_mesh(Mesh::new(&vertices, &faces).unwrap()).unwrap()
}

fn instances() -> Scene {
    let mesh = |(vertices, faces): Arrays| Arc::new(Mesh::new(&vertices, &faces).unwrap());
    let at = |mesh, place| Instance { mesh, world_from_mesh: DAffine3::from_translation(place) };
    let placed = std::iter::once(at(0, DVec3::ZERO)).chain(places().map(|p| at(1, p)));
    Scene::new(vec![mesh(ground()), mesh(statue())], placed.collect()).unwrap()
}

fn view() -> (Camera, Light) {
    let camera = Camera::look_at(
        DVec3::new(0.0, 4.0, 11.0),
        DVec3::new(0.0, 0.0, 1.0),
        DVec3::Y,
        60f64.to_radians(),
        1.0,
        0.1,
        100.0,
    );
    (camera.unwrap(), Light::Directional(DirectionalLight::new(DVec3::new(0.6, -1.0, 0.3)).unwrap()))
}

/// Rays through the pixels' centres in rows, then from what they meet to the light.
#[allow(clippy::type_complexity)]
fn rays(tracer: &Tracer, camera: &Camera, light: &Light) -> [(Vec<[f64; 3]>, Vec<[f64; 3]>); 2] {
    let centers = (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| (f64::from(x) + 0.5, f64::from(y) + 0.5)));
    let directions: Vec<[f64; 3]> =
        centers.map(|(x, y)| camera.pixel_ray(x, y, [SIZE; 2]).direction.to_array()).collect();
    let origins = vec![camera.eye().to_array(); directions.len()];
    let hits = tracer.first_hit(&origins, &directions, &Progress::new()).unwrap();
    let to_light = light.to_light(DVec3::ZERO);
    let start = |(hit, d): (&Hit, &[f64; 3])| {
        let p = camera.eye() + hit.t * DVec3::from_array(*d);
        hit.t.is_finite().then(|| (p + 1e-6 * to_light).to_array())
    };
    let starts: Vec<[f64; 3]> = hits.iter().zip(&directions).filter_map(start).collect();
    let to_light = vec![to_light.to_array(); starts.len()];
    [(origins, directions), (starts, to_light)]
}

fn benches(c: &mut Criterion) {
    let progress = Progress::new();
    let (camera, light) = view();
    for (name, scene) in [("one mesh", one_mesh()), ("50 instances", instances())] {
        let mut group = c.benchmark_group(format!("trace, {name}"));
        group.sample_size(20);
        let tracer = Tracer::new(&scene, &progress).unwrap();
        println!(
            "{name}: {} triangles, {} rays per mask, {:.1} bytes a triangle",
            scene.triangle_count(),
            SIZE * SIZE,
            tracer.memory() as f64 / scene.meshes().iter().map(|m| m.triangles().len()).sum::<usize>() as f64
        );
        let [(origins, directions), (starts, to_light)] = rays(&tracer, &camera, &light);
        let t_max = vec![f64::INFINITY; starts.len()];
        group.bench_function("build", |b| b.iter(|| Tracer::new(black_box(&scene), &progress).unwrap()));
        group.bench_function("primary", |b| b.iter(|| tracer.first_hit(&origins, &directions, &progress).unwrap()));
        group.bench_function("shadow", |b| b.iter(|| tracer.occluded(&starts, &to_light, &t_max, &progress).unwrap()));
        group.bench_function("mask", |b| b.iter(|| tracer.shadow_mask(&camera, &light, [SIZE; 2], &progress).unwrap()));
        group.finish();
    }
}

criterion_group!(all, benches);
criterion_main!(all);
