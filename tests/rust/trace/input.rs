//! Every input has an answer: a typed error that names the row, or a finite result.

use glam::{DAffine3, DVec3};
use shadowlab::image::TruthMask;
use shadowlab::scene::{DirectionalLight, PointLight};
use shadowlab::trace::{Hit, Tracer};
use shadowlab::{Camera, Error, Light, Mesh, Progress, Scene};

const FLOOR: [[f64; 3]; 4] = [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]];

fn scene(scale: f64) -> Scene {
    let vertices = FLOOR.map(|p| p.map(|x| x * scale));
    Scene::from_mesh(Mesh::new(&vertices, &[[0, 1, 2], [0, 2, 3]]).unwrap()).unwrap()
}

fn tracer() -> Tracer {
    Tracer::new(&scene(1.0), &Progress::new()).unwrap()
}

fn camera() -> Camera {
    Camera::look_at(DVec3::new(0.0, 3.0, 0.1), DVec3::ZERO, DVec3::Y, 1.0, 1.0, 0.1, 10.0).unwrap()
}

fn sun(direction: DVec3) -> Light {
    Light::Directional(DirectionalLight::new(direction).unwrap())
}

fn name_of(error: Error) -> String {
    let Error::InvalidArgument { name, .. } = error else { panic!("{error}") };
    name.into_owned()
}

#[test]
fn bad_rays_are_named_by_their_row() {
    let (tracer, progress) = (tracer(), Progress::new());
    let o = [[0.0, 1.0, 0.0]; 3];
    let d = [[0.0, -1.0, 0.0]; 3];
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut broken = d;
        broken[1][2] = bad;
        assert_eq!(name_of(tracer.first_hit(&o, &broken, &progress).unwrap_err()), "directions[1]");
        assert_eq!(name_of(tracer.occluded(&o, &broken, &[1.0; 3], &progress).unwrap_err()), "directions[1]");
        assert_eq!(name_of(tracer.first_hit(&broken, &d, &progress).unwrap_err()), "origins[1]");
    }
    let zero = [d[0], d[1], [0.0, -0.0, 0.0]];
    let error = tracer.first_hit(&o, &zero, &progress).unwrap_err();
    assert!(error.to_string().contains("directions[2]: expected three finite numbers, not all zero"), "{error}");
    assert_eq!(name_of(tracer.first_hit(&o, &d[..2], &progress).unwrap_err()), "directions");
    assert_eq!(name_of(tracer.occluded(&o, &d, &[1.0; 2], &progress).unwrap_err()), "t_max");
    assert_eq!(name_of(tracer.occluded(&o, &d, &[1.0, f64::NAN, 1.0], &progress).unwrap_err()), "t_max[1]");
    let limits = [f64::INFINITY, -1.0, 1.0];
    assert_eq!(tracer.occluded(&o, &d, &limits, &progress).unwrap(), [true, false, false]);
    assert!(tracer.first_hit(&[], &[], &progress).unwrap().is_empty());
    assert!(tracer.occluded(&[], &[], &[], &progress).unwrap().is_empty());
}

#[test]
fn sizes_are_checked() {
    let tracer = tracer();
    let sun = sun(DVec3::new(0.1, -1.0, 0.0));
    for size in [[0, 4], [4, 0], [0, 0], [16385, 1], [1, u32::MAX]] {
        let error = tracer.shadow_mask(&camera(), &sun, size, &Progress::new()).unwrap_err();
        assert_eq!(name_of(error), "size");
    }
    for size in [[1, 1], [1, 9], [17, 1], [9, 17]] {
        let mask = tracer.shadow_mask(&camera(), &sun, size, &Progress::new()).unwrap();
        assert_eq!((mask.size, mask.data.len()), (size, (size[0] * size[1]) as usize));
        assert!(mask.data.contains(&TruthMask::LIT));
    }
}

