//! Meshes much larger than the map: depth against the plane in closed form, edges shared between all ways to draw.

use glam::{DMat4, DVec2, DVec3, DVec4};
use shadowlab::{Mesh, Scene};

use crate::support::cpu::*;

/// Half the distance of two f32 just below 1.
const HALF_ULP: f64 = 0.25 * f32::EPSILON as f64;

/// Orthographic, slanted: the square of half side 1 around the origin.
fn slanted() -> DMat4 {
    let direction = DVec3::new(-0.4, -1.0, -0.3).normalize();
    let view = glam::dcamera::rh::view::look_to_mat4(-2.0 * direction, direction, DVec3::Z);
    glam::dcamera::rh::proj::directx::orthographic(-1.0, 1.0, -1.0, 1.0, 0.0, 4.0) * view
}

/// The same under a warp whose w falls to a quarter of its largest over the map.
fn warped() -> DMat4 {
    DMat4::from_cols_array(&[1., 0., 0., 0., 0., 1.25, 0., 0.75, 0., 0., 1., 0., 0., 0.75, 0., 1.25]) * slanted()
}

/// A camera one unit above the ground.
fn camera() -> DMat4 {
    let view = glam::dcamera::rh::view::look_to_mat4(DVec3::Y, DVec3::new(0.2, -0.3, -1.0).normalize(), DVec3::Y);
    glam::dcamera::rh::proj::directx::perspective(0.9, 1.0, 0.5, 50.0) * view
}

/// The depth of the plane y = 0 at a point of the map.
fn ground_depth(clip_from_world: &DMat4, ndc: DVec2) -> f64 {
    // The plane in clip space has the coefficients n with n . clip = y for every point.
    let n: DVec4 = clip_from_world.inverse().transpose() * DVec4::Y;
    -(n.x * ndc.x + n.y * ndc.y + n.w) / n.z
}

/// Largest error of depth over the map, and how many texels show the ground.
fn ground_error(scene: &Scene, m: DMat4) -> (f64, usize) {
    let n = 256u32;
    let (mut worst, mut seen) = (0.0f64, 0);
    for (i, z) in depth(scene, m, [n, n]).into_iter().enumerate() {
        let (x, y) = ((i as u32 % n) as f64 + 0.5, (i as u32 / n) as f64 + 0.5);
        let ndc = DVec2::new(2.0 * x / f64::from(n) - 1.0, 1.0 - 2.0 * y / f64::from(n));
        let expected = ground_depth(&m, ndc);
        let at = m.inverse() * DVec4::new(ndc.x, ndc.y, expected, 1.0);
        let visible = at.w > 0.0 && (0.0..1.0).contains(&expected);
        worst = worst.max((f64::from(z) - if visible { expected } else { 1.0 }).abs());
        seen += usize::from(visible);
    }
    (worst, seen)
}

#[test]
fn a_ground_of_any_extent_is_its_plane() {
    for (name, m) in [("slanted", slanted()), ("warped", warped()), ("camera", camera())] {
        for ratio in [1.5, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6] {
            // Single precision keeps y = 0 exactly, so the corners' own rounding stays within the plane.
            let p = |x: f64, z: f64| DVec3::new(x * ratio, 0.0, z * ratio);
            let (a, b, c, d) = (p(-1.0, -1.0), p(1.1, -1.0), p(1.0, 1.2), p(-1.0, 1.0));
            if name == "camera" && ratio < 1e2 {
                continue; // Does not reach the far plane.
            }
            if name != "camera" && ratio < 1e1 {
                continue; // Does not fill the slanted map.
            }
            let (error, seen) = ground_error(&triangles(&[[a, b, c], [a, c, d]]), m);
            assert!(seen > 20_000, "{name}: {seen}");
            // Roundings below 1: the corner of a block, two slopes over it, two sums, the result.
            let bound = 6.0 * HALF_ULP;
            assert!(error <= bound, "{name}, {ratio:e}: {error:e}, not below {bound:e}");
        }
    }
}

