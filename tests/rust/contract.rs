//! What holds for every technique, every setting, every scene and every light (architecture: the contract).

mod answers;
mod border;
mod checks;
mod configuration;
mod eye_scenes;
mod eye_views;
mod moved;
mod promise;
mod random_views;
mod wide_maps;

use glam::{DAffine3, DMat3, DVec3};
use shadowlab::Error;
use shadowlab::focus::{Focus, FocusedView, Samples};
use shadowlab::geometry::{Aabb, Rows};
use shadowlab::note;
use shadowlab::scene::{Camera, Light, Scene};
use shadowlab::techniques::{Needs, Technique, Value, technique};

use crate::support::by_body::by_body_with;
use crate::support::cameras::cameras_of_every_kind;
use crate::support::settings::settings;
use crate::support::views::{
    self, Random, View, by_hand, directional, directions, from_library, picture_of, points, shaded_samples, spots,
};
use answers::{Answers, answer, margin_is_too_wide};
use checks::{Receivers, assert_contract, assert_factors};

const RESOLUTION: u32 = 512;

/// NDC computed twice from matrices with entries up to 1e6 (an eye 1e-3 of the scene's size above a plane).
const TOLERANCE: f64 = 1e-7;

/// Holds techniques that serve the light of a view against it: those with their defaults, and a third of the other settings,
/// others in the next view. Some are made twice. SHADOWLAB_CONTRACT=all takes all settings in all views.
fn check(v: &View, made: &[(String, Box<dyn Technique>)], samples: &Samples, answers: &mut Answers) {
    let r = Receivers::new(v);
    let turn = answers.turn();
    let all = std::env::var("SHADOWLAB_CONTRACT").is_ok_and(|value| value == "all");
    let is_due = |i: usize, name: &str| all || (i + turn).is_multiple_of(3) || name.ends_with("()");
    for (i, (name, t)) in made.iter().enumerate().filter(|(i, (name, _))| is_due(*i, name)) {
        if t.serves(&v.light).is_err() {
            continue;
        }
        let what = format!("{} / {name}", v.name);
        let parameterized = answer(t.as_ref(), v, RESOLUTION, samples).unwrap_or_else(|e| panic!("{what}: {e}"));
        if (i + turn).is_multiple_of(2) {
            let again = answer(t.as_ref(), v, RESOLUTION, samples).unwrap_or_else(|e| panic!("{what}: {e}"));
            assert_eq!(parameterized, again, "{what}: not the same twice");
        }
        answers.count(t.spec().name, parameterized.is_some());
        if let Some(p) = parameterized {
            assert_factors(&what, &p);
            assert_contract(&what, v, &r, &p, samples);
        }
    }
}

#[test]
fn every_technique_on_scenes_made_by_hand_under_awkward_lights() {
    let made = settings();
    let mut answers = Answers::default();
    for (name, scene, camera) in by_hand() {
        let picture = picture_of(&scene, &camera);
        let lights = directions(&camera).into_iter().map(|(n, d)| (n, directional(d)));
        for (light_name, light) in lights.chain(spots(&scene, &camera)).chain(points(&scene, &camera)) {
            let samples = shaded_samples(&scene, &camera, &light, &picture);
            let v = View { name: format!("{name} / {light_name}"), scene: scene.clone(), camera, light };
            check(&v, &made, &samples, &mut answers);
        }
    }
    answers.assert_maps_of_all();
}

#[test]
fn every_technique_before_cameras_of_every_kind() {
    let made = settings();
    let mut answers = Answers::default();
    // Every fourth light before each camera, others before the next: all lights before every fourth.
    for (i, (name, scene, camera)) in cameras_of_every_kind().into_iter().enumerate() {
        let picture = picture_of(&scene, &camera);
        let lights = directions(&camera).into_iter().map(|(n, d)| (n, directional(d)));
        let lights = lights.chain(spots(&scene, &camera)).chain(points(&scene, &camera));
        for (light_name, light) in lights.skip(i % 4).step_by(4) {
            let samples = shaded_samples(&scene, &camera, &light, &picture);
            let v = View { name: format!("{name} / {light_name}"), scene: scene.clone(), camera, light };
            check(&v, &made, &samples, &mut answers);
        }
    }
    answers.assert_maps_of_all();
}

