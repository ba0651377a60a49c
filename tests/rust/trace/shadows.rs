//! Shadows whose shape is known: of a quad, of a sphere, of convex bodies, of coincident and enclosing surfaces.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3, swizzles::Vec3Swizzles};
use shadowlab::image::TruthMask;
use shadowlab::scene::{DirectionalLight, Instance, PointLight, SpotLight};
use shadowlab::trace::Tracer;
use shadowlab::{Camera, Light, Mesh, Progress, Scene};

const SIZE: [u32; 2] = [200, 150];
/// Points nearer than this to an edge of a shadow may be undecided: the band is the half extent times 2^-22, about 2e-6
/// here, over the slope of light and view, at most 10 here.
const EDGE: f64 = 2e-5;

fn mesh(points: &[DVec3], faces: &[[i64; 3]]) -> Mesh {
    Mesh::new(&points.iter().map(|p| p.to_array()).collect::<Vec<_>>(), faces).unwrap()
}

/// Quads of four corners each.
fn quads(corners: &[[DVec3; 4]]) -> Mesh {
    let faces: Vec<[i64; 3]> =
        (0..corners.len() as i64).flat_map(|q| [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|i: i64| i + 4 * q))).collect();
    mesh(corners.as_flattened(), &faces)
}

fn level(half: f64, y: f64) -> [DVec3; 4] {
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, z]| DVec3::new(half * x, y, half * z))
}

fn sphere(nu: usize, nv: usize, radius: f64, center: DVec3) -> Mesh {
    let mut index = HashMap::new();
    let mut points = Vec::new();
    let mut at = |i: usize, j: usize| {
        let key = if j == 0 || j == nv { (0, j) } else { (i % nu, j) };
        *index.entry(key).or_insert_with(|| {
            let (turn, tilt) = (TAU * key.0 as f64 / nu as f64, PI * j as f64 / nv as f64);
            let p = DVec3::new(tilt.sin() * turn.cos(), tilt.cos(), tilt.sin() * turn.sin());
            points.push(center + radius * p);
            points.len() as i64 - 1
        })
    };
    let mut faces = Vec::new();
    for i in 0..nu {
        for j in 0..nv {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            faces.extend([[a, b, c], [a, c, d]].into_iter().filter(|t| t[0] != t[1] && t[1] != t[2] && t[0] != t[2]));
        }
    }
    mesh(&points, &faces)
}

fn scene(meshes: Vec<Mesh>) -> Scene {
    let instances = (0..meshes.len() as u32).map(|mesh| Instance { mesh, world_from_mesh: DAffine3::IDENTITY });
    let instances = instances.collect();
    Scene::new(meshes.into_iter().map(Arc::new).collect(), instances).unwrap()
}

fn camera(eye: DVec3, target: DVec3) -> Camera {
    Camera::look_at(eye, target, DVec3::Y, 1.0, 4.0 / 3.0, 0.01, 100.0).unwrap()
}

fn sun(x: f64, y: f64, z: f64) -> Light {
    Light::Directional(DirectionalLight::new(DVec3::new(x, y, z)).unwrap())
}

fn mask(scene: &Scene, camera: &Camera, light: &Light) -> Vec<i8> {
    let tracer = Tracer::new(scene, &Progress::new()).unwrap();
    tracer.shadow_mask(camera, light, SIZE, &Progress::new()).unwrap().data
}

fn pixels(camera: &Camera) -> impl Iterator<Item = DVec3> {
    let camera = *camera;
    (0..SIZE[1]).flat_map(move |y| {
        (0..SIZE[0]).map(move |x| camera.pixel_ray(f64::from(x) + 0.5, f64::from(y) + 0.5, SIZE).direction)
    })
}

fn count(data: &[i8], value: i8) -> usize {
    data.iter().filter(|&&v| v == value).count()
}

