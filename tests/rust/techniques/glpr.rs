//! GLPR: errors that grow as depth does, and the floor of λ (theory.md 7).

use crate::support::setup::{EXACT, Setup, Values, at_angle, close, set};
use crate::support::tables::{number, tables};

#[test]
fn glpr_errors_grow_as_depth_does_where_the_floor_is_not_reached() {
    let t = tables();
    let mut linear = 0;
    for degrees in (1..=179).map(f64::from) {
        let s = Setup::whole_frustum(&t, at_angle(degrees.to_radians()));
        let (rows, values) = s.cropped("glpr", &[]);
        let acute = degrees.min(180.0 - degrees);
        let clamped = values.get("lambda") <= values.get("lambda_floor") || acute <= 30.0;
        assert_eq!(clamped, acute < 36.0, "{degrees}");
        let slope = s.f(&rows, 1.0);
        let apart = [2.0, 5.0, 10.0, 50.0, 100.0]
            .iter()
            .map(|z| (s.f(&rows, *z) / (slope * z) - 1.0).abs())
            .fold(0.0, f64::max);
        assert_eq!(apart < EXACT, !clamped, "{degrees}: {apart:e}");
        if !clamped {
            linear += 1;
            assert!(values.get("phi_offset").abs() < EXACT);
            // 7.1.
            let tangent = s.tan_phi() / acute.to_radians().tan();
            close("7.1", values.get("lambda"), (1.0 - tangent) / (99.0 + 101.0 * tangent), 1e-8);
        }
    }
    assert_eq!(linear, 109);
}

#[test]
fn the_floor_of_glpr_is_a_share_of_near_over_far() {
    let t = tables();
    let s = Setup::whole_frustum(&t, at_angle(31.0_f64.to_radians()));
    for floor in [0.02, 0.1, 0.5, 30.0] {
        let values = Values(s.provisional("glpr", &[set("lambda_floor", floor)]).values);
        close("floor", values.get("lambda_floor"), floor / 100.0, EXACT);
        let raw = number(&t["lambda"]["glpr_raw"][10]);
        close("lambda", values.get("lambda"), raw.max(floor / 100.0), 1e-8);
    }
}
