//! Alpha tests in depth maps and G-buffers: closed forms, what a test must not change, and both renderers.

use std::sync::Arc;

use glam::{DAffine3, DMat4, DVec3};
use shadowlab::parameterization::{Parameterization, PiecewiseLinear, PostWarp, Rectilinear};
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Renderer, Stored};
use shadowlab::scene::{AlphaTest, AlphaTestParts, AlphaTexture, Instance, Wrap};
use shadowlab::{Camera, Mesh, Progress, Scene};

use crate::support::cpu::{Random, clip_from_pixels, depth, one_map};
use crate::support::foliage::{alpha_test, hole, leaf, texture, waves};

const SIZE: [u32; 2] = [96, 64];

/// Covered texels.
fn covered(depth: &[f32]) -> usize {
    depth.iter().filter(|&&z| z < 1.0).count()
}

/// A rectangle over the whole image in pixels, at a depth.
fn curtain(z: f64, texture: Option<AlphaTexture>, repeats: [f32; 2]) -> Mesh {
    let [w, h] = SIZE.map(f64::from);
    leaf([0.0, 0.0, z], [[w, 0.0, 0.0], [0.0, h, 0.0]], texture, repeats)
}

#[test]
fn a_texel_a_pixel_is_the_texture_itself() {
    let mut random = Random(5);
    let levels: Vec<u8> = (0..SIZE[0] * SIZE[1]).map(|_| random.integer(0, 256) as u8).collect();
    let mesh = curtain(0.25, Some(AlphaTexture::new(SIZE, levels.clone()).unwrap()), [1.0, 1.0]);
    let map = depth(&Scene::from_mesh(mesh).unwrap(), clip_from_pixels(SIZE), SIZE);
    // Centres of pixels are centres of texels: no weighting.
    for (z, level) in map.iter().zip(&levels) {
        assert_eq!(*z < 1.0, *level >= 128, "{z} {level}");
    }
}

#[test]
fn a_checkerboard_lets_half_of_the_light_through() {
    // Squares of 8 pixels. Between two squares levels pass the cutoff halfway.
    let board = texture([2, 2], |x, y| if (x + y) % 2 == 0 { 255 } else { 0 });
    let repeats = SIZE.map(|n| n as f32 / 16.0);
    let map = depth(&Scene::from_mesh(curtain(0.5, Some(board), repeats)).unwrap(), clip_from_pixels(SIZE), SIZE);
    // The level is 255 (1/2 + 2 (1/2 - a) (1/2 - b)) where a and b are parts of the way between centres.
    for (i, z) in map.iter().enumerate() {
        let parts = [i as u32 % SIZE[0], i as u32 / SIZE[0]].map(|n| {
            let place = (f64::from(n) + 0.5) / 8.0 - 0.5;
            (place.floor() as i64, place - place.floor())
        });
        let [(x, a), (y, b)] = parts;
        let sign = if (x + y).rem_euclid(2) == 0 { 1.0 } else { -1.0 };
        let level = 0.5 + sign * 2.0 * (0.5 - a) * (0.5 - b);
        if (level - 0.5).abs() > 1e-9 {
            assert_eq!(*z < 1.0, level > 0.5, "{i}: {level}");
        }
    }
    assert_eq!(covered(&map), map.len() / 2);
}

#[test]
fn a_round_hole_has_the_area_of_a_disc() {
    let n = 512;
    let clip = clip_from_pixels([n; 2]);
    let side = f64::from(n);
    for radius in [0.1, 0.25, 0.45] {
        let mesh = leaf([0.0, 0.0, 0.5], [[side, 0.0, 0.0], [0.0, side, 0.0]], Some(hole(256, radius)), [1.0; 2]);
        let map = depth(&Scene::from_mesh(mesh).unwrap(), clip, [n; 2]);
        let open = (map.len() - covered(&map)) as f64 / map.len() as f64;
        // Texels at the rim are rounded to 1/255 and weighted: a hundredth of a texel of the texture along the rim.
        let (area, rim) = (std::f64::consts::PI * radius * radius, std::f64::consts::TAU * radius);
        assert!((open - area).abs() < rim * 0.1 / 256.0 + 2.0 * rim.sqrt() / side.powf(1.5), "{radius}: {open} {area}");
    }
}

