//! The CPU renderer on a generated scene of about 440,000 triangles: depth maps, G-buffer, shadow mask.

use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use glam::{DAffine3, DMat4, DVec3};
use shadowlab::parameterization::{Parameterization, Partition, PostWarp};
use shadowlab::render::cpu::{CpuRenderer, look_up};
use shadowlab::render::{Bias, Filter, MaskSettings, Renderer, Stored};
use shadowlab::scene::{DirectionalLight, Instance, SpotLight};
use shadowlab::{Camera, Light, Mesh, Progress, Scene};

/// A grid of (n + 1) x (m + 1) vertices from a function of [0, 1]^2.
fn grid(n: usize, m: usize, point: impl Fn(f64, f64) -> DVec3) -> Mesh {
    let at = |i: usize, j: usize| (j * (n + 1) + i) as i64;
    let vertices: Vec<[f64; 3]> = (0..=m)
        .flat_map(|j| (0..=n).map(move |i| (i, j)))
        .map(|(i, j)| point(i as f64 / n as f64, j as f64 / m as f64).to_array())
        .collect();
    let faces: Vec<[i64; 3]> = (0..m)
        .flat_map(|j| (0..n).map(move |i| (i, j)))
        .flat_map(|(i, j)| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]])
        .collect();
    Mesh::new(&vertices, &faces).expect("a grid is a mesh")
}

/// Four displaced spheres of 100,352 triangles each on a rolling ground of 39,200: 440,608 triangles.
fn scene() -> Scene {
    use std::f64::consts::{PI, TAU};
    let mut meshes = vec![Arc::new(grid(140, 140, |u, v| {
        DVec3::new(6.0 * u - 3.0, 0.05 * (9.0 * u).sin() * (7.0 * v).cos() - 1.0, 6.0 * v - 3.0)
    }))];
    for k in 0..4 {
        let (a, b) = (5.0 + f64::from(k), 3.0 + 2.0 * f64::from(k));
        let center = DVec3::new(f64::from(k % 2) * 2.2 - 1.1, 0.0, f64::from(k / 2) * 2.2 - 1.1);
        meshes.push(Arc::new(grid(224, 224, move |u, v| {
            let (phi, theta) = (TAU * u, PI * v);
            let r = 1.0 + 0.08 * (a * phi).sin() * (b * theta).sin();
            center + r * DVec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin())
        })));
    }
    let instances =
        (0..meshes.len()).map(|m| Instance { mesh: m as u32, world_from_mesh: DAffine3::IDENTITY }).collect();
    Scene::new(meshes, instances).expect("the scene is valid")
}

/// The orthographic map of a light that covers the scene.
fn map(scene: &Scene, direction: DVec3) -> Parameterization {
    let bounds = scene.bounds();
    let radius = 0.5 * bounds.diagonal();
    let eye = bounds.center() - 2.0 * radius * direction;
    let view = glam::dcamera::rh::view::look_to_mat4(eye, direction, DVec3::Z);
    let projection =
        glam::dcamera::rh::proj::directx::orthographic(-radius, radius, -radius, radius, radius, 3.0 * radius);
    Parameterization::of_partitions(vec![Partition::of_matrix(projection * view)], [1024; 2])
}

