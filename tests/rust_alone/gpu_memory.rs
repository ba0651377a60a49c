//! Memory of the process as the gpu renderer draws for long: flat, whatever is drawn.
//!
//! On Linux alone, which says what a process holds.

#[path = "../rust/support/gpu.rs"]
#[allow(dead_code)]
mod gpu_support;

use std::io::Write;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use shadowlab::render::cpu::look_up;
use shadowlab::render::{Bias, Filter, Format, MaskSettings, Renderer, Spacing, Stored, StoredSurface};
use shadowlab::scene::{AlphaTest, AlphaTestParts, AlphaTexture, DirectionalLight, Instance, Wrap};
use shadowlab::{Camera, Light, Mesh, Parameterization, Partition, Progress, Scene};

/// Calls of each kind that are watched.
const CALLS: usize = 1000;
/// Calls before: pipelines are compiled, pools and the allocator's arenas fill up.
const WARM_UP: usize = 100;
/// What the process may have gained after the calls, bytes: half a page a call. The least that a driver keeps of a call, one object
/// of its own or one compiled shader, is a page or hundreds of them; the allocator's own ups and downs were below 1 MiB.
const MOST_GAINED: usize = CALLS * 2048;

/// Bytes of this process in memory; nothing where the system does not say.
fn resident() -> Option<usize> {
    let status = std::fs::read_to_string("/proc/self/statm").ok()?;
    status.split(' ').nth(1)?.parse::<usize>().ok().map(|pages| pages * 4096)
}

fn tell(line: &str) {
    // Not eprintln: the test harness swallows what it prints in tests that pass.
    writeln!(std::io::stderr(), "\n{line}").expect("standard error");
}

const MAP: [u32; 2] = [32; 2];
const IMAGE: [u32; 2] = [24, 18];

/// A ground with cuboids on it, one of them with an alpha test, and a mesh far larger than its map, which the host projects.
fn scene() -> Scene {
    let quad = |y: f64, half: f64| [[-half, y, -half], [half, y, -half], [half, y, half], [-half, y, half]];
    let faces = [[0, 2, 1], [0, 3, 2]];
    let uv = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let texture = AlphaTexture::new([8; 2], (0..64).map(|i| 4 * i).collect()).unwrap();
    let parts = AlphaTestParts {
        texture: Some(Arc::new(texture)),
        uv: uv.to_vec(),
        cutoff: 0.5,
        wrap: [Wrap::Repeat, Wrap::Mirror],
        factor: 1.0,
    };
    let roof = Mesh::with_alpha_test(&quad(2.0, 1.5), &faces, Some(AlphaTest::new(parts).unwrap())).unwrap();
    let [ground, slab] = [quad(0.0, 1e5), quad(1.0, 1.0)].map(|q| Mesh::new(&q, &faces).unwrap());
    let instances = [0, 1, 2].map(|mesh| Instance { mesh, world_from_mesh: DAffine3::IDENTITY });
    Scene::new([ground, slab, roof].map(Arc::new).to_vec(), instances.to_vec()).unwrap()
}

/// Maps of the scene, one beside the other.
fn maps(count: usize, direction: DVec3) -> Parameterization {
    let view = glam::dcamera::rh::view::look_to_mat4(-10.0 * direction, direction, DVec3::X);
    let map = |k: usize| {
        let projection = glam::dcamera::rh::proj::directx::orthographic(-4.0, 4.0, -4.0, 4.0, 0.0, 20.0 + k as f64);
        Partition::of_matrix(projection * view)
    };
    Parameterization::of_partitions((0..count).map(map).collect(), MAP)
}

/// Bytes that calls of a kind leave in the process.
fn gained(mut call: impl FnMut()) -> isize {
    (0..WARM_UP).for_each(|_| call());
    let before = resident().unwrap() as isize;
    (0..CALLS).for_each(|_| call());
    resident().unwrap() as isize - before
}

