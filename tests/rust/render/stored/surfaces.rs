//! A box over a floor under maps of all kinds: what each surface, spacing and format stores.

use glam::{DAffine3, DMat4, DVec3};
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Format, Renderer, Spacing, Stored, StoredSurface};
use shadowlab::scene::Instance;
use shadowlab::{Error, Parameterization, Progress, Scene};

use super::oracle::{Measure, cases, expected, hits, ortho, ray, texel_ndc};
use crate::support::cpu::{one_map, triangles};

const SIZE: u32 = 96;
/// Roundings of a rasterised depth to f32, and of the plane that it lies on, relative to the whole depth of the map.
const ROUNDING: f64 = 16.0 * f32::EPSILON as f64;

fn quad([a, b, c, d]: [DVec3; 4]) -> [[DVec3; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

/// A box whose winding shows outwards.
pub fn cuboid(low: DVec3, high: DVec3) -> Vec<[DVec3; 3]> {
    let at = |x: usize, y: usize, z: usize| DVec3::new([low.x, high.x][x], [low.y, high.y][y], [low.z, high.z][z]);
    let faces = [
        [at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1)],
        [at(0, 1, 0), at(0, 1, 1), at(1, 1, 1), at(1, 1, 0)],
        [at(0, 0, 0), at(0, 0, 1), at(0, 1, 1), at(0, 1, 0)],
        [at(1, 0, 0), at(1, 1, 0), at(1, 1, 1), at(1, 0, 1)],
        [at(0, 0, 0), at(0, 1, 0), at(1, 1, 0), at(1, 0, 0)],
        [at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1)],
    ];
    faces.into_iter().flat_map(quad).collect()
}

/// A floor that faces up, and a box over it.
pub fn world() -> Vec<[DVec3; 3]> {
    let floor = quad([(-2.5, -2.5), (-2.5, 2.5), (2.5, 2.5), (2.5, -2.5)].map(|(x, z)| DVec3::new(x, 0.0, z)));
    let body = cuboid(DVec3::new(-0.8, 0.4, -0.7), DVec3::new(0.6, 1.3, 0.9));
    floor.into_iter().chain(body).collect()
}

fn draw(scene: &Scene, p: &Parameterization, stored: Stored) -> Vec<f32> {
    CpuRenderer::new().depth_maps(scene, p, [SIZE; 2], stored, &Progress::new()).unwrap().data
}

fn all() -> impl Iterator<Item = Stored> {
    let limits = [0.5, 40.0];
    StoredSurface::NAMES.into_iter().flat_map(move |(_, surface)| {
        Spacing::NAMES.into_iter().flat_map(move |(_, spacing)| {
            let limits = limits.into_iter().take(if surface == StoredSurface::Dual { 2 } else { 1 });
            limits.map(move |limit| Stored { surface, spacing, limit, format: Format::F32 })
        })
    })
}