fn render(c: &mut Criterion) {
    let scene = scene();
    assert_eq!(scene.triangle_count(), 440_608);
    let direction = DVec3::new(-0.4, -1.0, -0.3).normalize();
    let light = Light::Directional(DirectionalLight::new(direction).expect("a direction"));
    let p = map(&scene, direction);
    let camera = Camera::look_at(DVec3::new(4.0, 2.5, 5.0), DVec3::ZERO, DVec3::Y, 0.8, 1.0, 0.1, 50.0).expect("valid");
    let renderer = CpuRenderer::new();
    let progress = Progress::new();
    for n in [1024, 2048, 4096] {
        c.bench_function(&format!("depth/{n}"), |b| {
            b.iter(|| black_box(renderer.depth_maps(&scene, &p, [n, n], Stored::default(), &progress)))
        });
    }
    let size = [1024, 1024];
    for text in ["front:format=unorm16", "front:spacing=linear", "back", "second", "midpoint", "dual"] {
        let stored: Stored = text.parse().expect("a surface");
        c.bench_function(&format!("depth/1024/{text}"), |b| {
            b.iter(|| black_box(renderer.depth_maps(&scene, &p, size, stored, &progress)))
        });
    }
    c.bench_function("gbuffer/1024", |b| b.iter(|| black_box(renderer.gbuffer(&scene, &camera, size, &progress))));
    for (name, filter) in Filter::PLAIN {
        let settings = MaskSettings {
            resolution: size,
            size,
            bias: Bias::default(),
            filter,
            blend: 0.0,
            stored: Stored::default(),
        };
        c.bench_function(&format!("mask/1024/{name}"), |b| {
            b.iter(|| black_box(renderer.shadow_mask(&scene, &camera, &light, &p, &settings, &progress)))
        });
    }
    // Maps and G-buffer are there: 28 bytes read and 6 written a pixel, and the texels.
    let g = renderer.gbuffer(&scene, &camera, size, &progress).expect("a G-buffer");
    let spot = DVec3::new(2.0, 5.0, 1.5);
    let spot = SpotLight::new(spot, -spot, 1.0, 20.0).expect("a spot");
    let view = glam::dcamera::rh::view::look_to_mat4(spot.position(), spot.direction(), DVec3::Z);
    let seen = glam::dcamera::rh::proj::directx::perspective(1.0, 1.0, 1.0, 20.0) * view;
    let by_spot = Parameterization::of_partitions(vec![Partition::of_matrix(seen)], size);
    // Four maps of the whole, each for a quarter of the depths that are in view.
    let ends = [5.5, 6.5, 7.5, 50.0];
    let part = |end| Partition { eye_depth: [0.0, end], ..p.partitions[0].clone() };
    let by_depth = Parameterization::of_partitions(ends.map(part).to_vec(), size);
    let mut group = c.benchmark_group("lookup/1024");
    for (name, light, p) in [("one", &light, &p), ("spot", &Light::Spot(spot), &by_spot), ("four", &light, &by_depth)] {
        let maps = renderer.depth_maps(&scene, p, size, Stored::default(), &progress).expect("maps").data;
        for text in ["nearest", "bilinear", "pcf:size=3", "tent:size=3px"] {
            let filter = text.parse().expect("a filter");
            let (bias, stored) = (Bias::default(), Stored::default());
            let settings = MaskSettings { resolution: size, size, bias, filter, blend: 0.0, stored };
            group.bench_function(format!("{name}/{text}"), |b| {
                b.iter(|| black_box(look_up(&maps, g.surfaces(), &camera, light, p, &settings, &progress)))
            });
        }
    }
    group.finish();
    // A warp as the field's techniques make them: perspective over the map, small triangles at one end.
    let warp = DMat4::from_cols_array(&[1., 0., 0., 0., 0., 1.25, 0., 0.75, 0., 0., 1., 0., 0., 0.75, 0., 1.25]);
    let mut warped = p.clone();
    warped.partitions[0].shadow_clip_from_world = warp * p.partitions[0].shadow_clip_from_world;
    c.bench_function("depth/1024/warped", |b| {
        b.iter(|| black_box(renderer.depth_maps(&scene, &warped, size, Stored::default(), &progress)))
    });
    // And the logarithm of its w, which spans 1/2 to 2.
    let mut logarithmic = warped.clone();
    logarithmic.partitions[0].post_warp = PostWarp::Log { scale: 1.0 / 2.0_f64.ln(), offset: 0.0 };
    c.bench_function("depth/1024/logarithmic", |b| {
        b.iter(|| black_box(renderer.depth_maps(&scene, &logarithmic, size, Stored::default(), &progress)))
    });
}

criterion_group!(benches, render);
criterion_main!(benches);
