//! Memory of the CPU renderer beside scene and image, and of the hierarchy for rays, at its peak and afterwards, by counting every
//! allocation.

#[path = "../rust/support/cpu.rs"]
#[allow(dead_code)]
mod cpu_support;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use glam::{DMat4, DVec3};
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Bias, Filter, MaskSettings, Renderer, Stored};
use shadowlab::scene::DirectionalLight;
use shadowlab::trace::Tracer;
use shadowlab::{Camera, Light, Progress, Scene};

use cpu_support::*;

static NOW: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

struct Counting;

// SAFETY: the system's allocator, with numbers beside.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        PEAK.fetch_max(NOW.fetch_add(layout.size(), Relaxed) + layout.size(), Relaxed);
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, p: *mut u8, layout: Layout) {
        NOW.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller's promise is passed on.
        unsafe { System.dealloc(p, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Slivers from top to bottom of the map, side by side.
fn tall(count: usize) -> Scene {
    let corners: Vec<[DVec3; 3]> = (0..count)
        .map(|i| {
            let x = 1.9 * (i as f64 / count as f64) - 0.95;
            [DVec3::new(x, -1.0, 0.3), DVec3::new(x + 1e-3, -1.0, 0.3), DVec3::new(x, 1.0, 0.6)]
        })
        .collect();
    triangles(&corners)
}

/// A bumpy sheet of 2 n^2 triangles, `scale` times as large as the map.
fn sheet(n: usize, scale: f64) -> Scene {
    let p = |i: usize, j: usize| {
        let (u, v) = (i as f64 / n as f64, j as f64 / n as f64);
        DVec3::new(scale * (u * 2.0 - 1.0), scale * (v * 2.0 - 1.0), 0.5 + 0.3 * (11.0 * u).sin() * (7.0 * v * v).cos())
    };
    let quads = (0..n * n).map(|k| (k % n, k / n));
    let corners: Vec<_> = quads
        .flat_map(|(i, j)| [[p(i, j), p(i + 1, j), p(i + 1, j + 1)], [p(i, j), p(i + 1, j + 1), p(i, j + 1)]])
        .collect();
    triangles(&corners)
}

// One test: the count is of the whole process.
#[test]
fn memory_stays_below_a_hundred_bytes_a_triangle() {
    let cases = [
        ("tall", tall(32_768), [2048, 2048]),
        ("tall, many bands", tall(4096), [256, 8192]),
        ("tiny", sheet(360, 1.0), [1024, 1024]),
        ("pixels", sheet(300, 1.0), [2048, 2048]),
        ("small", sheet(60, 1.0), [2048, 2048]),
        ("clipped", sheet(100, 1e4), [1024, 1024]),
    ];
    for (name, scene, size) in cases {
        let renderer = CpuRenderer::new();
        let p = one_map(DMat4::IDENTITY);
        let before = NOW.load(Relaxed);
        PEAK.store(before, Relaxed);
        let maps = renderer.depth_maps(&scene, &p, size, Stored::default(), &Progress::new()).unwrap();
        let peak = PEAK.load(Relaxed) - before - 4 * maps.data.len();
        assert!(maps.data.iter().filter(|z| **z < 1.0).count() > maps.data.len() / 2, "{name} shows too little");
        drop(maps);
        let retained = NOW.load(Relaxed) - before;
        let promised = (8 << 20) + 100 * scene.triangle_count() as usize;
        println!("{name}: peak {peak}, retained {retained}, promised {promised}");
        assert!(peak <= promised, "{name}: {peak} bytes at the peak, not below {promised}");
        assert!(retained <= promised, "{name}: {retained} bytes retained, not below {promised}");
    }
    a_mask_takes_one_map_at_a_time();
    a_hierarchy_takes_at_most_ninety_bytes_a_triangle();
}

/// While it is made: boxes of the triangles, nodes, leaves. Then the packets, which are most of what stays.
fn a_hierarchy_takes_at_most_ninety_bytes_a_triangle() {
    for (name, scene) in [("sheet", sheet(360, 1.0)), ("slivers", tall(65_536))] {
        let before = NOW.load(Relaxed);
        PEAK.store(before, Relaxed);
        let tracer = Tracer::new(&scene, &Progress::new()).unwrap();
        let peak = PEAK.load(Relaxed) - before;
        let promised = 90 * scene.triangle_count() as usize + (1 << 20);
        println!("hierarchy, {name}: peak {peak}, retained {}, promised {promised}", tracer.memory());
        assert!(peak <= promised, "{name}: {peak} bytes at the peak, not below {promised}");
        assert!(tracer.memory() <= peak, "{name}: more is kept than was there");
    }
}

/// However many maps a mask asks, one is in memory.
fn a_mask_takes_one_map_at_a_time() {
    const RESOLUTION: u32 = 1024;
    let scene = sheet(60, 1.0);
    let eye = DVec3::new(0.0, 0.0, -2.0);
    let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, 1.0, 1.0, 0.1, 10.0).unwrap();
    let light = Light::Directional(DirectionalLight::new(DVec3::Z).unwrap());
    let (bias, filter) = (Bias::default(), Filter::Nearest);
    let settings = MaskSettings {
        resolution: [RESOLUTION; 2],
        size: [256; 2],
        bias,
        filter,
        blend: 0.0,
        stored: Stored::default(),
    };
    let peak = |count: usize| {
        let mut p = maps(&vec![DMat4::IDENTITY; count]);
        for (k, partition) in p.partitions.iter_mut().enumerate() {
            partition.eye_depth = [0.0, 2.0 + (k + 1) as f64 / count as f64];
        }
        let renderer = CpuRenderer::new();
        let before = NOW.load(Relaxed);
        PEAK.store(before, Relaxed);
        let mask = renderer.shadow_mask(&scene, &camera, &light, &p, &settings, &Progress::new()).unwrap();
        let asked = (0..count as i16).filter(|k| mask.partition.contains(k)).count();
        assert!(asked > count / 3, "{asked} of {count} maps are asked");
        PEAK.load(Relaxed) - before
    };
    let (one, many) = (peak(1), peak(24));
    println!("a mask of one map: {one}, of 24: {many}");
    let half_a_map = 2 * (RESOLUTION * RESOLUTION) as usize;
    assert!(many <= one + half_a_map, "{many} bytes for 24 maps, {one} for one");
}
