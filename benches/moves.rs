//! Scenes that move: time of taking hierarchies along by time of building them anew, and of tracing truth with either.
//!
//! `cargo bench --no-default-features --bench moves`
//!
//! Both are measured in turn, so that a busy machine slows both; ratios of medians are printed. Instances move by a share of
//! the mean distance of neighbours: little, as trees sway, up to several of them, where the order of a hierarchy is lost.

use std::time::Instant;

use glam::{DAffine3, DVec3};
use shadowlab::scene::library;
use shadowlab::trace::Tracer;
use shadowlab::{Progress, Scene};

const SIZE: [u32; 2] = [512, 288];
const ROUNDS: usize = 5;
/// Shares of the distance of neighbours by which instances move.
const WAYS: [f64; 6] = [0.0, 0.1, 0.5, 1.0, 2.0, 8.0];
/// How many of a hundred instances move.
const SHARES: [usize; 2] = [100, 1];

/// The scene with one of so many instances pushed along the ground by up to `way`; the first one, the ground, stays.
fn pushed(scene: &Scene, way: f64, one_of: usize) -> Scene {
    let index: Vec<usize> = (1..scene.instances().len()).step_by(one_of).collect();
    let push = |&i: &usize| {
        let k = i as f64;
        let way = way * DVec3::new((12.9898 * k).sin(), 0.0, (78.233 * k).sin());
        DAffine3::from_translation(way) * scene.instances()[i].world_from_mesh
    };
    let maps: Vec<DAffine3> = index.iter().map(push).collect();
    scene.with_transforms(&index, &maps, &Progress::new()).unwrap()
}

fn ms<T>(times: &mut Vec<f64>, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let made = work();
    times.push(1e3 * start.elapsed().as_secs_f64());
    made
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn main() {
    println!("| scene | of 100 move | by | hierarchy, ms anew | taken along | truth, ms anew | taken along |");
    println!("| --- | ---: | ---: | ---: | ---: | ---: | ---: |");
    for (name, params) in [("forest", ("trees", 10_000.0)), ("robots", ("robots", 500.0))] {
        let made = library::build(name, 1, &[(params.0.to_string(), params.1)]).unwrap();
        let extent = made.scene.bounds().extent();
        let apart = (extent.x * extent.z / params.1).sqrt();
        let progress = Progress::new();
        let before = Tracer::new(&made.scene, &progress).unwrap();
        for share in SHARES {
            for way in WAYS {
                let scene = pushed(&made.scene, way * apart, 100 / share);
                let mut times: [Vec<f64>; 4] = Default::default();
                for _ in 0..ROUNDS {
                    let anew = ms(&mut times[0], || Tracer::new(&scene, &progress).unwrap());
                    let along = ms(&mut times[1], || before.moved(&scene, &progress).unwrap());
                    for (k, tracer) in [(2, &anew), (3, &along)] {
                        ms(&mut times[k], || tracer.shadow_mask(&made.camera, &made.light, SIZE, &progress).unwrap());
                    }
                }
                let [build, take, truth, truth_along] = times.map(|mut t| median(&mut t));
                println!(
                    "| {name} | {share} | {way} | {build:.1} | {:.3} | {truth:.0} | {:.3} |",
                    take / build,
                    truth_along / truth
                );
            }
        }
    }
}
