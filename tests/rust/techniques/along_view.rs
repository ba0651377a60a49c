//! The family of warps along the view under a directional light: TSM, GMNPR and GLPR beside LiSPSM, PSM and XPSM. They differ
//! in where the reference point lies alone, so their tables, closed forms and each other are their oracles (theory.md 4 to 8).

use std::f64::consts::{FRAC_PI_2, PI};

use super::tsm::trapezoid;
use crate::support::setup::{
    self, EXACT, Params, Random, Setup, Values, apart, around, at_angle, camera, close, difference, matrix, number,
    oblique, random_setups, set, tables, turned, word,
};
use glam::{DVec2, DVec3};
use shadowlab::note::{Detail, Kind};
use shadowlab::rays::LightFrame;
use shadowlab::scene::Camera;
use shadowlab::techniques::Value;
use shadowlab::techniques::kit::{LEAST_LAMBDA, WarpSpace};

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
fn eta_of_the_tables() {
    // Overhead, the whole frustum from n to f: λ = f - n, δ = focus - n.
    let t = tables();
    for row in t["tsm_eta"].as_array().expect("rows") {
        let [lambda, delta, xi] = ["lam", "delta", "xi"].map(|k| number(&row[k]));
        let camera =
            Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0, 1.0, 1.0, 1.0 + lambda).expect("a camera");
        let s = Setup::new(around(), camera, DVec3::NEG_Y);
        let p = s.provisional("tsm", &[set("focus_depth", 1.0 + delta), set("share", 0.5 * (1.0 + xi))]);
        let (eta, notes) = (Values(p.values).get("eta"), p.notes);
        match row["eta"].as_f64() {
            Some(expected) => {
                // λ(1 + ξ) - 2δ is a difference: 0.2 of 16 in the third row.
                close("eta", eta, expected, 100.0 * EXACT);
                assert!(notes.is_empty(), "{notes:?}");
            }
            // In f64 the room is 0 or a rounding error of it, either way.
            None => assert!(eta > 1e12 * lambda, "{eta}"),
        }
    }
}