#[test]
fn every_technique_on_the_library_scenes() {
    let made = settings();
    let mut answers = Answers::default();
    for v in from_library() {
        let picture = picture_of(&v.scene, &v.camera);
        check(&v, &made, &shaded_samples(&v.scene, &v.camera, &v.light, &picture), &mut answers);
        // The whole list of lights with the defaults.
        let defaults = made.iter().filter(|(name, _)| name.ends_with("()"));
        let made: Vec<(String, Box<dyn Technique>)> =
            defaults.map(|(n, t)| (n.clone(), technique(t.spec().name, &[]).expect("made"))).collect();
        let lights = directions(&v.camera).into_iter().map(|(n, d)| (n, directional(d)));
        for (light_name, light) in lights.chain(spots(&v.scene, &v.camera)).chain(points(&v.scene, &v.camera)) {
            let name = format!("{} / {light_name}", v.name);
            let v = View { name, scene: v.scene.clone(), camera: v.camera, light };
            let samples = shaded_samples(&v.scene, &v.camera, &v.light, &picture);
            check(&v, &made, &samples, &mut answers);
        }
    }
    answers.assert_maps_of_all();
}

#[test]
fn the_check_of_pairs_sees_a_map_that_loses_casters() {
    let (name, scene, camera) = by_hand().into_iter().find(|s| s.0 == "town").expect("the town");
    let v = View { name: name.to_string(), scene, camera, light: directional(DVec3::new(0.4, -1.0, -0.3)) };
    let (r, samples) = (Receivers::new(&v), Samples::default());
    for (name, maps) in [("lispsm", 1), ("z_partition", 4), ("face_partition", 2)] {
        let good = by_body_with(name, &[]).parameterize(&v.scene, &v.camera, &v.light, RESOLUTION).expect("a map");
        assert!(good.partitions.len() >= maps, "{name}: {} maps", good.partitions.len());
        for k in 0..good.partitions.len() {
            let spoiled = |low: DVec3, high: DVec3| {
                let mut p = good.clone();
                let m = &mut p.partitions[k].shadow_clip_from_world;
                *m = Rows::of(m).cropped(low, high).matrix();
                std::panic::catch_unwind(|| assert_contract("spoiled", &v, &r, &p, &samples)).is_err()
            };
            let unit = (DVec3::new(-1.0, -1.0, 0.0), DVec3::ONE);
            assert!(!spoiled(unit.0, unit.1));
            let mirrored = (DVec3::new(1.0, -1.0, 0.0), DVec3::new(-1.0, 1.0, 1.0));
            assert!(spoiled(mirrored.0, mirrored.1), "{name}, {k}: mirrored");
            assert!(spoiled(unit.0 * 0.25, unit.1 * 0.25), "{name}, {k}: too narrow");
            assert!(spoiled(unit.0, DVec3::new(1.0, 1.0, 0.5)), "{name}, {k}: far plane too near");
            // Among the random receivers in the other maps is none below a caster at the very top of them.
            if k + 1 == good.partitions.len() {
                assert!(spoiled(DVec3::new(-1.0, -1.0, 0.3), unit.1), "{name}, {k}: near plane too far");
            }
        }
    }
}

#[test]
fn a_warp_from_far_away_is_no_warp() {
    let uniform = by_body_with("uniform", &[]);
    let warped = by_body_with("lispsm", &[("near", Value::Number(1e12))]);
    for (name, scene, camera) in by_hand() {
        let light = directional(DVec3::new(0.4, -1.0, -0.3));
        let a = uniform.parameterize(&scene, &camera, &light, RESOLUTION).expect("a map");
        let b = warped.parameterize(&scene, &camera, &light, RESOLUTION).expect("a map");
        for corner in scene.bounds().corners() {
            let (one, two) = (a.partitions[0].project(corner).0, b.partitions[0].project(corner).0);
            assert!((one - two).length() < 1e-6 * one.length().max(1.0), "{name}: {one} and {two}");
        }
    }
}

