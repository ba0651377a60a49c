//! Plane-optimal maps on a given plane: the tables, texels that are pixels, and views that cannot be served.

use glam::{DMat2, DVec2, DVec3};
use shadowlab::Error;
use shadowlab::focus::Samples;
use shadowlab::geometry::Rows;
use shadowlab::note::Kind;
use shadowlab::rays::LightRays;
use shadowlab::scene::{Camera, Light, PointLight, SpotLight};

use crate::support::published_view::{EXACT, View, difference};
use crate::support::tables::{box_scene, matrix, number, points, sun, tables};

const GROUND: &str = "plane_optimal:plane=(0,1,0,1)";

/// A slab of ground, seen from above it, that light from any of these reaches everywhere: 60 by 0.5 by 60, its top at y = -1.
fn slab(light: Light) -> View {
    let eye = DVec3::new(1.0, 2.0, 8.0);
    let camera = Camera::look_at(eye, DVec3::new(-2.0, -1.0, -10.0), DVec3::Y, 0.8, 1.5, 0.5, 60.0).expect("a camera");
    View { scene: box_scene(DVec3::new(-30.0, -1.5, -30.0), DVec3::new(30.0, -1.0, 30.0)), camera, light }
}

fn lamp(position: DVec3) -> Light {
    let target = DVec3::new(-2.0, -1.0, -8.0);
    Light::Spot(SpotLight::new(position, target - position, 1.2, 100.0).expect("a spot"))
}

fn screen(v: &View) -> Rows {
    v.local(&v.camera.clip_from_world())
}

/// Points of the plane y = -1 that are seen and lit.
fn on_the_plane(v: &View) -> Vec<DVec3> {
    let view = v.focused();
    let all = (0..40).flat_map(|i| (0..40).map(move |k| DVec3::new(f64::from(i) - 20.0, -1.0, f64::from(k) - 30.0)));
    let local = all.map(|p| p - view.origin);
    let seen: Vec<DVec3> = local.filter(|p| view.receiver_planes().all(|plane| plane.distance(*p) <= 0.0)).collect();
    assert!(seen.len() > 30, "{}", seen.len());
    seen
}

#[test]
fn the_matrix_of_the_tables() {
    let t = tables();
    let v = View::of_tables(&t);
    let table = &t["matrices"]["plane_optimal"];
    assert_eq!(table["plane"].as_array().unwrap().iter().map(number).collect::<Vec<_>>(), [0.0, 1.0, 0.0, 1.0]);
    let theirs = v.local(&matrix(&table["M"]));
    let ours = v.rows(GROUND);
    // Rows x, y and w are the oracle; the depth row is a matter of the fit.
    let d = difference(&v.cropped(&ours), &v.cropped(&theirs), false);
    assert!(d < EXACT, "{d:e}");
    // Theirs is not cropped: on the plane its NDC are those of the screen, and ours those up to the crop.
    let origin = v.focused().origin;
    let camera = screen(&v);
    for (p, ndc) in points(&table["ground_points"]).iter().zip(points(&table["ground_ndc"])) {
        let p = *p - origin;
        assert!((theirs.project(p) - camera.project(p)).truncate().length() < EXACT);
        assert!((theirs.project(p) - ndc).truncate().length() < EXACT);
    }
    // Rows x, y and w leave open only a crop of each axis: the probes' NDC are one constant apart.
    let probes = points(&t["matrices"]["inputs"]["probes"]);
    let images: Vec<(DVec2, DVec2)> = probes
        .iter()
        .zip(points(&table["probes_ndc"]))
        .map(|(p, ndc)| (ours.project(*p - origin).truncate(), ndc.truncate()))
        .collect();
    assert_one_crop("probes", &images);
}

/// One scale and offset an axis takes all of the second to the first.
fn assert_one_crop(what: &str, images: &[(DVec2, DVec2)]) -> DVec2 {
    let far = images
        .iter()
        .fold(images[0], |f, i| if (i.1 - images[0].1).length() > (f.1 - images[0].1).length() { *i } else { f });
    let scale = (far.0 - images[0].0) / (far.1 - images[0].1);
    let offset = images[0].0 - scale * images[0].1;
    for (ours, theirs) in images {
        assert!((*ours - (scale * *theirs + offset)).length() < EXACT, "{what}: {ours} and {theirs}");
    }
    scale
}

