//! The gpu renderer where w varies by many orders of magnitude: maps held against rays in f64, views against the cpu renderer.

use glam::{DMat4, DVec3};
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::gpu::GpuRenderer;
use shadowlab::render::{Renderer, Stored};
use shadowlab::{Camera, Progress, Scene};

use crate::render::strong::cases::{
    SIZE, assert_a_ground_has_no_hole, assert_no_triangle_is_lost, assert_singular_matrices_are_drawn,
};
use crate::support::cpu as cpu_support;
use crate::support::gpu::{renderer, single_map};

fn depth(gpu: &GpuRenderer, scene: &Scene, m: DMat4) -> Vec<f32> {
    gpu.depth_maps(scene, &single_map(m), SIZE, Stored::default(), &Progress::new()).unwrap().data
}

#[test]
fn no_triangle_is_lost_whatever_w_does() {
    let Some(gpu) = renderer() else { return };
    assert_no_triangle_is_lost(|scene, m| depth(&gpu, scene, m));
}

#[test]
fn a_ground_that_fills_the_map_has_no_hole() {
    let Some(gpu) = renderer() else { return };
    assert_a_ground_has_no_hole(|scene, m| depth(&gpu, scene, m));
}

#[test]
fn singular_matrices_draw_what_they_can() {
    let Some(gpu) = renderer() else { return };
    assert_singular_matrices_are_drawn(|scene, m| depth(&gpu, scene, m));
}

/// Pixels that may show another triangle: those on the edges between neighbours.
const OTHER_TRIANGLE_SHARE: f64 = 2e-3;

#[test]
fn views_of_any_depth_range_show_the_same_triangles() {
    let Some(gpu) = renderer() else { return };
    // A ground of rings about the eye's foot, each ten times as far as the one before, in one mesh.
    let mut corners = vec![];
    for ring in 0..9 {
        let radius = 1e-4 * 10f64.powi(ring);
        for k in 0..12 {
            let at = |r: f64, k: i32| {
                let angle = f64::from(k) * std::f64::consts::TAU / 12.0;
                DVec3::new(r * angle.cos(), 0.0, r * angle.sin())
            };
            let [a, b] = [at(radius, k), at(radius, k + 1)];
            let [c, d] = [at(10.0 * radius, k), at(10.0 * radius, k + 1)];
            corners.extend([[a, c, b], [b, c, d]]);
        }
    }
    let scene = cpu_support::triangles(&corners);
    for (height, near, far) in [(1.0, 0.1, 1e5), (1e-2, 1e-3, 1e5), (1e-3, 1e-4, 1e5), (1e-3, 1e-5, 1e6)] {
        let eye = DVec3::Y * height;
        let camera = Camera::look_at(eye, eye + DVec3::new(1.0, -0.5, 0.2), DVec3::Y, 1.2, 1.25, near, far).unwrap();
        let g = |r: &dyn Renderer| r.gbuffer(&scene, &camera, [200, 160], &Progress::new()).unwrap();
        let (a, b) = (g(&gpu), g(&CpuRenderer::new()));
        let seen = b.triangle.iter().filter(|&&t| t >= 0).count();
        let other = a.triangle.iter().zip(&b.triangle).filter(|(a, b)| a != b).count();
        println!("{height:e}, {near:e} to {far:e}: {other} of {seen} pixels show another triangle");
        assert!(seen > 10_000);
        assert!(other as f64 <= OTHER_TRIANGLE_SHARE * seen as f64, "{height:e}: {other} of {seen}");
    }
}
