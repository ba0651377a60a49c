//! Errors on a floor that a picture shows, and on the centre ray, against the papers' forms (theory.md E.1 and 6).
//!
//! A floor at height h below a level eye is in row y = f h / z of the image (f the focal length, pixels), and a row of the map is
//! dz/ds / N deep, so that m_s = (f h / z²) (dz/ds) / N; with dp/ds = (zn / z) dz/ds that is f h / (z zn) dp/ds / N. The map is
//! 2 zn tan(φx) dp/dt z / zn wide at a depth, which f / z pixels a unit make m_t = W dp/dt / N. N are the texels that receivers
//! fill: those of the border are none.

use glam::{DMat3, DVec3};
use shadowlab::aliasing::footprint::footprint;
use shadowlab::scene::{Camera, Light, Scene};
use shadowlab::{Parameterization, Progress};

use super::measured::{DEPTH, EXACT, MAJOR, Picture, SINGLE, Sizes, assert_close, gbuffer, one, ways};
use crate::support::measure::{degrees, frustum, inset, made};
use crate::support::views::{View, placed, square};

/// Rows of maps come from cuts of the frustum's planes, and warps divide by their differences.
const OF_MATRICES: f64 = 1e-9;

/// An odd number of columns: one of them lies in the middle, where warps do not shear.
const SIZES: Sizes = Sizes { image: [129, 129], map: [1024, 1024] };

/// The eye's height over the floor, which is seen from the near plane on.
const HEIGHT: f64 = 0.3;

fn tan() -> f64 {
    degrees(30.0).tan()
}

/// The part of a side that receivers fill, texels.
fn inner(p: &Parameterization) -> f64 {
    assert!(p.border_texels > 0, "borders are part of the form");
    f64::from(SIZES.map[0]) * inset(p).x
}

/// A floor in a frustum that the boxes around it fill.
fn floor(far: f64) -> (Scene, Camera, Light) {
    let (scene, camera, light) = frustum(90.0, 0.0, far);
    let wide = placed(&[(square(), DMat3::from_diagonal(DVec3::splat(1.9 * far)), DVec3::NEG_Y * HEIGHT)]);
    (scene.joined(&wide).expect("both"), camera, light)
}

/// dp/ds and dp/dt by depth, near plane at 1, of (E.3) and (E.4), and of the logarithm.
type Forms = fn(z: f64, far: f64, n: f64) -> [f64; 2];

fn warped(z: f64, far: f64, n: f64) -> [f64; 2] {
    let z_ = z - 1.0 + n;
    [z_ * z_ / z * (far - 1.0) / (n * (n + far - 1.0)), far * z_ / (z * (far - 1.0 + n))]
}

fn techniques(far: f64) -> Vec<(String, f64, Forms)> {
    let uniform: Forms = |z, far, _| [(far - 1.0) / z, far / z];
    let log: Forms = |_, far, _| [far.ln(), 1.0];
    let n = 1.0 + 0.3 * far.sqrt();
    vec![
        ("uniform".into(), 0.0, uniform),
        ("psm:slide=0".into(), 1.0, warped),
        ("lispsm:near=basic".into(), 1.0 + far.sqrt(), warped),
        (format!("lispsm:near={n}"), n, warped),
        ("log".into(), 0.0, log),
        ("log_psm".into(), 0.0, log),
    ]
}