#[test]
fn the_same_hole_opens_under_a_projective_map() {
    // Seen at an angle through a perspective map: each texel asks for the point that its ray meets.
    let n = [200, 150];
    let mesh = leaf([-1.0, -1.0, -3.0], [[2.0, 0.0, -4.0], [0.0, 2.0, 0.0]], Some(hole(512, 0.3)), [1.0; 2]);
    let clip = glam::dcamera::rh::proj::directx::perspective(0.9, 4.0 / 3.0, 0.5, 20.0);
    let map = depth(&Scene::from_mesh(mesh).unwrap(), clip, n);
    let tan = [(0.45_f64).tan() * 4.0 / 3.0, (0.45_f64).tan()];
    let (mut open, mut closed) = (0, 0);
    for (i, z) in map.iter().enumerate() {
        let ndc = [(2 * (i as u32 % n[0]) + 1) as f64 / 200.0 - 1.0, 1.0 - (2 * (i as u32 / n[0]) + 1) as f64 / 150.0];
        let (dx, dy) = (ndc[0] * tan[0], ndc[1] * tan[1]);
        // (-1 + 2 s, -1 + 2 t, -3 - 4 s) = d (dx, dy, -1)
        let d = 1.0 / (1.0 - 2.0 * dx) * 5.0;
        let (s, t) = ((d * dx + 1.0) / 2.0, (d * dy + 1.0) / 2.0);
        let inside = 0.0 < s && s < 1.0 && 0.0 < t && t < 1.0 && d > 0.0;
        let from_rim = ((s - 0.5).powi(2) + (t - 0.5).powi(2)).sqrt() - 0.3;
        // Within a texel of the texture the rim is what its levels make of it; pixels at the outline are another test's.
        if inside && from_rim.abs() > 1.0 / 512.0 && s.min(t).min(1.0 - s).min(1.0 - t) > 0.02 {
            assert_eq!(*z < 1.0, from_rim > 0.0, "{i}: {s} {t}");
            if from_rim > 0.0 { closed += 1 } else { open += 1 }
        }
    }
    assert!(open > 300 && closed > 1000, "{open} {closed}");
}

/// A thicket of triangles of all sizes, some across the near plane and beyond the sides of the view, with a test or without.
fn thicket(seed: u64, test: impl Fn(&[[f32; 2]]) -> Option<AlphaTest>) -> Mesh {
    let mut random = Random(seed);
    let (mut vertices, mut uv) = (Vec::new(), Vec::new());
    for i in 0..240 {
        let middle = random.vector(-1.0, 1.0) * DVec3::new(2.0, 2.0, 3.0) - DVec3::new(0.0, 0.0, 3.5);
        let reach = [0.03, 0.2, 1.0, 6.0][i % 4];
        for _ in 0..3 {
            vertices.push((middle + reach * random.vector(-1.0, 1.0)).to_array());
            uv.push([random.number(-3.0, 3.0) as f32, random.number(-3.0, 3.0) as f32]);
        }
    }
    let faces: Vec<[i64; 3]> = (0..240).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let test = test(&uv);
    Mesh::with_alpha_test(&vertices, &faces, test).unwrap()
}

fn perspective() -> DMat4 {
    glam::dcamera::rh::proj::directx::perspective(1.0, 1.5, 0.5, 20.0)
}

/// Every kind of map of a matrix.
fn every_kind(clip: DMat4) -> Vec<Parameterization> {
    let mut kinds: Vec<Parameterization> = (0..3).map(|_| one_map(clip)).collect();
    // y = scale ln w + offset over w from 0.5 to 20.
    let scale = 2.0 / (20.0_f64 / 0.5).ln();
    kinds[1].partitions[0].post_warp = PostWarp::Log { scale, offset: -1.0 - scale * 0.5_f64.ln() };
    let axis = |at: f64| PiecewiseLinear::new(&[[-1.0, -1.0], [at, 0.1], [1.0, 1.0]]).unwrap();
    kinds[2].partitions[0].post_warp = PostWarp::Rectilinear(Rectilinear { x: axis(-0.3), y: axis(0.4) }.into());
    kinds
}

fn maps(scene: &Scene, p: &Parameterization, size: [u32; 2]) -> Vec<f32> {
    CpuRenderer::new().depth_maps(scene, p, size, Stored::default(), &Progress::new()).unwrap().data
}

fn camera() -> Camera {
    Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0, 1.5, 0.5, 20.0).unwrap()
}

