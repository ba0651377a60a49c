//! The family of warps along the view under a directional light: TSM, GMNPR and GLPR beside LiSPSM, PSM and XPSM. They differ
//! in where the reference point lies alone, so their tables, closed forms and each other are their oracles (theory.md 4 to 8).

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec2, DVec3};
use shadowlab::note::{Detail, Kind};
use shadowlab::techniques::Value;
use shadowlab::techniques::kit::WarpSpace;

use super::tsm::trapezoid;
use crate::support::setup::{
    EXACT, Params, Random, Setup, Values, apart, around, close, difference, oblique, random_setups, set, turned, word,
};
use crate::support::tables::{self, camera, matrix, number, tables};

/// Of the tables: bodies that came from a joggled hull are good to this (theory.md 17).
const JOGGLED: f64 = 1e-6;

fn table_matrix(t: &serde_json::Value, name: &str, params: &[(&str, Value)], tolerance: f64) -> Values {
    let s = Setup::of_tables(t);
    let (rows, values) = s.cropped(name, params);
    let d = difference(&rows.moved_to_world(s.view.origin).matrix(), &matrix(&t["matrices"][name]["M"]));
    assert!(d < tolerance, "{name}: {d:e}");
    values
}

#[test]
fn the_matrices_of_the_tables_and_their_intermediates() {
    let t = tables();
    let m = &t["matrices"];
    let gmnpr = table_matrix(&t, "gmnpr", &[], JOGGLED);
    let glpr = table_matrix(&t, "glpr", &[], JOGGLED);
    for (name, values) in [("gmnpr", &gmnpr), ("glpr", &glpr)] {
        close(name, values.get("warp_distance"), number(&m[name]["Pn"]), EXACT);
        close(name, values.get("lambda"), number(&m[name]["lam"]), EXACT);
        close(name, values.get("kappa"), number(&m["inputs"]["kappa"]), EXACT);
    }
    let table = &m["tsm"];
    let params = [set("focus_depth", number(&table["focus_depth"])), set("share", 0.5 * (1.0 + number(&table["xi"])))];
    let tsm = table_matrix(&t, "tsm", &params, JOGGLED);
    for (name, key) in
        [("eta", "eta"), ("depth", "lam"), ("delta", "delta"), ("xi", "xi"), ("focus_depth", "focus_depth")]
    {
        close(name, tsm.get(name), number(&table[key]), 100.0 * EXACT);
    }
    let corners = trapezoid::trapezoid(&Setup::of_tables(&t), tsm.get("eta"));
    for (ours, expected) in corners.iter().zip(table["trapezoid"].as_array().expect("corners")) {
        assert!((*ours - DVec2::new(number(&expected[0]), number(&expected[1]))).length() < JOGGLED * 100.0);
    }
    close("top", tsm.get("top_width"), corners[2].x - corners[3].x, EXACT);
    close("base", tsm.get("base_width"), corners[1].x - corners[0].x, EXACT);
    let area = (corners[2] - corners[0]).perp_dot(corners[3] - corners[1]).abs() * 0.5;
    close("area", tsm.get("trapezoid_area"), area, EXACT);
}

#[test]
fn obtuse_angles_mirror_acute_ones() {
    let c = oblique();
    for name in ["gmnpr", "glpr", "tsm"] {
        for degrees in [2.0, 17.0, 28.0, 60.0, 89.0_f64] {
            // The opposite light has the same rays.
            let along = turned(&c, degrees.to_radians(), 0.3);
            let [one, two] = [along, -along].map(|l| Setup::new(around(), c, l));
            let [a, b] = [&one, &two].map(|s| Values(s.provisional(name, &[]).values));
            for value in ["warp_distance", "theta", "kappa"] {
                close(&format!("{name} {degrees} {value}"), b.get(value), a.get(value), EXACT);
            }
            let (a, b) = (one.cropped(name, &[]).0, two.cropped(name, &[]).0);
            for p in one.view.receivers.vertices() {
                let (a, b) = (a.project(*p), b.project(*p));
                // Seen from the other side: x turns, y stays.
                assert!((a.y - b.y).abs() < EXACT && (a.x + b.x).abs() < EXACT, "{name} {degrees}: {a} and {b}");
            }
        }
    }
}