/// A quad (half side 1 at height 1) over a floor (half side 6): the shadow is the quad seen from the light.
fn assert_quad_shadow(light: &Light, reaches: impl Fn(DVec3) -> Option<bool>) {
    let (floor_half, quad_half, height) = (6.0, 1.0, 1.0);
    let camera = camera(DVec3::new(1.5, 5.0, 8.0), DVec3::new(0.3, 0.0, 0.2));
    let data = mask(&scene(vec![quads(&[level(floor_half, 0.0)]), quads(&[level(quad_half, height)])]), &camera, light);
    // Signed distance of a point to a square about the origin, inside positive (maximum norm).
    let inside = |p: DVec2, half: f64| half - p.abs().max_element();
    let mut checked = HashMap::new();
    for (direction, value) in pixels(&camera).zip(data) {
        let on = |y: f64| (y - camera.eye().y) / direction.y;
        let at = |y: f64| camera.eye() + on(y) * direction;
        let (quad, floor) = (inside(at(height).xz(), quad_half), inside(at(0.0).xz(), floor_half));
        let is_level = direction.y >= 0.0;
        if !is_level && (quad.abs() < EDGE || floor.abs() < EDGE) {
            continue;
        }
        let expected = if !is_level && quad > 0.0 {
            reaches(at(height)).map(i8::from)
        } else if !is_level && floor > 0.0 {
            let p = at(0.0);
            let to_light = light.to_light(p);
            let crossing = inside((p + to_light * (height / to_light.y)).xz(), quad_half);
            let is_lit = if crossing.abs() < EDGE { None } else { Some(crossing < 0.0) };
            reaches(p).and_then(|r| if r { is_lit } else { Some(false) }).map(i8::from)
        } else {
            Some(TruthMask::NOTHING)
        };
        if let Some(expected) = expected {
            assert_eq!(value, expected, "{direction}");
            *checked.entry(expected).or_insert(0) += 1;
        }
    }
    for value in [TruthMask::LIT, TruthMask::SHADOW, TruthMask::NOTHING] {
        assert!(checked[&value] > 200, "{checked:?}");
    }
    assert!(checked.values().sum::<usize>() > 29_000, "{checked:?}");
}

#[test]
fn a_quad_throws_its_exact_shadow() {
    assert_quad_shadow(&sun(0.3, -1.0, -0.2), |_| Some(true));
    assert_quad_shadow(&sun(0.0, -1.0, 0.0), |_| Some(true));
    let place = DVec3::new(0.4, 3.0, -0.3);
    let range = 5.0;
    let within = move |p: DVec3| {
        let rest = range - p.distance(place);
        (rest.abs() > EDGE).then_some(rest > 0.0)
    };
    assert_quad_shadow(&Light::Point(PointLight::new(place, range).unwrap()), within);
    let axis = DVec3::new(0.1, -1.0, 0.2).normalize();
    let cone: f64 = 1.4;
    let in_cone = move |p: DVec3| {
        let rest = (p - place).normalize().dot(axis) - (0.5 * cone).cos();
        (rest.abs() > EDGE).then_some(rest > 0.0).and_then(|c| within(p).map(|w| w && c))
    };
    assert_quad_shadow(&Light::Spot(SpotLight::new(place, axis, cone, range).unwrap()), in_cone);
}

#[test]
fn a_sphere_throws_an_ellipse() {
    let (center, radius) = (DVec3::new(0.2, 1.5, -0.1), 1.0);
    let camera = camera(DVec3::new(0.0, 7.0, 7.0), DVec3::new(0.0, 0.0, -1.0));
    let light = sun(0.5, -1.0, -0.6);
    let scene = scene(vec![quads(&[level(8.0, 0.0)]), sphere(64, 32, radius, center)]);
    let tracer = Tracer::new(&scene, &Progress::new()).unwrap();
    let data = mask(&scene, &camera, &light);
    let directions: Vec<[f64; 3]> = pixels(&camera).map(|d| d.to_array()).collect();
    let origins = vec![camera.eye().to_array(); directions.len()];
    let hits = tracer.first_hit(&origins, &directions, &Progress::new()).unwrap();
    // The polyhedron lies between the sphere and one smaller by the sagitta of its largest facet, whose half diagonal is
    // below pi / 32 * sqrt(2).
    let inner = radius * (PI / 32.0 * 2f64.sqrt()).cos();
    let (mut lit, mut shadow) = (0, 0);
    for ((hit, d), value) in hits.iter().zip(&directions).zip(data) {
        if hit.instance != 0 {
            continue;
        }
        let p = camera.eye() + hit.t * DVec3::from_array(*d);
        let off_axis = (p - center).reject_from_normalized(light.to_light(p)).length();
        if off_axis > radius {
            assert_eq!(value, TruthMask::LIT);
            lit += 1;
        } else if off_axis < inner {
            assert_eq!(value, TruthMask::SHADOW);
            shadow += 1;
        }
    }
    assert!(lit > 5000 && shadow > 150, "{lit} {shadow}");
}

