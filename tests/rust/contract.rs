//! What holds for every technique, every setting, every scene and every light (architecture: the contract).

mod border;
mod checks;
mod configuration;
mod random_views;

use std::collections::BTreeSet;

use glam::{DAffine3, DMat3, DVec3};
use shadowlab::focus::{Focus, FocusedView, Samples};
use shadowlab::geometry::{Aabb, Rows};
use shadowlab::image::{GBuffer, Surfaces};
use shadowlab::note;
use shadowlab::scene::{Camera, Light, Scene};
use shadowlab::survey::SURVEY_COUNT;
use shadowlab::techniques::{Kind, Needs, Technique, Value, technique, techniques_of};
use shadowlab::{Error, Parameterization, Partition};

use crate::support::by_body::by_body_with;
use crate::support::views::{
    self, Random, View, by_hand, directional, directions, from_library, picture_of, points, settings, shaded_samples,
    spots,
};
use checks::{
    Answers, Local, Promise, Receivers, answer, assert_contract, assert_factors, margin_is_too_wide, own_view,
};

const RESOLUTION: u32 = 512;

/// NDC computed twice from matrices with entries up to 1e6 (an eye 1e-3 of the scene's size above a plane).
const TOLERANCE: f64 = 1e-7;

/// Holds all techniques that serve the light of a view against it.
fn check(v: &View, made: &[(String, Box<dyn Technique>)], samples: &Samples, answers: &mut Answers) {
    let r = Receivers::new(v);
    for (name, t) in made.iter().filter(|(_, t)| t.serves(&v.light).is_ok()) {
        let what = format!("{} / {name}", v.name);
        let parameterized = answer(t.as_ref(), v, RESOLUTION, samples).unwrap_or_else(|e| panic!("{what}: {e}"));
        let again = answer(t.as_ref(), v, RESOLUTION, samples).unwrap_or_else(|e| panic!("{what}: {e}"));
        assert_eq!(parameterized, again, "{what}: not the same twice");
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

fn moved(v: &View, scale: f64, offset: DVec3) -> View {
    let map = DAffine3::from_mat3_translation(DMat3::from_diagonal(DVec3::splat(scale)), offset);
    let point = |p: DVec3| map.transform_point3(p);
    let c = &v.camera;
    let camera = Camera::look_at(
        point(c.eye()),
        point(c.eye() + c.forward()),
        c.up(),
        c.fov_y(),
        c.aspect(),
        c.near() * scale,
        c.far() * scale,
    );
    let light = match v.light {
        Light::Spot(l) => Light::Spot(
            shadowlab::scene::SpotLight::new(point(l.position()), l.direction(), l.cone_angle(), l.range() * scale)
                .expect("a spot"),
        ),
        other => other,
    };
    let name = format!("{} x {scale:e} + {offset}", v.name);
    View { name, scene: v.scene.transformed(&map).expect("moved"), camera: camera.expect("a camera"), light }
}

/// Samples of a view at another scale, a power of two where there are any, and place.
fn moved_samples(samples: &Samples, picture: &GBuffer, to: &View, scale: f64, offset: DVec3) -> Samples {
    let surfaces = picture.surfaces();
    let position: Vec<[f32; 3]> = surfaces.position.iter().map(|p| p.map(|x| x * scale as f32)).collect();
    let surfaces = Surfaces { origin: surfaces.origin * scale + offset, position: &position, ..surfaces };
    let shadows = samples.shadows.as_ref().expect("states");
    Samples::of_surfaces(&surfaces, &to.camera).with_shadows(&to.light, shadows.image.clone(), &surfaces, SURVEY_COUNT)
}

/// A technique with its lengths in the units of a world scaled by `scale`, its planes in one moved by `offset` after that, and
/// so those within it.
fn scaled(t: &dyn Technique, scale: f64, offset: DVec3) -> Box<dyn Technique> {
    // The largest number means no limit at any scale.
    let times = |x: f64, k: f64| (x * k).min(f64::MAX);
    let params = t.spec().params.iter().zip(t.settings());
    let params: Vec<(String, Value)> = params
        .map(|(p, (name, value))| {
            let value = match (value, p.kind, p.unit) {
                (Value::Number(x), _, "world units") => Value::Number(times(x, scale)),
                (Value::Number(x), _, "per world unit") => Value::Number(times(x, scale.recip())),
                (Value::Numbers(list), _, "world units") => {
                    Value::Numbers(list.into_iter().map(|x| times(x, scale)).collect())
                }
                (Value::Numbers(list), _, _) if name == "plane" => {
                    let moved = DVec3::new(list[0], list[1], list[2]).dot(offset);
                    Value::Numbers(vec![list[0], list[1], list[2], times(list[3], scale) - moved])
                }
                (Value::Choice(text), Kind::Techniques, _) => {
                    let inner = techniques_of(&text).expect("a technique made it");
                    let inner: Vec<String> =
                        inner.iter().map(|t| text_of(scaled(t.as_ref(), scale, offset).as_ref())).collect();
                    Value::Choice(inner.join("/"))
                }
                (value, ..) => value,
            };
            (name.to_string(), value)
        })
        .collect();
    technique(t.spec().name, &params).expect("made")
}

/// A technique with all of its settings, as text.
fn text_of(t: &dyn Technique) -> String {
    let value = |value: Value| match value {
        Value::Choice(word) => format!("({word})"),
        other => other.to_string(),
    };
    let settings: Vec<String> = t.settings().into_iter().map(|(name, v)| format!("{name}={}", value(v))).collect();
    format!("({}:{})", t.spec().name, settings.join(","))
}

/// Corners of K are cuts of three planes, and the crop divides by their extents: a rounding of the input grows by this much
/// before the map's own steepness. Measured: 16 at most.
const CONDITION: f64 = 32.0;

/// The same of a map that is cut to corners of pixels, where rays of a picture meet the planes of f32 samples. Measured, at the
/// smallest warp distance there is: 41 at most.
const CONDITION_SEEN: f64 = 128.0;

/// Compares a view's maps with those of the same view at another scale and place; nothing where rounding alone could move a
/// map by a few texels.
fn compare_moved(
    v: &View,
    a: &Parameterization,
    samples: &Samples,
    moved: &Moved,
    compared: &mut bool,
    vague: &mut bool,
) {
    let &Moved { ref name, ref p, scale, offset, snapped } = moved;
    assert_eq!(a.partitions.len(), p.partitions.len(), "{name}");
    let r = Receivers::new(v);
    // The rounding of the moved scene's coordinates, and what each map makes of it.
    let size = v.scene.bounds().corners().iter().fold(r.view.origin.length(), |m, q| m.max(q.length()));
    let rounding = f64::EPSILON * (size + offset.length() / scale);
    let tolerances: Vec<f64> = (a.partitions.iter())
        .map(|partition| {
            let own = own_view(v, partition);
            let steepness = |q: &DVec3| steepness_at(partition, *q, own.origin);
            // Where a map holds samples alone, it is cut to the corners of their pixels, and w may be anything beyond.
            let promise = Promise::of(a);
            let corners = |(p, n): (DVec3, DVec3)| {
                let corners = samples.picture.expect("a picture").corners(p - v.camera.eye(), n);
                corners.map(|c| c + v.camera.eye() - own.origin)
            };
            let all: Vec<DVec3> = match promise {
                Promise::Body | Promise::Depths => own.receivers.vertices().to_vec(),
                Promise::Seen | Promise::Shadow => promise.held(v, samples).into_iter().flat_map(corners).collect(),
            };
            let steepest = all.iter().map(steepness).fold(0.0, f64::max);
            // The moved camera's direction is a difference of two points as far from the origin as the eye.
            let condition = if promise < Promise::Seen { CONDITION } else { CONDITION_SEEN };
            condition * (rounding * steepest).max(f64::EPSILON * v.camera.eye().length().max(1.0))
        })
        .collect();
    let shift = |k: usize| {
        let texels = p.partitions[k].project(offset).0 - a.partitions[k].project(DVec3::ZERO).0;
        let texels = texels.truncate() * 0.5 * f64::from(RESOLUTION);
        assert!(!snapped || texels.abs().max_element() < 1.0, "{name}: {texels} texels");
        if snapped { (texels * 2.0 / f64::from(RESOLUTION)).extend(0.0) } else { DVec3::ZERO }
    };
    let mut random = Random(5);
    for _ in 0..200 {
        let part = &r.boxes[random.below(r.boxes.len())];
        let q = Receivers::random_in(&mut random, part);
        let q_world = q + r.view.origin;
        let Some(k) = a.choose(q_world, v.camera.depth_of(q_world)).filter(|_| r.counts(q)) else { continue };
        // What is not held may lie where w is smaller.
        let tolerance = tolerances[k].max(CONDITION * rounding * steepness_at(&a.partitions[k], q, r.view.origin));
        if tolerance >= 0.01 {
            *vague = true;
            continue;
        }
        let one = a.partitions[k].project(q_world).0 + shift(k);
        let two = p.partitions[k].project(q_world * scale + offset).0;
        assert!((one - two).length() < tolerance, "{name}: {one} and {two}, {tolerance:e}");
        *compared = true;
    }
}

/// The fastest that a map moves along an axis, at a point relative to an origin.
fn steepness_at(partition: &Partition, q: DVec3, origin: DVec3) -> f64 {
    let local = Local::new(partition, origin);
    [DVec3::X, DVec3::Y, DVec3::Z].iter().map(|d| local.derivative(q, *d)).fold(0.0, f64::max)
}

/// A view's maps at another scale and place.
struct Moved {
    name: String,
    p: Parameterization,
    scale: f64,
    offset: DVec3,
    /// Whether its texels stand still in the world, so that the place shifts them.
    snapped: bool,
}

#[test]
fn the_same_map_at_every_scale_and_far_from_the_origin() {
    let made = settings();
    let utm = DVec3::new(455_000.0, 5_411_000.0, -1_200.0);
    // A stable map's radius is rounded to a part of a power of two: those scales keep it.
    let powers = [(-20.0_f64).exp2(), 30.0_f64.exp2()];
    let plain = [(1e-6, DVec3::ZERO), (1e9, DVec3::ZERO), (1.0, utm), (1e-6, utm * 1e-6), (1e9, utm * 1e9)];
    let lattice = powers.iter().flat_map(|&s| [(s, DVec3::ZERO), (s, utm * s)]).chain([(1.0, utm)]);
    let lattice: Vec<_> = lattice.collect();
    let (mut all_compared, mut all_vague, mut unsuited) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
    for (name, scene, camera) in by_hand().into_iter().filter(|s| ["cube", "town", "floor"].contains(&s.0)) {
        let picture = picture_of(&scene, &camera);
        let mut lights = spots(&scene, &camera);
        lights.truncate(1);
        lights.push(("slanted".into(), directional(DVec3::new(0.4, -1.0, -0.3))));
        for (light_name, light) in lights {
            let v = View { name: format!("{name} / {light_name}"), scene: scene.clone(), camera, light };
            let samples = shaded_samples(&scene, &camera, &light, &picture);
            for (setting, t) in made.iter().filter(|(_, t)| t.serves(&v.light).is_ok()) {
                // A spot's warp axis is taken at the mean of the body's vertices, and a face's borders meet the frustum's own
                // planes in single points: rounding decides how many vertices there are.
                if setting.contains("face_partition") && matches!(light, Light::Spot(_)) {
                    continue;
                }
                let stable = t.settings().contains(&("stable", Value::Flag(true)));
                let snapped = stable && matches!(light, Light::Directional(_));
                let what = format!("{} / {setting}", v.name);
                let map_of = |t: &dyn Technique, v: &View, samples: &Samples| {
                    answer(t, v, RESOLUTION, samples).unwrap_or_else(|e| panic!("{what}: {e}"))
                };
                let Some(a) = map_of(t.as_ref(), &v, &samples) else {
                    unsuited.insert(setting.as_str());
                    continue;
                };
                // Positions of samples are f32: times powers of two they stay what they are.
                let sampled = t.needs() != Needs::Nothing;
                for &(scale, offset) in if snapped || sampled { &lattice[..] } else { &plain[..] } {
                    let other = moved(&v, scale, offset);
                    let name = format!("{} / {setting}", other.name);
                    let seen = moved_samples(&samples, &picture, &other, scale, offset);
                    let b = map_of(scaled(t.as_ref(), scale, offset).as_ref(), &other, &seen);
                    // Where rounding takes all of a map, it is told.
                    let Some(p) = b else {
                        all_vague.insert(setting.as_str());
                        continue;
                    };
                    let (mut compared, mut vague) = (false, false);
                    let moved = Moved { name, p, scale, offset, snapped };
                    compare_moved(&v, &a, &samples, &moved, &mut compared, &mut vague);
                    all_compared.extend(compared.then_some(setting.as_str()));
                    all_vague.extend(vague.then_some(setting.as_str()));
                }
            }
        }
    }
    let all: BTreeSet<&str> = made.iter().map(|(name, _)| name.as_str()).collect();
    let answered: BTreeSet<&str> = all_compared.union(&unsuited).copied().collect();
    assert_eq!(answered, all);
    // The strongest warps: at their near end a rounding of the scene may be a texel, in some scenes; all are compared in
    // others. No default is as strong.
    println!("vague: {all_vague:?}");
    assert!(all_vague.iter().all(|setting| !setting.ends_with("()")), "{all_vague:?}");
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
        let on_point = t.parameterize_seen(&scene, &camera, &point.light, RESOLUTION, Some(&on_lamp));
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
