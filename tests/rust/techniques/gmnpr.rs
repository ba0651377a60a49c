//! GMNPR, GLPR beside it: λ at every light angle, and the errors on the centre ray (theory.md 6 and 7).

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use shadowlab::fit::crop;
use shadowlab::geometry::Rows;

use crate::support::setup::{
    EXACT, Params, Setup, Values, around, at_angle, close, difference, oblique, set, turned, word,
};
use crate::support::tables::{self, matrix, number, numbers, tables};

/// (6.1) and (6.3) as written there: λ_GMNPR of a whole frustum.
fn lambda_gmnpr([n, f]: [f64; 2], tan_phi: f64, theta: f64) -> f64 {
    let (phi, t) = (tan_phi.atan(), tan_phi / theta.tan());
    if theta >= phi {
        (n + (f * n).sqrt() - n * t) / (f - n + (f + n) * t)
    } else {
        (f * n).sqrt() / (2.0 * f) / (PI * theta / (4.0 * phi)).tan()
    }
}

#[test]
fn lambda_of_the_tables_at_every_angle() {
    let t = tables();
    let table = &t["lambda"];
    let angles = numbers(&table["theta_deg"]);
    for (i, degrees) in angles.iter().enumerate() {
        let theta = degrees.to_radians();
        for side in [theta, PI - theta] {
            let s = Setup::whole_frustum(&t, at_angle(side));
            for (key, name, params) in [
                ("gmnpr", "gmnpr", vec![]),
                ("gmnpr", "gmnpr", vec![word("body", "frustum")]),
                ("lispsm", "gmnpr", vec![word("lambda", "lispsm")]),
                ("lispsm", "gmnpr", vec![word("lambda", "lispsm"), word("body", "frustum")]),
                ("lispsm_dz", "gmnpr", vec![word("lambda", "lispsm-delta-z")]),
                ("lispsm_dz", "lispsm", vec![]),
                ("lispsm", "lispsm", vec![word("near", "basic")]),
                ("glpr_clamped", "glpr", vec![]),
            ] {
                let values = Values(s.provisional(name, &params).values);
                // At theta = phi the near end of the body lies at the eye up to rounding, and lambda is of size 1e-3 there.
                close(&format!("{key} {degrees} {params:?}"), values.get("lambda"), number(&table[key][i]), 1e-8);
            }
            let values = Values(s.provisional("gmnpr", &[]).values);
            close("theta", values.get("theta"), theta, EXACT);
            close("phi", values.get("silhouette"), number(&table["phi"]), EXACT);
            close("printed", values.get("lambda"), lambda_gmnpr([1.0, 100.0], s.tan_phi(), theta), 1e-8);
        }
    }
    assert_eq!(angles.len(), 24);
}

#[test]
fn whole_matrices_at_each_light_angle() {
    let t = tables();
    for (degrees, case) in t["theta_config"]["by_theta_deg"].as_object().expect("angles") {
        let s = Setup::whole_frustum(&t, tables::vector(&case["light_direction"]));
        for (key, name) in [("gmnpr", "gmnpr"), ("glpr_clamped", "glpr")] {
            let p = s.provisional(name, &[]);
            let k = s.view.receivers;
            let rows = crop(&p.clip_from_local, &s.view, k.vertices(), k.vertices());
            // The tables' casters are the frustum itself, ours all between it and the light: the depths' rows differ.
            let ours = Rows { z: rows.w, ..rows };
            let mut table = Rows::of(&matrix(&case[key]["M"]));
            table.z = table.w;
            let d = difference(&ours.moved_to_world(s.view.origin).matrix(), &table.matrix());
            assert!(d < EXACT, "{name} {degrees}: {d:e}");
            close(degrees, Values(p.values).get("warp_distance"), number(&case[key]["Pn"]), EXACT);
        }
    }
}

