//! What samples are to all warps: what is missing is said, old words still work, and a map holds them with its margin.

use glam::{DMat3, DVec3};
use shadowlab::focus::{Picture, Samples};
use shadowlab::parameterization::Region;
use shadowlab::scene::{DirectionalLight, Light, SpotLight};
use shadowlab::techniques::{Make, Needs, RENAMED, TECHNIQUES, Value, technique, technique_of};
use shadowlab::{Error, Parameterization};

use crate::support::settings::BY_SAMPLES;
use crate::support::views::{Random, View, cube, look, picture_of, placed, samples_of, shaded_samples, square};

const RESOLUTION: u32 = 512;

/// Of NDC through matrices whose w spans a few hundred.
const EXACT: f64 = 1e-9;

/// Boxes on a floor.
fn yard() -> View {
    let mut random = Random(4);
    let mut parts = vec![(square(), DMat3::from_diagonal(DVec3::new(40.0, 1.0, 40.0)), DVec3::ZERO)];
    for _ in 0..20 {
        let at = DVec3::new(random.between(-12.0, 12.0), 1.0, random.between(-12.0, 12.0));
        parts.push((cube(), DMat3::from_rotation_y(random.between(0.0, 3.0)), at));
    }
    let camera = look(DVec3::new(3.0, 5.0, 16.0), DVec3::ZERO, 0.9, 0.1, 100.0);
    View { name: "yard".into(), scene: placed(&parts), camera, light: sun(DVec3::new(0.5, -1.0, -0.3)) }
}

fn sun(along: DVec3) -> Light {
    Light::Directional(DirectionalLight::new(along).expect("a light"))
}

fn lamp() -> Light {
    Light::Spot(SpotLight::new(DVec3::new(2.0, 14.0, 3.0), DVec3::new(-0.1, -1.0, -0.2), 1.2, 60.0).expect("a lamp"))
}

/// A technique by name and words.
fn with(name: &str, words: &[(&str, &str)]) -> Box<dyn shadowlab::techniques::Technique> {
    let params: Vec<_> = words.iter().map(|(n, w)| (n.to_string(), Value::Choice(w.to_string()))).collect();
    technique(name, &params).unwrap_or_else(|e| panic!("{name} {words:?}: {e}"))
}

#[test]
fn what_a_technique_needs_follows_from_what_places_it_and_what_its_map_holds() {
    for entry in TECHNIQUES.iter().filter(|entry| matches!(entry.make, Make::Warp(_))) {
        let name = entry.spec.name;
        if BY_SAMPLES.contains(&name) {
            let of = |fit: &str| with(name, &[("range", "body"), ("fit", fit)]).needs();
            assert_eq!([of("seen"), of("shadow")], [Needs::Shadows; 2]);
            continue;
        }
        let formula: &[(&str, &str)] = if name == "lispsm" { &[("near", "basic")] } else { &[] };
        for (range, fit, needs) in [
            ("body", "exact", Needs::Nothing),
            ("seen", "exact", Needs::Surfaces),
            ("body", "seen", Needs::Surfaces),
            ("body", "shadow", Needs::Shadows),
            ("seen", "shadow", Needs::Shadows),
        ] {
            let own = if name == "plane_optimal" { Needs::Surfaces } else { Needs::Nothing };
            let t = with(name, &[formula, &[("range", range), ("fit", fit)]].concat());
            assert_eq!(t.needs(), needs.max(own), "{name} {range} {fit}");
        }
    }
    let body = [("range", "body"), ("fit", "exact"), ("near", "optimal")];
    for (over, norm, needs) in [
        ("body", "linf", Needs::Nothing),
        ("seen", "linf", Needs::Surfaces),
        ("seen", "auto", Needs::Shadows),
        ("seen", "flips", Needs::Shadows),
    ] {
        assert_eq!(with("lispsm", &[&body[..], &[("over", over), ("norm", norm)]].concat()).needs(), needs);
    }
    assert_eq!(technique_of("uniform:stable=true,range=seen,fit=shadow").expect("one").needs(), Needs::Nothing);
    assert_eq!(technique_of("z_partition:inner=lispsm").expect("one").needs(), Needs::Shadows);
    assert_eq!(technique_of("z_partition:range=seen").expect("one").needs(), Needs::Surfaces);
}

