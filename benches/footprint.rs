//! The texel at every pixel of a 1024² view of the courtyard, beyond its G-buffer: one map, four splits, a placed light.
//!
//! The floor: 28 bytes read and 34 written a pixel.

use criterion::{Criterion, criterion_group, criterion_main};
use shadowlab::aliasing::footprint::footprint;
use shadowlab::render::{Renderer, cpu::CpuRenderer};
use shadowlab::scene::library;
use shadowlab::techniques::technique_of;
use shadowlab::{Camera, Progress};

const SIZE: [u32; 2] = [1024; 2];

fn footprints(c: &mut Criterion) {
    let progress = Progress::new();
    let built = library::build("courtyard", 0, &[]).expect("a library scene");
    let (scene, light) = (&built.scene, &built.light);
    let camera: Camera = built.camera;
    let g = CpuRenderer::new().gbuffer(scene, &camera, SIZE, &progress).expect("a G-buffer");
    let mut group = c.benchmark_group("footprint");
    for text in [
        "uniform",
        "lispsm:near=delta-z,range=body,fit=exact",
        "z_partition:count=4,inner=(lispsm:near=delta-z,range=body,fit=exact)",
        "log:range=body,fit=exact",
    ] {
        let p = technique_of(text).and_then(|t| t.parameterize(scene, &camera, light, 1024)).expect("maps");
        group.bench_function(text, |b| {
            b.iter(|| footprint(&g.surfaces(), &camera, light, &p, [1024; 2], &progress).expect("a footprint"));
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = footprints
}
criterion_main!(benches);
