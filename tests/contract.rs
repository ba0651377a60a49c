//! What holds for every technique, every setting, every scene and every light (architecture: the contract).

#[path = "contract/views.rs"]
mod views;

use std::collections::BTreeSet;

use glam::{DAffine3, DMat3, DMat4, DVec3};
use shadowlab::focus::{Focus, FocusedView};
use shadowlab::geometry::{Aabb, OrientedBox, Rows};
use shadowlab::rays::LightRays;
use shadowlab::scene::{Camera, Light, Scene};
use shadowlab::techniques::{Technique, Value, technique};
use shadowlab::{Error, Parameterization};
use views::{Random, View, by_hand, directional, directions, from_library, settings, spots};

const RESOLUTION: u32 = 512;

/// NDC computed twice from matrices with entries up to 1e6 (an eye 1e-3 of the scene's size above a plane).
const TOLERANCE: f64 = 1e-7;

fn with_params(name: &str, params: &[(&str, Value)]) -> Box<dyn Technique> {
    let params: Vec<(String, Value)> = params.iter().map(|(n, v)| (n.to_string(), v.clone())).collect();
    technique(name, &params).expect("made")
}

/// What a map of this view has to show: points of instances' boxes that the camera can see and the light reaches.
struct Receivers {
    boxes: Vec<OrientedBox>,
    /// To coordinates in which the box is [-1, 1]³; not finite for a flat box.
    inverses: Vec<DMat3>,
    view: FocusedView,
}

impl Receivers {
    fn new(v: &View) -> Self {
        let view = FocusedView::new(&v.scene, &v.camera, &v.light, Focus::SceneFit);
        let transforms = v.scene.world_from_local().iter().enumerate();
        let boxes: Vec<OrientedBox> =
            transforms.map(|(i, m)| OrientedBox::new(v.scene.mesh_of(i).bounds_local(), m, view.origin)).collect();
        let inverses = boxes.iter().map(|b| DMat3::from_cols(b.half[0], b.half[1], b.half[2]).inverse()).collect();
        Self { boxes, inverses, view }
    }
    fn random_in(random: &mut Random, b: &OrientedBox) -> DVec3 {
        b.center + b.half.iter().map(|h| *h * random.between(-1.0, 1.0)).sum::<DVec3>()
    }
    /// Whether a local point can be seen and lit and is in the scene's box.
    fn counts(&self, p: DVec3) -> bool {
        self.view.receiver_planes().all(|plane| plane.distance(p) <= 0.0) && self.view.scene_box.contains(p)
    }
    /// Where the ray from p towards the light, in units of `to_light`, runs through a box: two distances.
    fn through(&self, i: usize, p: DVec3, to_light: DVec3) -> Option<(f64, f64)> {
        let (at, along) = (self.inverses[i] * (p - self.boxes[i].center), self.inverses[i] * to_light);
        if !at.is_finite() {
            return None;
        }
        let (mut near, mut far) = (0.0_f64, f64::INFINITY);
        for axis in 0..3 {
            let (a, d) = (at[axis], along[axis]);
            let (s, t) = ((-1.0 - a) / d, (1.0 - a) / d);
            if d == 0.0 && a.abs() > 1.0 {
                return None;
            }
            if d != 0.0 {
                (near, far) = (near.max(s.min(t)), far.min(s.max(t)));
            }
        }
        (near < far && far.is_finite()).then_some((near, far))
    }
}