#[test]
fn every_surface_and_spacing_is_stored_as_rays_find_it() {
    let world = world();
    let scene = triangles(&world);
    for case in cases() {
        let map = &case.p.partitions[0];
        // Texels whose rays, and those about them, meet the same triangles.
        let mut texels = vec![];
        for (x, y) in (0..SIZE).step_by(4).flat_map(|x| (1..SIZE).step_by(3).map(move |y| (x, y))) {
            let at = [f64::from(x), f64::from(y)];
            let found = |dx: f64, dy: f64| hits(&world, ray(map, texel_ndc([at[0] + dx, at[1] + dy], SIZE)));
            let middle = found(0.0, 0.0);
            let sides = [(-0.1, -0.1), (0.1, -0.1), (-0.1, 0.1), (0.1, 0.1)].map(|(dx, dy)| found(dx, dy));
            if sides.iter().all(|side| side.iter().map(|h| h.1).eq(middle.iter().map(|h| h.1))) {
                texels.push(((y * SIZE + x) as usize, ray(map, texel_ndc(at, SIZE)), middle));
            }
        }
        let layered = texels.iter().filter(|(.., hits)| hits.len() >= 3).count();
        let alone = texels.iter().filter(|(.., hits)| hits.len() == 1).count();
        assert!(layered > 10 && alone > 10, "{}: {layered} {alone} of {}", case.name, texels.len());
        for stored in all() {
            let (drawn, measure) = (draw(&scene, &case.p, stored), Measure::new(map, stored.spacing));
            for (i, ray, hits) in &texels {
                let expected = expected(&measure, *ray, hits, stored, SIZE);
                let apart = (f64::from(drawn[*i]) - expected).abs();
                assert!(apart <= ROUNDING, "{}, {stored}, texel {i}: {} instead of {expected}", case.name, drawn[*i]);
            }
            // A test that a change of what is stored fails.
            let other = draw(&scene, &case.p, Stored { surface: StoredSurface::Front, ..stored });
            assert_eq!(stored.surface == StoredSurface::Front, drawn == other, "{}, {stored}", case.name);
        }
    }
}

#[test]
fn numbers_on_paper() {
    // Straight down from 4 over a floor at 0, to -4: a box from 0.4 to 1.3 on a floor of 2.5 around.
    let scene = triangles(&world());
    let p = one_map(ortho(DVec3::NEG_Y, 4.0) * DMat4::from_translation(DVec3::Y * -12.0));
    let depth = |y: f64| ((4.0 + 24.0 - y) / 32.0) as f32;
    let texel = 8.0 / f64::from(SIZE);
    let of = |surface, limit| {
        let drawn = draw(&scene, &p, Stored { surface, limit, ..Stored::default() });
        let at = |x: f64, z: f64| {
            let (ndc, _) = p.partitions[0].project(DVec3::new(x, 0.0, z));
            let [i, j] = [0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y].map(|u| (u * f64::from(SIZE)) as usize);
            drawn[j * SIZE as usize + i]
        };
        [at(0.0, 0.0), at(2.0, 2.0), at(3.0, 3.0)]
    };
    let near = |found: [f32; 3], expected: [f32; 3]| {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 4e-7), "{found:?}, {expected:?}");
    };
    near(of(StoredSurface::Front, 0.0), [depth(1.3), depth(0.0), 1.0]);
    near(of(StoredSurface::Back, 0.0), [depth(0.4), 1.0, 1.0]);
    near(of(StoredSurface::Second, 0.0), [depth(0.4), 1.0, 1.0]);
    near(of(StoredSurface::Midpoint, 0.0), [depth(0.85), 1.0, 1.0]);
    near(of(StoredSurface::Dual, 2.0), [depth(1.3 - 2.0 * texel), depth(-2.0 * texel), 1.0]);
    near(of(StoredSurface::Dual, f64::INFINITY), [depth(0.85), 1.0, 1.0]);
}

#[test]
fn formats_round_what_is_stored() {
    let scene = triangles(&world());
    for case in cases() {
        for stored in all() {
            let exact = draw(&scene, &case.p, stored);
            for (_, format) in Format::NAMES {
                let rounded = draw(&scene, &case.p, Stored { format, ..stored });
                let expected: Vec<f32> = exact.iter().map(|z| format.quantise(*z)).collect();
                assert_eq!(rounded, expected, "{}, {stored}, {format:?}", case.name);
            }
        }
    }
}

