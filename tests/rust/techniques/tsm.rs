//! Trapezoidal maps: η of the tables, the trapezoid as the paper builds it, and what it is beside LiSPSM (theory.md 4).

pub mod trapezoid;

use glam::{DVec2, DVec3};
use shadowlab::note::Kind;
use shadowlab::rays::LightFrame;
use shadowlab::scene::Camera;
use shadowlab::techniques::kit::LEAST_LAMBDA;

use crate::support::setup::{EXACT, Setup, Values, apart, around, at_angle, close, random_setups, set};
use crate::support::tables::{number, tables};

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
