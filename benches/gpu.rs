//! Kernels of the gpu renderer, the way back to the host included: depth maps at three resolutions, G-buffer, mask, footprint;
//! beside the last one the G-buffer and aliasing's kernel on the processor.
//!
//! Scene: rolling ground of 400 x 400 quads with 12 tori over it, 440,000 triangles in one mesh and one instance.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use glam::DVec3;
use shadowlab::aliasing::footprint::footprint;
use shadowlab::parameterization::Partition;
use shadowlab::render::{Bias, Filter, MaskSettings, Renderer, Stored, gpu::GpuRenderer};
use shadowlab::scene::DirectionalLight;
use shadowlab::{Camera, Light, Mesh, Parameterization, Progress, Scene};

/// The scene: deterministic, no file.
fn scene() -> Scene {
    let mut vertices: Vec<[f64; 3]> = Vec::new();
    let mut faces: Vec<[i64; 3]> = Vec::new();
    let mut patch = |columns: i64, rows: i64, point: &dyn Fn(f64, f64) -> [f64; 3]| {
        let first = vertices.len() as i64;
        for j in 0..=rows {
            vertices.extend((0..=columns).map(|i| point(i as f64 / columns as f64, j as f64 / rows as f64)));
        }
        for j in 0..rows {
            for i in 0..columns {
                let [a, b] = [first + j * (columns + 1) + i, first + (j + 1) * (columns + 1) + i];
                faces.extend([[a, b, a + 1], [a + 1, b, b + 1]]);
            }
        }
    };
    patch(400, 400, &|u, v| {
        let (x, z) = (40.0 * u - 20.0, 40.0 * v - 20.0);
        [x, 0.8 * (0.7 * x).sin() * (0.5 * z).cos(), z]
    });
    for k in 0..12 {
        let (cx, cz) = (f64::from(k % 4) * 9.0 - 13.5, f64::from(k / 4) * 12.0 - 12.0);
        patch(100, 50, &|u, v| {
            let (a, b) = (std::f64::consts::TAU * u, std::f64::consts::TAU * v);
            let ring = 2.5 + 0.8 * b.cos();
            [cx + ring * a.cos(), 3.5 + ring * a.sin(), cz + 0.8 * b.sin()]
        });
    }
    Scene::from_mesh(Mesh::new(&vertices, &faces).unwrap()).unwrap()
}

/// A light from above at an angle that sees all of the scene.
fn parameterization(light_direction: DVec3) -> Parameterization {
    let view = glam::dcamera::rh::view::look_to_mat4(-60.0 * light_direction, light_direction, DVec3::Z);
    let projection = glam::dcamera::rh::proj::directx::orthographic(-30.0, 30.0, -30.0, 30.0, 1.0, 120.0);
    Parameterization::of_partitions(vec![Partition::of_matrix(projection * view)], [1024; 2])
}

fn bench(c: &mut Criterion) {
    let renderer = match GpuRenderer::new(None) {
        Ok(renderer) => renderer,
        Err(error) => return println!("skipped: {error}"),
    };
    println!("adapter: {}", renderer.adapter());
    let (scene, progress) = (scene(), Progress::new());
    assert_eq!(scene.triangle_count(), 440_000);
    let light = DirectionalLight::new(DVec3::new(0.4, -1.0, 0.3)).unwrap();
    let p = parameterization(light.direction());
    let mut group = c.benchmark_group("gpu");
    group.sample_size(10);
    for side in [1024, 2048, 4096] {
        group.bench_with_input(BenchmarkId::new("depth_map", side), &side, |b, &side| {
            b.iter(|| black_box(renderer.depth_maps(&scene, &p, [side; 2], Stored::default(), &progress).unwrap()));
        });
    }
    let eye = DVec3::new(18.0, 12.0, 22.0);
    let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, 1.0, 1.0, 0.1, 100.0).unwrap();
    let size = [1024; 2];
    group.bench_function("gbuffer/1024", |b| {
        b.iter(|| black_box(renderer.gbuffer(&scene, &camera, size, &progress).unwrap()));
    });
    let light = Light::Directional(light);
    for (name, filter) in Filter::PLAIN {
        let settings = MaskSettings {
            resolution: [2048; 2],
            size,
            bias: Bias::default(),
            filter,
            blend: 0.0,
            stored: Stored::default(),
        };
        group.bench_function(format!("mask/{name}/1024"), |b| {
            b.iter(|| black_box(renderer.shadow_mask(&scene, &camera, &light, &p, &settings, &progress).unwrap()));
        });
    }
    let resolution = [2048; 2];
    group.bench_function("footprint/1024", |b| {
        b.iter(|| black_box(renderer.footprint(&scene, &camera, &light, &p, resolution, size, &progress).unwrap()));
    });
    group.bench_function("footprint/on the processor/1024", |b| {
        b.iter(|| {
            let g = renderer.gbuffer(&scene, &camera, size, &progress).unwrap();
            black_box(footprint(&g.surfaces(), &camera, &light, &p, resolution, &progress).unwrap())
        });
    });
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