#[test]
fn under_an_overhead_light_glpr_is_psm_and_gmnpr_is_psm_slid_back_and_lispsm() {
    let c = oblique();
    // Any frustum, and what a floor and a wall leave of it: at 90 degrees the near end of a body that the near plane cuts is
    // the near plane's.
    let scenes = [around(), tables::box_scene(DVec3::new(-300.0, -4.0, -300.0), DVec3::new(300.0, 5.0, 300.0))];
    let mut compared = 0;
    for scene in scenes {
        for azimuth in [0.0, 0.5, 1.5, 3.0] {
            let s = Setup::new(scene.clone(), c, turned(&c, FRAC_PI_2, azimuth));
            let [n, f] = s.view.eye_depth;
            let of = |name: &str, params: &[(&str, Value)]| s.cropped(name, params).0;
            let (glpr, gmnpr) = (of("glpr", &[]), of("gmnpr", &[]));
            let pairs = [
                ("glpr, psm", &glpr, of("psm", &[set("slide", 0.0)])),
                ("gmnpr, psm slid back", &gmnpr, of("psm", &[set("slide", (n * f).sqrt())])),
                ("gmnpr, lispsm", &gmnpr, of("lispsm", &[word("near", "basic")])),
                ("glpr, lispsm at the eye", &glpr, of("lispsm", &[set("near", n)])),
            ];
            for (what, a, b) in pairs {
                let d = apart(&s, a, &b);
                assert!(d < 1e-8, "{what} {azimuth}: {d:e}");
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 2 * 4 * 4);
}

/// The largest distance in x and y between a technique's cropped map and the uniform one, over the corners of the receivers.
fn from_uniform(s: &Setup, name: &str, params: &[(&str, Value)]) -> f64 {
    apart(s, &s.cropped(name, params).0, &s.cropped("uniform", &[]).0)
}

#[test]
fn maps_go_to_the_uniform_one_as_the_light_turns_along_the_view() {
    // Measured over the corners of K; over the whole of it the maps are monotone in each other along every line.
    let c = oblique();
    let scenes = [around(), tables::box_scene(DVec3::new(-20.0, -9.0, -50.0), DVec3::new(40.0, 3.0, -4.0))];
    for scene in scenes {
        for (name, params) in [
            ("gmnpr", vec![]),
            ("gmnpr", vec![word("body", "frustum")]),
            ("glpr", vec![]),
            ("lispsm", vec![]),
            ("lispsm", vec![word("near", "basic")]),
        ] {
            for azimuth in [0.0, 1.0, 3.0] {
                let at = |theta: f64| {
                    let s = Setup::new(scene.clone(), c, turned(&c, theta, azimuth));
                    from_uniform(&s, name, &params)
                };
                let differences: Vec<f64> = (0..14).map(|i| at(0.2 * 0.5_f64.powi(i))).collect();
                // Each halving of the angle brings it nearer; in the end in proportion, as lambda is one over the angle.
                assert!(differences.windows(2).all(|d| d[1] < d[0]), "{name} {params:?}: {differences:?}");
                let [.., a, b] = differences[..] else { panic!("two") };
                assert!((1.8..2.2).contains(&(a / b)), "{name} {params:?} {azimuth}: {differences:?}");
                // Beyond the least sine the map is the uniform one.
                assert!(at(0.0) < EXACT && at(1e-7) < EXACT && at(PI) < EXACT, "{name}");
            }
        }
    }
}

#[test]
fn every_warp_goes_to_the_uniform_map_as_its_distance_goes_to_infinity() {
    // Each in its own unit: a length, a factor of a formula, a share of the body, one of n/f, the inverse of a length.
    let units = |s: &Setup| {
        let extent = s.view.receivers.aabb().diagonal();
        let kappa = s.camera.forward().cross(s.along).length();
        [extent, 1.0, 1.0, s.view.eye_depth[1] / s.view.eye_depth[0], extent / kappa, extent]
    };
    type Strength = fn(f64) -> Params;
    let strengths: [(&str, Strength); 6] = [
        ("lispsm", |x| vec![set("near", x)]),
        ("lispsm", |x| vec![set("near_factor", x)]),
        ("gmnpr", |x| vec![set("lambda", x)]),
        ("glpr", |x| vec![set("lambda_floor", x)]),
        ("xpsm", |x| vec![set("coefficient", x.recip()), set("min_sin", 0.0)]),
        ("psm", |x| vec![set("slide", x)]),
    ];
    let mut compared = 0;
    for s in random_setups(200) {
        for ((name, params), unit) in strengths.iter().zip(units(&s)) {
            let [weak, none] = [1e5, 1e8].map(|x| from_uniform(&s, name, &params(x * unit)));
            // A thousand times as far, a thousand times nearer, once the distance is large beside the body.
            assert!(none < 2e-3 * weak + EXACT && none < 1e-4, "{name}: {weak:e} to {none:e}");
            compared += 1;
        }
        // The trapezoid's distance is infinite where the focus has its share anyway.
        let focus = s.view.eye_depth[1] * 1e3;
        assert!(from_uniform(&s, "tsm", &[set("focus_depth", focus)]) < EXACT);
    }
    assert_eq!(compared, 200 * 6);
}

#[test]
fn xpsm_is_the_reference_point_behind_the_eye() {
    let mut compared = 0;
    let mut random = Random(3);
    for s in random_setups(200) {
        let coefficient = 10.0_f64.powf(random.between(-3.0, 1.0));
        let (xpsm, values) = s.cropped("xpsm", &[set("coefficient", coefficient), set("min_sin", 0.0)]);
        let Some(&(_, p)) = values.0.iter().find(|v| v.0 == "p") else { continue };
        let along = WarpSpace::directional(&s.view, s.along, s.camera.forward()).expect("a warp");
        let y_min = along.y[0] - along.rows.y.dot(s.view.eye.extend(1.0));
        let (lispsm, _) = s.cropped("lispsm", &[set("near", 1.0 / p + y_min)]);
        let d = apart(&s, &xpsm, &lispsm);
        assert!(d < 1e-8, "{d:e} at p {p}");
        // Its own matrix: w = 1 + p Y.
        let q = s.view.receivers.vertex_mean();
        let y = along.rows.y.dot((q - s.view.eye).extend(0.0));
        let w = |point: DVec3| xpsm.w.dot(point.extend(1.0));
        close("w", w(q) / w(s.view.eye), 1.0 + p * y, 1e-8);
        compared += 1;
    }
    assert!(compared > 150, "{compared}");
}

#[test]
fn what_cannot_be_warped_is_uniform_and_says_so() {
    let t = tables();
    let nothing = Setup::new(
        tables::box_scene(DVec3::splat(50.0), DVec3::splat(60.0)),
        camera(&t["theta_config"]["camera"]),
        DVec3::NEG_Y,
    );
    for name in ["tsm", "gmnpr", "glpr"] {
        for along in [DVec3::NEG_Z, DVec3::Z] {
            let s = Setup::whole_frustum(&t, along);
            let p = s.provisional(name, &[]);
            assert!(p.notes.len() == 1 && p.notes[0].details() == [Detail::LightAlongAxis], "{name}: {:?}", p.notes);
            assert_eq!(Values(p.values).get("kappa"), 0.0);
            assert!(from_uniform(&s, name, &[]) < EXACT);
        }
        let p = nothing.provisional(name, &[]);
        assert!(p.values.is_empty() && p.notes.is_empty(), "{name}: {:?} {:?}", p.values, p.notes);
    }
    let s = Setup::whole_frustum(&t, DVec3::NEG_Y);
    for (focus, why) in [(0.5, Detail::FocusBeforeBody), (95.0, Detail::FocusHasShare)] {
        let p = s.provisional("tsm", &[set("focus_depth", focus)]);
        assert!(p.notes.iter().any(|note| note.details() == [why]), "{focus}: {:?}", p.notes);
    }
    let p = s.provisional("gmnpr", &[set("lambda", 0.0)]);
    assert!(p.notes.iter().any(|note| note.kind() == Kind::WarpDistanceRaised), "{:?}", p.notes);
}