#[test]
fn the_trapezoid_by_product_by_four_points_and_by_our_warp_is_one_map() {
    let (mut warped, mut parallel) = (0, 0);
    for s in random_setups(400) {
        let (rows, values) = s.cropped("tsm", &[]);
        let Some(&(_, eta)) = values.0.iter().find(|v| v.0 == "eta") else { continue };
        let uniform = eta * LEAST_LAMBDA > values.get("depth");
        let corners = trapezoid::trapezoid(&s, if uniform { f64::INFINITY } else { eta });
        // A body that the light sees nearly edge-on has a trapezoid without width.
        let width = values.get("base_width");
        if width < 1e-3 * values.get("depth") || values.get("top_width") < 1e-6 * width {
            continue;
        }
        let four = trapezoid::four_points(&corners).expect("a convex trapezoid");
        match trapezoid::product(&corners) {
            Some(product) => {
                for (corner, target) in corners.iter().zip([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) {
                    let (a, b) = (trapezoid::image(&product, *corner), trapezoid::image(&four, *corner));
                    // The product cancels where legs are nearly parallel: their intersection is far away.
                    let digits = 1e-12 * (1.0 + (eta / values.get("depth")).powi(2));
                    assert!((a - DVec2::from(target)).length() < digits, "{a} {target:?}");
                    assert!((b - DVec2::from(target)).length() < 1e-9, "{b} {target:?}");
                }
                let center = corners.iter().sum::<DVec2>() / 4.0;
                let inside = corners.iter().map(|p| p.lerp(center, 0.3)).chain([center]);
                for p in inside {
                    let digits = 1e-12 * (1.0 + (eta / values.get("depth")).powi(2));
                    let d = trapezoid::image(&product, p) - trapezoid::image(&four, p);
                    assert!(d.length() < digits, "{d:?}");
                }
                warped += 1;
            }
            None => parallel += 1,
        }
        // The near end at y = -1: the trapezoid's map turned over.
        let (frame, _) = LightFrame::towards(s.along, s.camera.forward()).expect("an axis");
        for p in s.view.receivers.vertices() {
            let p_light = DVec2::new(frame.right.dot(*p - s.view.eye), frame.up.dot(*p - s.view.eye));
            let expected = trapezoid::image(&four, p_light) * DVec2::new(1.0, -1.0);
            let ours = rows.project(*p).truncate();
            // w at the near end is smaller than at the far end by this much.
            let digits = 1e-10 * (1.0 + values.get("depth") / eta);
            assert!((ours - expected).length() < digits, "{ours} and {expected}, eta {eta}");
        }
    }
    assert!(warped > 200 && parallel > 10, "{warped} warped, {parallel} parallel");
}

#[test]
fn the_focus_depth_gets_its_share_and_the_body_fills_the_map() {
    let mut met = 0;
    for s in random_setups(300) {
        for share in [0.5, 0.8, 0.9] {
            let p = s.provisional("tsm", &[set("share", share)]);
            let (rows, values) = s.cropped("tsm", &[set("share", share)]);
            let images: Vec<DVec3> = s.view.receivers.vertices().iter().map(|p| rows.project(*p)).collect();
            for axis in 0..2 {
                let low = images.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min);
                let high = images.iter().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max);
                assert!((low + 1.0).abs() < EXACT && (high - 1.0).abs() < EXACT, "{axis}: {low} to {high}");
            }
            if !p.notes.is_empty() || values.get("kappa") == 0.0 {
                continue;
            }
            let focus = s.view.eye + s.camera.forward() * values.get("focus_depth");
            close("depth", values.get("focus_depth"), (s.view.eye_depth[0] * s.view.eye_depth[1]).sqrt(), EXACT);
            let y = rows.project(focus).y;
            assert!((y - (2.0 * share - 1.0)).abs() < 1e-8, "{y} for {share}");
            met += 1;
        }
    }
    assert!(met > 300, "{met}");
}

#[test]
fn tsm_is_lispsm_at_its_eta_across_the_light() {
    let mut compared = 0;
    for s in random_setups(300) {
        let (tsm, values) = s.cropped("tsm", &[]);
        let Some(&(_, eta)) = values.0.iter().find(|v| v.0 == "eta") else { continue };
        let (lispsm, _) = s.cropped("lispsm", &[set("near", eta)]);
        let d = apart(&s, &tsm, &lispsm);
        assert!(d < 1e-8, "{d:e} at eta {eta}");
        compared += 1;
    }
    assert!(compared > 250, "{compared}");
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
    let scenes = [around(), setup::box_scene(DVec3::new(-300.0, -4.0, -300.0), DVec3::new(300.0, 5.0, 300.0))];
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
    let scenes = [around(), setup::box_scene(DVec3::new(-20.0, -9.0, -50.0), DVec3::new(40.0, 3.0, -4.0))];
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
fn the_published_trapezoid_does_not_fade_along_the_view() {
    // The centre ray in the middle of the frustum: δ = λ/2, so η = λ (1 - s) / (2 s - 1) with the share s; 1/3 for 0.8.
    let t = tables();
    let s = Setup::whole_frustum(&t, at_angle(1e-4));
    for (share, expected) in [(0.8, 1.0 / 3.0), (0.6, 2.0)] {
        let values = Values(s.provisional("tsm", &[set("share", share)]).values);
        close("lambda", values.get("lambda"), expected, 0.01);
    }
    let along = Setup::whole_frustum(&t, at_angle(0.0)).provisional("tsm", &[]);
    assert!(along.notes.iter().any(|note| note.kind() == Kind::NoWarp), "{:?}", along.notes);
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
        let along = WarpSpace::directional(&s.view, s.along, s.camera.forward(), &s.view.receivers).expect("a warp");
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
        setup::box_scene(DVec3::splat(50.0), DVec3::splat(60.0)),
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
