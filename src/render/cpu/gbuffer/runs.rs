//! Runs of pixels that show one triangle: what [`Surface::seen_along`] finds of each, bit for bit.
//!
//! Most pixels meet the plane of their triangle inside it. For those the answer is a straight line of arithmetic, the same
//! operations in the same order, in a loop that the compiler turns into vector instructions. The others are found
//! in the same loop and left to the function.

use glam::DVec3;

use super::surface::{BESIDE, EDGE_ON, Surface};
use crate::scene::{Camera, PixelRay};

/// Pixels that are worked on at once: a vector of f64. Runs of scenes with hundreds of thousands of triangles are six to
/// nine pixels long.
pub(super) const LANES: usize = 4;

/// What some pixels side by side show.
pub(super) struct Seen {
    /// Camera depths.
    depth: [f64; LANES],
    /// In NDC.
    pub(super) ndc_depth: [f32; LANES],
    /// Relative to the origin of the scene.
    pub(super) position: [[f32; LANES]; 3],
    /// Unit normals towards the eye.
    pub(super) normal: [[f32; LANES]; 3],
    /// 1 where the plane is met inside the triangle, as most are; 0 elsewhere, where the numbers mean nothing.
    plain: [f64; LANES],
}

impl Seen {
    pub(super) const NONE: Self = Self {
        depth: [0.0; LANES],
        ndc_depth: [0.0; LANES],
        position: [[0.0; LANES]; 3],
        normal: [[0.0; LANES]; 3],
        plain: [0.0; LANES],
    };
}

/// The rays through the centres of pixels: affine in the pixel, so three of them tell all.
pub(super) struct Rays {
    first: PixelRay,
    right: PixelRay,
    down: PixelRay,
}

/// Those of a row.
pub(super) struct RowRays<'a> {
    rays: &'a Rays,
    /// From those of the first row.
    down: PixelRay,
}

impl Rays {
    pub(super) fn new(camera: &Camera, size: [u32; 2]) -> Self {
        let first = camera.pixel_ray(0.5, 0.5, size);
        let from_first = |x: f64, y: f64| {
            let ray = camera.pixel_ray(x, y, size);
            PixelRay { from_eye: ray.from_eye - first.from_eye, direction: ray.direction - first.direction }
        };
        Self { first, right: from_first(1.5, 0.5), down: from_first(0.5, 1.5) }
    }

    pub(super) fn row(&self, y: usize) -> RowRays<'_> {
        let PixelRay { from_eye, direction } = self.down;
        RowRays { rays: self, down: PixelRay { from_eye: y as f64 * from_eye, direction: y as f64 * direction } }
    }
}

impl RowRays<'_> {
    /// The ray of a column.
    #[inline(always)]
    fn at(&self, x: f64) -> PixelRay {
        let Rays { first, right, .. } = self.rays;
        PixelRay {
            from_eye: first.from_eye + x * right.from_eye + self.down.from_eye,
            direction: first.direction + x * right.direction + self.down.direction,
        }
    }
}

/// What the pixels from a column on show of a triangle, `count` of them; the rest of the lanes means nothing.
#[inline(always)]
pub(super) fn seen(
    surface: &Surface,
    (camera, eye_from_origin): (&Camera, DVec3),
    rays: &RowRays,
    first: usize,
    depths: &[f32],
    seen: &mut Seen,
) {
    lanes(surface, eye_from_origin, rays, first as f64, seen);
    if surface.normal == DVec3::ZERO {
        seen.plain = [0.0; LANES];
    }
    for (i, &depth) in depths.iter().enumerate() {
        if seen.plain[i] == 0.0 {
            let ray = rays.at((first + i) as f64);
            let (t, normal) = surface.seen_along(camera, &ray, f64::from(depth));
            let position = (eye_from_origin + ray.at(t)).as_vec3();
            seen.depth[i] = t;
            (0..3).for_each(|axis| seen.position[axis][i] = position[axis]);
            (0..3).for_each(|axis| seen.normal[axis][i] = normal.as_vec3()[axis]);
        }
    }
    let volume = camera.volume();
    for i in 0..LANES {
        seen.ndc_depth[i] = volume.ndc_depth(seen.depth[i]) as f32;
    }
}

