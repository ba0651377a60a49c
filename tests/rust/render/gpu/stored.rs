//! What maps store, on a device against the processor: every surface, spacing and format.

use glam::{DMat4, DVec3};
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Bias, Filter, Format, MaskSettings, Renderer, Spacing, Stored, StoredSurface};
use shadowlab::scene::library;
use shadowlab::{Parameterization, Progress, Scene};

use crate::render::stored::oracle::cases;
use crate::render::stored::surfaces::{cuboid, world};
use crate::support::by_body::by_body;
use crate::support::cpu::{one_map, triangles};
use crate::support::gpu::renderer;

/// Units of single precision near 1 by which two rasterisers and the quotients after them may differ, in maps whose w varies by
/// four, and in steps of the format.
const ROUNDING: f64 = 24.0 * f32::EPSILON as f64;
/// Texels on outlines, which either rasteriser may give to either side, and whose layers then change places.
const DIFFERING_SHARE: f64 = 2e-3;
/// Of pixels of a mask: of texels, and of lookups that fall beside a texel's border by rounding.
const MASK_SHARE: f64 = 3e-3;

fn all() -> impl Iterator<Item = Stored> {
    StoredSurface::NAMES.into_iter().flat_map(|(_, surface)| {
        Spacing::NAMES.into_iter().flat_map(move |(_, spacing)| {
            let kind = Stored { surface, spacing, limit: 1.5, ..Stored::default() };
            Format::NAMES.into_iter().map(move |(_, format)| Stored { format, ..kind })
        })
    })
}

/// Texels of which two maps differ by more than a step of the format and rounding.
fn differing(a: &[f32], b: &[f32], stored: Stored) -> usize {
    let differs = |(a, b): (&f32, &f32)| {
        let step = stored.format.step(f64::from(a.max(*b)).min(0.999_999));
        // NaN differs from everything.
        !((f64::from(*a) - f64::from(*b)).abs() <= ROUNDING + 1.001 * step)
    };
    a.iter().zip(b).filter(|pair| differs(*pair)).count()
}

fn compared(gpu: &dyn Renderer, scene: &Scene, p: &Parameterization, n: u32, share: f64, name: &str) {
    let (cpu, progress) = (CpuRenderer::new(), Progress::new());
    for stored in all() {
        let draw = |r: &dyn Renderer| r.depth_maps(scene, p, [n; 2], stored, &progress).unwrap().data;
        let (a, b) = (draw(gpu), draw(&cpu));
        let covered = b.iter().filter(|z| **z < 1.0).count();
        let found = differing(&a, &b, stored);
        println!("{name}, {stored}: {found} of {covered} differ");
        assert!(covered > b.len() / 50, "{name}, {stored}: {covered}: an empty map agrees with anything");
        assert!(found as f64 <= share * b.len() as f64, "{name}, {stored}: {found} of {covered} texels differ");
    }
}

#[test]
fn the_comparison_fails_on_one_texel() {
    for (_, format) in Format::NAMES {
        let stored = Stored { format, ..Stored::default() };
        let map: Vec<f32> = (0..100).map(|i| format.quantise(i as f32 / 101.0)).collect();
        let mut other = map.clone();
        assert_eq!(differing(&map, &other, stored), 0);
        other[50] += 2.5 * (format.step(0.5) as f32).max(20.0 * f32::EPSILON);
        assert_eq!(differing(&map, &other, stored), 1, "{format:?}");
        other[50] = f32::NAN;
        assert_eq!(differing(&map, &other, stored), 1, "{format:?}");
    }
}

#[test]
fn stored_maps_agree_under_maps_of_all_kinds() {
    let Some(gpu) = renderer() else { return };
    let scene = triangles(&world());
    for case in cases() {
        if case.p.partitions[0].post_warp != Default::default() {
            let stored = Stored { surface: StoredSurface::Midpoint, ..Stored::default() };
            let refused = gpu.depth_maps(&scene, &case.p, [16; 2], stored, &Progress::new());
            assert!(refused.unwrap_err().to_string().contains("cpu"), "{}", case.name);
            continue;
        }
        compared(&gpu, &scene, &case.p, 200, DIFFERING_SHARE, case.name);
    }
}