/// All of the contract that one matrix can show by itself.
fn assert_contract(what: &str, v: &View, r: &Receivers, p: &Parameterization) {
    let view = &r.view;
    for partition in &p.partitions {
        let m = partition.shadow_clip_from_world;
        assert!(m.is_finite(), "{what}: {m:?}");
        let [near, far] = partition.eye_depth;
        assert!(near > 0.0 && near <= far && far.is_finite(), "{what}: {:?}", partition.eye_depth);
        let rows = Rows::of(&m);
        // (0.1): the rows x, y, w vanish on the light, up to the rounding of their terms.
        let light = v.light.point();
        let across = [rows.x, rows.y, rows.w];
        let terms = across.iter().map(|row| (*row * light).abs().element_sum()).fold(0.0, f64::max);
        for row in across {
            assert!(row.dot(light).abs() <= 1e-12 * terms, "{what}: {row} on {light}");
        }
        assert!(rows.z.dot(light) != 0.0, "{what}: depth does not see the light");
    }
    let values = || p.partitions.iter().flat_map(|partition| &partition.values);
    assert!(values().all(|(_, x)| x.is_finite()), "{what}: {:?}", values().collect::<Vec<_>>());
    // From here on relative to the eye, as the map itself is made.
    let local = local_rows(p, view.origin);
    let seen = view.coverage == shadowlab::focus::Coverage::AsAsked;
    if seen {
        for q in view.receivers.vertices() {
            assert!(local.w.dot(q.extend(1.0)) > 0.0, "{what}: w <= 0 at {q}");
        }
        let mean = view.receivers.vertex_mean();
        let rays = LightRays::new(&v.light, view.origin);
        assert_eq!(rays.orientation(&local, mean), 1.0, "{what}: orientation");
    }
    // Where nothing is seen there is no receiver; the map that says so covers all that the light reaches.
    if seen || p.notes.iter().any(|note| note.contains("sees no part")) {
        assert_pairs(what, v, r, &local, p);
    }
}

fn local_rows(p: &Parameterization, origin: DVec3) -> Rows {
    Rows::of(&(p.partitions[0].shadow_clip_from_world * DMat4::from_translation(origin)))
}

/// Random receivers lie inside the border; whatever box a ray from them to the light meets shares x and y, lies in [0, 1] and
/// before them.
fn assert_pairs(what: &str, v: &View, r: &Receivers, local: &Rows, p: &Parameterization) {
    let mut random = Random(11);
    let [intersection, published] = ["intersection", "published"].map(|word| ("fit", Value::Choice(word.into())));
    if p.settings.contains(&published) {
        // Loses casters and is offered as that; tests/xpsm.rs shows it.
        return;
    }
    let inset = f64::from(p.resolution - 2 * p.border_texels) / f64::from(p.resolution);
    let nearest = r.view.spot().map(|spot| spot.depth() - glam::DVec4::W * spot.frustum.near);
    for _ in 0..100 {
        let b = &r.boxes[random.below(r.boxes.len())];
        let q = Receivers::random_in(&mut random, b);
        if !r.counts(q) {
            continue;
        }
        let project = |q: DVec3| p.partitions[0].post_warp.apply(local.project(q), local.w.dot(q.extend(1.0)));
        let ndc = project(q);
        let across = ndc.truncate().abs().max_element();
        let inside = local.w.dot(q.extend(1.0)) > 0.0 && across <= inset + TOLERANCE;
        let inside = inside && (-TOLERANCE..=1.0 + TOLERANCE).contains(&ndc.z);
        // This fit leaves out receivers that nothing casts on.
        assert!(inside || p.settings.contains(&intersection), "{what}: receiver {q} at {ndc}");
        let to_light = match v.light {
            Light::Directional(l) => -l.direction(),
            Light::Spot(l) => l.position() - r.view.origin - q,
            Light::Point(l) => l.position() - r.view.origin - q,
        };
        let all = r.boxes.len() <= 64;
        for i in 0..if all { r.boxes.len() } else { 16 } {
            let other = if all { i } else { random.below(r.boxes.len()) };
            let Some((near, far)) = r.through(other, q, to_light) else { continue };
            let far = if matches!(v.light, Light::Directional(_)) { far } else { far.min(1.0) };
            // The farthest point of every second box: nothing may be cut off there.
            let at = if i % 2 == 0 { far * (1.0 - 1e-9) } else { random.between(near, far) };
            let caster = q + to_light * at;
            let apart = (caster - q).length() > 1e-9 * r.view.scene_box.diagonal();
            let reached = nearest.is_none_or(|f| f.dot(caster.extend(1.0)) > 0.0);
            if !(apart && at > 0.0 && reached) {
                continue;
            }
            assert!(inside, "{what}: receiver {q} at {ndc} under {caster}");
            let image = project(caster);
            let w = local.w.dot(caster.extend(1.0));
            assert!(w > 0.0 && (image - ndc).truncate().abs().max_element() < TOLERANCE, "{what}: {image} over {ndc}");
            assert!(image.z >= -TOLERANCE && image.z < ndc.z + 1e-12, "{what}: caster {image} over {ndc}");
        }
    }
}

