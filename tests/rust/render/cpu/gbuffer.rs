//! The CPU G-buffer: positions and normals against f64 geometry, ties, placement, degenerate triangles.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use shadowlab::image::GBuffer;
use shadowlab::render::Renderer;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::{Camera, Error, Progress, Scene};

use crate::support::cpu::*;

fn camera(eye: DVec3, target: DVec3) -> Camera {
    Camera::look_at(eye, target, DVec3::Y, 0.9, 1.25, 0.05, 100.0).unwrap()
}

fn gbuffer(scene: &Scene, camera: &Camera, size: [u32; 2]) -> GBuffer {
    CpuRenderer::new().gbuffer(scene, camera, size, &Progress::new()).unwrap()
}

fn vector(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

/// Loose triangles all over the place.
fn cloud(random: &mut Random, count: usize, size: f64) -> Vec<[DVec3; 3]> {
    (0..count)
        .map(|_| {
            let middle = random.vector(-1.0, 1.0);
            [0, 1, 2].map(|_| middle + random.vector(-size, size))
        })
        .collect()
}

/// A triangle of the scene in the world, f64.
fn world_triangle(scene: &Scene, instance: usize, triangle: usize) -> [DVec3; 3] {
    let mesh = scene.mesh_of(instance);
    mesh.triangles()[triangle]
        .map(|i| scene.world_from_local(instance).transform_point3(mesh.positions_local()[i as usize].as_dvec3()))
}

/// Distance along a ray to a triangle, in units of the ray's direction.
fn hit(eye: DVec3, ray: DVec3, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let n = (b - a).cross(c - a);
    let t = n.dot(a - eye) / n.dot(ray);
    let p = eye + t * ray;
    let inside = [(a, b), (b, c), (c, a)].iter().all(|(u, v)| (*v - *u).cross(p - *u).dot(n) >= 0.0);
    (t > 0.0 && inside).then_some(t)
}

#[test]
fn pixels_show_what_rays_hit() {
    let mut random = Random(5);
    let map = DAffine3::from_mat3_translation(
        DMat3::from_cols(DVec3::new(-1.1, 0.2, 0.0), DVec3::new(0.3, 0.9, 0.1), DVec3::new(0.0, -0.4, 1.2)),
        DVec3::new(0.3, 0.1, -0.8),
    );
    let scene = instances(triangle_mesh(&cloud(&mut random, 150, 0.35)), &[DAffine3::IDENTITY, map]);
    let (camera, size) = (camera(DVec3::new(0.4, 0.8, 4.0), DVec3::ZERO), [125, 100]);
    let g = gbuffer(&scene, &camera, size);
    assert_eq!(g.origin, scene.origin());
    let (mut shown, mut differing) = (0, 0);
    for (i, &triangle) in g.triangle.iter().enumerate() {
        let (x, y) = ((i as u32 % size[0]) as f64 + 0.5, (i as u32 / size[0]) as f64 + 0.5);
        let ray = camera.pixel_ray(x, y, size).direction;
        let mut nearest = (f64::INFINITY, -1, -1);
        for instance in 0..2 {
            for t in 0..150 {
                if let Some(distance) = hit(camera.eye(), ray, world_triangle(&scene, instance, t))
                    && distance < nearest.0
                {
                    nearest = (distance, t as i32, instance as i32);
                }
            }
        }
        // Pixels within 1/512 of an edge may go either way.
        if (triangle, g.instance[i]) != (nearest.1, nearest.2) {
            differing += 1;
            continue;
        }
        if triangle < 0 {
            assert_eq!((g.depth[i], g.position[i], g.normal[i]), (1.0, [0.0; 3], [0.0; 3]));
            continue;
        }
        shown += 1;
        let expected = camera.eye() + nearest.0 * ray - scene.origin();
        // One rounding to f32 of coordinates below 8.
        assert!((vector(g.position[i]) - expected).length() < 4.0 * f64::from(f32::EPSILON), "pixel {i}");
        let [a, b, c] = world_triangle(&scene, g.instance[i] as usize, triangle as usize);
        let n = (b - a).cross(c - a).normalize();
        let n = if n.dot(ray) > 0.0 { -n } else { n };
        assert!((vector(g.normal[i]) - n).length() < 2.0 * f64::from(f32::EPSILON), "pixel {i}");
        let ndc_z = 100.0 * (nearest.0 - 0.05) / (nearest.0 * 99.95);
        assert!((f64::from(g.depth[i]) - ndc_z).abs() < 1e-5, "pixel {i}: {} not {ndc_z}", g.depth[i]);
    }
    assert!(shown > 3000, "{shown} pixels show something");
    assert!(differing < shown / 100, "{differing} of {shown} pixels differ");
}

#[test]
fn of_equal_depths_the_first_wins() {
    // The same triangles five times over in three instances, small ones and large ones.
    for size in [0.02, 0.1, 3.0] {
        let one = cloud(&mut Random(6), 40, size);
        let all: Vec<_> = one.iter().chain(&one).copied().collect();
        let (mesh, twice) = (triangle_mesh(&one), triangle_mesh(&all));
        let camera = camera(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO);
        let plain = gbuffer(&instances(mesh, &[DAffine3::IDENTITY]), &camera, [200, 160]);
        assert!(plain.triangle.iter().any(|&t| t >= 0));
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let scene = instances(triangle_mesh(&all), &[DAffine3::IDENTITY; 3]);
            assert_eq!(pool.install(|| gbuffer(&scene, &camera, [200, 160])), plain);
        }
        drop(twice);
    }
}