#[test]
fn stored_maps_agree_on_library_scenes() {
    let Some(gpu) = renderer() else { return };
    for name in ["robots", "forest"] {
        let s = library::build(name, 1, &[]).unwrap();
        let p = by_body("lispsm").parameterize(&s.scene, &s.camera, &s.light, 256).unwrap();
        // Leaves are thinner than texels: most of them are outlines.
        let share = if name == "forest" { 2e-2 } else { 2.0 * DIFFERING_SHARE };
        compared(&gpu, &s.scene, &p, 256, share, name);
    }
}

#[test]
fn several_maps_are_several_layers() {
    let Some(gpu) = renderer() else { return };
    let scene = triangles(&world());
    let cases: Vec<_> = cases().into_iter().filter(|c| c.p.partitions[0].post_warp == Default::default()).collect();
    let mut all = cases[0].p.clone();
    all.partitions = cases.iter().map(|case| case.p.partitions[0].clone()).collect();
    let stored = Stored { surface: StoredSurface::Dual, spacing: Spacing::Linear, ..Stored::default() };
    let draw = |p: &Parameterization| gpu.depth_maps(&scene, p, [64; 2], stored, &Progress::new()).unwrap().data;
    let apart: Vec<f32> = cases.iter().flat_map(|case| draw(&case.p)).collect();
    assert_eq!(draw(&all), apart);
}

#[test]
fn masks_of_stored_maps_agree() {
    let Some(gpu) = renderer() else { return };
    let (cpu, progress) = (CpuRenderer::new(), Progress::new());
    let s = library::build("robots", 1, &[]).unwrap();
    for technique in ["uniform", "lispsm"] {
        let p = by_body(technique).parameterize(&s.scene, &s.camera, &s.light, 512).unwrap();
        for (i, stored) in all().enumerate() {
            let ndc = 0.5 * stored.format.step(0.99) + 1e-6;
            let slope = Bias { ndc, ..Bias::default() };
            let plane = Bias { plane: 1.0, slope: 0.1, texels: 0.3, ndc, ..Bias::default() };
            for (filter, bias) in [[(Filter::Nearest, slope)], [(Filter::Bilinear, plane)]][i / 4 % 2] {
                let settings =
                    MaskSettings { resolution: [512; 2], size: [256, 192], bias, filter, blend: 0.0, stored };
                let draw = |r: &dyn Renderer| {
                    r.shadow_mask(&s.scene, &s.camera, &s.light, &p, &settings, &progress).unwrap().data
                };
                let (a, b) = (draw(&gpu), draw(&cpu));
                let differs = |(a, b): &(&f32, &f32)| a.is_nan() != b.is_nan() || (*a - *b).abs() > 1e-3;
                let found = a.iter().zip(&b).filter(differs).count();
                let (lit, dark) = (b.iter().filter(|x| **x == 1.0).count(), b.iter().filter(|x| **x == 0.0).count());
                println!("{technique}, {stored}, {filter:?}: {found} of {lit} lit and {dark} dark pixels differ");
                assert!(lit > 1000 && dark > 1000, "{technique}, {stored}: {lit} {dark}");
                assert!(found as f64 <= MASK_SHARE * b.len() as f64, "{technique}, {stored}, {filter:?}: {found}");
            }
        }
    }
}

#[test]
fn what_the_host_projects_is_turned_as_it_is() {
    // A ground far larger than its map takes more than single precision: its triangles come projected.
    let Some(gpu) = renderer() else { return };
    let large = cuboid(DVec3::new(-3e6, -2.0, -3e6), DVec3::new(3e6, 0.0, 3e6));
    let scene = triangles(&large);
    for matrix in [cases()[0].p.partitions[0].shadow_clip_from_world, cases()[7].p.partitions[0].shadow_clip_from_world]
    {
        let far = DMat4::from_scale(DVec3::new(1.0, 1.0, 0.9)) * matrix;
        for surface in [StoredSurface::Front, StoredSurface::Back, StoredSurface::Midpoint] {
            for (_, spacing) in Spacing::NAMES {
                let stored = Stored { surface, spacing, ..Stored::default() };
                let draw = |r: &dyn Renderer| {
                    r.depth_maps(&scene, &one_map(far), [64; 2], stored, &Progress::new()).unwrap().data
                };
                let (a, b) = (draw(&gpu), draw(&CpuRenderer::new()));
                assert!(b.iter().all(|z| *z < 1.0), "{stored}");
                let worst = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert!(worst < 3e-6, "{stored}: {worst}");
            }
        }
    }
}
