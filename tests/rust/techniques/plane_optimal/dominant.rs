//! The dominant plane: found where most of the visible, lit-facing receivers are, and nowhere else.

use glam::DVec3;
use shadowlab::Error;
use shadowlab::focus::Samples;
use shadowlab::parameterization::Region;
use shadowlab::render::Renderer;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::scene::{Camera, library};
use shadowlab::techniques::plane_optimal::{DominantPlane, dominant_plane};

use crate::support::published_view::{EXACT, View, difference};
use crate::support::tables::sun;

/// Numbers in [0, 1) that are the same every time.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

/// Positions are f32 relative to their mean, up to 64 units away here: half of their step.
const SINGLE: f64 = 64.0 * f32::EPSILON as f64 / 4.0;

/// Points with their normals.
type Patch = Vec<(DVec3, DVec3)>;

/// Points of the plane through `foot` with a normal, off it by up to `noise`, before the camera of [`View::of_frustum`].
fn patch(random: &mut Random, count: usize, foot: DVec3, normal: DVec3, size: f64, noise: f64) -> Patch {
    let (a, b) = normal.any_orthonormal_pair();
    let point = |_| {
        let across = a * random.between(-size, size) + b * random.between(-size, size);
        (foot + across + normal * random.between(-noise, noise), normal)
    };
    (0..count).map(point).collect()
}

fn joined(parts: Vec<Patch>) -> Samples {
    let (points, normals): (Vec<DVec3>, Vec<DVec3>) = parts.into_iter().flatten().unzip();
    Samples::of_points(&points, &normals)
}

fn found(v: &View, samples: &Samples) -> Option<DominantPlane> {
    dominant_plane(&v.focused(), &Region::ALL, samples)
}

/// Angle between normals, and the distance of a world point from the plane.
fn assert_plane(what: &str, v: &View, plane: &DominantPlane, normal: DVec3, point: DVec3, tolerance: f64) {
    let (angle, distance) =
        (plane.normal.angle_between(normal), plane.normal.dot(point - v.focused().origin) + plane.offset);
    assert!(angle < tolerance && distance.abs() < tolerance, "{what}: {plane:?}, off by {angle} and {distance}");
}

fn view() -> View {
    View::of_frustum(1.0, DVec3::new(0.3, -1.0, -0.4))
}

#[test]
fn the_larger_of_two_planes_that_face_the_light() {
    let v = view();
    let mut random = Random(1);
    let (floor, wall) = (DVec3::new(0.0, -2.0, -30.0), DVec3::new(-8.0, 0.0, -30.0));
    for (on_floor, on_wall) in [(700, 300), (300, 700)] {
        let samples = joined(vec![
            patch(&mut random, on_floor, floor, DVec3::Y, 8.0, 0.0),
            patch(&mut random, on_wall, wall, DVec3::NEG_X, 8.0, 0.0),
            // More than both, but facing away from the light.
            patch(&mut random, 5000, DVec3::new(0.0, 5.0, -30.0), DVec3::NEG_Y, 8.0, 0.0),
        ]);
        let plane = found(&v, &samples).expect("a plane");
        let (normal, point) = if on_floor > on_wall { (DVec3::Y, floor) } else { (DVec3::NEG_X, wall) };
        assert_plane("exact", &v, &plane, normal, point, SINGLE);
        assert!((plane.share - 0.7).abs() < 1e-12, "{plane:?}");
    }
}

#[test]
fn tilted_and_rough_ground_with_things_on_it() {
    let v = view();
    let mut random = Random(2);
    for tilt in [0.0, 0.07, 0.125, 0.3, 0.5] {
        let normal = DVec3::new(tilt, 1.0, 0.5 * tilt).normalize();
        let foot = DVec3::new(0.0, -3.0, -25.0);
        for (noise, tolerance) in [(0.0, SINGLE), (0.05, 0.02)] {
            let mut ground = patch(&mut random, 3000, foot, normal, 10.0, noise);
            for (_, n) in &mut ground {
                let bump = DVec3::new(random.unit() - 0.5, 0.0, random.unit() - 0.5) * noise * 4.0;
                *n = (*n + bump).normalize();
            }
            let boxes = (0..10).map(|i| {
                let on = foot + normal * (1.0 + 0.3 * f64::from(i)) + DVec3::X * (f64::from(i) - 5.0);
                patch(&mut random, 150, on, DVec3::Y, 0.7, 0.0)
            });
            let samples = joined(std::iter::once(ground).chain(boxes.collect::<Vec<_>>()).collect());
            let plane = found(&v, &samples).expect("a plane");
            assert_plane(&format!("tilt {tilt}, noise {noise}"), &v, &plane, normal, foot, tolerance);
            assert!(plane.share > 0.6, "{plane:?}");
            assert_eq!(Some(plane), found(&v, &samples), "not the same twice");
        }
    }
}

