//! Errors of finished maps, by central differences of where they put points: nothing here knows of techniques.
//!
//! Source: theory.md E.1, E.2: lengths across the light's ray, over eye depth, in heights of the image.
//!
//! ```text
//!   s ^     /------/      a texel across the ray, of which a warp shears the sides of constant t
//!     |    /      /|      along: its slanted side     height: between the sides of constant s
//!     +-->/------/ |      across: a side of constant s
//!        t      height
//! ```

use glam::{DMat2, DMat3, DMat4, DVec2, DVec3};
use shadowlab::Parameterization;
use shadowlab::focus::{Focus, FocusedView};
use shadowlab::geometry::Rows;
use shadowlab::parameterization::{Partition, PostWarp};
use shadowlab::rays::LightFrame;
use shadowlab::scene::{Camera, DirectionalLight, Light, Scene};

use crate::support::by_body::by_body;
use crate::support::views::{cube, placed};

const RESOLUTION: u32 = 1024;

/// Central differences with a step of 1e-5 of the distance over which w doubles: h² and rounding over h.
pub const DIFFERENCES: f64 = 1e-6;

/// What a map does to a point of the body: lengths of a texel over the map's side, and its area, in heights of the image.
pub struct Measured {
    /// m_s, shear included.
    pub along: f64,
    /// m_s, shear aside.
    pub height: f64,
    /// m_t.
    pub across: f64,
    pub area: f64,
}

/// A map for points relative to an origin.
pub struct LocalMap {
    rows: Rows,
    post_warp: PostWarp,
    /// The share of the map that receivers fill.
    inset: f64,
}

/// The shares of a map along x and y that receivers fill.
pub fn inset(p: &Parameterization) -> DVec2 {
    let texels = DVec2::from_array(p.resolution.map(f64::from));
    1.0 - 2.0 * f64::from(p.border_texels) / texels
}

impl LocalMap {
    pub fn new(p: &Parameterization, partition: &Partition, origin: DVec3) -> Self {
        let inset = inset(p).x;
        let rows = Rows::of(&(partition.shadow_clip_from_world * DMat4::from_translation(origin)));
        Self { rows, post_warp: partition.post_warp.clone(), inset }
    }
    /// t and s, 1 apart over what receivers span.
    fn ts(&self, p: DVec3) -> DVec2 {
        let w = self.rows.w.dot(p.extend(1.0));
        self.post_warp.apply(self.rows.project(p), w).truncate() * (0.5 / self.inset)
    }
    pub fn measured(&self, view: &FocusedView, p: DVec3) -> Measured {
        let ray = view.rays.direction_at(p).expect("off the light");
        let frame = LightFrame::any(ray);
        let depth = (p - view.eye).dot(view.camera.forward());
        let doubling = self.rows.w.dot(p.extend(1.0)).abs() / self.rows.w.truncate().length();
        let h = 1e-5 * if doubling.is_finite() { doubling.min(depth) } else { depth };
        let column = |d: DVec3| -> DVec2 { (self.ts(p + d * h) - self.ts(p - d * h)) / (2.0 * h) };
        let ts_from_across = DMat2::from_cols(column(frame.right), column(frame.up));
        let across_from_ts = ts_from_across.inverse();
        let heights = 0.5 / (depth * (0.5 * view.camera.fov_y()).tan());
        Measured {
            across: across_from_ts.x_axis.length() * heights,
            along: across_from_ts.y_axis.length() * heights,
            height: heights / ts_from_across.row(1).length(),
            area: across_from_ts.determinant().abs() * heights * heights,
        }
    }
}

/// Vertices, and points along the edges evenly in the logarithm of depth.
pub fn outline(view: &FocusedView, steps: i32) -> Vec<DVec3> {
    let mut points = view.receivers.vertices().to_vec();
    for [a, b] in view.receivers.edges() {
        let [near, far] = [a, b].map(|p| (p - view.eye).dot(view.camera.forward()));
        for i in 1..steps {
            let share = f64::from(i) / f64::from(steps);
            let depth = near * (far / near).powf(share);
            let along = (depth - near) / (far - near);
            points.push(a.lerp(b, if (0.0..=1.0).contains(&along) { along } else { share }));
        }
    }
    points
}

pub fn degrees(x: f64) -> f64 {
    x.to_radians()
}

/// A camera whose whole frustum is the body, and light at an angle to its view, from above or, by azimuth, from the right.
pub fn frustum(gamma_deg: f64, azimuth_deg: f64, far: f64) -> (Scene, Camera, Light) {
    let around = DMat3::from_diagonal(DVec3::splat(2.0 * far));
    let scene = placed(&[(cube(), around, DVec3::ZERO)]);
    let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, degrees(60.0), 1.0, 1.0, far).expect("a camera");
    let from = DVec3::Y * degrees(azimuth_deg).cos() + DVec3::X * degrees(azimuth_deg).sin();
    let along = DVec3::NEG_Z * degrees(gamma_deg).cos() - from * degrees(gamma_deg).sin();
    (scene, camera, Light::Directional(DirectionalLight::new(along).expect("a light")))
}

pub fn made(text: &str, (scene, camera, light): &(Scene, Camera, Light)) -> Parameterization {
    by_body(text).parameterize(scene, camera, light, RESOLUTION).expect("a map")
}

pub fn view_of((scene, camera, light): &(Scene, Camera, Light)) -> FocusedView<'static> {
    FocusedView::new(scene, camera, light, Focus::SceneFit)
}

/// Half a unit of the last printed digit, exponent included.
pub fn half_digit(text: &str) -> f64 {
    let (mantissa, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let decimals = mantissa.split('.').nth(1).map_or(0, str::len) as i32;
    0.5 * 10.0_f64.powi(exponent.parse::<i32>().expect("an exponent") - decimals)
}

/// Panics unless a number is the printed one in all its digits.
pub fn assert_printed(what: &str, ours: f64, printed: &str) {
    let value: f64 = printed.parse().expect("a number");
    assert!((ours - value).abs() <= half_digit(printed) * (1.0 + DIFFERENCES), "{what}: {ours} is not {printed}");
}

#[test]
fn one_digit_more_or_less_is_not_the_printed_one() {
    assert_printed("", 8.6540e5, "8.65e5");
    assert_printed("", 1.9949, "1.99");
    for (ours, printed) in [(8.6551e5, "8.65e5"), (1.984, "1.99"), (8575.0, "8574"), (f64::NAN, "1")] {
        assert!(std::panic::catch_unwind(|| assert_printed("", ours, printed)).is_err(), "{ours} {printed}");
    }
}