#[test]
fn f_and_g_on_the_centre_ray_are_measured_on_our_matrices() {
    let t = tables();
    let f = &t["F"];
    let techniques: [(&str, &str, Params); 4] = [
        ("gmnpr", "gmnpr", vec![]),
        ("glpr_clamped", "glpr", vec![]),
        ("lispsm", "gmnpr", vec![word("lambda", "lispsm")]),
        ("lispsm_dz", "gmnpr", vec![word("lambda", "lispsm-delta-z")]),
    ];
    let mut checked = 0;
    for (key, name, params) in techniques {
        for (i, degrees) in numbers(&f["theta_deg"]).iter().enumerate() {
            let s = Setup::whole_frustum(&t, at_angle(degrees.to_radians()));
            let (rows, _) = s.cropped(name, &params);
            for (j, z) in numbers(&f["z"]).iter().enumerate() {
                close(&format!("F {key} {degrees} {z}"), s.f(&rows, *z), number(&f[key][i][j]), 1e-8);
                checked += 1;
            }
        }
        for row in t["centre_ray_maxima"][key].as_array().expect("rows") {
            let degrees = number(&row["theta_deg"]);
            let s = Setup::whole_frustum(&t, at_angle(degrees.to_radians()));
            let (rows, _) = s.cropped(name, &params);
            // Both are largest at an end: F is convex, and G is a constant plus one over z.
            let ends = |error: &dyn Fn(f64) -> f64| error(1.0).max(error(100.0));
            close(&format!("max F {key} {degrees}"), ends(&|z| s.f(&rows, z)), number(&row["max_F"]), 1e-8);
            close(&format!("max G {key} {degrees}"), ends(&|z| s.g(&rows, z)), number(&row["max_G"]), 1e-8);
            checked += 1;
        }
    }
    assert!(checked >= 4 * 12 * 7, "{checked}");
}

#[test]
fn gmnpr_has_equal_errors_at_both_ends_and_the_least_at_their_geometric_mean() {
    let t = tables();
    for degrees in [30.5, 35.0, 50.0, 70.0, 90.0, 110.0, 149.0] {
        let s = Setup::whole_frustum(&t, at_angle(f64::to_radians(degrees)));
        let (rows, values) = s.cropped("gmnpr", &[]);
        close("ends", s.f(&rows, 1.0), s.f(&rows, 100.0), 1e-10);
        close("phi_offset", values.get("phi_offset"), 10.0, 1e-10);
        let least = s.f(&rows, 10.0);
        assert!(s.f(&rows, 9.9) > least && s.f(&rows, 10.1) > least, "{degrees}");
        // No other distance has smaller largest errors.
        let largest = s.f(&rows, 1.0);
        for factor in [0.99, 1.01] {
            let (other, _) = s.cropped("gmnpr", &[set("lambda", factor * values.get("lambda"))]);
            assert!(s.f(&other, 1.0).max(s.f(&other, 100.0)) > largest, "{degrees} x {factor}");
        }
    }
}

#[test]
fn at_any_azimuth_the_whole_frustum_has_the_printed_lambda() {
    let c = oblique();
    for azimuth in [0.0, 0.4, 1.2, FRAC_PI_2, 2.5, 4.0] {
        for degrees in [3.0, 15.0, 25.0, 33.0, 48.0, 75.0, 90.0, 120.0, 170.0_f64] {
            let theta = degrees.to_radians();
            let s = Setup::new(around(), c, turned(&c, theta, azimuth));
            assert_eq!(s.view.receivers.vertices().len(), 8);
            let acute = theta.min(PI - theta);
            // u lies in the plane of view and light; its reach in the frustum is that of the corner it points to.
            let [tan_x, tan_y] = c.half_size().to_array();
            let tan_phi = azimuth.sin().abs() * tan_x + azimuth.cos().abs() * tan_y;
            let expected = lambda_gmnpr([0.7, 60.0], tan_phi, acute);
            for body in ["clipped", "frustum"] {
                let values = Values(s.provisional("gmnpr", &[word("body", body)]).values);
                close(&format!("{azimuth} {degrees} {body}"), values.get("lambda"), expected, 1e-8);
            }
        }
    }
}

