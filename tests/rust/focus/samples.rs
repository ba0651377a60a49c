//! Samples of what a camera sees: which of them count, what their outline holds, and how deep they are, against all corners of
//! all pixels.

use std::sync::Arc;

use glam::{DVec2, DVec3, DVec4};
use shadowlab::Progress;
use shadowlab::focus::{Outline, Picture, RayFrame, Samples};
use shadowlab::geometry::{clipped, convex_hull};
use shadowlab::parameterization::Region;
use shadowlab::render::Renderer;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::scene::{Camera, DirectionalLight, Light, Scene, SpotLight};
use shadowlab::survey;
use shadowlab::techniques::Needs;

use crate::support::views::{Random, by_hand, directional};

/// Of an extent: two ways to the same corners in f64.
const EXACT: f64 = 1e-12;

#[test]
fn lit_samples_are_those_of_the_part_that_face_the_light() {
    let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0, 1.0, 1.0, 10.0).expect("a camera");
    // Positions are f32 relative to their mean: these, whose depths lie on the camera's planes, have no more digits.
    let depths = [0.5, 1.0, 5.0, 10.0, 11.0];
    let points: Vec<DVec3> =
        depths.iter().flat_map(|d| [DVec3::new(0.125, -1.0, -d), DVec3::new(-0.125, -1.0, -d)]).collect();
    let samples = Samples::of_points(&points, &[DVec3::Y, DVec3::NEG_Y].repeat(depths.len()));
    assert_eq!(samples.positions().collect::<Vec<_>>(), points);
    let down = Light::Directional(DirectionalLight::new(DVec3::NEG_Y).expect("a light"));
    let seen = |light: &Light, region: &Region| -> Vec<f64> {
        samples.lit(&camera, light, region).map(|(p, _)| -p.z).collect()
    };
    // Points to the right face up, those to the left down.
    assert_eq!(seen(&down, &Region::ALL), [1.0, 5.0, 10.0]);
    assert_eq!(seen(&down, &Region::new(&[DVec4::new(0.0, 0.0, 1.0, 5.0)])), [1.0, 5.0]);
    assert!(seen(&down, &Region::new(&[DVec4::new(-1.0, 0.0, 0.0, 0.0)])).is_empty());
    let spot = SpotLight::new(DVec3::new(0.0, 5.0, -5.0), DVec3::NEG_Y, 0.5, 20.0).expect("a spot");
    assert_eq!(seen(&Light::Spot(spot), &Region::ALL), [5.0]);
}

/// What a picture shows, with shadow states.
struct Seen {
    name: String,
    camera: Camera,
    light: Light,
    samples: Samples,
}

/// Pictures of the scenes made by hand, small and large, under random suns and lamps.
fn pictures() -> Vec<Seen> {
    let mut random = Random(23);
    let mut all = Vec::new();
    let scenes = ["town", "town from inside", "cube", "sheared and mirrored", "eye in a corner", "floor"];
    for (name, scene, camera) in by_hand().into_iter().filter(|s| scenes.contains(&s.0)) {
        for (i, size) in [[40, 28], [64, 45], [420, 300]].into_iter().enumerate() {
            for light in [directional(random.direction().with_y(-0.6)), lamp(&mut random, &scene)] {
                let progress = Progress::new();
                let picture = CpuRenderer::new().gbuffer(&scene, &camera, size, &progress).expect("a picture");
                let of = picture.surfaces();
                let samples = survey::samples_of_surfaces(&scene, &camera, &light, of, Needs::Shadows, &progress);
                let name = format!("{name} / {} {i}", light.kind());
                all.push(Seen { name, camera, light, samples: samples.expect("samples") });
            }
        }
    }
    all
}

/// Above a scene, towards a place in it.
fn lamp(random: &mut Random, scene: &Scene) -> Light {
    let b = scene.bounds();
    let size = b.diagonal();
    let above = b.center() + DVec3::new(random.between(-0.3, 0.3), random.between(0.2, 0.6), 0.1) * size;
    let towards = random.in_box(b) - above;
    Light::Spot(SpotLight::new(above, towards, random.between(0.6, 1.8), 3.0 * size).expect("a lamp"))
}

