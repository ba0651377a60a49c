//! Alpha tests on the device, held against the cpu renderer.

use glam::{DAffine3, DMat4, DVec3};
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Renderer, Stored};
use shadowlab::scene::{AlphaTexture, Wrap};
use shadowlab::{Camera, Mesh, Progress, Scene};

use super::agreement::DEPTH_TOLERANCE;
use crate::support::cpu::Random;
use crate::support::foliage::{alpha_test, texture, waves};
use crate::support::gpu::{renderer, single_map};

/// Texels that may differ: those whose level is within rounding of the cutoff, and those on the edges of triangles. Chosen
/// above what a software device leaves: at most 2 of 65536 and 9 of a million.
const DIFFERING_SHARE: f64 = 1e-4;

/// Leaves around the origin, some large enough to cross the near plane and the sides of a view.
fn leaves(seed: u64, count: usize, wrap: Wrap, texture: AlphaTexture) -> Mesh {
    let mut random = Random(seed);
    let (mut vertices, mut uv) = (Vec::new(), Vec::new());
    for i in 0..count {
        let middle = random.vector(-4.0, 4.0);
        let reach = [0.1, 0.4, 1.0, 5.0][i % 4];
        for _ in 0..3 {
            vertices.push((middle + reach * random.vector(-1.0, 1.0)).to_array());
            uv.push([random.number(-3.0, 4.0) as f32, random.number(-2.0, 5.0) as f32]);
        }
    }
    let faces: Vec<[i64; 3]> = (0..count as i64).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let test = Some(alpha_test(Some(texture), &uv, wrap));
    Mesh::with_alpha_test(&vertices, &faces, test).unwrap()
}

fn scene(wrap: Wrap) -> Scene {
    let plain = Mesh::new(&[[-9.0, -5.0, -9.0], [9.0, -5.0, -9.0], [0.0, -5.0, 9.0]], &[[0, 1, 2]]).unwrap();
    let one = Scene::from_mesh(leaves(17, 60, wrap, waves(32))).unwrap();
    let other = Scene::from_mesh(leaves(18, 30, Wrap::Clamp, texture([5, 3], |x, y| (50 * x + 60 * y) as u8))).unwrap();
    let place = DAffine3::from_translation(DVec3::new(3.0, 1.0, -2.0)) * DAffine3::from_rotation_y(0.7);
    let again = one.transformed(&(place * DAffine3::from_scale(DVec3::new(0.5, -0.6, 0.4)))).unwrap();
    let ground = Scene::from_mesh(plain).unwrap();
    one.joined(&ground).unwrap().joined(&other).unwrap().joined(&again).unwrap()
}

fn camera() -> Camera {
    Camera::look_at(DVec3::new(6.0, 5.0, 8.0), DVec3::ZERO, DVec3::Y, 1.0, 1.5, 0.5, 40.0).unwrap()
}

/// Matrices: of an eye, of a sun, of a warp whose w varies so much that the host projects, and of a close-up.
fn clips() -> Vec<DMat4> {
    use glam::dcamera::rh::{proj::directx, view};
    let sun = view::look_at_mat4(DVec3::new(8.0, 14.0, 6.0), DVec3::ZERO, DVec3::Z);
    let lamp = view::look_at_mat4(DVec3::new(0.2, 1.0, 0.3), DVec3::new(0.0, -1.0, 0.1), DVec3::Z);
    vec![
        camera().clip_from_world(),
        directx::orthographic(-9.0, 9.0, -9.0, 9.0, 1.0, 40.0) * sun,
        directx::perspective(2.4, 1.0, 1e-4, 40.0) * lamp,
        directx::orthographic(-0.05, 0.05, -0.05, 0.05, 1.0, 40.0) * sun,
    ]
}

#[test]
fn maps_have_the_same_holes() {
    let Some(gpu) = renderer() else { return };
    let (cpu, progress) = (CpuRenderer::new(), Progress::new());
    for wrap in Wrap::ALL {
        let scene = scene(wrap);
        for (k, clip) in clips().into_iter().enumerate() {
            let p = single_map(clip);
            for n in [256, 1024] {
                let a = cpu.depth_maps(&scene, &p, [n; 2], Stored::default(), &progress).unwrap().data;
                let b = gpu.depth_maps(&scene, &p, [n; 2], Stored::default(), &progress).unwrap().data;
                let differs = |(a, b): &(&f32, &f32)| (**a - **b).abs() > DEPTH_TOLERANCE;
                let (differ, drawn) =
                    (a.iter().zip(&b).filter(differs).count(), a.iter().filter(|&&z| z < 1.0).count());
                println!("{wrap:?} {k} {n}: {differ} of {} texels differ, {drawn} drawn", a.len());
                assert!(drawn > a.len() / 20, "{wrap:?} {k}: an empty map agrees with anything");
                assert!((differ as f64) < DIFFERING_SHARE * a.len() as f64, "{wrap:?} {k} {n}: {differ}");
            }
        }
    }
}

#[test]
fn eyes_see_through_the_same_holes() {
    let Some(gpu) = renderer() else { return };
    let (cpu, progress) = (CpuRenderer::new(), Progress::new());
    let near = Camera::look_at(DVec3::new(0.2, 1.0, 0.3), DVec3::NEG_Y, DVec3::Z, 2.4, 1.5, 1e-4, 40.0).unwrap();
    for camera in [camera(), near] {
        let scene = scene(Wrap::Repeat);
        let size = [360, 240];
        let a = cpu.gbuffer(&scene, &camera, size, &progress).unwrap();
        let b = gpu.gbuffer(&scene, &camera, size, &progress).unwrap();
        let ids = |g: &shadowlab::image::GBuffer| -> Vec<(i32, i32)> {
            g.instance.iter().copied().zip(g.triangle.iter().copied()).collect()
        };
        let (a, b) = (ids(&a), ids(&b));
        let differ = a.iter().zip(&b).filter(|(a, b)| a != b).count();
        println!("{differ} of {} pixels differ", a.len());
        assert!((differ as f64) < DIFFERING_SHARE * a.len() as f64, "{differ}");
        assert!(a.iter().filter(|(instance, _)| *instance != 1).count() > a.len() / 10);
    }
}

#[test]
fn a_test_that_keeps_all_changes_no_bit() {
    let Some(gpu) = renderer() else { return };
    let progress = Progress::new();
    let kept = leaves(19, 60, Wrap::Repeat, texture([2, 2], |_, _| 128));
    let positions: Vec<[f64; 3]> = kept
        .positions_local()
        .iter()
        .map(|p| kept.mesh_from_local().transform_point3(p.as_dvec3()).to_array())
        .collect();
    let faces: Vec<[i64; 3]> = kept.triangles().iter().map(|t| t.map(i64::from)).collect();
    let plain = Scene::from_mesh(Mesh::new(&positions, &faces).unwrap()).unwrap();
    let none = Scene::from_mesh(leaves(19, 60, Wrap::Repeat, texture([2, 2], |_, _| 127))).unwrap();
    let kept = Scene::from_mesh(kept).unwrap();
    for clip in clips() {
        let map = |scene: &Scene| {
            gpu.depth_maps(scene, &single_map(clip), [300; 2], Stored::default(), &progress).unwrap().data
        };
        assert!(map(&plain) == map(&kept));
        assert!(map(&none).iter().all(|&z| z == 1.0));
    }
    let seen = |scene: &Scene| gpu.gbuffer(scene, &camera(), [150, 100], &progress).unwrap();
    assert_eq!(seen(&plain), seen(&kept));
}
