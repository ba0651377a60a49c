//! What each technique costs beyond the bodies, over mixed configurations: medians over cameras and lights in the library's
//! scenes, once as they are, of hundreds of instances, each of which the shared fit looks at, and once as one mesh.
//!
//! `cargo bench --bench techniques --no-default-features [name]`. The columns are microseconds: `whole` is `parameterize_seen`, its
//! samples made before;
//! `beyond bodies` is less the bodies K and B of the same configuration; `beyond uniform` is less the uniform map, so what the
//! technique adds to focusing and fit, B included, which the uniform map does without. Each number is the least of many short
//! runs, all of a configuration's techniques by turns, so that a busy machine disturbs all alike.

#![allow(missing_docs)]

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use glam::{DAffine3, DVec3};
use shadowlab::Progress;
use shadowlab::focus::{Focus, FocusedView, Samples};
use shadowlab::scene::{Camera, DirectionalLight, Instance, Light, Mesh, Scene, library};
use shadowlab::survey::samples_of_view;
use shadowlab::techniques::{Needs, Technique, specs, technique_of};

/// Cameras and lights for each of the scenes.
const VIEWS_PER_SCENE: usize = 13;
/// Rounds over all techniques, the least of which counts.
const ROUNDS: usize = 40;
/// Calls in a run: some tens of microseconds, far above the clock's step.
const CALLS: u32 = 8;

/// Beside every technique with its defaults. Those that look at a G-buffer's samples are given what they would find there.
const VARIANTS: [&str; 8] = [
    "lispsm:near=basic",
    "lispsm:axis=middle",
    "lispsm:near=optimal,over=body,range=body,fit=exact",
    "lispsm:near=delta-z,range=body,fit=exact",
    "psm:slide=0",
    "tsm:share=0.6",
    "gmnpr:body=frustum",
    "plane_optimal:plane=(0,1,0,0)",
];

struct Configuration {
    scene: Scene,
    camera: Camera,
    light: Light,
    /// What the camera sees and what of it is in shadow: its cost is a renderer's.
    samples: Samples,
}

/// Uniform random numbers from a seed (SplitMix64).
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        low + (high - low) * (((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64)
    }
}

/// A scene's box as one mesh: what focusing and fit see of a single loaded file.
fn one_mesh(scene: &Scene) -> Scene {
    let corners = scene.bounds().corners().map(|p| p.to_array());
    let faces: [[i64; 4]; 6] = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];
    let triangles: Vec<[i64; 3]> = faces.iter().flat_map(|f| [[f[0], f[1], f[2]], [f[0], f[2], f[3]]]).collect();
    let mesh = Arc::new(Mesh::new(&corners, &triangles).expect("a box"));
    Scene::new(vec![mesh], vec![Instance { mesh: 0, world_from_mesh: DAffine3::IDENTITY }]).expect("a scene")
}

/// The library's own views and others around them: eye, direction, field of view and depth range moved, light from anywhere.
/// The forest has ten thousand instances, whose fit is another bench's.
fn configurations(merged: bool) -> Vec<Configuration> {
    let mut random = Random(1);
    let mut all = Vec::new();
    for name in ["courtyard", "robots", "ceiling", "skylight", "dueling"] {
        let built = library::build(name, 1, &[]).expect(name);
        let scene = if merged { one_mesh(&built.scene) } else { built.scene };
        let size = scene.bounds().diagonal();
        println!("{name}: {} instances", scene.instances().len());
        for i in 0..VIEWS_PER_SCENE {
            let c = &built.camera;
            let mut vector = |length: f64| DVec3::from_array([0; 3].map(|_| random.between(-length, length)));
            let (eye, towards, along) = (c.eye() + vector(0.02 * size), c.forward() + vector(0.3), vector(1.0));
            let (fov, deeper) = (random.between(0.6, 1.6), random.between(0.5, 4.0));
            let camera = Camera::look_at(eye, eye + towards, c.up(), fov, 1.5, c.near() * deeper, c.far());
            let light = Light::Directional(DirectionalLight::new(along).expect("a light"));
            let (camera, light) = if i == 0 { (*c, built.light) } else { (camera.expect("a camera"), light) };
            let samples = samples_of_view(&scene, &camera, &light, Needs::Shadows, &Progress::new());
            let samples = samples.expect("samples").expect("asked for");
            all.push(Configuration { scene: scene.clone(), camera, light, samples });
        }
    }
    all
}