#[test]
fn only_samples_of_the_part_count() {
    let mut v = view();
    let mut random = Random(3);
    let (near, far) = (DVec3::new(0.0, -2.0, -15.0), DVec3::new(0.0, 3.0, -70.0));
    let samples = joined(vec![
        patch(&mut random, 400, near, DVec3::Y, 5.0, 0.0),
        patch(&mut random, 4000, far, DVec3::Y, 9.0, 0.0),
    ]);
    assert_plane("all", &v, &found(&v, &samples).expect("a plane"), DVec3::Y, far, SINGLE);
    v.camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0, 1.0, 1.0, 40.0).expect("a camera");
    assert_plane("near split", &v, &found(&v, &samples).expect("a plane"), DVec3::Y, near, SINGLE);
    let v = view();
    let left = Region::new(&[DVec3::NEG_X.extend(-20.0)]);
    assert_eq!(dominant_plane(&v.focused(), &left, &samples), None);
}

#[test]
fn few_equal_and_broken_samples_have_an_answer() {
    let v = view();
    let one = |p: DVec3, n: DVec3, count: usize| Samples::of_points(&vec![p; count], &vec![n; count]);
    let p = DVec3::new(0.0, -2.0, -9.0);
    for count in [1, 2, 3, 1000] {
        let plane = found(&v, &one(p, DVec3::Y, count)).expect("a plane");
        assert_plane("a point", &v, &plane, DVec3::Y, p, 1e-12);
        assert_eq!(plane.share, 1.0);
    }
    let line: Vec<DVec3> = (0..50).map(|i| p - DVec3::Z * f64::from(i)).collect();
    let plane = found(&v, &Samples::of_points(&line, &[DVec3::Y; 50])).expect("a plane");
    assert_plane("a line", &v, &plane, DVec3::Y, p, 1e-9);
    for (p, n) in [(DVec3::NAN, DVec3::Y), (p, DVec3::NAN), (p, DVec3::ZERO), (DVec3::INFINITY, DVec3::Y)] {
        assert_eq!(found(&v, &one(p, n, 5)), None, "{p} {n}");
    }
    assert_eq!(found(&v, &Samples::default()), None);
}

#[test]
fn the_technique_uses_what_is_seen_and_says_what_it_found() {
    let v = view();
    let missing = v.try_map("plane_optimal", None).unwrap_err();
    assert!(matches!(&missing, Error::InvalidArgument { name, .. } if name == "samples"), "{missing}");
    let none = v.try_map("plane_optimal", Some(&Samples::default())).unwrap_err();
    assert!(matches!(&none, Error::UnsuitedView { reason, .. } if reason.contains("none of the 0 samples")), "{none}");
    // The ground of a scene, as the renderer sees it; the same map as for the plane that it names.
    let built = library::build("courtyard", 1, &[]).expect("courtyard");
    let gbuffer =
        CpuRenderer::new().gbuffer(&built.scene, &built.camera, [160, 90], &Default::default()).expect("seen");
    let samples = Samples::of_surfaces(&gbuffer.surfaces(), &built.camera);
    let v = View { scene: built.scene, camera: built.camera, light: sun(DVec3::new(0.3, -1.0, -0.2)) };
    let p = v.try_map("plane_optimal", Some(&samples)).expect("a map");
    let plane = ["plane_x", "plane_y", "plane_z", "plane_d"].map(|name| p.value(name).expect(name));
    // Positions are float32 relative to the middle of the scene, tens of units away.
    let apart = plane.iter().zip([0.0, 1.0, 0.0, 0.0]).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
    assert!(apart < 1e-5, "{plane:?}");
    let share = p.value("plane_share").expect("a share");
    assert!((0.2..0.9).contains(&share), "{share}");
    let [x, y, z, d] = plane;
    let given = v.try_map(&format!("plane_optimal:plane=({x},{y},{z},{d})"), None).expect("a map");
    let [a, b] = [&p, &given].map(|p| v.local(&p.partitions[0].shadow_clip_from_world));
    assert!(difference(&a, &b, true) < EXACT);
}
