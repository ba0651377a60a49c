//! Bias by the receiver's own plane and along its normal: exact for planes, whatever the light, the warp and the filter.

use glam::{DMat4, DVec3};
use shadowlab::parameterization::Parameterization;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::cpu::lookup::{Comparison, MapLookup};
use shadowlab::render::{Bias, Filter, MaskSettings, Renderer, Stored};
use shadowlab::scene::DirectionalLight;
use shadowlab::{Camera, Light, Progress, Scene};

use crate::support::by_body::by_body_with;
use crate::support::cpu::*;

const SIZE: [u32; 2] = [64, 64];
/// Roundings to f32 of the map, of the receiver's place and of its normal, of which the steepest planes make the most.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64;
/// Vertices are rounded to 1/256 of a texel, each way by half of it: in reaches of a nearest lookup.
const SNAP: f64 = 2.0 / 256.0;

/// The receiver's plane, and no more than what rasterisers make of it.
const PLANE: Bias = Bias { plane: 1.0, slope: SNAP, ndc: ROUNDING, ..Bias::NONE };

/// A large square through a height, tilted about the z axis.
fn sheet(height: f64, tilt: f64) -> [[DVec3; 3]; 2] {
    let p = |x: f64, z: f64| DVec3::new(x * tilt.cos(), height + x * tilt.sin(), z);
    [[p(-9.0, -9.0), p(9.0, -9.0), p(9.0, 9.0)], [p(-9.0, -9.0), p(9.0, 9.0), p(-9.0, 9.0)]]
}

fn directional(direction: DVec3) -> Light {
    Light::Directional(DirectionalLight::new(direction).unwrap())
}

/// The square of half side `radius` about the origin, seen along a direction; depth 8 radii.
fn ortho(direction: DVec3, radius: f64, turn: f64) -> DMat4 {
    let up = DMat4::from_axis_angle(direction, turn).transform_vector3(direction.any_orthonormal_vector());
    let view = glam::dcamera::rh::view::look_to_mat4(-4.0 * radius * direction, direction, up);
    glam::dcamera::rh::proj::directx::orthographic(-radius, radius, -radius, radius, 0.0, 8.0 * radius) * view
}

/// Looks down on the origin.
fn from_above() -> Camera {
    Camera::look_at(DVec3::new(0.3, 4.0, 0.2), DVec3::ZERO, DVec3::Z, 0.5, 1.0, 0.1, 50.0).unwrap()
}

fn mask(scene: &Scene, light: &Light, p: &Parameterization, resolution: u32, bias: Bias, filter: Filter) -> Vec<f32> {
    let settings =
        MaskSettings { resolution: [resolution; 2], size: SIZE, bias, filter, blend: 0.0, stored: Stored::default() };
    CpuRenderer::new().shadow_mask(scene, &from_above(), light, p, &settings, &Progress::new()).unwrap().data
}

fn share_of_light(mask: &[f32]) -> f64 {
    mask.iter().map(|x| f64::from(*x)).sum::<f64>() / mask.len() as f64
}

/// Light that makes an angle with the normal of a sheet, from any side, and a map for it.
fn lit_sheet(random: &mut Random, degrees: f64, tilt: f64) -> (Light, Parameterization) {
    let normal = DVec3::new(-tilt.sin(), tilt.cos(), 0.0);
    let across = normal.any_orthonormal_vector();
    let across = DMat4::from_axis_angle(normal, random.number(0.0, 6.3)).transform_vector3(across);
    let angle = degrees.to_radians();
    let direction = across * angle.sin() - normal * angle.cos();
    let warp = DMat4::from_cols_array(&[1., 0., 0., 0., 0., 1.25, 0., 0.75, 0., 0., 1., 0., 0., 0.75, 0., 1.25]);
    let map = ortho(direction, 3.0, random.number(0.0, 6.3));
    (directional(direction), one_map(if random.number(0.0, 1.0) < 0.5 { map } else { warp * map }))
}

#[test]
fn a_plane_under_any_light_has_no_acne_by_its_own_plane() {
    let mut random = Random(11);
    for degrees in 1..90 {
        let tilt = random.number(-0.6, 0.6);
        let scene = triangles(&sheet(0.0, tilt));
        let (light, p) = lit_sheet(&mut random, f64::from(degrees), tilt);
        for filter in [Filter::Nearest, Filter::Bilinear] {
            let lit = |bias| share_of_light(&mask(&scene, &light, &p, 128, bias, filter));
            assert_eq!(lit(PLANE), 1.0, "{degrees} degrees, {filter:?}: acne by the plane");
            let slope = Bias { slope: 1.0 + SNAP, ndc: ROUNDING, ..Bias::NONE };
            assert_eq!(lit(slope), 1.0, "{degrees} degrees, {filter:?}: acne by the slope");
            if degrees > 10 {
                assert!(lit(Bias { plane: 0.0, ..PLANE }) < 0.9, "{degrees} degrees: no acne to remove");
            }
        }
    }
}