#[test]
fn missing_samples_shadows_and_those_of_another_light_are_errors_that_say_what_to_do() {
    let v = yard();
    let picture = picture_of(&v.scene, &v.camera);
    let bare = samples_of(&v.scene, &v.camera);
    let other = shaded_samples(&v.scene, &v.camera, &sun(DVec3::new(-0.5, -1.0, 0.3)), &picture);
    let own = v.samples();
    let try_map = |text: &str, samples: Option<&Samples>| {
        technique_of(text).expect(text).parameterize_seen(&v.scene, &v.camera, &v.light, [RESOLUTION; 2], samples)
    };
    for text in ["lispsm", "tsm", "uniform:fit=shadow", "z_partition:count=2,inner=lispsm", "face_partition"] {
        let refusal = |samples: Option<&Samples>| match try_map(text, samples) {
            Err(Error::InvalidArgument { name, got, fix, .. }) if name == "samples" => format!("{got}; {fix}"),
            answer => panic!("{text}: {answer:?}"),
        };
        let missing = refusal(None);
        assert!(missing.contains("none") && missing.contains("range=body and fit=exact"), "{missing}");
        let stateless = refusal(Some(&bare));
        assert!(stateless.contains("without shadows") && stateless.contains("fit=seen"), "{stateless}");
        let foreign = refusal(Some(&other));
        assert!(foreign.contains("another light") && foreign.contains("this light"), "{foreign}");
        assert!(try_map(text, Some(&own)).is_ok(), "{text}");
    }
    // What needs surfaces alone takes all of them.
    for samples in [&bare, &other, &own] {
        assert!(try_map("tsm:fit=seen", Some(samples)).is_ok());
    }
    assert!(try_map("lispsm:near=delta-z,range=body,fit=exact", None).is_ok());
}

#[test]
fn words_of_earlier_versions_are_todays() {
    for old in RENAMED {
        let [was, is] = old.words.map(|word| with(old.technique, &[(old.param, word)]));
        assert_eq!(was.settings(), is.settings(), "{old:?}");
        assert!(was.settings().contains(&(old.param, Value::Choice(old.words[1].into()))), "{old:?}");
        // Those of the spec are the new ones alone.
        let spec = TECHNIQUES.iter().find(|entry| entry.spec.name == old.technique).expect("a technique").spec;
        let kind = spec.params.iter().find(|p| p.name == old.param).expect("a parameter").kind.to_string();
        assert!(kind.contains(old.words[1]) && !kind.contains(old.words[0]), "{kind}");
    }
    let error = technique_of("lispsm:range=receivers").unwrap_err();
    assert!(matches!(&error, Error::InvalidArgument { name, .. } if name == "range"), "{error}");
}

/// The largest NDC x or y of the corners of all pixels of samples that a map must hold.
fn reach(p: &Parameterization, v: &View, samples: &Samples, shaded: bool) -> [f64; 4] {
    let picture: Picture = samples.picture.expect("a picture");
    let eye = v.camera.eye();
    let shadows = samples.shadows.as_ref().expect("states");
    let held: Vec<(DVec3, DVec3)> = if shaded {
        shadows.shaded.iter().map(|&i| samples.sample(i as usize)).collect()
    } else {
        samples.lit(&v.camera, &v.light, &Region::ALL).collect()
    };
    let in_pyramid = |q: DVec3| match v.light {
        Light::Spot(l) => {
            let frame = shadowlab::rays::LightFrame::any(l.direction());
            let p = q - l.position();
            let most = p.dot(frame.along) * (0.5 * l.cone_angle()).tan();
            p.dot(frame.right).abs().max(p.dot(frame.up).abs()) <= most
        }
        _ => true,
    };
    let corners = held.iter().flat_map(|(p, n)| picture.corners(*p - eye, *n)).map(|c| c + eye);
    let images = corners.filter(|q| in_pyramid(*q)).map(|q| p.partitions[0].project(q).0);
    images.fold([0.0; 4], |[a, b, c, d], q: DVec3| [a.min(q.x), b.max(q.x), c.min(q.y), d.max(q.y)])
}