/// The rays of samples and of all corners of their pixels, without those of a pixel of which one lies behind the light.
fn corners(s: &Seen, rays: &RayFrame, chosen: impl Iterator<Item = (DVec3, DVec3)>) -> Vec<DVec2> {
    let (eye, picture) = (s.camera.eye(), s.samples.picture.expect("a picture"));
    let before = |p: DVec3| match s.light {
        Light::Spot(l) => (p + eye - l.position()).dot(l.direction()) > 0.0,
        _ => true,
    };
    let of = |(p, n): (DVec3, DVec3)| {
        let corners = picture.corners(p - eye, n);
        let corners = if corners.iter().all(|c| before(*c)) { corners.to_vec() } else { Vec::new() };
        // Corners of a grazing plane are cut to a share of the depth, and need not lie around the sample.
        corners.into_iter().chain([p - eye]).map(|c| rays.ray(c)).collect::<Vec<_>>()
    };
    chosen.flat_map(of).collect()
}

/// The hull of all of them, of a spot without what lies outside of its pyramid.
fn hull(s: &Seen, mut points: Vec<DVec2>) -> Vec<DVec2> {
    convex_hull(&mut points, &mut Vec::new());
    let Light::Spot(spot) = s.light else { return points };
    let tangent = (0.5 * spot.cone_angle()).tan();
    let sides = [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y];
    sides.iter().fold(points, |hull, side| clipped(&hull, side.extend(tangent)))
}

/// By how far one polygon reaches beyond another, in any of many directions, as a share of the larger one's extent.
fn apart(a: &[DVec2], b: &[DVec2]) -> f64 {
    let reach = |points: &[DVec2], d: DVec2| points.iter().map(|p| d.dot(*p)).fold(f64::NEG_INFINITY, f64::max);
    let directions = (0..720).map(|i| DVec2::from_angle(f64::from(i) * std::f64::consts::TAU / 720.0));
    let (mut off, mut extent) = (0.0_f64, 0.0_f64);
    for d in directions {
        off = off.max((reach(a, d) - reach(b, d)).abs());
        extent = extent.max(reach(b, d) + reach(b, -d));
    }
    off / extent
}

fn assert_outline(what: &str, s: &Seen, outline: &Outline, chosen: impl Iterator<Item = (DVec3, DVec3)> + Clone) {
    let expected = hull(s, corners(s, &outline.rays, chosen.clone()));
    let off = apart(&outline.corners, &expected);
    assert!(off < EXACT, "{what}: {off:e}: {:?} and {expected:?}", outline.corners);
    let turns = |i: usize| {
        let at = |k: usize| outline.corners[(i + k) % outline.corners.len()];
        (at(1) - at(0)).perp_dot(at(2) - at(1)) >= 0.0
    };
    assert!((0..outline.corners.len()).all(turns), "{what}: not convex and counter-clockwise");
    let eye = s.camera.eye();
    assert!(chosen.clone().any(|(p, _)| p - eye == outline.middle), "{what}: the middle is no sample");
}

#[test]
fn an_outline_is_the_hull_of_the_corners_of_all_pixels() {
    let (mut seen, mut shaded, mut parts) = (0, 0, 0);
    for s in pictures() {
        let all = || s.samples.lit(&s.camera, &s.light, &Region::ALL);
        if let Some(outline) = s.samples.outline(&s.camera, &s.light, &Region::ALL) {
            assert_outline(&s.name, &s, &outline, all());
            seen += 1;
        } else {
            assert_eq!(all().count(), 0, "{}", s.name);
        }
        let shadows = s.samples.shadows.as_ref().expect("states");
        let dark = || shadows.shaded.iter().map(|&i| s.samples.sample(i as usize));
        let within = |(p, _): &(DVec3, DVec3)| (s.camera.near()..=s.camera.far()).contains(&s.camera.depth_of(*p));
        if let Some(outline) = s.samples.shaded_outline(&s.camera, &s.light, &Region::ALL) {
            assert_outline(&format!("{}, shaded", s.name), &s, &outline, dark().filter(within));
            shaded += 1;
        }
        // A part of the view: the half of the depths and the rays on one side.
        let Some(middle) = all().nth(all().count() / 2) else { continue };
        let camera = s.camera.with_depths(s.camera.near(), s.camera.depth_of(middle.0)).expect("depths");
        let functional = s.camera.right().extend(-s.camera.right().dot(middle.0));
        let region = Region::new(&[functional]);
        let part: Vec<_> = all()
            .filter(|(p, _)| functional.dot(p.extend(1.0)) >= 0.0 && camera.depth_of(*p) <= camera.far())
            .collect();
        if let Some(outline) = s.samples.outline(&camera, &s.light, &region) {
            assert_outline(&format!("{}, a part", s.name), &s, &outline, part.iter().copied());
            parts += 1;
        }
    }
    println!("{seen} outlines, {shaded} of shadows, {parts} of parts");
    assert!(seen > 25 && shaded > 20 && parts > 20, "{seen} {shaded} {parts}");
}

