//! Masks under every filter: light and dark stay what they are, planes have no acne, and pixels are pixels of the picture.

use glam::{DMat4, DVec3};
use shadowlab::parameterization::Parameterization;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Bias, Filter, MaskSettings, Renderer, Stored};
use shadowlab::scene::DirectionalLight;
use shadowlab::{Camera, Light, Progress, Scene};

use crate::support::cpu::*;

const SIZE: [u32; 2] = [96, 96];
/// Roundings to f32 of the map and of the receiver's place.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64;

/// The square of half side `radius` about the origin, seen along a direction; depth 8 radii.
fn ortho(direction: DVec3, radius: f64) -> DMat4 {
    let direction = direction.normalize();
    let up = direction.any_orthonormal_vector();
    let view = glam::dcamera::rh::view::look_to_mat4(-4.0 * radius * direction, direction, up);
    glam::dcamera::rh::proj::directx::orthographic(-radius, radius, -radius, radius, 0.0, 8.0 * radius) * view
}

fn directional(direction: DVec3) -> Light {
    Light::Directional(DirectionalLight::new(direction).unwrap())
}

/// The map of light straight down whose axes are those of the picture of [`from_above`].
fn as_the_picture() -> DMat4 {
    let view = glam::dcamera::rh::view::look_to_mat4(DVec3::Y * 20.0, DVec3::NEG_Y, DVec3::NEG_Z);
    glam::dcamera::rh::proj::directx::orthographic(-8.0, 8.0, -8.0, 8.0, 0.0, 40.0) * view
}

/// A rectangle of a level plane from one corner to another at a height.
fn level([x0, z0]: [f64; 2], [x1, z1]: [f64; 2], y: f64) -> [[DVec3; 3]; 2] {
    let p = |x: f64, z: f64| DVec3::new(x, y, z);
    [[p(x0, z0), p(x1, z0), p(x1, z1)], [p(x0, z0), p(x1, z1), p(x0, z1)]]
}

/// Looks down on the origin, -z to the top, x to the right.
fn from_above(height: f64) -> Camera {
    Camera::look_at(DVec3::Y * height, DVec3::ZERO, DVec3::NEG_Z, 0.8, 1.0, 0.05, 100.0).unwrap()
}

fn mask_of(
    (scene, camera, light): (&Scene, &Camera, &Light),
    p: &Parameterization,
    resolution: u32,
    bias: Bias,
    filter: Filter,
) -> Vec<f32> {
    drawn_mask(&CpuRenderer::new(), (scene, camera, light), p, resolution, bias, filter)
}

fn drawn_mask(
    renderer: &dyn Renderer,
    (scene, camera, light): (&Scene, &Camera, &Light),
    p: &Parameterization,
    resolution: u32,
    bias: Bias,
    filter: Filter,
) -> Vec<f32> {
    let settings =
        MaskSettings { resolution: [resolution; 2], size: SIZE, bias, filter, blend: 0.0, stored: Stored::default() };
    renderer.shadow_mask(scene, camera, light, p, &settings, &Progress::new()).unwrap().data
}

#[test]
fn planes_have_no_acne_under_any_filter() {
    assert_planes_have_no_acne(&CpuRenderer::new(), 0.0, ROUNDING);
}

/// That a renderer draws a plane without acne under biases that are enough for planes, on which it has acne without.
/// `snapping` is what its depths tilt by when corners are snapped to the grid of 1/256 of a texel, in reaches of a nearest lookup;
/// `rounding` what a map and a receiver are rounded by.
pub fn assert_planes_have_no_acne(renderer: &dyn Renderer, snapping: f64, rounding: f64) {
    let scene = triangles(&level([-9.0, -9.0], [9.0, 9.0], 0.0));
    let camera = Camera::look_at(DVec3::new(0.3, 6.0, 0.2), DVec3::ZERO, DVec3::Z, 0.8, 1.0, 0.1, 50.0).unwrap();
    let warp = DMat4::from_cols_array(&[1., 0., 0., 0., 0., 1.25, 0., 0.75, 0., 0., 1., 0., 0., 0.75, 0., 1.25]);
    let slope = Bias { slope: 1.0 + snapping, ndc: rounding, ..Bias::NONE };
    // Rounding of vertices to the grid of 1/256 of a texel, in reaches of the kernel: twice that of a nearest lookup is enough.
    let plane = Bias { plane: 1.0, slope: 2.0 / 256.0 + snapping, ndc: rounding, ..Bias::NONE };
    for direction in [DVec3::new(0.3, -1.0, 0.2), DVec3::new(-2.0, -1.0, 0.7), DVec3::new(9.0, -1.0, 5.0)] {
        let light = directional(direction);
        let uniform = ortho(direction, 8.0);
        for matrix in [uniform, warp * ortho(direction, 10.0)] {
            let p = one_map(matrix);
            for text in FILTERS {
                let draw = |bias| drawn_mask(renderer, (&scene, &camera, &light), &p, 96, bias, filter(text));
                let dark = |mask: &[f32]| mask.iter().filter(|x| **x < 1.0).count();
                assert!(dark(&draw(Bias::NONE)) > 2000, "{direction} {text}: no acne to remove");
                // The default limits the slope part to 16 texels, which light this flat exceeds under wide kernels.
                let is_flat = direction.x.abs() > 5.0;
                for bias in [slope, plane, Bias::default()].into_iter().take(if is_flat { 2 } else { 3 }) {
                    assert_eq!(dark(&draw(bias)), 0, "{direction} {text} {bias:?}");
                }
            }
        }
    }
}