#[test]
fn many_threads_and_batches_agree() {
    let mut random = Random(7);
    let mesh = triangle_mesh(&cloud(&mut random, 3000, 0.1));
    let places: Vec<_> = (0..400).map(|_| DAffine3::from_translation(random.vector(-2.0, 2.0))).collect();
    let scene = instances(mesh, &places);
    let camera = camera(DVec3::new(0.0, 0.5, 1.0), DVec3::ZERO);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| gbuffer(&scene, &camera, [90, 70]))
    };
    let one = on(1);
    assert!(one.triangle.iter().all(|&t| t >= 0));
    assert_eq!(one, on(2));
    assert_eq!(one, on(5));
}

#[test]
fn place_and_scale_do_not_matter() {
    let corners = cloud(&mut Random(8), 200, 0.3);
    let size = [100, 80];
    let at = |scale: f64, place: DVec3| {
        let moved: Vec<_> = corners.iter().map(|t| t.map(|p| p * scale + place)).collect();
        let eye = DVec3::new(0.5, 0.6, 3.0) * scale + place;
        let camera = Camera::look_at(eye, place, DVec3::Y, 0.9, 1.25, 0.05 * scale, 100.0 * scale).unwrap();
        gbuffer(&triangles(&moved), &camera, size)
    };
    let near = at(1.0, DVec3::ZERO);
    let utm = DVec3::new(512_345.0, 5_412_345.0, 234.0);
    for (scale, place) in [(1.0, utm), (1e-6, DVec3::ZERO), (1e9, DVec3::ZERO), (1e9, utm)] {
        let far = at(scale, place);
        let differing = (0..near.depth.len())
            .filter(|&i| {
                let apart = (vector(near.position[i]) - vector(far.position[i]) / scale).length();
                near.triangle[i] != far.triangle[i] || apart > 1e-5
            })
            .count();
        assert!(differing <= 8, "scale {scale}, place {place}: {differing} pixels differ");
    }
}

