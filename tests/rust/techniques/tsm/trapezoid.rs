//! The trapezoidal map as the paper builds it (Martin and Tan 2004; theory.md 4, steps 1 to 6): the oracle for ours.

use glam::{DMat3, DVec2, DVec3};
use shadowlab::geometry::square_from_quadrilateral;
use shadowlab::rays::LightFrame;

use crate::support::setup::Setup;

/// The corners in light space, (x, Y) from the eye: t0 and t1 at the base, t2 and t3 at the top.
pub fn trapezoid(s: &Setup, eta: f64) -> [DVec2; 4] {
    let (frame, _) = LightFrame::towards(s.along, s.camera.forward()).expect("an axis");
    let eye = s.view.eye;
    let points: Vec<DVec2> = s
        .view
        .receivers
        .vertices()
        .iter()
        .map(|p| *p - eye)
        .map(|p| DVec2::new(frame.right.dot(p), frame.up.dot(p)))
        .collect();
    let low = points.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    let high = points.iter().map(|p| p.y).fold(f64::NEG_INFINITY, f64::max);
    if eta == f64::INFINITY {
        let left = points.iter().map(|p| p.x).fold(f64::INFINITY, f64::min);
        let right = points.iter().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max);
        return [[left, high], [right, high], [right, low], [left, low]].map(DVec2::from);
    }
    let slopes = || points.iter().map(|p| p.x / (p.y - (low - eta)));
    let (left, right) = (slopes().fold(f64::INFINITY, f64::min), slopes().fold(f64::NEG_INFINITY, f64::max));
    let (top, base) = (eta, eta + high - low);
    [[left * base, high], [right * base, high], [right * top, low], [left * top, low]].map(DVec2::from)
}

/// `N_T = S2 T3 N S1 H T2 R T1` on columns (x, Y, 1): base to y = -1, top to y = 1. Nothing for parallel legs, which have no
/// intersection to translate to the origin.
pub fn product(t: &[DVec2; 4]) -> Option<DMat3> {
    let [t0, t1, t2, t3] = *t;
    let rows = |a: [f64; 3], b: [f64; 3], c: [f64; 3]| DMat3::from_cols(a.into(), b.into(), c.into()).transpose();
    let moved = |by: DVec2| rows([1.0, 0.0, by.x], [0.0, 1.0, by.y], [0.0, 0.0, 1.0]);
    let image = |m: &DMat3, p: DVec2| *m * p.extend(1.0);
    let point = |m: &DMat3, p: DVec2| image(m, p).truncate() / image(m, p).z;
    let r = (t2 - t3).normalize();
    let m = rows([r.x, r.y, 0.0], [r.y, -r.x, 0.0], [0.0, 0.0, 1.0]) * moved(-0.5 * (t2 + t3));
    let [q0, q1, q2, q3] = [t0, t1, t2, t3].map(|p| point(&m, p));
    let legs = (q3 - q0, q2 - q1);
    let cross = legs.0.perp_dot(legs.1);
    if cross == 0.0 {
        return None;
    }
    let i = q0 + legs.0 * ((q1 - q0).perp_dot(legs.1) / cross);
    let m = moved(-i) * m;
    let u = 0.5 * (point(&m, t2) + point(&m, t3));
    let m = rows([1.0, -u.x / u.y, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]) * m;
    let u = point(&m, t2);
    let m = DMat3::from_diagonal(DVec3::new(1.0 / u.x, 1.0 / u.y, 1.0)) * m;
    let m = rows([1.0, 0.0, 0.0], [0.0, 1.0, 1.0], [0.0, 1.0, 0.0]) * m;
    let (u, v) = (point(&m, t0), point(&m, t2));
    let m = moved(DVec2::new(0.0, -0.5 * (u.y + v.y))) * m;
    let u = point(&m, t0);
    Some(DMat3::from_diagonal(DVec3::new(1.0, -1.0 / u.y, 1.0)) * m)
}

/// The same by its four corners; parallel legs are no special case.
pub fn four_points(t: &[DVec2; 4]) -> Option<DMat3> {
    square_from_quadrilateral(t)
}

/// Image of a point of the plane.
pub fn image(m: &DMat3, p: DVec2) -> DVec2 {
    let q = *m * p.extend(1.0);
    q.truncate() / q.z
}