#[test]
fn the_comparison_of_outlines_sees_one_pixel() {
    let s = pictures().into_iter().find(|s| s.name.starts_with("town / directional")).expect("the town");
    let outline = s.samples.outline(&s.camera, &s.light, &Region::ALL).expect("an outline");
    let mut fewer = s.samples.clone();
    let all: Vec<(DVec3, DVec3)> = s.samples.lit(&s.camera, &s.light, &Region::ALL).collect();
    let expected = hull(&s, corners(&s, &outline.rays, all.iter().copied()));
    // The pixel that has the first corner.
    let has = |i: &usize| corners(&s, &outline.rays, [fewer.sample(*i)].into_iter()).contains(&expected[0]);
    let found = (0..fewer.len()).find(has).expect("a pixel");
    Arc::make_mut(&mut fewer.points).remove(found);
    Arc::make_mut(&mut fewer.normals).remove(found);
    fewer.shadows = None;
    let without = fewer.outline(&s.camera, &s.light, &Region::ALL).expect("an outline");
    assert!(apart(&without.corners, &expected) > EXACT);
}

#[test]
fn without_a_picture_a_sample_is_a_point() {
    let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0, 1.0, 1.0, 100.0).expect("a camera");
    let down = directional(DVec3::NEG_Y);
    let points = [DVec3::new(-1.0, -1.0, -4.0), DVec3::new(1.0, -1.0, -4.0), DVec3::new(0.0, -1.0, -8.0)];
    let samples = Samples::of_points(&points, &[DVec3::Y; 3]);
    let outline = samples.outline(&camera, &down, &Region::ALL).expect("an outline");
    assert_eq!(outline.corners.len(), 3);
    for p in points {
        let nearest = outline.corners.iter().map(|c| (*c - outline.rays.ray(p)).length()).fold(f64::INFINITY, f64::min);
        // Of f32: positions are relative to their mean, some units away.
        assert!(nearest < 1e-6, "{nearest}");
    }
    let depths = samples.depths(&camera, &down, &Region::ALL).expect("depths");
    assert!((depths[0] - 4.0).abs() < 1e-6 && (depths[1] - 8.0).abs() < 1e-6, "{depths:?}");
    assert!(samples.outline(&camera, &directional(DVec3::Y), &Region::ALL).is_none());
    assert!(samples.depths(&camera, &directional(DVec3::Y), &Region::ALL).is_none());
    assert!(samples.shaded_outline(&camera, &down, &Region::ALL).is_none());
}

#[test]
fn depths_reach_to_the_corners_of_pixels_and_the_cameras_planes() {
    let mut beyond = 0;
    for s in pictures() {
        let eye = s.camera.eye();
        let picture: Picture = s.samples.picture.expect("a picture");
        let (mut ends, mut centers) = ([f64::INFINITY, f64::NEG_INFINITY], [f64::INFINITY, f64::NEG_INFINITY]);
        let widen = |range: &mut [f64; 2], depth: f64| *range = [range[0].min(depth), range[1].max(depth)];
        for (p, n) in s.samples.lit(&s.camera, &s.light, &Region::ALL) {
            widen(&mut centers, s.camera.depth_of(p));
            picture.corners(p - eye, n).iter().for_each(|c| widen(&mut ends, c.dot(s.camera.forward())));
        }
        let found = s.samples.depths(&s.camera, &s.light, &Region::ALL);
        let Some([near, far]) = found else {
            assert!(centers[0] > centers[1], "{}", s.name);
            continue;
        };
        // And a step of f32, as positions are, for the surfaces themselves.
        let reach = s.samples.points.iter().flatten().fold(0.0_f64, |most, x| most.max(f64::from(x.abs())));
        let step = f64::from(f32::EPSILON) * 3.0_f64.sqrt() * reach;
        let clamped = |depth: f64| depth.clamp(s.camera.near(), s.camera.far());
        assert!((clamped(ends[0] - step)..=clamped(ends[0])).contains(&near), "{}: {found:?} and {ends:?}", s.name);
        assert!((clamped(ends[1])..=clamped(ends[1] + step)).contains(&far), "{}: {found:?} and {ends:?}", s.name);
        beyond += usize::from(near < centers[0] && far > centers[1]);
    }
    assert!(beyond > 10, "{beyond}");
}