#[test]
fn what_is_lit_stays_lit_and_what_is_dark_dark() {
    let floor = level([-9.0, -9.0], [9.0, 9.0], 0.0);
    let roofed = triangles(&[floor, level([-9.0, -9.0], [9.0, 9.0], 2.0)].concat());
    let eye = DVec3::new(0.0, 1.0, 3.0);
    let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, 0.8, 1.0, 0.05, 100.0).unwrap();
    let direction = DVec3::new(0.4, -1.0, 0.3);
    let (light, p) = (directional(direction), one_map(ortho(direction, 8.0)));
    for text in FILTERS {
        let lit = mask_of((&triangles(&floor), &camera, &light), &p, 128, Bias::default(), filter(text));
        let seen = lit.iter().filter(|x| !x.is_nan()).count();
        assert!(seen > 5000 && lit.iter().all(|x| x.is_nan() || *x == 1.0), "{text}");
        let dark = mask_of((&roofed, &camera, &light), &p, 128, Bias::default(), filter(text));
        // Within the roof's shadow by more than any kernel reaches.
        assert!(dark.iter().filter(|x| **x == 0.0).count() > 3000, "{text}");
    }
}

#[test]
fn a_kernel_in_pixels_is_as_wide_in_the_picture_at_any_distance() {
    // The shadow of a half plane whose edge runs along z, seen from three heights.
    let floor = level([-20.0, -20.0], [20.0, 20.0], 0.0);
    let down = DVec3::NEG_Y;
    let scene = triangles(&[floor, level([-20.0, -20.0], [-0.001, 20.0], 0.05)].concat());
    let p = one_map(as_the_picture());
    for (text, width) in [("pcf:size=6px", 6.0), ("tent:size=9px", 9.0), ("poisson:count=256,radius=4px", 8.0)] {
        let of = |height: f64| {
            let camera =
                Camera::look_at(DVec3::new(0.0, height, 0.0), DVec3::ZERO, DVec3::NEG_Z, 0.8, 1.0, 0.01, 100.0)
                    .unwrap();
            // From between floor and half plane nothing of the half plane would be seen; from above, its lit side is.
            let bias = Bias::default();
            let mask = mask_of((&scene, &camera, &directional(down)), &p, 2048, bias, filter(text));
            let row = &mask[48 * 96..49 * 96];
            // The light on the floor right of the edge: half of the kernel's integral, and so of its width.
            let lost: f64 = row[48..].iter().map(|x| 1.0 - f64::from(*x)).sum();
            lost
        };
        // Of a box of width W the light lost beside the edge is W / 8, of a tent W / 12, of a disc of radius R 2 R / (3 pi).
        let expected = match text.split(':').next().unwrap() {
            "pcf" => width / 8.0,
            "tent" => width / 12.0,
            _ => 0.5 * width * 2.0 / (3.0 * std::f64::consts::PI),
        };
        let found = [1.0, 2.0, 4.0].map(of);
        println!("{text}: {found:?}, expected {expected}");
        // The pixel's own width adds to the sum; texels are up to a sixth of a pixel.
        assert!(found.iter().all(|lost| (lost / expected - 1.0).abs() < 0.1), "{text}: {found:?}, not {expected}");
    }
}

#[test]
fn a_kernel_in_pixels_has_its_limits_in_texels() {
    let floor = triangles(&[level([-40.0, -40.0], [40.0, 40.0], 0.0), level([-40.0, -40.0], [0.1, 0.2], 0.3)].concat());
    let light = directional(DVec3::NEG_Y);
    let p = one_map(as_the_picture());
    let bits = |resolution, height: f64, text: &str| {
        let mask = mask_of((&floor, &from_above(height), &light), &p, resolution, Bias::default(), filter(text));
        assert!(mask.iter().any(|x| *x > 0.0 && *x < 1.0), "{text}: no penumbra");
        mask.iter().map(|x| x.to_bits()).collect::<Vec<_>>()
    };
    // So near that a pixel is a hundredth of a texel: bilinear. So far that it is two texels: the widest.
    assert_eq!(bits(64, 2.0, "pcf:size=3px"), bits(64, 2.0, "bilinear"));
    assert_eq!(bits(1024, 4.0, "pcf:size=64px"), bits(1024, 4.0, "pcf:size=64"));
    assert_ne!(bits(1024, 4.0, "pcf:size=20px"), bits(1024, 4.0, "pcf:size=64"));
    assert_eq!(bits(1024, 4.0, "tent:size=64px"), bits(1024, 4.0, "tent:size=64"));
    // A disc of half a texel each way, and of 32.
    assert_eq!(bits(64, 2.0, "poisson:radius=1px"), bits(64, 2.0, "poisson:radius=0.5"));
    assert_eq!(bits(1024, 4.0, "poisson:radius=32px"), bits(1024, 4.0, "poisson:radius=32"));
}