#[test]
fn on_the_plane_texels_are_pixels_up_to_one_crop() {
    let over = [DVec3::new(0.4, -1.0, -0.3), DVec3::new(0.0, -1.0, 0.0), DVec3::new(-0.7, -1.0, 0.1)];
    // From below the plane viewer and light see its two sides: the map is mirrored.
    let lights = over.iter().flat_map(|l| [sun(*l), sun(*l * DVec3::new(1.0, -1.0, 1.0))]);
    let lamps = [DVec3::new(-4.0, 9.0, -2.0), DVec3::new(3.0, 25.0, -9.0), DVec3::new(-2.0, -30.0, -8.0)].map(lamp);
    for light in lights.chain(lamps) {
        let v = slab(light);
        let what = format!("{light:?}");
        let p = v.map(GROUND);
        let below = match light {
            Light::Directional(l) => l.direction().y > 0.0,
            Light::Spot(l) => l.position().y < -1.0,
            Light::Point(_) => unreachable!(),
        };
        assert_eq!(p.value("mirrored"), Some(f64::from(below)), "{what}");
        let (rows, camera) = (v.rows(GROUND), screen(&v));
        let seen = on_the_plane(&v);
        let images: Vec<(DVec2, DVec2)> =
            seen.iter().map(|p| (rows.project(*p).truncate(), camera.project(*p).truncate())).collect();
        let scale = assert_one_crop(&what, &images);
        assert!(scale.y > 0.0 && (scale.x < 0.0) == below, "{what}: {scale}");
        let rays = LightRays::new(&light, v.focused().origin);
        for p in &seen {
            // d(screen) / d(shadow) of two directions of the plane (E.5): the crop, the same everywhere.
            let j = camera.jacobian(*p, [DVec3::X, DVec3::Z]) * rows.jacobian(*p, [DVec3::X, DVec3::Z]).inverse();
            let crop = DMat2::from_diagonal(scale.recip());
            let apart = (j - crop).to_cols_array().iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            assert!(apart < 1e3 * EXACT, "{what}: {j} and {crop}");
            assert_eq!(rays.orientation(&rows, *p), 1.0, "{what}");
        }
    }
}

#[test]
fn a_normal_of_any_length_and_sign_is_the_same_plane() {
    let v = slab(sun(DVec3::new(0.4, -1.0, -0.3)));
    let one = v.rows(GROUND);
    for text in ["(0,-1,0,-1)", "(0,3e200,0,3e200)", "(0,1e-200,0,1e-200)"] {
        let other = v.rows(&format!("plane_optimal:plane={text}"));
        assert!(difference(&one, &other, true) < EXACT, "{text}");
    }
    // Far from the origin: the plane goes along with the scene.
    let offset = DVec3::new(4.55e5, 5.411e6, -1.2e3);
    let scene = v.scene.transformed(&glam::DAffine3::from_translation(offset)).unwrap();
    let (eye, c) = (v.camera.eye() + offset, v.camera);
    let camera = Camera::look_at(eye, eye + c.forward(), c.up(), c.fov_y(), c.aspect(), c.near(), c.far()).unwrap();
    let far = View { scene, camera, light: v.light };
    let rows = far.rows(&format!("plane_optimal:plane=(0,1,0,{})", 1.0 - offset.y));
    // 5e6 has 1e-9 of a unit, the map about one unit at its near end.
    assert!(difference(&one, &rows, true) < 100.0 * EXACT);
}

#[test]
fn planes_that_are_none_are_refused_when_they_are_given() {
    for text in ["(0,0,0,1)", "(1e-300,0,0,1e300)", "(0,1,0)", "(0,1,0,inf)", "flat"] {
        let error = shadowlab::techniques::technique_of(&format!("plane_optimal:plane={text}")).unwrap_err();
        assert!(matches!(&error, Error::InvalidArgument { name, .. } if name == "plane"), "{text}: {error}");
    }
}