#[test]
fn a_test_that_keeps_all_changes_no_bit_and_one_that_keeps_nothing_leaves_nothing() {
    let full = |uv: &[[f32; 2]]| Some(alpha_test(Some(texture([3, 3], |_, _| 200)), uv, Wrap::Repeat));
    let none = |uv: &[[f32; 2]]| Some(alpha_test(Some(texture([3, 3], |_, _| 100)), uv, Wrap::Mirror));
    let place = DAffine3::from_translation(DVec3::new(0.4, -0.2, -1.0));
    let scene = |mesh: Option<Mesh>| {
        // Beside others, and twice.
        let plain = Arc::new(thicket(3, |_| None));
        let mut meshes = vec![plain];
        let mut instances = vec![Instance { mesh: 0, world_from_mesh: DAffine3::from_scale(DVec3::splat(0.7)) }];
        if let Some(mesh) = mesh {
            meshes.push(Arc::new(mesh));
            instances.insert(0, Instance { mesh: 1, world_from_mesh: DAffine3::IDENTITY });
            instances.push(Instance { mesh: 1, world_from_mesh: place });
        }
        Scene::new(meshes, instances).unwrap()
    };
    let [plain, kept, gone, absent] =
        [Some(thicket(7, |_| None)), Some(thicket(7, full)), Some(thicket(7, none)), None].map(scene);
    for size in [[300, 200], [5, 7]] {
        for (kind, p) in every_kind(perspective()).iter().enumerate() {
            let (a, b) = (maps(&plain, p, size), maps(&kept, p, size));
            assert!(covered(&a) > a.len() / 4, "{kind}");
            assert_eq!(a, b, "{kind}");
            assert_eq!(maps(&gone, p, size), maps(&absent, p, size), "{kind}");
        }
        let gbuffer = |scene: &Scene| CpuRenderer::new().gbuffer(scene, &camera(), size, &Progress::new()).unwrap();
        let (a, b) = (gbuffer(&plain), gbuffer(&kept));
        assert_eq!((&a.depth, &a.triangle, &a.instance), (&b.depth, &b.triangle, &b.instance));
        let (a, b) = (gbuffer(&gone), gbuffer(&absent));
        assert_eq!((a.depth, a.triangle), (b.depth, b.triangle));
    }
}

#[test]
fn what_is_seen_through_holes_is_what_stands_behind() {
    // In every map the depth of a texel is that of the tested mesh where it exists and of what is behind where it does not.
    let leaves = thicket(11, |uv| Some(alpha_test(Some(waves(32)), uv, Wrap::Mirror)));
    let only_leaves = Scene::from_mesh(leaves).unwrap();
    let behind = Scene::from_mesh(thicket(12, |_| None)).unwrap();
    let both = only_leaves.joined(&behind).unwrap();
    let opaque = Scene::from_mesh(thicket(11, |_| None)).unwrap();
    for p in every_kind(perspective()) {
        let solid = maps(&opaque, &p, [240, 160]);
        let [leaves, behind, both] = [&only_leaves, &behind, &both].map(|scene| maps(scene, &p, [240, 160]));
        let holes = leaves.iter().zip(&solid).filter(|(z, solid)| z != solid).count();
        assert!(holes > leaves.len() / 200, "{holes}");
        for ((a, b), both) in leaves.iter().zip(&behind).zip(&both) {
            assert_eq!(a.min(*b), *both);
        }
    }
}

#[test]
fn uneven_maps_have_the_holes_of_projective_ones() {
    // Texels of a rectilinear map are places of its matrix's own map: fine maps of both agree at the same places.
    let leaves = Scene::from_mesh(thicket(21, |uv| Some(alpha_test(Some(waves(8)), uv, Wrap::Repeat)))).unwrap();
    let kinds = every_kind(perspective());
    let (fine, coarse) = ([1536, 1024], [384, 256]);
    let even = maps(&leaves, &kinds[0], fine);
    let PostWarp::Rectilinear(warp) = &kinds[2].partitions[0].post_warp else { panic!("the third is rectilinear") };
    let uneven = maps(&leaves, &kinds[2], coarse);
    let mut differ = 0;
    for (i, z) in uneven.iter().enumerate() {
        let [x, y] = [i % 384, i / 384];
        let (u, v) = ((x as f64 + 0.5) / 192.0 - 1.0, 1.0 - (y as f64 + 0.5) / 128.0);
        let (u, v) = (warp.x.before(u), warp.y.before(v));
        let (column, row) = ((u + 1.0) * 768.0, (1.0 - v) * 512.0);
        let near = even[(row as usize).min(1023) * 1536 + (column as usize).min(1535)];
        differ += usize::from((*z < 1.0) != (near < 1.0));
    }
    // Places at the rims of holes and triangles, half a fine texel apart.
    assert!(differ < uneven.len() / 50, "{differ} of {}", uneven.len());
}

#[test]
fn tests_without_a_texture_decide_by_their_factor() {
    for (factor, cutoff, exists) in [(1.0, 0.5, true), (0.4, 0.5, false), (0.5, 0.5, true), (0.0, 0.0, true)] {
        let parts = AlphaTestParts { texture: None, uv: vec![[0.0; 2]; 4], cutoff, wrap: [Wrap::Clamp; 2], factor };
        let [w, h] = SIZE.map(f64::from);
        let vertices = [[0.0, 0.0, 0.5], [w, 0.0, 0.5], [w, h, 0.5], [0.0, h, 0.5]];
        let test = Some(AlphaTest::new(parts).unwrap());
        let mesh = Mesh::with_alpha_test(&vertices, &[[0, 1, 2], [0, 2, 3]], test).unwrap();
        let map = depth(&Scene::from_mesh(mesh).unwrap(), clip_from_pixels(SIZE), SIZE);
        assert_eq!(covered(&map), if exists { map.len() } else { 0 }, "{factor} {cutoff}");
    }
}