#[test]
fn a_stop_is_heeded_and_progress_is_told() {
    let (tracer, stopped) = (tracer(), Progress::new());
    let sun = sun(DVec3::NEG_Y);
    stopped.stop();
    assert_eq!(Tracer::new(&scene(1.0), &stopped).unwrap_err(), Error::Interrupted);
    assert_eq!(tracer.shadow_mask(&camera(), &sun, [8, 8], &stopped).unwrap_err(), Error::Interrupted);
    assert_eq!(tracer.first_hit(&[[0.0; 3]], &[[1.0; 3]], &stopped).unwrap_err(), Error::Interrupted);
    assert_eq!(tracer.occluded(&[[0.0; 3]], &[[1.0; 3]], &[1.0], &stopped).unwrap_err(), Error::Interrupted);
    let progress = Progress::new();
    tracer.shadow_mask(&camera(), &sun, [50, 37], &progress).unwrap();
    assert_eq!(progress.state(), (37, 37));
    tracer.first_hit(&[[0.0; 3]; 5000], &[[1.0; 3]; 5000], &progress).unwrap();
    assert_eq!(progress.state(), (5000, 5000));
}

#[test]
fn extreme_rays_and_scales_are_answered() {
    for scale in [1e-100, 1e-6, 1.0, 1e9, 1e100] {
        let tracer = Tracer::new(&scene(scale), &Progress::new()).unwrap();
        let ask =
            |o: [f64; 3], d: [f64; 3]| tracer.first_hit(&[o.map(|x| x * scale)], &[d], &Progress::new()).unwrap()[0];
        for length in [1e-290, 1e-20, 1.0, 1e20, 1e200] {
            let hit = ask([0.25, 1.0, 0.5], [0.0, -length, 0.0]);
            let t = scale / length;
            if t.is_finite() {
                assert!((hit.t - t).abs() <= 4.0 * f64::EPSILON * t, "{scale} {length}: {hit:?}");
            }
            let up = ask([0.25, 1.0, 0.5], [0.0, length, 0.0]);
            assert_eq!(up, Hit { t: f64::INFINITY, triangle: -1, instance: -1 });
        }
        // From 1e12 extents away straight down, and along the floor's own plane.
        assert_eq!(ask([0.25, 1e12, 0.5], [0.0, -1.0, 0.0]).instance, 0);
        assert_eq!(ask([-5.0, 0.0, 0.3], [1.0, 0.0, 0.0]).instance, -1);
    }
}

#[test]
fn scenes_without_area_show_nothing() {
    let point = Mesh::new(&[[3.0, 2.0, 1.0]; 3], &[[0, 1, 2]]).unwrap();
    let line = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], &[[0, 1, 2], [0, 0, 1]]).unwrap();
    let floor = scene(1.0);
    let crushed = floor.transformed(&DAffine3::from_scale(DVec3::ZERO)).unwrap();
    let thin = floor.transformed(&DAffine3::from_scale(DVec3::new(1.0, 1.0, 0.0))).unwrap();
    for scene in [Scene::from_mesh(point).unwrap(), Scene::from_mesh(line).unwrap(), crushed, thin] {
        let tracer = Tracer::new(&scene, &Progress::new()).unwrap();
        let mask = tracer.shadow_mask(&camera(), &sun(DVec3::NEG_Y), [16, 16], &Progress::new()).unwrap();
        assert!(mask.data.iter().all(|&v| v == TruthMask::NOTHING));
    }
}

#[test]
fn lights_in_awkward_places_are_answered() {
    let tracer = tracer();
    let counts = |light: Light| {
        let data = tracer.shadow_mask(&camera(), &light, [32, 32], &Progress::new()).unwrap().data;
        [-1, 0, 1].map(|v| data.iter().filter(|&&x| x == v).count())
    };
    let point = |p: DVec3| Light::Point(PointLight::new(p, 10.0).unwrap());
    // In the floor's plane, beside it and on it: edge-on, in shadow by definition.
    for place in [DVec3::new(5.0, 0.0, 0.0), DVec3::new(0.1, 0.0, 0.1)] {
        let [undecided, shadow, lit] = counts(point(place));
        assert!(undecided == 0 && shadow > 100 && lit == 0, "{undecided} {shadow} {lit}");
    }
    assert_eq!(counts(sun(DVec3::X))[2], 0);
    // Edge-on up to single precision, and beyond it.
    assert_eq!(counts(sun(DVec3::new(1.0, -1e-9, 0.0)))[2], 0);
    assert!(counts(sun(DVec3::new(1.0, -1e-6, 0.0)))[2] > 100);
    assert!(counts(sun(DVec3::NEG_Y))[2] > 100);
    assert_eq!(counts(sun(DVec3::Y))[2], 0);
    // At the eye: everything that is seen is lit.
    let [undecided, shadow, lit] = counts(point(camera().eye()));
    assert!(undecided == 0 && shadow == 0 && lit > 100, "{undecided} {shadow} {lit}");
}
