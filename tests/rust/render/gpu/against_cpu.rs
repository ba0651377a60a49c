//! The two renderers on every library scene: depth maps, G-buffers and masks.

use glam::{DMat4, DVec3};
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Bias, Filter, MaskSettings, Renderer, Stored};
use shadowlab::scene::{DirectionalLight, library};
use shadowlab::{Camera, Light, Mesh, Progress, Scene};

use super::agreement::{DEPTH_TOLERANCE, DIFFERING_SHARE, Difference, compare};
use crate::support::by_body::by_body;
use crate::support::gpu::{renderer, single_map};

#[test]
fn depth_maps_agree_on_every_library_scene() {
    let Some(gpu) = renderer() else { return };
    let (cpu, progress) = (CpuRenderer::new(), Progress::new());
    for name in library::names() {
        let s = library::build(name, 1, &[]).unwrap();
        for technique in ["uniform", "lispsm"] {
            let technique = by_body(technique);
            for n in [512, 2048] {
                let p = technique.parameterize(&s.scene, &s.camera, &s.light, n).unwrap();
                let a = gpu.depth_maps(&s.scene, &p, [n; 2], Stored::default(), &progress).unwrap();
                let b = cpu.depth_maps(&s.scene, &p, [n; 2], Stored::default(), &progress).unwrap();
                let clip = &p.partitions[0].shadow_clip_from_world;
                let difference = compare(&s.scene, clip, [n; 2], &a.data, &b.data);
                let covered = b.data.iter().filter(|&&z| z < 1.0).count();
                let Difference { edge, thin, steep, tilted, unexplained, .. } = &difference;
                println!(
                    "{name}, {}, {n}: {} of {covered} covered texels differ: {edge} edge, {thin} thin, {steep} steep, {tilted} tilted, {} without reason",
                    p.technique,
                    difference.count(),
                    unexplained.len()
                );
                assert!(covered > difference.texels / 20, "{name}: an empty map agrees with anything");
                difference.assert_small(&format!("{name}, {}, {n}", p.technique));
            }
        }
    }
}

/// Pixels of a G-buffer that may show another triangle at the same depth: across the edge between neighbours, or where the
/// depth buffer cannot tell two surfaces far away apart. Trees far away are a few pixels high and full of edges.
const OTHER_TRIANGLE_SHARE: f64 = 2e-3;
/// Roundings of a position in single precision, in units of the last place of the farthest point of the scene from the eye.
const POSITION_ROUNDINGS: f64 = 16.0;
/// Unit normals closer than this agree. Edges are rounded to 24 bits, so that this holds for triangles down to a
/// thousandth as high as long.
const NORMAL_TOLERANCE: f64 = 1e-4;
/// Pixels of triangles thinner than that.
const NORMAL_SHARE: f64 = 1e-4;
/// Pixels of a mask that may differ: those of maps, times the texels a filter reads, and those whose lookups fall on the
/// other side of a texel's border by rounding.
const MASK_SHARE: f64 = 1e-3;

#[test]
fn gbuffers_agree_on_every_library_scene() {
    let Some(gpu) = renderer() else { return };
    let (cpu, progress) = (CpuRenderer::new(), Progress::new());
    for name in library::names() {
        let s = library::build(name, 1, &[]).unwrap();
        let size = [512, 384];
        let (a, b) = (
            gpu.gbuffer(&s.scene, &s.camera, size, &progress).unwrap(),
            cpu.gbuffer(&s.scene, &s.camera, size, &progress).unwrap(),
        );
        assert_eq!((a.size, a.origin), (b.size, b.origin));
        let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let bounds = s.scene.bounds();
        let reach = bounds.corners().iter().map(|p| (*p - s.camera.eye()).length()).fold(0.0, f64::max);
        let rounding = POSITION_ROUNDINGS * f64::from(f32::EPSILON) * reach;
        let (mut other, mut beside, mut bent, mut seen) = (0, 0, 0, 0);
        let (mut worst_off_plane, mut worst_normal) = (0.0f64, 0.0f64);
        for i in 0..a.depth.len() {
            seen += usize::from(b.triangle[i] >= 0);
            let (apart, n) = (vector(a.position[i]) - vector(b.position[i]), vector(b.normal[i]));
            // The plane is off by a rounding, so the ray meets it farther off the flatter it comes.
            let ray = s.camera.pixel_ray((i % 512) as f64 + 0.5, (i / 512) as f64 + 0.5, size).direction.normalize();
            let limit = rounding / ray.dot(n).abs().max(f64::MIN_POSITIVE);
            let is_same_place = apart.length() <= limit;
            if (a.triangle[i], a.instance[i]) != (b.triangle[i], b.instance[i]) {
                let is_same_depth = (a.depth[i] - b.depth[i]).abs() <= DEPTH_TOLERANCE;
                beside += usize::from(is_same_depth);
                other += usize::from(!is_same_depth);
                continue;
            }
            let bend = (vector(a.normal[i]) - n).length();
            worst_normal = worst_normal.max(bend);
            if bend > NORMAL_TOLERANCE {
                bent += 1;
                continue;
            }
            worst_off_plane = worst_off_plane.max(apart.dot(n).abs());
            assert!(is_same_place, "{name}, pixel {i}: {apart} over {limit}");
        }
        println!(
            "{name}: of {seen} pixels {other} show another triangle and depth, {beside} another at the same depth, {bent} a bent normal; off the plane by up to {:.1e} of the reach; normals apart by up to {worst_normal:.1e}",
            worst_off_plane / reach
        );
        assert!(seen > a.depth.len() / 3);
        assert!(other as f64 <= DIFFERING_SHARE * a.depth.len() as f64, "{name}: {other} other depths");
        assert!(beside as f64 <= OTHER_TRIANGLE_SHARE * a.depth.len() as f64, "{name}: {beside} other triangles");
        assert!(bent as f64 <= NORMAL_SHARE * a.depth.len() as f64, "{name}: {bent} bent normals");
    }
}