#[test]
fn small_triangles_of_a_vast_mesh_keep_their_depth() {
    for ratio in [1e2, 1e3, 1e4, 1e5] {
        // A fine grid over the map; one far triangle in the same mesh sets the extent.
        let n = 60;
        let p = |i: usize, j: usize| DVec3::new(i as f64 / n as f64 * 6.0 - 3.0, 0.0, j as f64 / n as f64 * 6.0 - 3.0);
        let mut corners: Vec<[DVec3; 3]> = (0..n * n)
            .map(|k| (k % n, k / n))
            .flat_map(|(i, j)| [[p(i, j), p(i + 1, j), p(i + 1, j + 1)], [p(i, j), p(i + 1, j + 1), p(i, j + 1)]])
            .collect();
        let far = |x: f64, z: f64| DVec3::new(x, 0.0, z) * ratio;
        corners.push([far(1.0, 1.0), far(1.0, 0.9), far(0.9, 0.9)]);
        corners.push([far(-1.0, -1.0), far(-1.0, -0.9), far(-0.9, -0.9)]);
        let (error, seen) = ground_error(&triangles(&corners), slanted());
        assert!(seen == 256 * 256);
        // Depth of three vertices and the plane through them: three products, a quotient, three products and sums.
        let bound = 10.0 * HALF_ULP;
        assert!(error <= bound, "{ratio:e}: {error:e}, not below {bound:e}");
    }
}

#[test]
fn rings_of_small_large_and_clipped_triangles_cover_each_texel_once() {
    let size = [160u32, 160];
    let mut random = Random(5);
    for (round, outer) in [170.0, 500.0, 3e4, 1e5, 1e7].into_iter().enumerate() {
        for depths in [[0.5; 4], [0.2, 0.4, 0.6, 0.9]] {
            let hub = DVec2::new(random.number(70.0, 90.0), random.number(70.0, 90.0));
            let spokes = 7 + round;
            let mut vertices = vec![hub.extend(depths[0])];
            for (ring, radius) in [9.0, 50.0, outer].into_iter().enumerate() {
                for k in 0..spokes {
                    let angle = (k as f64 + 0.3 * ring as f64) * std::f64::consts::TAU / spokes as f64;
                    vertices.push((hub + radius * 1.6 * DVec2::from_angle(angle)).extend(depths[ring + 1]));
                }
            }
            let at = |ring: usize, k: usize| (1 + ring * spokes + k % spokes) as i64;
            let mut faces: Vec<[i64; 3]> = (0..spokes).map(|k| [0, at(0, k), at(0, k + 1)]).collect();
            for ring in 0..2 {
                faces.extend((0..spokes).flat_map(|k| {
                    let (a, b, c, d) = (at(ring, k), at(ring, k + 1), at(ring + 1, k), at(ring + 1, k + 1));
                    [[a, c, b], [b, c, d]]
                }));
            }
            let vertices: Vec<[f64; 3]> = vertices.iter().map(|p| p.to_array()).collect();
            let mut times = vec![0; (size[0] * size[1]) as usize];
            for face in &faces {
                // All vertices stay in the mesh, by triangles without area, so that each face is placed as in the whole.
                let points = (0..vertices.len() as i64).map(|i| [i; 3]);
                let own: Vec<[i64; 3]> = points.chain([*face]).collect();
                let scene = Scene::from_mesh(Mesh::new(&vertices, &own).unwrap()).unwrap();
                for (t, z) in times.iter_mut().zip(depth(&scene, clip_from_pixels(size), size)) {
                    *t += usize::from(z < 1.0);
                }
            }
            let wrong = times.iter().filter(|&&t| t != 1).count();
            assert_eq!(wrong, 0, "outer ring at {outer:e}: {wrong} texels are not covered once");
        }
    }
}