#[test]
fn a_convex_body_does_not_shadow_its_own_lit_side() {
    // Coarse and fine, near and far from the origin, tiny and huge, long slivers at the poles.
    for (nu, nv, scale, center) in [
        (8, 4, 1.0, DVec3::ZERO),
        (300, 150, 1.0, DVec3::ZERO),
        (300, 150, 1.0, DVec3::new(5e5, 20.0, 4e6)),
        (60, 300, 1e-6, DVec3::ZERO),
        (300, 20, 1e9, DVec3::splat(-3e9)),
    ] {
        let scene = scene(vec![sphere(nu, nv, scale, center)]);
        let eye = center + scale * DVec3::new(1.0, 1.2, 2.2);
        let camera = Camera::look_at(eye, center, DVec3::Y, 0.9, 4.0 / 3.0, 0.01 * scale, 100.0 * scale).unwrap();
        let light = sun(-0.53, -0.81, 0.17);
        let tracer = Tracer::new(&scene, &Progress::new()).unwrap();
        let data = tracer.shadow_mask(&camera, &light, SIZE, &Progress::new()).unwrap().data;
        let directions: Vec<[f64; 3]> = pixels(&camera).map(|d| d.to_array()).collect();
        let origins = vec![eye.to_array(); directions.len()];
        let hits = tracer.first_hit(&origins, &directions, &Progress::new()).unwrap();
        for (hit, value) in hits.iter().zip(&data) {
            if hit.instance < 0 || *value == TruthMask::UNDECIDED {
                continue;
            }
            let mesh = scene.mesh_of(0);
            let [a, b, c] =
                mesh.triangles()[hit.triangle as usize].map(|i| mesh.positions_local()[i as usize].as_dvec3());
            // Counter-clockwise or not, the centre is inside.
            let outward = (b - a).cross(c - a);
            let outward = outward * outward.dot(a).signum();
            let is_facing = outward.dot(light.to_light(DVec3::ZERO)) > 0.0;
            assert_eq!(*value, i8::from(is_facing), "{nu} {nv} {scale}");
        }
        let (lit, shadow, undecided) = (count(&data, 1), count(&data, 0), count(&data, -1));
        assert!(lit > 2000 && shadow > 1000, "{lit} {shadow}");
        assert!(undecided * 1000 <= lit + shadow, "{undecided} undecided of {}", lit + shadow);
    }
}

#[test]
fn coincident_surfaces_do_not_shadow_each_other() {
    let floor = || quads(&[level(3.0, 0.0)]);
    let tilted = DAffine3::from_rotation_x(0.2) * DAffine3::from_rotation_z(0.1);
    let camera = camera(DVec3::new(0.5, 4.0, 5.0), DVec3::ZERO);
    let light = sun(0.4, -1.0, 0.1);
    let once = scene(vec![floor()]).transformed(&tilted).unwrap();
    let twice = scene(vec![floor(), floor()]).transformed(&tilted).unwrap();
    // And a third time through another frame: shifted there, scaled back here.
    let third = scene(vec![quads(&[level(3.0, 0.0).map(|p| 7.0 * p)])]);
    let thrice = twice.joined(&third.transformed(&(tilted * DAffine3::from_scale(DVec3::splat(1.0 / 7.0)))).unwrap());
    let reference = mask(&once, &camera, &light);
    assert!(count(&reference, 1) > 5000);
    for many in [twice, thrice.unwrap()] {
        let data = mask(&many, &camera, &light);
        let differ = data.iter().zip(&reference).filter(|(a, b)| a != b).count();
        assert!(differ <= 2, "{differ} pixels differ");
    }
}