#[test]
fn a_view_of_nothing_is_empty() {
    let Some(gpu) = renderer() else { return };
    let (scene, _, _) = small_map();
    let camera = Camera::look_at(DVec3::Z, 2.0 * DVec3::Z, DVec3::Y, 1.0, 1.0, 0.1, 10.0).unwrap();
    let light = Light::Directional(DirectionalLight::new(DVec3::NEG_Z).unwrap());
    let settings = MaskSettings {
        resolution: [16; 2],
        size: [8, 6],
        bias: Bias::default(),
        filter: Filter::Nearest,
        blend: 0.0,
        stored: Stored::default(),
    };
    let drawn = |r: &dyn Renderer| {
        let (p, progress) = (single_map(DMat4::IDENTITY), Progress::new());
        let gbuffer = r.gbuffer(&scene, &camera, [8, 6], &progress).unwrap();
        (gbuffer, r.shadow_mask(&scene, &camera, &light, &p, &settings, &progress).unwrap())
    };
    let ((a, mask), (b, _)) = (drawn(&gpu), drawn(&CpuRenderer::new()));
    assert_eq!(a, b);
    assert!(a.triangle == [-1; 48] && mask.data.iter().all(|x| x.is_nan()));
}

#[test]
fn masks_agree_on_every_library_scene() {
    let Some(gpu) = renderer() else { return };
    let (cpu, progress) = (CpuRenderer::new(), Progress::new());
    for name in library::names() {
        let s = library::build(name, 1, &[]).unwrap();
        for technique in ["uniform", "lispsm"] {
            let technique = by_body(technique);
            let p = technique.parameterize(&s.scene, &s.camera, &s.light, 1024).unwrap();
            let parts = Bias { plane: 1.0, slope: 0.75, texels: 0.4, normal: 0.2, ..Bias::default() };
            let [nearest, pcf] = Filter::PLAIN;
            for ((filter_name, filter), bias) in
                [(nearest, Bias::default()), (pcf, Bias::default()), (nearest, parts), (pcf, parts)]
            {
                let settings = MaskSettings {
                    resolution: [1024; 2],
                    size: [512, 384],
                    bias,
                    filter,
                    blend: 0.0,
                    stored: Stored::default(),
                };
                let a = gpu.shadow_mask(&s.scene, &s.camera, &s.light, &p, &settings, &progress).unwrap();
                let b = cpu.shadow_mask(&s.scene, &s.camera, &s.light, &p, &settings, &progress).unwrap();
                let differs = |(a, b): &(&f32, &f32)| a.is_nan() != b.is_nan() || (*a - *b).abs() > 1e-3;
                let differing = a.data.iter().zip(&b.data).filter(differs).count();
                let lit = b.data.iter().filter(|&&x| x == 1.0).count();
                let dark = b.data.iter().filter(|&&x| x == 0.0).count();
                println!(
                    "{name}, {}, {filter_name}: {differing} of {lit} lit and {dark} dark pixels differ",
                    p.technique
                );
                assert!(lit > 1000 && dark > 1000, "{name}: a mask of one value agrees with anything");
                assert!(differing as f64 <= MASK_SHARE * a.data.len() as f64, "{name}, {}: {differing}", p.technique);
            }
        }
    }
}

/// A square of 9 x 9 texels in the middle of a map of 16 x 16, and its depths.
fn small_map() -> (Scene, DMat4, Vec<f32>) {
    let vertices = [[-0.55, -0.55, 0.25], [0.55, -0.55, 0.25], [0.55, 0.55, 0.75], [-0.55, 0.55, 0.75]];
    let scene = Scene::from_mesh(Mesh::new(&vertices, &[[0, 1, 2], [0, 2, 3]]).unwrap()).unwrap();
    let depths = CpuRenderer::new().depth_maps(
        &scene,
        &single_map(DMat4::IDENTITY),
        [16; 2],
        Stored::default(),
        &Progress::new(),
    );
    (scene, DMat4::IDENTITY, depths.unwrap().data)
}

#[test]
fn the_comparison_fails_on_one_texel() {
    let (scene, clip, map) = small_map();
    let compared = |i: usize, z: f32| {
        let mut other = map.clone();
        other[i] = z;
        compare(&scene, &clip, [16; 2], &map, &other)
    };
    // A texel in the inside, off the diagonal; one of the empty border; a NaN.
    for (i, z) in [(16 * 6 + 5, map[16 * 6 + 5] + 2.0 * DEPTH_TOLERANCE), (16 + 1, 0.5), (16 * 6 + 5, f32::NAN)] {
        let difference = compared(i, z);
        assert_eq!((difference.count(), difference.unexplained.len()), (1, 1), "{difference:?}");
        assert!(std::panic::catch_unwind(|| difference.assert_small("")).is_err());
    }
    // Within the tolerance nothing differs.
    assert_eq!(compared(16 * 6 + 5, map[16 * 6 + 5] + 0.5 * DEPTH_TOLERANCE).count(), 0);
    // The diagonal of the quad is an outline: a reason, but one of 256 texels is more than may differ.
    let on_edge = compared(16 * 7 + 8, 1.0);
    assert_eq!((on_edge.count(), on_edge.share() > DIFFERING_SHARE), (1, true), "{on_edge:?}");
    assert!(std::panic::catch_unwind(|| on_edge.assert_small("")).is_err());
}
