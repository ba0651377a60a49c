//! Surfaces seen edge on: whichever of their pixels the grid shows, the point is on the surface.

use glam::DVec3;
use shadowlab::render::Renderer;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::{Camera, Mesh, Progress, Scene};

use crate::support::views::Random;

const SIZE: [u32; 2] = [65, 50];

fn renderers() -> Vec<Box<dyn Renderer>> {
    #[cfg_attr(not(feature = "gpu"), expect(unused_mut))]
    let mut renderers: Vec<Box<dyn Renderer>> = vec![Box::new(CpuRenderer::new())];
    #[cfg(feature = "gpu")]
    renderers.extend(crate::support::gpu::renderer().map(|r| Box::new(r) as Box<dyn Renderer>));
    renderers
}

/// A square floor of two triangles, at a height.
fn floor(height: f64) -> Scene {
    let corners = [[-1.0, height, -1.0], [1.0, height, -1.0], [1.0, height, 1.0], [-1.0, height, 1.0]];
    Scene::from_mesh(Mesh::new(&corners, &[[0, 2, 1], [0, 3, 2]]).unwrap()).unwrap()
}

#[test]
fn a_floor_at_the_eyes_height_shows_points_of_the_floor() {
    for renderer in renderers() {
        let mut shown = 0;
        let mut random = Random(5);
        for turn in 0..1000 {
            // Up to the rounding of a vertex beside the very height.
            let height = [-0.001, 0.3, 0.7][turn % 3];
            let beside = if turn % 7 == 0 { 0.0 } else { 10f64.powf(random.between(-9.0, -2.0)) };
            let beside = if random.unit() < 0.5 { beside } else { -beside };
            let eye = DVec3::new(random.between(-0.5, 0.5), height + beside, random.between(-2.5, -1.2));
            let target = DVec3::new(random.between(-1.0, 1.0), random.between(-0.2, 0.2), random.between(-0.5, 1.0));
            let up = DVec3::new(random.between(-0.5, 0.5), 1.0, 0.0);
            let camera = Camera::look_at(eye, target, up, 1.2, 1.3, 1e-3, 1e3).unwrap();
            let g = renderer.gbuffer(&floor(height), &camera, SIZE, &Progress::new()).unwrap();
            for i in (0..g.triangle.len()).filter(|&i| g.triangle[i] >= 0) {
                shown += 1;
                let p = g.origin + DVec3::from_array(g.position[i].map(f64::from));
                // A pixel of the rim is up to 1/362 of a pixel beside the floor, and the point is on the pixel's ray; of a triangle
                // seen at an angle a 64th of its sides may lie between.
                let room = 1e-3 * (p - eye).length() + 2.0 / 64.0;
                let off = (p - DVec3::new(0.0, height, 0.0)).abs() - DVec3::new(1.0, 0.0, 1.0);
                assert!(off.max_element() <= room, "turn {turn}: pixel {i} shows {p} from {eye}");
            }
        }
        assert!(shown > 300, "{shown} pixels");
    }
}