#[test]
fn a_map_holds_the_corners_of_its_samples_pixels_and_a_margin() {
    let warps: Vec<&str> =
        TECHNIQUES.iter().filter(|e| matches!(e.make, Make::Warp(_))).map(|entry| entry.spec.name).collect();
    let (mut maps, mut reached) = (0, 0);
    for light in [yard().light, lamp()] {
        let v = View { light, ..yard() };
        let samples = v.samples();
        for name in
            warps.iter().filter(|name| TECHNIQUES.iter().any(|e| e.spec.name == **name && e.spec.lights.serves(&light)))
        {
            for (fit, margin) in [("shadow", 0.0), ("shadow", 1.0), ("shadow", 20.0), ("seen", 3.0), ("seen", 127.5)] {
                let params = [("fit", Value::Choice(fit.into())), ("margin", Value::Number(margin))];
                let params: Vec<_> = params.map(|(n, value)| (n.to_string(), value)).into();
                let t = technique(name, &params).expect("a technique");
                let what = format!("{name} {fit} {margin} {}", light.kind());
                let p = match t.parameterize_seen(&v.scene, &v.camera, &v.light, [RESOLUTION; 2], Some(&samples)) {
                    Ok(p) => p,
                    Err(Error::UnsuitedView { .. }) => continue,
                    Err(error) => panic!("{what}: {error}"),
                };
                // The border's texel, and the margin's.
                let inset = 1.0 - 2.0 * (1.0 + margin) / f64::from(RESOLUTION);
                let [x0, x1, y0, y1] = reach(&p, &v, &samples, fit == "shadow");
                let ends = [-x0, x1, -y0, y1];
                assert!(ends.iter().all(|x| *x <= inset + EXACT), "{what}: {ends:?} and {inset}");
                // No more room than that: of a lamp the pyramid's own sides may be what the map is cut to.
                let all = ends.iter().all(|x| (x - inset).abs() < EXACT);
                assert!(all || matches!(light, Light::Spot(_)), "{what}: {ends:?} and {inset}");
                reached += usize::from(all);
                maps += 1;
            }
        }
    }
    println!("{maps} maps, {reached} to the last digit");
    assert!(maps > 60, "{maps}");
}

#[test]
fn margins_that_leave_no_map_are_refused() {
    let v = yard();
    let samples = v.samples();
    let made = |margin: f64, resolution: u32| {
        let params = vec![("margin".to_string(), Value::Number(margin))];
        technique("lispsm", &params)?.parameterize_seen(&v.scene, &v.camera, &v.light, [resolution; 2], Some(&samples))
    };
    // A quarter of the texels between the borders.
    assert!(made(127.5, 512).is_ok() && made(1.0, 6).is_ok() && made(0.0, 3).is_ok());
    for (margin, resolution) in [(-1.0, 512), (f64::NAN, 512), (127.6, 512), (1.0, 5), (1e6, 16384)] {
        let error = made(margin, resolution).unwrap_err();
        assert!(matches!(&error, Error::InvalidArgument { name, .. } if name == "margin"), "{margin}: {error}");
    }
    // Without samples a map has no margin.
    let body = technique_of("lispsm:near=delta-z,range=body,fit=exact,margin=127.6").expect("a technique");
    assert!(body.parameterize(&v.scene, &v.camera, &v.light, 512).is_ok());
}
