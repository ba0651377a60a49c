//! Several maps on a graphics device: each pixel asks the map that it asks on the processor, and gets the same light.

use std::sync::Arc;

use glam::{DMat4, DVec3};
use shadowlab::parameterization::{Parameterization, PiecewiseLinear, PostWarp, Rectilinear};
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Bias, Filter, MaskSettings, Renderer, Stored};
use shadowlab::scene::library;
use shadowlab::{Error, Progress};

use crate::render::selection::maps::{View, alone, repeated, views};
use crate::render::selection::seams;
use crate::support::by_body::by_body;
use crate::support::gpu::{camera_above, renderer, single_map};

const SIZE: [u32; 2] = [300, 200];
/// Roundings of a receiver's place in f32, in units of the last place of the farthest point of the scene from the eye.
const PLACE_ROUNDINGS: f64 = 32.0;
/// Pixels that may get other light, as between single maps.
const MASK_SHARE: f64 = 1e-3;
/// Pixels that may ask another map: those on a border to a rounding, and those of other triangles.
const OTHER_MAP_SHARE: f64 = 2e-3;

fn settings(resolution: u32) -> MaskSettings {
    MaskSettings {
        resolution: [resolution; 2],
        size: SIZE,
        bias: Bias::default(),
        filter: Filter::Nearest,
        blend: 0.0,
        stored: Stored::default(),
    }
}

/// Whether a receiver as near as rounding brings it asks map `k`.
fn is_on_a_border(v: &View, p_world: DVec3, k: i16) -> bool {
    let reach = v.scene.bounds().corners().iter().map(|c| (*c - v.camera.eye()).length()).fold(0.0, f64::max);
    let step = PLACE_ROUNDINGS * f64::from(f32::EPSILON) * reach;
    let steps = [-step, 0.0, step];
    steps.iter().any(|&x| {
        steps.iter().any(|&y| {
            steps.iter().any(|&z| {
                let p = p_world + DVec3::new(x, y, z);
                v.p.choose(p, v.camera.depth_of(p)).map_or(-1, |k| k as i16) == k
            })
        })
    })
}

#[test]
fn both_renderers_ask_the_same_maps() {
    let Some(gpu) = renderer() else { return };
    let (cpu, progress) = (CpuRenderer::new(), Progress::new());
    for v in views() {
        let mask = |r: &dyn Renderer| r.shadow_mask(&v.scene, &v.camera, &v.light, &v.p, &settings(512), &progress);
        let (a, b) = (mask(&gpu).unwrap(), mask(&cpu).unwrap());
        let g = cpu.gbuffer(&v.scene, &v.camera, SIZE, &progress).unwrap();
        let gpu_g = gpu.gbuffer(&v.scene, &v.camera, SIZE, &progress).unwrap();
        let (mut other, mut light, mut compared) = (0, 0, 0);
        for i in 0..a.data.len() {
            // Another triangle, or none: that is the other test's matter.
            if (gpu_g.triangle[i], gpu_g.instance[i]) != (g.triangle[i], g.instance[i]) {
                continue;
            }
            compared += 1;
            light += usize::from(a.data[i].is_nan() != b.data[i].is_nan() || (a.data[i] - b.data[i]).abs() > 1e-3);
            if a.partition[i] != b.partition[i] {
                other += 1;
                let (p, _) = g.surfaces().receiver(i).expect("something is seen where a map is asked");
                assert!(
                    is_on_a_border(&v, p + g.origin, a.partition[i]),
                    "{}, pixel {i}: {}, not {}",
                    v.name,
                    a.partition[i],
                    b.partition[i]
                );
            }
        }
        println!("{}: of {compared} pixels {other} ask another map, {light} get other light", v.name);
        assert!(compared as f64 > 0.99 * a.data.len() as f64);
        assert!(other as f64 <= OTHER_MAP_SHARE * compared as f64, "{}: {other}", v.name);
        assert!(light as f64 <= MASK_SHARE * compared as f64, "{}: {light}", v.name);
    }
}

#[test]
fn more_maps_than_are_drawn_at_once_give_the_same_mask() {
    let Some(gpu) = renderer() else { return };
    let s = library::build("robots", 1, &[]).unwrap();
    let p = by_body("lispsm");
    let p = p.parameterize(&s.scene, &s.camera, &s.light, 2048).unwrap();
    let mask = |p: &Parameterization| {
        gpu.shadow_mask(&s.scene, &s.camera, &s.light, p, &settings(2048), &Progress::new()).unwrap()
    };
    // Sixteen maps of 2048 x 2048 are drawn at once.
    let (one, many) = (mask(&p), mask(&repeated(&p, &s.camera, 24)));
    let bits = |data: &[f32]| data.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&one.data), bits(&many.data));
    let highest = many.partition.iter().max().copied();
    assert!(highest > Some(16), "{highest:?}");
    assert!(many.partition.iter().any(|k| (0..16).contains(k)));
    for (a, b) in one.partition.iter().zip(&many.partition) {
        assert_eq!(*a < 0, *b < 0);
    }
    // And the depth maps of many are those of each.
    let all =
        gpu.depth_maps(&s.scene, &repeated(&p, &s.camera, 24), [64; 2], Stored::default(), &Progress::new()).unwrap();
    let single = gpu.depth_maps(&s.scene, &alone(&p, 0), [64; 2], Stored::default(), &Progress::new()).unwrap();
    assert!(all.layers == 24 && all.data.chunks(64 * 64).all(|layer| layer == single.data));
}

#[test]
fn a_post_warp_is_refused_with_a_way_out() {
    let Some(gpu) = renderer() else { return };
    let s = library::build("robots", 1, &[]).unwrap();
    let mut p = single_map(DMat4::IDENTITY);
    let camera = camera_above(3.0);
    let even = || PiecewiseLinear::new(&[[-1.0, -1.0], [1.0, 1.0]]).unwrap();
    let warps = [
        (PostWarp::Log { scale: 1.0, offset: 0.0 }, "logarithmic"),
        (PostWarp::Rectilinear(Arc::new(Rectilinear { x: even(), y: even() })), "rectilinear"),
    ];
    for (post_warp, name) in warps {
        p.partitions[0].post_warp = post_warp;
        let progress = Progress::new();
        let depth = gpu.depth_maps(&s.scene, &p, [16; 2], Stored::default(), &progress).map(|_| ());
        let mask = gpu.shadow_mask(&s.scene, &camera, &s.light, &p, &settings(16), &progress).map(|_| ());
        let footprint = gpu.footprint(&s.scene, &camera, &s.light, &p, [16; 2], [16; 2], &progress).map(|_| ());
        // The footprint of a logarithm is there.
        assert_eq!(footprint.is_ok(), name == "logarithmic", "{name}");
        for error in [depth, mask, footprint].into_iter().filter_map(Result::err) {
            assert!(matches!(error, Error::InvalidArgument { .. }), "{error:?}");
            let text = error.to_string();
            assert!(text.contains(name) && text.contains("cpu"), "{text}");
        }
    }
}

#[test]
fn seams_are_no_worse_than_elsewhere() {
    let Some(gpu) = renderer() else { return };
    seams::assert_seams_hold(&gpu);
}
