//! Maps that are wider than high, or higher than wide: the border is whole texels along each axis, and nothing else changes.

use glam::{DVec2, DVec3};
use shadowlab::focus::Samples;
use shadowlab::scene::{DirectionalLight, SpotLight};
use shadowlab::techniques::{Technique, specs, technique_of};
use shadowlab::{Camera, Light, Parameterization};

use crate::support::by_body::by_body;
use crate::support::measure::inset;
use crate::support::settings::BY_SAMPLES;
use crate::support::views::{View, by_hand, directional, from_library, picture_of, shaded_samples};

const SIZES: [[u32; 2]; 3] = [[512, 128], [96, 480], [1024, 1000]];

fn views() -> Vec<View> {
    let town = by_hand().into_iter().filter(|s| s.0 == "town");
    let mut all: Vec<View> = from_library().into_iter().take(4).collect();
    for (name, scene, camera) in town {
        let b = *scene.bounds();
        let lamp = SpotLight::new(b.center() + DVec3::Y * b.diagonal(), DVec3::NEG_Y, 1.0, 3.0 * b.diagonal());
        for light in [directional(DVec3::new(0.4, -1.0, 0.3)), Light::Spot(lamp.expect("a lamp"))] {
            all.push(View { name: format!("{name} / {}", light.kind()), scene: scene.clone(), camera, light });
        }
    }
    all
}

fn maps(t: &dyn Technique, v: &View, size: [u32; 2], samples: &Samples) -> Option<Parameterization> {
    t.parameterize_seen(&v.scene, &v.camera, &v.light, size, Some(samples)).ok()
}

#[test]
fn the_picture_between_the_borders_is_stretched() {
    let mut compared = 0;
    for v in views() {
        let samples = shaded_samples(&v.scene, &v.camera, &v.light, &picture_of(&v.scene, &v.camera));
        // What is best for texels of other sides is another map.
        let made = specs().filter(|s| s.lights.serves(&v.light) && !BY_SAMPLES.contains(&s.name));
        for t in made.map(|s| by_body(s.name)) {
            let Some(square) = maps(t.as_ref(), &v, [500; 2], &samples) else { continue };
            for size in SIZES {
                let what = format!("{}, {} at {size:?}", v.name, square.technique);
                let wide = maps(t.as_ref(), &v, size, &samples).expect(&what);
                assert_eq!((wide.resolution, wide.partitions.len()), (size, square.partitions.len()), "{what}");
                for (a, b) in square.partitions.iter().zip(&wide.partitions) {
                    for p in samples.positions().step_by(31) {
                        let ((a, w), (b, _)) = (a.project(p), b.project(p));
                        if w <= 0.0 || a.truncate().abs().max_element() > 1.0 {
                            continue;
                        }
                        let [a, b] = [(a, &square), (b, &wide)].map(|(ndc, p)| ndc.truncate() / inset(p));
                        assert!((a - b).abs().max_element() < 1e-7, "{what}: {a} and {b}");
                        compared += 1;
                    }
                }
            }
        }
    }
    assert!(compared > 10_000, "{compared} points");
}

#[test]
fn what_is_seen_lies_between_the_borders() {
    let mut held = 0;
    for v in views() {
        let samples = shaded_samples(&v.scene, &v.camera, &v.light, &picture_of(&v.scene, &v.camera));
        for spec in specs().filter(|s| s.lights.serves(&v.light) && s.params.iter().any(|p| p.name == "margin")) {
            let t = technique_of(&format!("{}:fit=seen,margin=2.5", spec.name)).expect(spec.name);
            for size in SIZES {
                let Some(p) = maps(t.as_ref(), &v, size, &samples) else { continue };
                let [map] = p.partitions.as_slice() else { continue };
                let texels = DVec2::from_array(size.map(f64::from));
                let room = inset(&p) - 2.0 * 2.5 / texels + 1e-9;
                for (q, _) in samples.lit(&v.camera, &v.light, &shadowlab::parameterization::Region::ALL) {
                    let (ndc, w) = map.project(q);
                    assert!(
                        w > 0.0 && ndc.truncate().abs().cmple(room).all(),
                        "{}, {} at {size:?}: {ndc}",
                        v.name,
                        spec.name
                    );
                    held += 1;
                }
            }
        }
    }
    assert!(held > 100_000, "{held} samples");
}

#[test]
fn texels_stand_still_along_both_axes() {
    let v = &views()[0];
    let sun = Light::Directional(DirectionalLight::new(DVec3::new(0.3, -1.0, 0.2)).expect("a light"));
    let t = technique_of("uniform:stable=true").expect("a technique");
    let at = |camera: &Camera, size: [u32; 2]| {
        let p = t.parameterize_seen(&v.scene, camera, &sun, size, None).expect("a map");
        let ndc = p.partitions[0].project(DVec3::ZERO).0.truncate();
        0.5 * ndc * DVec2::from_array(size.map(f64::from))
    };
    let c = &v.camera;
    let moved = |by: DVec3| {
        let (eye, target) = (c.eye() + by, c.eye() + c.forward() + by);
        Camera::look_at(eye, target, c.up(), c.fov_y(), c.aspect(), c.near(), c.far()).expect("a camera")
    };
    for size in SIZES {
        let steps =
            [DVec3::new(1.234, 0.1, -0.77), DVec3::new(-3.1, 2.9, 0.4)].map(|by| at(&moved(by), size) - at(c, size));
        for step in steps {
            assert!((step - step.round()).abs().max_element() < 1e-6, "{size:?}: {step} texels");
        }
        assert!(steps[0] != steps[1], "the map moves");
    }
}