#[inline(always)]
fn lanes(surface: &Surface, eye_from_origin: DVec3, rays: &RowRays, first: f64, seen: &mut Seen) {
    let Surface { corner, normal, depths, sides, .. } = *surface;
    for i in 0..LANES {
        let ray = rays.at(first + i as f64);
        let along = normal.dot(ray.direction);
        let t = normal.dot(corner - ray.from_eye) / along;
        let is_edge_on = along.abs() <= EDGE_ON * ray.direction.length();
        let p = ray.at(t);
        let is_beside = |k: usize| sides[k].0.dot(p) + sides[k].1 < -BESIDE;
        let is_inside = !(is_beside(0) | is_beside(1) | is_beside(2));
        seen.plain[i] = if is_edge_on | !is_inside | !(t.abs() < f64::INFINITY) { 0.0 } else { 1.0 };
        let t = t.max(depths[0]).min(depths[1]);
        let p = eye_from_origin + ray.at(t);
        let n = if along > 0.0 { -normal } else { normal };
        seen.depth[i] = t;
        (seen.position[0][i], seen.position[1][i], seen.position[2][i]) = (p.x as f32, p.y as f32, p.z as f32);
        (seen.normal[0][i], seen.normal[1][i], seen.normal[2][i]) = (n.x as f32, n.y as f32, n.z as f32);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Mesh, Scene};

    /// Numbers from -1 to 1, the same each time.
    fn number(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    #[test]
    fn runs_have_the_bits_of_single_pixels() {
        let mut state = 7;
        // Some seen edge on, and some without an area.
        let thin = |k: usize| [1.0, 1.0, 1.0, 1e-7, 0.0][k % 5];
        let corners: Vec<[f64; 3]> = (0..300)
            .map(|i| [number(&mut state), number(&mut state) * thin(i / 3), 0.8 * number(&mut state)])
            .collect();
        let faces: Vec<[i64; 3]> = (0..100).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let scene = Scene::from_mesh(Mesh::new(&corners, &faces).unwrap()).unwrap();
        let (size, aspect) = ([61, 43], 61.0 / 43.0);
        let level = Camera::look_at(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO, DVec3::Y, 0.5, aspect, 0.5, 9.0).unwrap();
        let above = Camera::look_at(DVec3::new(1.0, 3.0, 2.0), DVec3::ZERO, DVec3::Y, 0.6, aspect, 0.5, 9.0).unwrap();
        let (mut plain, mut others) = (0, 0);
        for camera in [level, above] {
            let (rays, origin) = (Rays::new(&camera, size), camera.eye() - scene.origin());
            for id in 0..scene.triangle_count() as u32 {
                let surface = Surface::new(&scene, &camera, scene.first_triangles(), id);
                for y in 0..size[1] as usize {
                    let row = rays.row(y);
                    for first in (0..size[0] as usize).step_by(7) {
                        let mut found = Seen::NONE;
                        let depths = [-0.25; LANES - 1];
                        seen(&surface, (&camera, origin), &row, first, &depths, &mut found);
                        for (i, depth) in depths.into_iter().enumerate() {
                            let ray = row.at((first + i) as f64);
                            let (t, normal) = surface.seen_along(&camera, &ray, f64::from(depth));
                            let position = (origin + ray.at(t)).as_vec3().to_array();
                            let bits = |v: [f32; 3]| v.map(f32::to_bits);
                            assert_eq!(bits(found.position.map(|axis| axis[i])), bits(position), "{id} {first} {y}");
                            assert_eq!(bits(found.normal.map(|axis| axis[i])), bits(normal.as_vec3().to_array()));
                            let ndc_depth = camera.volume().ndc_depth(t) as f32;
                            assert_eq!(found.ndc_depth[i].to_bits(), ndc_depth.to_bits());
                            *if found.plain[i] == 0.0 { &mut others } else { &mut plain } += 1;
                        }
                    }
                }
            }
        }
        assert!(plain > 1000 && others > 1000, "{plain} {others}");
    }
}