#[test]
fn the_errors_of_the_ideal_case_on_a_floor() {
    let focal_px = 0.5 * f64::from(SIZES.image[1]) / tan();
    for far in [10.0, 100.0, 1000.0] {
        let seen = floor(far);
        let v = View { name: format!("floor to {far}"), scene: seen.0.clone(), camera: seen.1, light: seen.2 };
        let g = gbuffer(&v, SIZES.image);
        for (text, n, forms) in techniques(far) {
            let p = made(&text, &seen);
            let errors = |z: f64| {
                let [dp_ds, dp_dt] = forms(z, far, n);
                let m_s = focal_px * HEIGHT / z * dp_ds / inner(&p);
                [m_s, f64::from(SIZES.image[0]) * dp_dt / inner(&p)]
            };
            for i in 0..=20 {
                let z = far.powf(f64::from(i) / 20.0);
                let what = format!("{text}, far {far}, z {z}");
                let texel = one(&v, &p, SIZES, DVec3::new(0.0, -HEIGHT, -z), DVec3::Y);
                let ([a, b, c, d], [m_s, m_t]) = (texel.jacobian, errors(z));
                // A row nearer to the eye is lower in both.
                assert_close(&format!("{what}: m_s"), d, m_s, OF_MATRICES);
                assert_close(&format!("{what}: m_t"), a.abs(), m_t, OF_MATRICES);
                assert!(b.abs() + c.abs() < 1e-9 * (m_s + m_t), "{what}: {texel:?}");
                assert_close(&format!("{what}: major"), texel.major, m_s.max(m_t), OF_MATRICES);
                assert_close(&format!("{what}: minor"), texel.minor, m_s.min(m_t), OF_MATRICES);
                // The normal is that way to the light: cos(n, -d) is 1.
                let [to_eye, _] = ways(&v.camera, &v.light, DVec3::new(0.0, -HEIGHT, -z));
                assert_close(&format!("{what}: projection"), texel.projection, to_eye.y, EXACT);
            }
            // In a picture.
            let progress = Progress::new();
            let f = footprint(&g.surfaces(), &v.camera, &v.light, &p, SIZES.map, &progress).expect("a footprint");
            let f = Picture::of(&f);
            let mut rows = 0;
            for y in 65..129 {
                let i = y * 129 + 64;
                let z = focal_px * HEIGHT / (y as f64 + 0.5 - 64.5);
                if g.triangle[i] < 0 || f.map[i] < 0 {
                    // The near plane, and the far one: rounding decides of the rows that meet them.
                    assert!(!(1.001..far * 0.999).contains(&z), "{text}, {far}: row {y} at depth {z}");
                    continue;
                }
                let [m_s, m_t] = errors(z);
                let what = format!("{text}, far {far}, row {y}");
                let number = |k: usize| f64::from(f.numbers[i][k]);
                // A position in f32 is good to its last digit, and z to that over the height of a row.
                let single = SINGLE * (far / HEIGHT);
                assert_close(&format!("{what}: depth"), number(DEPTH), z, single);
                assert_close(&format!("{what}: m_s"), number(3), m_s, 4.0 * single);
                assert_close(&format!("{what}: m_t"), number(0).abs(), m_t, 4.0 * single);
                assert_close(&format!("{what}: major"), number(MAJOR), m_s.max(m_t), 4.0 * single);
                rows += 1;
            }
            assert!(rows >= 15, "{text}, far {far}: {rows} rows");
        }
    }
}

/// λ, A and ϕ of (6.1) and (6.2) of a light at θ to the view, from n = 1 to f.
struct Family {
    lambda: f64,
    a: f64,
    /// T of the papers: tan φ over tan θ.
    t: f64,
    phi: f64,
}

impl Family {
    /// θ >= φ: the near corners are the near end.
    fn new(p: &Parameterization, theta: f64, far: f64) -> Self {
        let (t, lambda) = (tan() / theta.tan(), p.value("lambda").expect("lambda"));
        let a = far - 1.0 + (far + 1.0) * t;
        Self { lambda, a, t, phi: a * lambda + t - 1.0 }
    }
    /// (6.2): 1 / (z tan φ) dz/ds.
    fn f(&self, z: f64) -> f64 {
        (z + self.phi).powi(2) / z / (tan() * self.a * self.lambda * (self.lambda + 1.0))
    }
    /// G of theory.md E.1: 1 / (z tan φ) dx/dt. z' / sin θ is z + ϕ; the widest corners are the near or the far lower
    /// ones.
    fn g(&self, z: f64, far: f64) -> f64 {
        let at_corner = |c: f64| c / (self.phi + c * (1.0 - self.t));
        2.0 * (z + self.phi) / z * at_corner(1.0).max(at_corner(far))
    }
}