#[test]
fn without_a_warp_the_notes_say_why() {
    let (_, scene, camera) = by_hand().into_iter().find(|s| s.0 == "cube").expect("the cube");
    let t = by_body_with("lispsm", &[]);
    let notes =
        |light: Light, camera: &Camera| t.parameterize(&scene, camera, &light, RESOLUTION).expect("a map").notes;
    assert!(notes(directional(camera.forward()), &camera)[0].kind() == note::Kind::NoWarp);
    assert!(notes(directional(DVec3::new(0.4, -1.0, -0.3)), &camera).is_empty());
    let away = views::look(camera.eye(), camera.eye() - camera.forward(), 0.9, 0.1, 100.0);
    assert!(notes(directional(DVec3::NEG_Y), &away)[0].kind() == note::Kind::NothingSeen);
}

#[test]
fn a_spot_inside_a_box_says_what_it_cannot_see() {
    let (_, scene, camera) = by_hand().into_iter().find(|s| s.0 == "cube").expect("the cube");
    for (light_name, light) in spots(&scene, &camera) {
        for name in ["uniform", "lispsm"] {
            let p = by_body_with(name, &[]).parameterize(&scene, &camera, &light, RESOLUTION).expect("a map");
            let told = p.notes.iter().filter(|n| n.kind() == note::Kind::LightInBox).count();
            assert_eq!(told, usize::from(light_name == "inside"), "{name} {light_name}: {:?}", p.notes);
        }
    }
}

#[test]
fn fitting_to_the_scene_never_costs_texels() {
    let light = directional(DVec3::new(0.4, -1.0, -0.3));
    for (name, scene, camera) in by_hand() {
        let texel = |focus: &str| {
            let t = by_body_with("uniform", &[("focus", Value::Choice(focus.into()))]);
            let p = t.parameterize(&scene, &camera, &light, RESOLUTION).expect("a map");
            (p.value("texel_x").expect("a size"), p.value("texel_y").expect("a size"))
        };
        if Receivers::new(&View { name: name.into(), scene: scene.clone(), camera, light }).view.coverage
            != shadowlab::focus::Coverage::AsAsked
        {
            continue;
        }
        let (fit, frustum) = (texel("scene-fit"), texel("frustum"));
        let room = 1.0 + TOLERANCE;
        assert!(fit.0 <= frustum.0 * room && fit.1 <= frustum.1 * room, "{name}: {fit:?} and {frustum:?}");
    }
}

#[test]
fn lights_and_resolutions_that_cannot_be_served_are_errors() {
    let (_, scene, camera) = by_hand().into_iter().find(|s| s.0 == "cube").expect("the cube");
    let picture = picture_of(&scene, &camera);
    let view = |light| View { name: "cube".into(), scene: scene.clone(), camera, light };
    let (down, point) = (view(directional(DVec3::NEG_Y)), view(points(&scene, &camera)[0].1));
    let [samples, on_lamp] = [&down, &point].map(|v| shaded_samples(&scene, &camera, &v.light, &picture));
    for (name, t) in settings() {
        let on_point = t.parameterize_seen(&scene, &camera, &point.light, [RESOLUTION; 2], Some(&on_lamp));
        match (on_point, t.serves(&point.light)) {
            (Ok(p), Ok(())) => assert!(t.spec().lights.point && p.partitions.len() >= 6, "{name}"),
            (Err(Error::UnsuitedView { .. }), Ok(())) => {}
            (Err(Error::InvalidArgument { name: parameter, .. }), Ok(())) => {
                assert!(parameter == "margin" && margin_is_too_wide(t.as_ref(), RESOLUTION), "{name}: {parameter}");
            }
            (Err(error), Err(refused)) => {
                assert!(error == refused && matches!(error, Error::UnsupportedLight { .. }), "{name}: {error}");
            }
            (answer, serves) => panic!("{name}: {answer:?}, and {serves:?}"),
        }
        if t.serves(&down.light).is_err() {
            continue;
        }
        for resolution in [0, 1, 2] {
            let error = answer(t.as_ref(), &down, resolution, &samples).unwrap_err();
            assert!(matches!(error, Error::InvalidArgument { .. }), "{name}: {error}");
        }
        answer(t.as_ref(), &down, 3, &samples).expect("one texel");
        let unseen = t.parameterize(&scene, &camera, &down.light, RESOLUTION);
        let missing = matches!(&unseen, Err(Error::InvalidArgument { name, .. }) if name == "samples");
        assert_eq!(missing, t.needs() != Needs::Nothing, "{name}: {unseen:?}");
    }
}