#[test]
fn enclosing_surfaces_keep_the_light_out_or_in() {
    let shell = sphere(40, 20, 2.0, DVec3::ZERO);
    let camera = camera(DVec3::new(0.1, 0.2, 0.3), DVec3::new(1.0, -1.0, 0.2));
    let scene = scene(vec![shell]);
    // The eye inside a caster: the sun does not come in.
    let data = mask(&scene, &camera, &sun(0.3, -1.0, 0.2));
    assert_eq!(count(&data, 0) + count(&data, -1), data.len());
    assert!(count(&data, -1) * 1000 <= data.len(), "{} undecided", count(&data, -1));
    // A lamp in the middle lights all of it, a lamp outside nothing.
    let lamp = |p: DVec3| Light::Point(PointLight::new(p, 100.0).unwrap());
    let data = mask(&scene, &camera, &lamp(DVec3::new(0.0, 0.1, 0.0)));
    assert_eq!(count(&data, 1), data.len());
    let data = mask(&scene, &camera, &lamp(DVec3::new(0.0, 5.0, 0.0)));
    assert_eq!(count(&data, 1), 0);
}

#[test]
fn the_near_and_far_planes_cut() {
    let scene = scene(vec![quads(&[level(3.0, 0.0), level(1.0, 1.0)])]);
    let cut = |near, far| {
        let camera = Camera::look_at(DVec3::new(0.0, 3.0, 0.0), DVec3::ZERO, DVec3::Z, 1.0, 1.0, near, far).unwrap();
        let tracer = Tracer::new(&scene, &Progress::new()).unwrap();
        tracer.shadow_mask(&camera, &sun(0.01, -1.0, 0.0), [9, 9], &Progress::new()).unwrap().data[40]
    };
    // The upper quad is 2 away, the floor below it 3.
    assert_eq!(cut(0.5, 10.0), TruthMask::LIT);
    assert_eq!(cut(2.5, 10.0), TruthMask::SHADOW);
    assert_eq!(cut(0.5, 1.5), TruthMask::NOTHING);
    assert_eq!(cut(2.5, 2.9), TruthMask::NOTHING);
    assert_eq!(cut(3.5, 9.0), TruthMask::NOTHING);
}

#[test]
fn several_lights_say_what_each_says_alone() {
    let scene = scene(vec![quads(&[level(6.0, 0.0)]), sphere(40, 20, 1.0, DVec3::new(0.0, 1.2, 0.0))]);
    let camera = camera(DVec3::new(3.0, 5.0, 7.0), DVec3::ZERO);
    let lamp = Light::Point(PointLight::new(DVec3::new(1.0, 4.0, 2.0), 50.0).unwrap());
    let lights = [sun(0.3, -1.0, 0.2), lamp, sun(-1.0, -0.4, 0.3), sun(0.3, -1.0, 0.2)];
    let tracer = Tracer::new(&scene, &Progress::new()).unwrap();
    // Neither side is a multiple of a tile's.
    let size = [157, 83];
    let together = tracer.shadow_masks(&camera, &lights, size, &Progress::new()).unwrap();
    assert_eq!(together.len(), lights.len());
    for (light, mask) in lights.iter().zip(&together) {
        assert_eq!(*mask, tracer.shadow_mask(&camera, light, size, &Progress::new()).unwrap());
        assert!(count(&mask.data, TruthMask::SHADOW) > 100 && count(&mask.data, TruthMask::LIT) > 100);
    }
    assert_ne!(together[0], together[1]);
    assert!(tracer.shadow_masks(&camera, &[], size, &Progress::new()).unwrap().is_empty());
}
