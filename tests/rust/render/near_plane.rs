//! What an eye sees does not depend on its near plane: both renderers against rays, down to far / near = 1e7.

use glam::DVec3;
use shadowlab::render::Renderer;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::{Camera, Mesh, Progress, Scene};

const FAR: f64 = 1000.0;
const SIZE: [u32; 2] = [64, 64];

/// Horizontal rectangles: middle, half sides along x and z.
fn plates(plates: &[(DVec3, f64)]) -> Scene {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for (middle, half) in plates {
        let first = vertices.len() as i64;
        for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            vertices.push((*middle + *half * DVec3::new(x, 0.0, z)).to_array());
        }
        triangles.extend([[first, first + 2, first + 1], [first, first + 3, first + 2]]);
    }
    Scene::from_mesh(Mesh::new(&vertices, &triangles).unwrap()).unwrap()
}

/// The plate that a ray from the eye meets first, and how far it passes a border by at the least, over the depth there.
fn first_plate(eye: DVec3, ray: DVec3, plates: &[(DVec3, f64)]) -> (Option<usize>, f64) {
    let (mut best, mut margin) = ((f64::INFINITY, None), f64::INFINITY);
    for (i, (middle, half)) in plates.iter().enumerate() {
        let t = (middle.y - eye.y) / ray.y;
        let off = ((eye + t * ray) - *middle).abs();
        let outside = off.x.max(off.z) / half - 1.0;
        if t > 0.0 {
            margin = margin.min(outside.abs() * half / t);
        }
        if t > 0.0 && outside <= 0.0 && t < best.0 {
            best = (t, Some(i));
        }
    }
    (best.1, margin)
}

/// Pixels that show another plate than a ray meets; those within a twentieth of a pixel of a border, or less where it is seen at
/// an angle, are left out.
fn wrong_pixels(renderer: &dyn Renderer, camera: &Camera, plates_of: &[(DVec3, f64)]) -> usize {
    let g = renderer.gbuffer(&plates(plates_of), camera, SIZE, &Progress::new()).unwrap();
    let half_pixel = camera.half_size().y / f64::from(SIZE[1]);
    let wrong = (0..g.triangle.len()).filter(|&i| {
        let (x, y) = ((i as u32 % SIZE[0]) as f64 + 0.5, (i as u32 / SIZE[0]) as f64 + 0.5);
        let (expected, margin) = first_plate(camera.eye(), camera.pixel_ray(x, y, SIZE).direction, plates_of);
        let shown = (g.triangle[i] >= 0).then_some(g.triangle[i] as usize / 2);
        shown != expected && margin > 0.1 * half_pixel
    });
    wrong.count()
}

fn check(camera: impl Fn(f64) -> Camera, plates: &[(DVec3, f64)], what: &str) {
    #[cfg_attr(not(feature = "gpu"), expect(unused_mut))]
    let mut renderers: Vec<Box<dyn Renderer>> = vec![Box::new(CpuRenderer::new())];
    #[cfg(feature = "gpu")]
    renderers.extend(crate::support::gpu::renderer().map(|r| Box::new(r) as Box<dyn Renderer>));
    for renderer in &renderers {
        for ratio in [1e3, 1e4, 1e5, 1e6, 1e7] {
            let wrong = wrong_pixels(renderer.as_ref(), &camera(FAR / ratio), plates);
            assert_eq!(wrong, 0, "{what}, {}, far / near = {ratio:e}", renderer.backend());
        }
    }
}

#[test]
fn a_table_top_hides_the_floor_below_it() {
    let eye = DVec3::new(0.0, 500.0, 1.0);
    let camera = |near| Camera::look_at(eye, DVec3::ZERO, DVec3::Y, 0.2, 1.0, near, FAR).unwrap();
    check(camera, &[(DVec3::ZERO, 400.0), (DVec3::Y * 2.0, 31.0)], "a table top 2 below, 498 away");
}

#[test]
fn a_floor_close_to_the_far_plane_is_there() {
    for distance in [900.0, 970.0, 985.0, 998.0] {
        let eye = DVec3::new(0.0, 1.0, 1.0).normalize() * distance;
        let camera = |near| Camera::look_at(eye, DVec3::ZERO, DVec3::Y, 0.002, 1.0, near, FAR).unwrap();
        check(camera, &[(DVec3::ZERO, 10.0)], "a floor before the far plane");
    }
}

#[test]
fn slabs_on_a_ground_that_runs_below_the_eye_hide_it() {
    // One plane from the near plane to the far plane, and what lies close above it at all distances.
    let slab = |distance: f64| (DVec3::new(0.1 * distance, 0.002 * distance, -distance), 0.09 * distance);
    let all: Vec<(DVec3, f64)> =
        std::iter::once((DVec3::ZERO, 900.0)).chain([4.0, 12.0, 40.0, 150.0, 500.0].map(slab)).collect();
    let eye = DVec3::new(0.0, 1.7, 0.0);
    let camera = |near| Camera::look_at(eye, DVec3::new(0.3, 1.2, -3.0), DVec3::Y, 0.9, 1.0, near, FAR).unwrap();
    check(camera, &all, "slabs on the ground");
}