#[test]
fn a_mirrored_instance_and_a_mirrored_map_have_the_same_outer_sides() {
    let world = world();
    let mesh = |corners: &[[DVec3; 3]]| std::sync::Arc::new(crate::support::cpu::triangle_mesh(corners));
    let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    // The mesh's mirror image, its winding turned to show outwards again, placed by a mirror.
    let mirrored: Vec<[DVec3; 3]> =
        world.iter().map(|[a, b, c]| [a, c, b].map(|p| mirror.transform_point3(*p))).collect();
    let plain = triangles(&world);
    let by_mirror = Scene::new(vec![mesh(&mirrored)], vec![Instance { mesh: 0, world_from_mesh: mirror }]).unwrap();
    for case in cases() {
        let back = Stored { surface: StoredSurface::Back, ..Stored::default() };
        let (a, b) = (draw(&plain, &case.p, back), draw(&by_mirror, &case.p, back));
        let covered = a.iter().filter(|z| **z < 1.0).count();
        assert!(covered > 100, "{}", case.name);
        // Vertices are the same numbers, in another order.
        let apart = a.iter().zip(&b).filter(|(a, b)| (*a - *b).abs() > 1e-6).count();
        assert!(apart <= covered / 50, "{}: {apart} of {covered}", case.name);
        // The winding alone decides: turned inside out, fronts are backs.
        let inside_out: Vec<[DVec3; 3]> = world.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
        let (front, turned) = (draw(&plain, &case.p, Stored::default()), draw(&triangles(&inside_out), &case.p, back));
        let apart = front.iter().zip(&turned).filter(|(a, b)| (*a - *b).abs() > 1e-6).count();
        assert!(apart <= covered / 50, "{}: {apart} of {covered}", case.name);
    }
}

#[test]
fn maps_without_linear_depth_are_refused() {
    let scene = triangles(&world());
    let linear = Stored { spacing: Spacing::Linear, ..Stored::default() };
    let midpoint = Stored { surface: StoredSurface::Midpoint, ..Stored::default() };
    let refused = |matrix: DMat4, stored: Stored, name: &str| {
        let result = CpuRenderer::new().depth_maps(&scene, &one_map(matrix), [8; 2], stored, &Progress::new());
        match result {
            Err(Error::InvalidArgument { name: n, .. }) => assert_eq!(n, name),
            other => panic!("{:?}", other.map(|_| ())),
        }
    };
    let singular = DMat4::from_scale(DVec3::new(1.0, 0.0, 1.0));
    refused(singular, linear, "shadow_clip_from_world");
    refused(singular, midpoint, "shadow_clip_from_world");
    // All of it lies behind the projection centre.
    refused(ortho(DVec3::NEG_Y, 4.0) * -1.0, linear, "stored");
    refused(DMat4::IDENTITY, Stored { limit: f64::NAN, ..Stored::default() }, "stored.limit");
    refused(DMat4::IDENTITY, Stored { limit: -1.0, ..Stored::default() }, "stored.limit");
}

#[test]
fn a_map_that_reaches_beyond_its_horizon_has_linear_depth_before_it() {
    // w is 1 + 2 y of a map from above whose lower half lies behind; its horizon is in the upper half of the square.
    let warp = DMat4::from_cols_array(&[1., 0., 0., 0., 0., 1., 0., 0.9, 0., 0., 0.25, 0., 0., 0., 0., 1.]);
    let shift = DMat4::from_translation(DVec3::new(0.0, -0.06, 0.0)) * DMat4::from_scale(DVec3::new(1.0, 1.9, 1.0));
    let p = one_map(shift * warp * ortho(DVec3::NEG_Y, 3.0));
    let (scene, map) = (triangles(&world()), &p.partitions[0]);
    let linear = draw(&scene, &p, Stored { spacing: Spacing::Linear, ..Stored::default() });
    let projective = draw(&scene, &p, Stored::default());
    let mut seen = 0;
    for (i, (a, b)) in linear.iter().zip(&projective).enumerate() {
        assert!((0.0..=1.0).contains(a) && (*a < 1.0 || *b == 1.0), "texel {i}: {a} {b}");
        seen += usize::from(*b < 1.0);
    }
    assert!(seen > 500, "{seen}");
    let (ndc, w) = map.project(DVec3::ZERO);
    assert!(w > 0.0 && ndc.x.abs() < 1.0 && ndc.y.abs() < 1.0);
}