/// Techniques that cannot serve every view, and say so.
const PARTICULAR: [&str; 1] = ["log"];

/// A technique's maps of a view; nothing where it says that it does not serve the light, or this view.
fn maps(what: &str, t: &dyn Technique, v: &View) -> Option<Parameterization> {
    match t.parameterize(&v.scene, &v.camera, &v.light, RESOLUTION) {
        Err(Error::UnsupportedLight { .. }) if t.serves(&v.light).is_err() => None,
        Err(Error::UnsuitedView { technique, .. }) if PARTICULAR.contains(&&*technique) => None,
        other => Some(other.unwrap_or_else(|e| panic!("{what}: {e}"))),
    }
}

fn check(v: &View, made: &[(String, Box<dyn Technique>)]) {
    let r = Receivers::new(v);
    for (name, t) in made.iter().filter(|(_, t)| t.spec().lights.serves(&v.light)) {
        let what = format!("{} / {name}", v.name);
        let Some(p) = maps(&what, t.as_ref(), v) else { continue };
        assert_contract(&what, v, &r, &p);
        let again = t.parameterize(&v.scene, &v.camera, &v.light, RESOLUTION).expect("again");
        assert_eq!(p, again, "{what}: not the same twice");
    }
}

#[test]
fn every_technique_on_scenes_made_by_hand_under_awkward_lights() {
    let made = settings();
    for (name, scene, camera) in by_hand() {
        for (light_name, direction) in directions(&camera) {
            let light = directional(direction);
            check(&View { name: format!("{name} / {light_name}"), scene: scene.clone(), camera, light }, &made);
        }
        for (light_name, light) in spots(&scene, &camera) {
            check(&View { name: format!("{name} / spot {light_name}"), scene: scene.clone(), camera, light }, &made);
        }
    }
}

#[test]
fn every_technique_on_the_library_scenes() {
    let made = settings();
    for v in from_library() {
        check(&v, &made);
        // The whole list of lights with the defaults.
        let defaults = made.iter().filter(|(name, _)| name.ends_with("()"));
        let made: Vec<(String, Box<dyn Technique>)> =
            defaults.map(|(n, t)| (n.clone(), technique(t.spec().name, &[]).expect("made"))).collect();
        let lights = directions(&v.camera).into_iter().map(|(n, d)| (n, directional(d)));
        for (light_name, light) in lights.chain(spots(&v.scene, &v.camera)) {
            let name = format!("{} / {light_name}", v.name);
            check(&View { name, scene: v.scene.clone(), camera: v.camera, light }, &made);
        }
    }
}