#[test]
fn a_stable_map_moves_in_whole_texels_and_keeps_its_texel_size() {
    let (_, scene, _) = by_hand().into_iter().find(|s| s.0 == "town").expect("the town");
    let t = by_body_with("uniform", &[("stable", Value::Flag(true))]);
    let light = directional(DVec3::new(0.4, -1.0, -0.3));
    for offset in [DVec3::ZERO, DVec3::new(455_000.0, 80.0, -5_411_000.0)] {
        let scene = scene.transformed(&DAffine3::from_translation(offset)).expect("moved");
        let mut random = Random(17);
        let mut texels = Vec::new();
        let mut fractions: Vec<glam::DVec2> = Vec::new();
        for _ in 0..40 {
            let eye = offset + random.in_box(&Aabb { min: DVec3::splat(-30.0), max: DVec3::splat(30.0) });
            let camera = views::look(eye, eye + random.direction(), 0.9, 0.1, 80.0);
            let p = t.parameterize(&scene, &camera, &light, RESOLUTION).expect("a map");
            let (ndc, _) = p.partitions[0].project(offset);
            let texel = (ndc.truncate() * 0.5 + 0.5) * f64::from(RESOLUTION);
            fractions.push(texel - texel.floor());
            texels.push(p.value("texel_x").expect("a texel size"));
            let frustum = FocusedView::new(&scene, &camera, &light, Focus::Frustum);
            for q in frustum.camera_frustum().corners() {
                let across = p.partitions[0].project(q + camera.eye()).0.truncate().abs().max_element();
                let inset = f64::from(RESOLUTION - 2) / f64::from(RESOLUTION);
                // One texel of snapping may lie beyond the sphere: it is the border's.
                assert!(across <= inset + 1.0 / f64::from(RESOLUTION) + 1e-9, "{across}");
            }
        }
        assert!(texels.iter().all(|x| *x == texels[0]));
        for f in &fractions {
            let d = (*f - fractions[0] + 0.5).rem_euclid(glam::DVec2::ONE) - 0.5;
            // Rounding of coordinates near 5.4e6 over a texel of 0.3: 1e-8 texels.
            assert!(d.abs().max_element() < 1e-6, "{f} and {}", fractions[0]);
        }
    }
}

#[test]
fn scenes_join_without_a_gap_between_receivers_and_casters() {
    // A caster far above what the camera sees, outside of the frustum: it must be in the map's depth.
    let scene: Scene = views::placed(&[
        (views::square(), DMat3::from_diagonal(DVec3::new(10.0, 1.0, 10.0)), DVec3::ZERO),
        (views::cube(), DMat3::from_diagonal(DVec3::splat(0.5)), DVec3::new(0.0, 400.0, 0.0)),
    ]);
    let camera = views::look(DVec3::new(0.0, 1.0, 6.0), DVec3::ZERO, 0.8, 0.1, 30.0);
    for name in ["uniform", "lispsm"] {
        let p = by_body_with(name, &[]).parameterize(&scene, &camera, &directional(DVec3::NEG_Y), 64).expect("a map");
        let (low, _) = p.partitions[0].project(DVec3::ZERO);
        let (high, _) = p.partitions[0].project(DVec3::new(0.0, 400.5, 0.0));
        assert!((0.0..0.1).contains(&high.z) && high.z < low.z && low.z <= 1.0, "{name}: {high} {low}");
    }
}
