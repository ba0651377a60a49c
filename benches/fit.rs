//! What a parameterization costs: bodies, fit, and the whole, for one mesh and for ten thousand instances.
//!
//! `cargo bench --bench fit --no-default-features`. On a noisy machine count instructions instead:
//! `valgrind --tool=callgrind --toggle-collect='*parameterize*' <the bench's binary> --profile-time 1 <name>`.

#![allow(missing_docs)]

use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use glam::{DAffine3, DMat3, DVec3};
use shadowlab::Progress;
use shadowlab::fit::{MapSize, Tightening, fit};
use shadowlab::focus::{Focus, FocusedView};
use shadowlab::geometry::Aabb;
use shadowlab::rays::LightFrame;
use shadowlab::scene::{Camera, DirectionalLight, Instance, Light, Mesh, Scene, SpotLight};
use shadowlab::survey::samples_of_view;
use shadowlab::techniques::{specs, technique_of};

fn cube() -> Arc<Mesh> {
    let corners = Aabb { min: DVec3::NEG_ONE, max: DVec3::ONE }.corners().map(|p| p.to_array());
    let faces: [[i64; 4]; 6] = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];
    let triangles: Vec<[i64; 3]> = faces.iter().flat_map(|f| [[f[0], f[1], f[2]], [f[0], f[2], f[3]]]).collect();
    Arc::new(Mesh::new(&corners, &triangles).expect("a cube"))
}

fn instance(scale: DVec3, turn: f64, at: DVec3) -> Instance {
    let matrix = DMat3::from_rotation_y(turn) * DMat3::from_diagonal(scale);
    Instance { mesh: 0, world_from_mesh: DAffine3::from_mat3_translation(matrix, at) }
}

/// One box around everything, as a single loaded mesh has.
fn one_mesh() -> Scene {
    Scene::new(vec![cube()], vec![instance(DVec3::new(30.0, 6.5, 45.0), 0.0, DVec3::new(0.0, 5.5, -35.0))])
        .expect("a scene")
}

/// A floor and a hundred rows of a hundred turned boxes.
fn ten_thousand() -> Scene {
    let mut all = vec![instance(DVec3::new(200.0, 0.1, 200.0), 0.0, DVec3::ZERO)];
    for i in 0..10_000 {
        let at = DVec3::new(f64::from(i % 100) * 4.0 - 198.0, 2.0, f64::from(i / 100) * 4.0 - 198.0);
        all.push(instance(DVec3::new(1.0, 2.0 + f64::from(i % 7), 1.2), f64::from(i), at));
    }
    Scene::new(vec![cube()], all).expect("a scene")
}

fn camera() -> Camera {
    let eye = DVec3::new(1.0, 2.0, 8.0);
    Camera::look_at(eye, eye + DVec3::new(-0.1, -0.15, -1.0), DVec3::Y, 1.047, 4.0 / 3.0, 1.0, 100.0).expect("a camera")
}

fn sun() -> Light {
    Light::Directional(DirectionalLight::new(DVec3::new(0.4, -1.0, -0.3)).expect("a light"))
}

fn lamp() -> Light {
    Light::Spot(SpotLight::new(DVec3::new(-12.0, 11.0, 2.0), DVec3::new(0.6, -0.6, -0.9), 1.2, 90.0).expect("a light"))
}

/// Every technique with its defaults, under the lights it serves; medians over many views are `benches/techniques.rs`'s.
fn parameterize(c: &mut Criterion) {
    let (one, many, camera) = (one_mesh(), ten_thousand(), camera());
    // The search for the least error, in its norms, with a weight and with a fit that its outline of receivers is not of.
    let optimal = [
        "lispsm:over=body,range=body,fit=exact",
        "lispsm:over=body,range=body,fit=exact,norm=storage",
        "lispsm:over=body,range=body,fit=exact,norm=mean",
        "lispsm:over=body,range=body,fit=exact,near_weight=3",
        "lispsm:over=body,range=body,fit=intersection",
        "lispsm:near=delta-z,range=body,fit=exact",
        "lispsm:near=delta-z,range=body,fit=intersection",
    ];
    let names = specs().map(|spec| spec.name).chain(["lispsm:axis=middle"]).chain(optimal);
    for name in names {
        let t = technique_of(name).expect(name);
        for (scene_name, scene) in [("one mesh", &one), ("10,000 instances", &many)] {
            for (light_name, light) in [("sun", sun()), ("spot", lamp())] {
                let samples = samples_of_view(scene, &camera, &light, t.needs(), &Progress::new()).expect("samples");
                let samples = samples.as_ref();
                if t.parameterize_seen(scene, &camera, &light, [1024; 2], samples).is_err() {
                    continue;
                }
                c.bench_function(&format!("parameterize/{name}/{scene_name}/{light_name}"), |b| {
                    b.iter(|| {
                        let (scene, camera, light) = (black_box(scene), black_box(&camera), black_box(&light));
                        t.parameterize_seen(scene, camera, light, [1024; 2], black_box(samples))
                    });
                });
            }
        }
    }
}

fn parts(c: &mut Criterion) {
    let (one, many, camera, light) = (one_mesh(), ten_thousand(), camera(), sun());
    c.bench_function("focus/receivers K", |b| {
        b.iter(|| FocusedView::new(black_box(&one), black_box(&camera), black_box(&light), Focus::SceneFit));
    });
    let view = FocusedView::new(&one, &camera, &light, Focus::SceneFit);
    c.bench_function("focus/casters B", |b| b.iter(|| black_box(&view).casters()));
    let frame = LightFrame::any(DVec3::new(0.4, -1.0, -0.3).normalize());
    let size = MapSize::new([1024; 2]).expect("a size");
    for (name, scene) in [("one mesh", &one), ("10,000 instances", &many)] {
        let view = FocusedView::new(scene, &camera, &light, Focus::SceneFit);
        c.bench_function(&format!("focus/unit cube/{name}"), |b| {
            b.iter(|| fit(black_box(&frame.orthographic()), black_box(&view), scene, &size, Tightening::Exact));
        });
    }
}

criterion_group!(benches, parameterize, parts);
criterion_main!(benches);