#[test]
fn the_check_of_pairs_sees_a_map_that_loses_casters() {
    let (name, scene, camera) = by_hand().into_iter().find(|s| s.0 == "town").expect("the town");
    let v = View { name: name.to_string(), scene, camera, light: directional(DVec3::new(0.4, -1.0, -0.3)) };
    let good = with_params("lispsm", &[]).parameterize(&v.scene, &v.camera, &v.light, RESOLUTION).expect("a map");
    let r = Receivers::new(&v);
    let spoiled = |low: DVec3, high: DVec3| {
        let mut p = good.clone();
        let m = &mut p.partitions[0].shadow_clip_from_world;
        *m = Rows::of(m).cropped(low, high).matrix();
        std::panic::catch_unwind(|| assert_contract("spoiled", &v, &r, &p)).is_err()
    };
    let unit = (DVec3::new(-1.0, -1.0, 0.0), DVec3::ONE);
    assert!(!spoiled(unit.0, unit.1));
    assert!(spoiled(unit.0 * 0.5, unit.1), "too narrow");
    assert!(spoiled(DVec3::new(-1.0, -1.0, 0.3), unit.1), "near plane too far");
    assert!(spoiled(unit.0, DVec3::new(1.0, 1.0, 0.8)), "far plane too near");
    assert!(spoiled(unit.0, DVec3::new(-1.0, 1.0, 1.0) * DVec3::new(-1.0, -1.0, 1.0)), "upside down");
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

/// A technique with its lengths in the units of a world scaled by `scale`.
fn scaled(t: &dyn Technique, scale: f64) -> Box<dyn Technique> {
    let params = t.spec().params.iter().zip(t.settings());
    let params: Vec<(String, Value)> = params
        .map(|(p, (name, value))| match value {
            // The largest number means no limit at any scale.
            Value::Number(x) if p.unit == "world units" => (name.to_string(), Value::Number((x * scale).min(f64::MAX))),
            Value::Number(x) if p.unit == "per world unit" => {
                (name.to_string(), Value::Number((x / scale).min(f64::MAX)))
            }
            other => (name.to_string(), other),
        })
        .collect();
    technique(t.spec().name, &params).expect("made")
}

/// Corners of K are cuts of three planes, and the crop divides by their extents: a rounding of the input grows by this much
/// before the map's own steepness. Measured: 16 at most.
const CONDITION: f64 = 32.0;

#[test]
fn the_same_map_at_every_scale_and_far_from_the_origin() {
    let made = settings();
    let utm = DVec3::new(455_000.0, 5_411_000.0, -1_200.0);
    // A stable map's radius is rounded to a part of a power of two: those scales keep it.
    let powers = [(-20.0_f64).exp2(), 30.0_f64.exp2()];
    let plain = [(1e-6, DVec3::ZERO), (1e9, DVec3::ZERO), (1.0, utm), (1e-6, utm * 1e-6), (1e9, utm * 1e9)];
    let lattice = powers.iter().flat_map(|&s| [(s, DVec3::ZERO), (s, utm * s)]).chain([(1.0, utm)]);
    let lattice: Vec<_> = lattice.collect();
    let (mut compared, mut vague) = (BTreeSet::new(), BTreeSet::new());
    for (name, scene, camera) in by_hand().into_iter().filter(|s| ["cube", "town", "floor"].contains(&s.0)) {
        let mut lights = spots(&scene, &camera);
        lights.truncate(1);
        lights.push(("slanted".into(), directional(DVec3::new(0.4, -1.0, -0.3))));
        for (light_name, light) in lights {
            let v = View { name: format!("{name} / {light_name}"), scene: scene.clone(), camera, light };
            let r = Receivers::new(&v);
            for (setting, t) in made.iter().filter(|(_, t)| t.spec().lights.serves(&v.light)) {
                let stable = t.settings().contains(&("stable", Value::Flag(true)));
                let snapped = stable && matches!(light, Light::Directional(_));
                let Some(a) = maps(setting, t.as_ref(), &v) else { continue };
                for &(scale, offset) in if snapped { &lattice[..] } else { &plain[..] } {
                    let other = moved(&v, scale, offset);
                    let what = format!("{} / {setting}", other.name);
                    let t = scaled(t.as_ref(), scale);
                    let b = t.parameterize(&other.scene, &other.camera, &other.light, RESOLUTION).expect("a map");
                    let (one, two) = (&a.partitions[0], &b.partitions[0]);
                    // The rounding of the moved scene's coordinates, and what the map makes of it.
                    let size = v.scene.bounds().corners().iter().fold(r.view.origin.length(), |m, q| m.max(q.length()));
                    let rounding = f64::EPSILON * (size + offset.length() / scale);
                    let local = local_rows(&a, r.view.origin);
                    let steepness = |q: DVec3| {
                        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
                        axes.iter().map(|d| local.derivative(q, *d).length()).fold(0.0, f64::max)
                    };
                    let steepest = r.view.receivers.vertices().iter().map(|q| steepness(*q)).fold(0.0, f64::max);
                    let tolerance = CONDITION * rounding * steepest;
                    if tolerance >= 0.01 {
                        vague.insert(setting.as_str());
                        continue;
                    }
                    let shift = if snapped {
                        let texels = (two.project(offset).0 - one.project(DVec3::ZERO).0) * 0.5 * f64::from(RESOLUTION);
                        assert!(texels.truncate().abs().max_element() < 1.0, "{what}: {texels} texels");
                        (texels * 2.0 / f64::from(RESOLUTION)).truncate().extend(0.0)
                    } else {
                        DVec3::ZERO
                    };
                    let mut random = Random(5);
                    for _ in 0..200 {
                        let part = &r.boxes[random.below(r.boxes.len())];
                        let q = Receivers::random_in(&mut random, part);
                        if !r.counts(q) {
                            continue;
                        }
                        let q = q + r.view.origin;
                        let (one, two) = (one.project(q).0 + shift, two.project(q * scale + offset).0);
                        let d = (one - two).length();
                        assert!(d < tolerance, "{what}: {one} and {two}, {tolerance:e}");
                        compared.insert(setting.as_str());
                    }
                }
            }
        }
    }
    let all: BTreeSet<&str> = made.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(compared, all);
    // The strongest warps: at their near end a rounding of the scene may be a texel, in some scenes; all are compared in
    // others.
    let strongest = ["gmnpr(lambda=0)", "lispsm(near=0)", "lispsm(near=0.001)", "lispsm(near_factor=0.000001)"];
    assert_eq!(vague.into_iter().collect::<Vec<_>>(), strongest);
}

#[test]
fn a_warp_from_far_away_is_no_warp() {
    let uniform = with_params("uniform", &[]);
    let warped = with_params("lispsm", &[("near", Value::Number(1e12))]);
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
    let t = with_params("lispsm", &[]);
    let note = |light: Light, camera: &Camera| t.parameterize(&scene, camera, &light, RESOLUTION).expect("a map").notes;
    assert!(note(directional(camera.forward()), &camera)[0].contains("no warp"));
    assert!(note(directional(DVec3::new(0.4, -1.0, -0.3)), &camera).is_empty());
    let away = views::look(camera.eye(), camera.eye() - camera.forward(), 0.9, 0.1, 100.0);
    assert!(note(directional(DVec3::NEG_Y), &away)[0].contains("sees no part of the scene"));
}

#[test]
fn a_spot_inside_a_box_says_what_it_cannot_see() {
    let (_, scene, camera) = by_hand().into_iter().find(|s| s.0 == "cube").expect("the cube");
    for (light_name, light) in spots(&scene, &camera) {
        for name in ["uniform", "lispsm"] {
            let p = with_params(name, &[]).parameterize(&scene, &camera, &light, RESOLUTION).expect("a map");
            let told = p.notes.iter().filter(|note| note.contains("inside a mesh's box")).count();
            assert_eq!(told, usize::from(light_name == "inside"), "{name} {light_name}: {:?}", p.notes);
        }
    }
}

#[test]
fn fitting_to_the_scene_never_costs_texels() {
    let light = directional(DVec3::new(0.4, -1.0, -0.3));
    for (name, scene, camera) in by_hand() {
        let texel = |focus: &str| {
            let t = with_params("uniform", &[("focus", Value::Choice(focus.into()))]);
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
    let point = Light::Point(shadowlab::scene::PointLight::new(DVec3::Y * 9.0, 50.0).expect("a light"));
    for (name, t) in settings() {
        match t.parameterize(&scene, &camera, &point, RESOLUTION) {
            Ok(p) => assert!(t.spec().lights.point && p.partitions.len() >= 6, "{name}"),
            Err(error) => assert!(!t.spec().lights.point && matches!(error, Error::UnsupportedLight { .. }), "{name}"),
        }
        for resolution in [0, 1, 2] {
            let error = t.parameterize(&scene, &camera, &directional(DVec3::NEG_Y), resolution).unwrap_err();
            assert!(matches!(error, Error::InvalidArgument { .. }), "{name}: {error}");
        }
        t.parameterize(&scene, &camera, &directional(DVec3::NEG_Y), 3).expect("one texel");
    }
}

#[test]
fn a_stable_map_moves_in_whole_texels_and_keeps_its_texel_size() {
    let (_, scene, _) = by_hand().into_iter().find(|s| s.0 == "town").expect("the town");
    let t = with_params("uniform", &[("stable", Value::Flag(true))]);
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
        let p = with_params(name, &[]).parameterize(&scene, &camera, &directional(DVec3::NEG_Y), 64).expect("a map");
        let (low, _) = p.partitions[0].project(DVec3::ZERO);
        let (high, _) = p.partitions[0].project(DVec3::new(0.0, 400.5, 0.0));
        assert!((0.0..0.1).contains(&high.z) && high.z < low.z && low.z <= 1.0, "{name}: {high} {low}");
    }
}
