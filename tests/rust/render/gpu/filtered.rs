//! Filters and blending on a graphics device: the light that they have on the processor.

use glam::DVec3;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Bias, Filter, MaskSettings, Renderer, Stored};
use shadowlab::scene::{DirectionalLight, library};
use shadowlab::{Camera, Light, Progress};

use crate::render::filtered::assert_planes_have_no_acne;
use crate::support::by_body::by_body;
use crate::support::cpu::{FILTERS, filter, one_map, triangles};
use crate::support::gpu::renderer;

const SIZE: [u32; 2] = [240, 180];

#[test]
fn every_filter_gives_the_light_of_the_processor() {
    let Some(gpu) = renderer() else { return };
    let (cpu, progress) = (CpuRenderer::new(), Progress::new());
    for name in ["robots", "courtyard"] {
        let s = library::build(name, 1, &[]).unwrap();
        let p = by_body("lispsm").parameterize(&s.scene, &s.camera, &s.light, 1024).unwrap();
        for text in FILTERS {
            for bias in [Bias::default(), Bias { plane: 1.0, slope: 0.2, normal: 0.1, ..Bias::default() }] {
                let settings = MaskSettings {
                    resolution: [1024; 2],
                    size: SIZE,
                    bias,
                    filter: filter(text),
                    blend: 0.0,
                    stored: Stored::default(),
                };
                let draw =
                    |r: &dyn Renderer| r.shadow_mask(&s.scene, &s.camera, &s.light, &p, &settings, &progress).unwrap();
                let (a, b) = (draw(&gpu), draw(&cpu));
                let apart = |limit: f32| {
                    let pairs = a.data.iter().zip(&b.data);
                    pairs.filter(|(a, b)| a.is_nan() != b.is_nan() || (*a - *b).abs() > limit).count()
                };
                let between = b.data.iter().filter(|x| **x > 0.0 && **x < 1.0).count();
                let [whole, part] = [apart(0.25), apart(2e-3)];
                println!(
                    "{name}, {text}: {whole} and {part} of {} pixels differ; {between} are penumbra",
                    a.data.len()
                );
                assert!(text == "nearest" || between > 300, "{name}, {text}: {between}");
                // Those of another triangle, and of a comparison or two that go the other way by rounding.
                assert!(whole <= a.data.len() / 1000 && part <= a.data.len() / 100, "{name}, {text}: {whole}, {part}");
            }
        }
    }
}

/// Of f32, in places of a map of 64 texels: four roundings of 2^-24 of it, over the width of the kernel at least 1.
const PLACE: f32 = 64.0 * 4.0 / 16_777_216.0;
/// Of weights in f32, where places have double precision: one rounding of 2^-24 for each of up to 16 rows or columns.
const WEIGHTS: f32 = 16.0 / 16_777_216.0;

#[test]
fn weights_are_those_of_the_processor_where_comparisons_agree() {
    let Some(gpu) = renderer() else { return };
    let (cpu, progress) = (CpuRenderer::new(), Progress::new());
    let level = |s: f64, y: f64| {
        let p = |x: f64, z: f64| DVec3::new(x * s, y, z * s);
        [[p(-1.0, -1.0), p(1.0, -1.0), p(1.0, 1.0)], [p(-1.0, -1.0), p(1.0, 1.0), p(-1.0, 1.0)]]
    };
    let scene = triangles(&[level(9.0, 0.0), level(1.013, 2.0)].concat());
    let camera = Camera::look_at(DVec3::new(3.0, 7.0, 4.0), DVec3::ZERO, DVec3::Y, 0.9, 1.3, 0.1, 50.0).unwrap();
    let direction = DVec3::new(0.3, -1.0, 0.17).normalize();
    let view = glam::dcamera::rh::view::look_to_mat4(-10.0 * direction, direction, DVec3::X);
    let p = one_map(glam::dcamera::rh::proj::directx::orthographic(-6.0, 6.0, -6.0, 6.0, 0.0, 20.0) * view);
    let light = Light::Directional(DirectionalLight::new(direction).unwrap());
    for text in FILTERS {
        let filter: Filter = filter(text);
        let settings = MaskSettings {
            resolution: [64; 2],
            size: SIZE,
            bias: Bias::default(),
            filter,
            blend: 0.0,
            stored: Stored::default(),
        };
        let draw = |r: &dyn Renderer| r.shadow_mask(&scene, &camera, &light, &p, &settings, &progress).unwrap();
        let (a, b) = (draw(&gpu), draw(&cpu));
        let mut apart: Vec<f32> = a.data.iter().zip(&b.data).map(|(a, b)| (a - b).abs()).collect();
        apart.sort_by(f32::total_cmp);
        let seen: Vec<f32> = apart.into_iter().filter(|x| !x.is_nan()).collect();
        // A comparison that goes the other way, by rounding of a depth or of a place at a texel's border.
        let nearly_all = seen[seen.len() - 1 - seen.len() / 1000];
        println!("{text}: apart by at most {nearly_all:e} in 999 of 1000 pixels, {:e} in all", seen[seen.len() - 1]);
        let most = if gpu.has_double() { WEIGHTS } else { PLACE };
        assert!(nearly_all <= most, "{text}: {nearly_all:e}");
        assert!(b.data.iter().filter(|x| **x > 0.0 && **x < 1.0).count() > 100 || text == "nearest", "{text}");
    }
}

#[test]
fn maps_blend_as_on_the_processor() {
    let Some(gpu) = renderer() else { return };
    let (cpu, progress) = (CpuRenderer::new(), Progress::new());
    let s = library::build("robots", 1, &[]).unwrap();
    let technique = by_body("z_partition:distances=(7,10,14),overlap=0.4,inner=lispsm,range=body");
    let p = technique.parameterize(&s.scene, &s.camera, &s.light, 512).unwrap();
    let mut by_containment = p.clone();
    by_containment.selection = shadowlab::parameterization::Selection::Containment;
    for (what, p) in [("depth", p), ("containment", by_containment)] {
        for (resolution, blend) in [(512, 0.4), (512, 1.0), (4096, 0.4)] {
            let filter = filter("pcf:size=3");
            let settings = MaskSettings {
                resolution: [resolution; 2],
                size: SIZE,
                bias: Bias::default(),
                filter,
                blend,
                stored: Stored::default(),
            };
            let draw =
                |r: &dyn Renderer| r.shadow_mask(&s.scene, &s.camera, &s.light, &p, &settings, &progress).unwrap();
            let (a, b) = (draw(&gpu), draw(&cpu));
            let other = (0..a.data.len()).filter(|&i| a.partition[i] != b.partition[i]).count();
            let apart = |i: &usize| {
                a.partition[*i] == b.partition[*i]
                    && (a.data[*i] - b.data[*i]).abs() > if resolution > 512 { 0.02 } else { 2e-3 }
            };
            let light = (0..a.data.len()).filter(apart).count();
            println!("{what}, {resolution}, {blend}: {other} other maps, {light} other light");
            assert!(other <= a.data.len() / 500 && light <= a.data.len() / 200, "{what}, {blend}: {other}, {light}");
        }
    }
}

/// Corners that a device snaps to 1/256 of a texel along both axes, and depths that it interpolates between them there.
const SNAPPING: f64 = 2.0 / 256.0;
/// Roundings to f32 of depths in the map and at the receiver.
const ROUNDING: f64 = 8.0 * f32::EPSILON as f64;

#[test]
fn planes_have_no_acne_under_any_filter_on_the_device() {
    let Some(gpu) = renderer() else { return };
    assert_planes_have_no_acne(&gpu, SNAPPING, ROUNDING);
}
