//! Closed meshes under the back, the second and the midpoint surface: no acne without bias.

use glam::{DVec3, Vec3};
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Bias, Filter, MaskSettings, Renderer, Spacing, Stored, StoredSurface};
use shadowlab::trace::Tracer;
use shadowlab::{Camera, Progress, Scene};

use super::oracle::cases;
use super::surfaces::cuboid;
use crate::support::cpu::triangles;

const SIZE: [u32; 2] = [200, 150];
const RESOLUTION: [u32; 2] = [256; 2];

/// A closed ball of triangles whose winding shows outwards.
fn ball(centre: DVec3, radius: f64) -> Vec<[DVec3; 3]> {
    let (n, m) = (32, 16);
    let at = |i: usize, j: usize| {
        let (a, b) = (std::f64::consts::TAU * (i % n) as f64 / n as f64, std::f64::consts::PI * j as f64 / m as f64);
        centre + radius * DVec3::new(b.sin() * a.cos(), b.cos(), b.sin() * a.sin())
    };
    let mut found = vec![];
    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
        let (p, q, r, s) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
        if j > 0 {
            found.push([p, q, r]);
        }
        if j + 1 < m {
            found.push([p, r, s]);
        }
    }
    found
}

fn scene() -> Scene {
    let slab = cuboid(DVec3::new(-2.2, -0.4, -2.2), DVec3::new(2.2, 0.0, 2.2));
    let body = cuboid(DVec3::new(-1.2, 0.3, -0.9), DVec3::new(-0.2, 1.1, 0.4));
    triangles(&[slab, body, ball(DVec3::new(0.8, 0.9, 0.3), 0.5)].concat())
}

#[test]
fn closed_casters_have_no_acne_without_bias() {
    let scene = scene();
    assert_eq!(scene.meshes()[0].border_edges(&Progress::new()), Ok(0));
    let camera = Camera::look_at(DVec3::new(2.5, 3.5, 3.0), DVec3::ZERO, DVec3::Y, 0.9, 4.0 / 3.0, 0.1, 50.0).unwrap();
    let tracer = Tracer::new(&scene, &Progress::new()).unwrap();
    let g = CpuRenderer::new().gbuffer(&scene, &camera, SIZE, &Progress::new()).unwrap();
    let normal = |i: usize| Vec3::from_array(g.normal[i]);
    for case in cases() {
        let truth = tracer.shadow_mask(&camera, &case.light, SIZE, &Progress::new()).unwrap();
        let mask = |surface, spacing| {
            let stored = Stored { surface, spacing, ..Stored::default() };
            let (bias, filter) = (Bias::NONE, Filter::Nearest);
            let settings = MaskSettings { resolution: RESOLUTION, size: SIZE, bias, filter, blend: 0.0, stored };
            CpuRenderer::new()
                .shadow_mask(&scene, &camera, &case.light, &case.p, &settings, &Progress::new())
                .unwrap()
                .data
        };
        // Lit pixels with nothing around but light and faces that are turned alike: at a sharp edge a caster is thinner than
        // what its front's depth gains over a texel.
        let (w, h) = (SIZE[0] as usize, SIZE[1] as usize);
        let away = 4;
        let inner = |i: usize| {
            let (x, y) = (i % w, i / w);
            let alike = |j: usize| truth.data[j] == 1 && normal(i).dot(normal(j)) > 0.7;
            let all_lit = || (y - away..=y + away).all(|y| (x - away..=x + away).all(|x| alike(y * w + x)));
            (away..w - away).contains(&x) && (away..h - away).contains(&y) && all_lit()
        };
        let inner: Vec<usize> = (0..w * h).filter(|&i| inner(i)).collect();
        assert!(inner.len() > 3000, "{}: {}", case.name, inner.len());
        for (_, spacing) in Spacing::NAMES {
            for surface in [StoredSurface::Back, StoredSurface::Second, StoredSurface::Midpoint] {
                let mask = mask(surface, spacing);
                let dark = inner.iter().filter(|&&i| mask[i] == 0.0).count();
                assert_eq!(dark, 0, "{}, {surface:?}, {spacing:?}: acne", case.name);
                let shaded = truth.data.iter().zip(&mask).filter(|(t, m)| **t == 0 && **m == 0.0).count();
                assert!(shaded > 1000, "{}, {surface:?}: {shaded}", case.name);
            }
            let front = mask(StoredSurface::Front, spacing);
            assert!(inner.iter().filter(|&&i| front[i] == 0.0).count() > 500, "{}: no acne to remove", case.name);
        }
    }
}