#[test]
fn f_and_g_of_gmnpr_on_the_centre_ray() {
    for far in [10.0, 100.0] {
        for theta_deg in [31.0, 45.0, 70.0, 90.0] {
            let seen = frustum(theta_deg, 0.0, far);
            let v = View { name: format!("{theta_deg}"), scene: seen.0.clone(), camera: seen.1, light: seen.2 };
            let p = made("gmnpr", &seen);
            let theta = degrees(theta_deg);
            let family = Family::new(&p, theta, far);
            // Half an image a unit of NDC, and s from 0 to 1 over the map.
            let px = [0, 1].map(|axis| 0.5 * f64::from(SIZES.image[axis]) / inner(&p));
            for i in 0..=10 {
                let z = far.powf(f64::from(i) / 10.0);
                let q = DVec3::NEG_Z * z;
                let [to_eye, to_light] = ways(&v.camera, &v.light, q);
                let what = format!("{theta_deg} degrees, far {far}, z {z}");
                let across = one(&v, &p, SIZES, q, to_eye + to_light);
                let [m_t, m_s] = across.perspective_ts;
                assert_close(&format!("{what}: F"), m_s, family.f(z) * theta.sin() * px[1], OF_MATRICES);
                assert_close(&format!("{what}: G"), m_t, family.g(z, far) * px[0], OF_MATRICES);
                // Any slope in the plane of view and light: F sin θ cos α / cos β along, nothing across.
                for turn in [-50.0, -10.0, 0.0, 30.0, 60.0, 100.0] {
                    let n = DVec3::new(0.0, degrees(turn).sin(), degrees(turn).cos());
                    let (cos_alpha, cos_beta) = (n.dot(to_eye), n.dot(to_light));
                    if cos_alpha < 0.1 || cos_beta < 0.1 {
                        continue;
                    }
                    let texel = one(&v, &p, SIZES, q, n);
                    let [a, b, c, d] = texel.jacobian;
                    let slope = cos_alpha / cos_beta;
                    assert_close(&format!("{what}, {turn}: m_s"), d.abs(), m_s * slope, OF_MATRICES);
                    assert_close(&format!("{what}, {turn}: m_t"), a.abs(), m_t, OF_MATRICES);
                    assert!(b.abs() + c.abs() < OF_MATRICES * (m_s + m_t) * slope.max(1.0), "{what}: {texel:?}");
                }
            }
        }
    }
}

#[test]
fn off_the_axis_the_image_is_stretched_by_its_own_angle() {
    // The published storage factors are told over depth: of the axis. An angle from it is longer in a flat image by 1 / cos in
    // the direction away from the axis, and the sides of a warped texel slant with the frustum's (techniques/storage_factors.rs).
    let cos = degrees(30.0).cos();
    // Beside the axis the step along s of a warp points away from the eye, and turns up in the image on the plane across h; of
    // a uniform map cos of it does, and tan of it is away from the axis.
    for (text, beside_axis) in [("uniform", cos.hypot(tan())), ("psm:slide=0", 1.0 / cos)] {
        let seen = frustum(90.0, 0.0, 10.0);
        let v = View { name: text.into(), scene: seen.0.clone(), camera: seen.1, light: seen.2 };
        let p = made(text, &seen);
        let perspective_at = |q: DVec3| {
            let [to_eye, to_light] = ways(&v.camera, &v.light, q);
            one(&v, &p, SIZES, q, to_eye + to_light).perspective_ts
        };
        for z in [1.0, 3.0, 10.0] {
            let [t, s] = perspective_at(DVec3::NEG_Z * z);
            // Just within the frustum; the step along s below the axis is the one away from it.
            let edge = tan() * (1.0 - EXACT);
            let below = perspective_at(DVec3::new(0.0, -edge, -1.0) * z);
            assert_close(&format!("{text}, below: m_s"), below[1], s / cos, OF_MATRICES);
            assert_close(&format!("{text}, below: m_t"), below[0], t, OF_MATRICES);
            let beside = perspective_at(DVec3::new(edge, 0.0, -1.0) * z);
            assert_close(&format!("{text}, beside: m_s"), beside[1], s * beside_axis, OF_MATRICES);
            // A step across turns with h where it has a part along e, and is away from the axis with the rest.
            assert_close(&format!("{text}, beside: m_t"), beside[0], t * (0.5_f64).hypot(1.0), OF_MATRICES);
        }
    }
}