fn microseconds(work: &mut dyn FnMut()) -> f64 {
    let start = Instant::now();
    for _ in 0..CALLS {
        work();
    }
    start.elapsed().as_secs_f64() * 1e6 / f64::from(CALLS)
}

fn median(mut all: Vec<f64>) -> f64 {
    all.sort_by(f64::total_cmp);
    all[all.len() / 2]
}

/// The least time of each technique, and of the bodies, on one configuration; infinite where a technique refuses the view.
fn times(c: &Configuration, techniques: &[(String, Box<dyn Technique>)], rounds: usize) -> (f64, Vec<f64>) {
    let mut least = vec![f64::INFINITY; techniques.len()];
    let mut bodies = f64::INFINITY;
    let made = |t: &dyn Technique| {
        let (scene, camera, light) = (black_box(&c.scene), black_box(&c.camera), black_box(&c.light));
        t.parameterize_seen(scene, camera, light, [1024; 2], Some(black_box(&c.samples)))
    };
    let serves: Vec<bool> = techniques.iter().map(|(_, t)| made(t.as_ref()).is_ok()).collect();
    for _ in 0..rounds {
        let mut both = || {
            let view =
                FocusedView::new(black_box(&c.scene), black_box(&c.camera), black_box(&c.light), Focus::SceneFit);
            black_box(black_box(&view).casters());
        };
        bodies = bodies.min(microseconds(&mut both));
        for (i, (_, t)) in techniques.iter().enumerate().filter(|(i, _)| serves[*i]) {
            let mut whole = || {
                black_box(made(t.as_ref())).ok();
            };
            least[i] = least[i].min(microseconds(&mut whole));
        }
    }
    (bodies, least)
}

fn main() {
    let given: Vec<String> = std::env::args().skip(1).collect();
    // Run by `cargo test --benches`: that it works is all that is asked.
    let rounds = if given.iter().any(|a| a == "--test") { 1 } else { ROUNDS };
    let wanted = given.iter().find(|a| !a.starts_with('-'));
    let names = specs().map(|spec| spec.name.to_string()).chain(VARIANTS.map(str::to_string));
    // "uniform" is always there: the others are told beside it.
    let names = names.filter(|name| wanted.is_none_or(|w| name == "uniform" || name.contains(w.as_str())));
    let made: Vec<(String, Box<dyn Technique>)> = names
        .filter_map(|name| match technique_of(&name) {
            Ok(t) => Some((name, t)),
            Err(e) => {
                println!("{name}: {e}");
                None
            }
        })
        .collect();
    for merged in [true, false] {
        println!("\n{}", if merged { "as one mesh" } else { "as instances" });
        table(&made, &configurations(merged), rounds);
    }
}

fn table(techniques: &[(String, Box<dyn Technique>)], all: &[Configuration], rounds: usize) {
    let measured: Vec<(f64, Vec<f64>)> = all.iter().map(|c| times(c, techniques, rounds)).collect();
    let bodies = median(measured.iter().map(|m| m.0).collect());
    println!("bodies K and B: {bodies:.2} µs, median of {} configurations", all.len());
    println!("{:<32}{:>8}{:>16}{:>16}{:>10}", "technique", "whole", "beyond bodies", "beyond uniform", "refused");
    for (i, (name, _)) in techniques.iter().enumerate() {
        let served: Vec<(f64, f64, f64)> =
            measured.iter().map(|(bodies, all)| (all[i], *bodies, all[0])).filter(|m| m.0.is_finite()).collect();
        if served.is_empty() {
            println!("{name:<32} refuses every view");
            continue;
        }
        let of = |what: fn(&(f64, f64, f64)) -> f64| median(served.iter().map(what).collect());
        let (whole, beyond, added) = (of(|m| m.0), of(|m| m.0 - m.1), of(|m| m.0 - m.2));
        println!("{name:<32}{whole:>8.2}{beyond:>16.2}{added:>16.2}{:>10}", all.len() - served.len());
    }
}