#[test]
fn the_published_frustum_puts_the_reference_point_where_it_was_whatever_is_seen() {
    let c = oblique();
    let small = || tables::box_scene(DVec3::new(2.0, -9.0, -40.0), DVec3::new(22.0, 1.0, -10.0));
    for degrees in [8.0, 20.0, 40.0, 80.0, 130.0_f64] {
        let along = turned(&c, degrees.to_radians(), 0.7);
        let (whole, part) = (Setup::new(around(), c, along), Setup::new(small(), c, along));
        for lambda in ["gmnpr", "lispsm", "lispsm-delta-z"] {
            let params = [word("lambda", lambda), word("body", "frustum")];
            let [one, two] = [&whole, &part].map(|s| Values(s.provisional("gmnpr", &params).values));
            close("phi_offset", two.get("phi_offset"), one.get("phi_offset"), EXACT);
            close("lambda", two.get("lambda_frustum"), one.get("lambda"), EXACT);
            let own = Values(part.provisional("gmnpr", &[word("lambda", lambda)]).values);
            assert!(
                (own.get("lambda") / two.get("lambda") - 1.0).abs() > 1e-3,
                "{degrees} {lambda}: a choice without effect"
            );
        }
    }
}

#[test]
fn distances_are_continuous_in_the_light_angle_for_whole_and_clipped_bodies() {
    let c = oblique();
    let scenes = [around(), tables::box_scene(DVec3::new(-20.0, -9.0, -50.0), DVec3::new(40.0, 3.0, -4.0))];
    let mut across = 0;
    for scene in scenes {
        for azimuth in [0.0, 0.9, 2.2, 5.0] {
            let at = |theta: f64, name: &str| {
                let s = Setup::new(scene.clone(), c, turned(&c, theta, azimuth));
                Values(s.provisional(name, &[]).values)
            };
            for name in ["gmnpr", "glpr"] {
                // Each side of where the body's near end passes the eye, found by bisection.
                let (mut low, mut high) = (0.01, FRAC_PI_2);
                if at(low, name).get("y_min") >= 0.0 {
                    continue;
                }
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if at(middle, name).get("y_min") < 0.0 { low = middle } else { high = middle }
                }
                let (below, above) = (at(low, name), at(high, name));
                assert!(below.get("y_min") < 0.0 && above.get("y_min") >= 0.0);
                close(&format!("{name} at {low}"), below.get("warp_distance"), above.get("warp_distance"), 1e-10);
                close("the silhouette", low, below.get("silhouette"), 1e-10);
                across += 1;
                // And no jump anywhere: a hundredth of a degree moves nothing by a tenth.
                let mut last = at(0.02, name).get("lambda");
                for i in 1..15_000 {
                    let lambda = at(0.02 + f64::from(i) * 1e-4, name).get("lambda");
                    assert!((lambda / last - 1.0).abs() < 0.1, "{name}: {last} to {lambda} at step {i}");
                    last = lambda;
                }
            }
        }
    }
    assert!(across >= 8, "{across}");
}

#[test]
fn under_an_overhead_light_the_closed_forms_of_lispsm_and_psm() {
    let t = tables();
    let s = Setup::whole_frustum(&t, DVec3::NEG_Y);
    for (name, key) in [("gmnpr", "lispsm"), ("glpr", "psm")] {
        let (rows, _) = s.cropped(name, &[]);
        for (z, expected) in numbers(&t["ideal_dp_ds"]["z"]).iter().zip(numbers(&t["ideal_dp_ds"][key])) {
            // dp/ds over a near plane of height 1: F of height 2 tan phi, on a screen of height 2.
            close(key, s.f(&rows, *z) * s.tan_phi(), expected, EXACT);
        }
    }
    // Across, a perspective map has equal errors everywhere.
    let (rows, _) = s.cropped("glpr", &[]);
    close("G", s.g(&rows, 1.0), s.g(&rows, 100.0), EXACT);
}
