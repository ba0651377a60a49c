//! Samples of a part of a view in the coordinates of the light's rays: what a search over maps looks at.
//!
//! Source: theory.md 10.2: with D = d(pixel) / d(ray) on a sample's tangent plane and J = d(map) / d(ray), a texel is
//! `G = D J⁻¹ 2/N` pixels long and wide (10.1); D is fixed, J is the map's.

use glam::{DMat2, DVec2, DVec3};

use super::facing::counts;
use super::outline::RayFrame;
use super::picture::Picture;
use super::samples::Samples;
use crate::parameterization::Region;
use crate::scene::{Camera, Light};

/// A sample at an edge of a shadow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayEdge {
    /// Its ray.
    pub ray: DVec2,
    /// d(pixel) / d(ray), along the surface.
    pub pixel: DMat2,
    /// Pixels across the edge per unit of the ray's coordinates, along the surface.
    pub across: DVec2,
    /// Pixels at edges that it stands for.
    pub weight: f64,
    /// Its camera depth.
    pub depth: f64,
}

impl Samples {
    /// Up to `count` positions, relative to the eye, of the samples that a map for a part of a view has to answer for.
    pub fn spread(&self, camera: &Camera, light: &Light, region: &Region, count: usize) -> Vec<DVec3> {
        let step = self.len().div_ceil(count.max(1)).max(1);
        let eye = camera.eye();
        self.lit(camera, light, region).step_by(step).map(|(p, _)| p - eye).collect()
    }
    /// Up to `count` samples at shadows' edges of a part of a view, in an order of which every beginning is spread over the
    /// picture. Where no edge is known, so many of all samples, each with an edge along x and one along y. Nothing for samples without
    /// a picture or a point light.
    pub fn ray_edges(
        &self,
        camera: &Camera,
        light: &Light,
        region: &Region,
        count: usize,
    ) -> Option<(RayFrame, Vec<RayEdge>)> {
        let (eye, picture) = (camera.eye(), self.picture.as_ref()?);
        let rays = RayFrame::new(light, eye)?;
        let mut found = Vec::new();
        let add = |found: &mut Vec<RayEdge>, (p, n): (DVec3, DVec3), normals: &[DVec2], weight: f64| {
            if let Some(pixel) = pixel_per_ray(picture, &rays, p - eye, n) {
                let (ray, depth) = (rays.ray(p - eye), camera.depth_of(p));
                found.extend(normals.iter().map(|edge| RayEdge {
                    ray,
                    pixel,
                    across: pixel.transpose() * *edge,
                    weight,
                    depth,
                }));
            }
        };
        let edges = self.shadows.iter().flat_map(|shadows| &shadows.edges);
        let seen = edges.map(|edge| (edge, self.sample(edge.sample as usize)));
        for (edge, sample) in seen.filter(|(_, (p, n))| counts(camera, light, region, *p, *n)).take(count) {
            add(&mut found, sample, &[DVec2::from_array(edge.normal.map(f64::from))], f64::from(edge.weight));
        }
        if found.is_empty() {
            let step = (2 * self.len()).div_ceil(count.max(1)).max(1);
            for sample in self.lit(camera, light, region).step_by(step) {
                add(&mut found, sample, &[DVec2::X, DVec2::Y], 1.0);
            }
        }
        Some((rays, found))
    }
}

/// d(pixel) / d(ray) at a point, along its surface; nothing where the surface runs along the ray.
pub(super) fn pixel_per_ray(picture: &Picture, rays: &RayFrame, p: DVec3, n: DVec3) -> Option<DMat2> {
    let [a, b] = on_tangent(rays, p, n)?;
    let [x, y] = picture.gradients(p);
    Some(DMat2::from_cols(DVec2::new(x.dot(a), y.dot(a)), DVec2::new(x.dot(b), y.dot(b))))
}

/// Steps along a surface that change one coordinate of the ray by 1; nothing where the surface runs along the ray.
fn on_tangent(rays: &RayFrame, p: DVec3, n: DVec3) -> Option<[DVec3; 2]> {
    let [a, b] = rays.gradients(p);
    let volume = a.cross(b).dot(n);
    let steps = [b.cross(n) / volume, n.cross(a) / volume];
    steps.iter().all(|s| s.is_finite()).then_some(steps)
}