#[test]
fn inside_a_box_all_walls_face_the_eye() {
    let p = |i: usize| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64) * 2.0 - 1.0;
    let quads = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let corners: Vec<_> = quads.iter().flat_map(|&[a, b, c, d]| [[p(a), p(b), p(c)], [p(a), p(c), p(d)]]).collect();
    let scene = triangles(&corners);
    for target in [DVec3::X, DVec3::NEG_Z, DVec3::new(1.0, 1.0, 1.0), DVec3::new(0.1, -1.0, 0.0)] {
        let camera = camera(DVec3::new(0.1, 0.2, -0.3), target);
        let g = gbuffer(&scene, &camera, [64, 48]);
        for (position, normal) in g.position.iter().zip(&g.normal) {
            let (position, normal) = (vector(*position) + g.origin, vector(*normal));
            assert!((position.abs().max_element() - 1.0).abs() < 1e-6, "{position} is not on a wall");
            assert!(normal.dot(camera.eye() - position) > 0.0);
            assert_eq!(normal.length(), 1.0);
        }
    }
}

#[test]
fn nothing_is_ever_nan() {
    let mut random = Random(9);
    let mut corners = vec![];
    for n in 0..4000 {
        let a = random.vector(-1.0, 1.0);
        let along = random.vector(-1.0, 1.0);
        // Without area, nearly so, and seen edge on from the eye (0, 0, 3).
        let to_eye = DVec3::Z * 3.0 - a;
        let c = match n % 4 {
            0 => a + 0.5 * along,
            1 => a + 0.5 * along + random.vector(-1e-7, 1e-7),
            2 => a + 0.2 * to_eye,
            _ => a + 0.2 * to_eye + 0.3 * along + random.vector(-1e-9, 1e-9),
        };
        corners.push([a, a + along, c]);
    }
    let g = gbuffer(&triangles(&corners), &camera(DVec3::Z * 3.0, DVec3::ZERO), [600, 500]);
    let mut shown = 0;
    for i in 0..g.depth.len() {
        assert!(vector(g.position[i]).is_finite() && (0.0..=1.0).contains(&g.depth[i]));
        if g.triangle[i] >= 0 {
            shown += 1;
            assert!((vector(g.normal[i]).length() - 1.0).abs() < 1e-6, "{:?}", g.normal[i]);
            // Within the scene, seen from the eye.
            assert!(vector(g.position[i]).length() < 8.0);
        }
    }
    assert!(shown > 100, "some slivers cover pixels: {shown}");
}

#[test]
fn flattened_and_turned_instances_keep_true_normals() {
    let quad = [
        [DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 0.0)],
        [DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 0.0), DVec3::new(-1.0, 1.0, 0.0)],
    ];
    for angle in [0.0, 0.4, -1.1] {
        for scale in [DVec3::ONE, DVec3::new(1.0, -2.0, 1.0), DVec3::new(2.0, 0.7, 0.0)] {
            let map = DAffine3::from_scale_rotation_translation(scale, DQuat::from_rotation_y(angle), DVec3::ZERO);
            let g = gbuffer(&instances(triangle_mesh(&quad), &[map]), &camera(DVec3::Z * 5.0, DVec3::ZERO), [50, 40]);
            let middle = 20 * 50 + 25;
            let expected = DVec3::new(angle.sin(), 0.0, angle.cos());
            assert!((vector(g.normal[middle]) - expected).length() < 1e-6, "angle {angle}, scale {scale}");
        }
    }
}

#[test]
fn one_pixel_and_bad_sizes() {
    let scene = triangles(&cloud(&mut Random(3), 300, 1.0));
    let camera = camera(DVec3::Z * 4.0, DVec3::ZERO);
    assert_eq!(gbuffer(&scene, &camera, [1, 1]).triangle.len(), 1);
    for size in [[0, 1], [1, 0], [16385, 1]] {
        let result = CpuRenderer::new().gbuffer(&scene, &camera, size, &Progress::new());
        assert!(matches!(result, Err(Error::InvalidArgument { name, .. }) if name == "size"));
    }
    // Positions of this scene do not fit into f32.
    let scene = triangles(&[[DVec3::ZERO, DVec3::X * 1e60, DVec3::Y * 1e60]]);
    let result = CpuRenderer::new().gbuffer(&scene, &camera, [8, 8], &Progress::new());
    assert!(matches!(result, Err(Error::InvalidArgument { name, .. }) if name == "scene"));
}