#[test]
fn a_thousand_calls_of_each_kind_leave_nothing() {
    if resident().is_none() {
        return tell("skipped: the system does not say how much memory a process holds");
    }
    // One test: others of this process would be watched, too.
    let mut kept = vec![];
    let watched = gained(|| kept.push(vec![1u8; 4096]));
    assert!(watched > MOST_GAINED as isize, "the watch sees nothing of what calls keep: {watched}");
    drop(kept);
    let Some(gpu) = gpu_support::renderer() else { return };
    let (gpu, progress) = (&gpu, &Progress::new());
    let scene = &scene();
    let direction = DVec3::new(0.3, -1.0, 0.17).normalize();
    let light = &Light::Directional(DirectionalLight::new(direction).unwrap());
    let eye = DVec3::new(3.0, 7.0, 4.0);
    let camera = &Camera::look_at(eye, DVec3::ZERO, DVec3::Y, 0.9, 1.3, 0.1, 50.0).unwrap();
    let (one, three) = (&maps(1, direction), &maps(3, direction));
    let mask = |p: &Parameterization, filter: &str, stored: Stored| {
        let settings = MaskSettings {
            resolution: MAP,
            size: IMAGE,
            bias: Bias { plane: 1.0, slope: 0.5, ..Bias::default() },
            filter: filter.parse::<Filter>().unwrap(),
            blend: 0.1,
            stored,
        };
        gpu.shadow_mask(scene, camera, light, p, &settings, progress).unwrap()
    };
    let map = |p: &Parameterization, stored: Stored| gpu.depth_maps(scene, p, MAP, stored, progress).unwrap();
    let stored = |surface, spacing, format| Stored { surface, spacing, format, ..Stored::default() };
    let midpoint = stored(StoredSurface::Midpoint, Spacing::Linear, Format::Unorm16);
    let looked_up = || {
        let settings = MaskSettings {
            resolution: MAP,
            size: IMAGE,
            bias: Bias::default(),
            filter: Filter::Bilinear,
            blend: 0.0,
            stored: Stored::default(),
        };
        let g = gpu.gbuffer(scene, camera, IMAGE, progress).unwrap();
        let maps = map(one, Stored::default()).data;
        look_up(&maps, g.surfaces(), camera, light, one, &settings, progress).unwrap();
    };
    let size = std::cell::Cell::new(0);
    let of_new_sizes = || {
        // More than wait, all of them once before calls are watched.
        size.set(size.get() % 90 + 1);
        gpu.depth_maps(scene, one, [size.get(), 3], midpoint, progress).unwrap();
        gpu.gbuffer(scene, camera, [3, size.get()], progress).unwrap();
    };
    let kinds: [(&str, &dyn Fn()); 14] = [
        ("shadow map", &|| drop(map(one, Stored::default()))),
        ("shadow maps", &|| drop(map(three, Stored::default()))),
        ("stored, back", &|| drop(map(one, stored(StoredSurface::Back, Spacing::Projective, Format::F32)))),
        ("stored, second", &|| drop(map(one, stored(StoredSurface::Second, Spacing::Linear, Format::F16)))),
        ("stored, midpoint", &|| drop(map(three, midpoint))),
        ("stored, dual", &|| drop(map(one, stored(StoredSurface::Dual, Spacing::Projective, Format::Unorm24)))),
        ("G-buffer", &|| drop(gpu.gbuffer(scene, camera, IMAGE, progress).unwrap())),
        ("mask", &|| drop(mask(one, "nearest", Stored::default()))),
        ("mask, pcf", &|| drop(mask(three, "pcf:size=5", Stored::default()))),
        ("mask, poisson", &|| drop(mask(one, "poisson:count=16,radius=2px,seed=1", midpoint))),
        ("footprint", &|| drop(gpu.footprint(scene, camera, light, three, MAP, IMAGE, progress).unwrap())),
        ("look-up", &looked_up),
        ("new sizes", &of_new_sizes),
        ("released", &|| {
            map(one, Stored::default());
            gpu.release().unwrap();
        }),
    ];
    let mut told = vec![];
    for (name, call) in kinds {
        let gained = gained(call);
        println!("{name}: {:.1} bytes a call", gained as f64 / CALLS as f64);
        told.push((name, gained));
    }
    told.retain(|(_, gained)| *gained > MOST_GAINED as isize);
    assert!(told.is_empty(), "bytes gained in {CALLS} calls: {told:?}");
}