#[test]
fn a_caster_near_a_plane_shades_it_all() {
    // Sheets over one another: the gap that the plane's bias may light is what is left of the slope, that of the slope a texel.
    let mut random = Random(12);
    // Nearer to 90 degrees the upper sheet ends before the gap does.
    for degrees in (1..88).step_by(4) {
        let tilt = random.number(-0.6, 0.6);
        let (light, p) = lit_sheet(&mut random, f64::from(degrees), tilt);
        let angle = f64::from(degrees).to_radians();
        // Along the ray a texel of up to 6 / 128 x 2 (the warp stretches less) gains its size times the tangent, along both axes.
        let gain = 2.0 * (6.0 / 128.0) * 2.0_f64.sqrt() * angle.tan();
        // And by the change of w alone: of 24 world units of depth, w being 0.5 to 2 and changing by 0.75 over half the map.
        let gain = gain + 24.0 * 2.0 * (0.75 / 128.0) / 0.5;
        let rounding = 24.0 * 4.0 * ROUNDING + 1e-5;
        for (bias, reach) in [(PLANE, SNAP), (Bias { slope: 1.0 + SNAP, ndc: ROUNDING, ..Bias::NONE }, 1.0 + SNAP)] {
            let gap = (reach * gain + rounding) * angle.cos();
            let above: Vec<_> = sheet(0.0, tilt).into_iter().chain(sheet(gap / tilt.cos(), tilt)).collect();
            let scene = triangles(&above);
            // The eye is between the sheets only in thought: what it sees is looked up by hand.
            let lookup = MapLookup::new(
                &p.partitions[0],
                &light,
                DVec3::ZERO,
                [128; 2],
                bias,
                Filter::Nearest,
                Stored::default(),
            )
            .unwrap();
            let map = CpuRenderer::new().depth_maps(&scene, &p, [128; 2], Stored::default(), &Progress::new()).unwrap();
            let normal = DVec3::new(-tilt.sin(), tilt.cos(), 0.0);
            let mut looked_at = 0;
            for _ in 0..500 {
                let (x, z) = (random.number(-0.8, 0.8), random.number(-0.8, 0.8));
                let q = DVec3::new(x * tilt.cos(), x * tilt.sin(), z);
                if let Comparison::At(_) = lookup.compare_at(q, normal) {
                    looked_at += 1;
                    let light = lookup.light(&map.data, q, normal);
                    assert_eq!(light, 0.0, "{degrees} degrees, {bias:?}: light through the gap at {q}");
                }
            }
            assert!(looked_at > 100, "{looked_at} of 500 in the map");
        }
    }
}

#[test]
fn the_plane_is_exact_behind_post_warps() {
    let scene = triangles(&sheet(0.0, 0.1));
    let camera = Camera::look_at(DVec3::new(0.0, 0.6, 4.0), DVec3::ZERO, DVec3::Y, 0.9, 1.0, 0.1, 20.0).unwrap();
    let direction = DVec3::new(0.7, -1.0, 0.4);
    let light = directional(direction);
    for name in ["log", "log_psm"] {
        let p = by_body_with(name, &[]).parameterize(&scene, &camera, &light, 64).unwrap();
        let settings = |bias| MaskSettings {
            resolution: [64; 2],
            size: SIZE,
            bias,
            filter: Filter::Nearest,
            blend: 0.0,
            stored: Stored::default(),
        };
        let draw = |bias| {
            let mask = CpuRenderer::new().shadow_mask(&scene, &camera, &light, &p, &settings(bias), &Progress::new());
            let mask = mask.unwrap().data;
            let seen: Vec<f32> = mask.into_iter().filter(|x| !x.is_nan()).collect();
            assert!(seen.len() > 1000);
            share_of_light(&seen)
        };
        // The rasteriser of uneven rows rounds no vertex.
        assert_eq!(draw(Bias { slope: 0.0, ..PLANE }), 1.0, "{name}");
        assert!(draw(Bias { plane: 0.0, slope: 0.0, ..PLANE }) < 0.9, "{name}: no acne to remove");
    }
}

#[test]
fn the_normal_part_moves_the_receiver() {
    let mut random = Random(13);
    for _ in 0..200 {
        let (light, p) = lit_sheet(&mut random, 40.0, 0.2);
        let normal = DVec3::new(-0.2_f64.sin(), 0.2_f64.cos(), 0.0);
        let lookup = |bias| {
            MapLookup::new(&p.partitions[0], &light, DVec3::ZERO, [128; 2], bias, Filter::Nearest, Stored::default())
                .unwrap()
        };
        let q = DVec3::new(random.number(-0.5, 0.5), 0.0, random.number(-0.5, 0.5));
        let depth = |bias, q| match lookup(bias).compare_at(q, normal) {
            Comparison::At(r) => Some((r.p_texel, lookup(bias).depth_at(&r, r.p_texel.floor() + 0.5))),
            Comparison::Lit => None,
        };
        // The size of a texel, by the part along the ray: how far it moves over the whole depth of the map.
        let along = |texels: f64| depth(Bias { texels, ..Bias::NONE }, q).unwrap().1;
        let world = |world: f64| depth(Bias { world, ..Bias::NONE }, q).unwrap().1;
        let texel = (along(0.0) - along(1.0)) / (world(0.0) - world(1.0));
        for parts in [Bias::NONE, PLANE, Bias::default()] {
            let (by_bias, by_hand) = (depth(Bias { normal: 1.5, ..parts }, q), depth(parts, q + 1.5 * texel * normal));
            let ((a, x), (b, y)) = (by_bias.unwrap(), by_hand.unwrap());
            assert!((a - b).length() < 1e-9 && (x - y).abs() < 1e-9, "{a} {x} and {b} {y}");
        }
    }
}

#[test]
fn parts_out_of_range_are_refused() {
    for (bias, name) in [
        (Bias { plane: 1.5, ..Bias::default() }, "bias.plane"),
        (Bias { plane: f64::NAN, ..Bias::default() }, "bias.plane"),
        (Bias { plane: -0.1, ..Bias::default() }, "bias.plane"),
        (Bias { normal: f64::INFINITY, ..Bias::default() }, "bias.normal"),
    ] {
        assert!(bias.checked().unwrap_err().to_string().contains(name));
    }
}
