//! Shared by the tests of the CPU renderer: scenes in pixel coordinates, hand-made parameterizations, a generator.

use std::sync::Arc;

use glam::{DAffine3, DMat4, DVec2, DVec3};
use shadowlab::parameterization::{Parameterization, Partition};
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Filter, Kernels, Renderer, Stored};
use shadowlab::scene::Instance;
use shadowlab::{Mesh, Progress, Scene};

/// A parameterization of one map.
pub fn one_map(shadow_clip_from_world: DMat4) -> Parameterization {
    maps(&[shadow_clip_from_world])
}

pub fn maps(matrices: &[DMat4]) -> Parameterization {
    Parameterization::of_partitions(matrices.iter().map(|m| Partition::of_matrix(*m)).collect(), [1; 2])
}

/// `clip_from_world` for a world in pixels: x right, y down, z depth in [0, 1].
pub fn clip_from_pixels(size: [u32; 2]) -> DMat4 {
    let [w, h] = size.map(f64::from);
    DMat4::from_translation(DVec3::new(-1.0, 1.0, 0.0)) * DMat4::from_scale(DVec3::new(2.0 / w, -2.0 / h, 1.0))
}

/// Filters of every kind, small and large, and in pixels.
pub const FILTERS: [&str; 9] = [
    "nearest",
    "bilinear",
    "pcf:size=3",
    "pcf:size=9.5",
    "tent:size=4.5",
    "poisson:count=16,radius=2.5,seed=3",
    "pcf:size=3px",
    "tent:size=5px",
    "poisson:count=12,radius=2px,seed=1",
];

pub fn filter(text: &str) -> Filter {
    text.parse().unwrap()
}

/// How far from the point the centre of a compared texel can lie, of a kernel in texels.
pub fn reach_texels(filter: Filter) -> f64 {
    Kernels::new(filter, None).unwrap().fixed().unwrap().reach().max_element()
}

/// A scene of loose triangles.
pub fn triangles(corners: &[[DVec3; 3]]) -> Scene {
    Scene::from_mesh(triangle_mesh(corners)).unwrap()
}

pub fn triangle_mesh(corners: &[[DVec3; 3]]) -> Mesh {
    let vertices: Vec<[f64; 3]> = corners.iter().flatten().map(|p| p.to_array()).collect();
    let faces: Vec<[i64; 3]> = (0..corners.len() as i64).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Mesh::new(&vertices, &faces).unwrap()
}

pub fn instances(mesh: Mesh, places: &[DAffine3]) -> Scene {
    let instances = places.iter().map(|&world_from_mesh| Instance { mesh: 0, world_from_mesh }).collect();
    Scene::new(vec![Arc::new(mesh)], instances).unwrap()
}

/// The depth map of a scene under a matrix.
pub fn depth(scene: &Scene, clip_from_world: DMat4, size: [u32; 2]) -> Vec<f32> {
    CpuRenderer::new()
        .depth_maps(scene, &one_map(clip_from_world), size, Stored::default(), &Progress::new())
        .unwrap()
        .data
}

/// SplitMix64 (S. Vigna): enough randomness for tests, and the same on every machine.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }
    /// An integer in low..high.
    pub fn integer(&mut self, low: i64, high: i64) -> i64 {
        low + (self.next() % (high - low) as u64) as i64
    }
    /// A number in [low, high).
    pub fn number(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
    pub fn vector(&mut self, low: f64, high: f64) -> DVec3 {
        DVec3::new(self.number(low, high), self.number(low, high), self.number(low, high))
    }
}

/// The slow rasteriser that the fast one is held against: exact integers, one pixel and one triangle at a time.
///
/// Triangles in pixels, depth in z. Coordinates are rounded to 1/256 pixel, halves to even. A centre on an edge is decided
/// by moving it to the right, and if that moves along the edge, down, by less than anything: the top-left rule in other words.
pub fn reference_coverage(corners: &[DVec3; 3], size: [u32; 2]) -> Vec<[u32; 2]> {
    let grid = corners.map(|p| [(p.x * 256.0).round_ties_even() as i128, (p.y * 256.0).round_ties_even() as i128]);
    let cross = |u: [i128; 2], v: [i128; 2]| u[0] * v[1] - u[1] * v[0];
    let minus = |a: [i128; 2], b: [i128; 2]| [a[0] - b[0], a[1] - b[1]];
    let area = cross(minus(grid[1], grid[0]), minus(grid[2], grid[0]));
    let mut covered = vec![];
    if area == 0 {
        return covered;
    }
    for y in 0..size[1] {
        for x in 0..size[0] {
            let centre = [256 * i128::from(x) + 128, 256 * i128::from(y) + 128];
            let inside = (0..3).all(|k| {
                let edge = minus(grid[(k + 1) % 3], grid[k]);
                let side = |d: [i128; 2]| area.signum() * cross(edge, d).signum();
                let sides = [side(minus(centre, grid[k])), side([1, 0]), side([0, 1])];
                sides.into_iter().find(|&s| s != 0).is_some_and(|s| s > 0)
            });
            if inside {
                covered.push([x, y]);
            }
        }
    }
    covered
}

/// Value and gradient per pixel of the plane of depth at a point, in f64; nothing for a triangle without area.
pub fn reference_depth(corners: &[DVec3; 3], at: DVec2) -> Option<(f64, DVec2)> {
    let [a, b, c] = *corners;
    let n = (b - a).cross(c - a);
    let gradient = -DVec2::new(n.x, n.y) / n.z;
    (n.z != 0.0).then(|| (a.z + gradient.dot(at - a.truncate()), gradient))
}