/// What a view is refused for; with fallback=uniform it gets exactly the uniform map, and a note with the same reason.
fn refusal(v: &View, technique: &str, samples: Option<&Samples>) -> String {
    let Err(Error::UnsuitedView { technique: name, reason, .. }) = v.try_map(technique, samples) else {
        panic!("{technique} serves the view")
    };
    assert_eq!(name, "plane_optimal");
    let uniform = v.try_map(&format!("{technique},fallback=uniform"), samples).expect("a uniform map");
    assert_eq!(uniform.partitions[0].shadow_clip_from_world, v.map("uniform").partitions[0].shadow_clip_from_world);
    assert!(uniform.notes.iter().any(|note| note.reason() == reason), "{:?}", uniform.notes);
    reason
}

#[test]
fn lights_and_eyes_in_the_plane_are_refused() {
    for light in [sun(DVec3::new(1.0, 0.0, -0.4)), sun(DVec3::new(1.0, -1e-9, -0.4)), lamp(DVec3::new(9.0, -1.0, -8.0))]
    {
        assert_eq!(refusal(&slab(light), GROUND, None), "the light lies in the plane", "{light:?}");
    }
    let v = slab(sun(DVec3::new(0.4, -1.0, -0.3)));
    let reason = refusal(&v, "plane_optimal:plane=(0,1,0,-2)", None);
    assert!(reason.contains("the eye lies in the plane"), "{reason}");
}

#[test]
fn rays_that_meet_the_plane_behind_the_eye_are_refused_and_counted() {
    // Towers, with light from ahead: high up near the eye, rays go down to the ground behind it.
    let mut v = slab(sun(DVec3::new(0.0, -0.3, 1.0)));
    v.scene = box_scene(DVec3::new(-30.0, -1.5, -30.0), DVec3::new(30.0, 9.0, 30.0));
    let origin = v.focused().origin;
    // By hand: the depth of the ray's foot on y = -1, for the corners of K.
    let foot = |p: DVec3| p + DVec3::new(0.0, -0.3, 1.0) * ((p.y + 1.0) / 0.3);
    let corners: Vec<DVec3> = v.focused().receivers.vertices().iter().map(|p| *p + origin).collect();
    let lost = corners.iter().filter(|p| v.camera.depth_of(foot(**p)) <= 0.0).count();
    assert!(lost > 0 && lost < corners.len());
    let reason = refusal(&v, GROUND, None);
    assert!(reason.contains(&format!("{lost} of {} corners", corners.len())), "{reason}");
    assert!(!reason.contains("samples"), "{reason}");
    // Of what is seen: two on the ground are served, one high up near the eye is not.
    let points = [DVec3::new(0.0, -1.0, 0.0), DVec3::new(0.0, -1.0, -9.0), DVec3::new(0.8, 1.5, 6.0)];
    let samples = Samples::of_points(&points, &[DVec3::Y; 3]);
    let reason = refusal(&v, GROUND, Some(&samples));
    assert!(reason.contains("of 3 visible samples 1 are lost"), "{reason}");
}

#[test]
fn a_point_light_has_its_plane_where_the_light_reaches_it() {
    let v = slab(Light::Point(PointLight::new(DVec3::new(-2.0, 6.0, -6.0), 100.0).expect("a light")));
    let p = v.map(&format!("{GROUND},fallback=uniform"));
    assert_eq!(p.partitions.len(), 6);
    let planar = p.partitions.iter().filter(|map| map.value("mirrored").is_some()).count();
    assert!(planar >= 1, "{:?}", p.notes);
}

#[test]
fn nothing_seen_is_covered_all_the_same() {
    let mut v = slab(sun(DVec3::new(0.4, -1.0, -0.3)));
    v.scene = box_scene(DVec3::splat(100.0), DVec3::splat(110.0));
    assert!(v.map(GROUND).notes[0].kind() == Kind::NothingSeen);
}
