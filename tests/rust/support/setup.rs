//! The tables' numbers and views, and warps by name.

use glam::{DMat4, DVec3};
use serde_json::Value as Json;
use shadowlab::fit::{MapSize, crop};
use shadowlab::focus::{Focus, FocusedView};
use shadowlab::geometry::Rows;
use shadowlab::parameterization::Region;
use shadowlab::progress::Progress;
use shadowlab::scene::{Camera, Scene};
use shadowlab::techniques::{Make, Named, Part, Provisional, TECHNIQUES, Value};

use crate::support::by_body::by_body_with;
use crate::support::tables::{box_scene, camera, sun, vector};

/// Of f64 through a dozen operations on numbers of size 100.
pub const EXACT: f64 = 1e-9;

/// Some of a technique's parameters.
pub type Params = Vec<(&'static str, Value)>;

/// A scene, a camera and a directional light, focused.
pub struct Setup {
    pub scene: Scene,
    pub camera: Camera,
    pub along: DVec3,
    pub view: FocusedView<'static>,
}

impl Setup {
    pub fn new(scene: Scene, camera: Camera, along: DVec3) -> Self {
        let view = FocusedView::new(&scene, &camera, &sun(along), Focus::SceneFit);
        Self { scene, camera, along: along.normalize(), view }
    }
    /// The view that all matrices of the tables share.
    pub fn of_tables(t: &Json) -> Self {
        let inputs = &t["matrices"]["inputs"];
        let scene = box_scene(vector(&inputs["scene_aabb"][0]), vector(&inputs["scene_aabb"][1]));
        Self::new(scene, camera(&inputs["camera"]), vector(&inputs["light_direction_unnormalised"]))
    }
    /// The tables' camera of light angles, its whole frustum seen.
    pub fn whole_frustum(t: &Json, along: DVec3) -> Self {
        Self::new(around(), camera(&t["theta_config"]["camera"]), along)
    }
    /// The provisional map of a technique with some of its parameters.
    pub fn provisional(&self, name: &str, params: &[(&str, Value)]) -> Provisional {
        let entry = TECHNIQUES.iter().find(|e| e.spec.name == name).expect(name);
        let of_body = by_body_with(name, params).settings();
        let params: Vec<_> = of_body.into_iter().map(|(name, value)| (name.to_string(), value)).collect();
        let Make::Warp(make) = entry.make else { panic!("{name} is no warp") };
        let warp = make(&entry.spec.resolve(&params).expect("settings")).expect("a warp");
        let size = MapSize::new([1024; 2]).expect("a size");
        let (camera, light) = (self.camera, sun(self.along));
        let progress = &Progress::new();
        let part = Part { scene: &self.scene, camera, light, size, samples: None, region: Region::ALL, progress };
        warp.warp(&self.view, &part).expect("a map")
    }
    /// The map cropped to the bodies, as the tables do it, and its values.
    pub fn cropped(&self, name: &str, params: &[(&str, Value)]) -> (Rows, Values) {
        let p = self.provisional(name, params);
        let (k, b) = (self.view.receivers, self.view.casters());
        (crop(&p.clip_from_local, &self.view, k.vertices(), b.vertices()), Values(p.values))
    }
    /// 1 / (z tan φ) dz/ds on the centre ray, s in [0, 1] (6.2).
    pub fn f(&self, rows: &Rows, z: f64) -> f64 {
        let forward = self.camera.forward();
        2.0 / (rows.derivative(forward * z, forward).y * z * self.tan_phi())
    }
    /// The same across: 1 / (z tan φ) dx/dt.
    pub fn g(&self, rows: &Rows, z: f64) -> f64 {
        let across = self.camera.forward().cross(self.along).normalize();
        2.0 / (rows.derivative(self.camera.forward() * z, across).x.abs() * z * self.tan_phi())
    }
    pub fn tan_phi(&self) -> f64 {
        (0.5 * self.camera.fov_y()).tan()
    }
}

/// A box that holds the tables' frusta.
pub fn around() -> Scene {
    box_scene(DVec3::splat(-300.0), DVec3::splat(300.0))
}

/// A warp's intermediate numbers.
pub struct Values(pub Vec<Named>);

impl Values {
    pub fn get(&self, name: &str) -> f64 {
        self.0.iter().find(|v| v.0 == name).unwrap_or_else(|| panic!("{name} in {:?}", self.0)).1
    }
}

/// Light at an angle to the view of a camera that looks along -z with y up, in the plane of view and up.
pub fn at_angle(theta: f64) -> DVec3 {
    DVec3::new(0.0, -theta.sin(), -theta.cos())
}

/// Largest difference of two matrices of one map, after scaling both to the largest entry and undoing a mirrored x.
pub fn difference(a: &DMat4, b: &DMat4) -> f64 {
    let normed = |m: &DMat4| {
        let largest = m.to_cols_array().iter().fold(0.0_f64, |s, x| s.max(x.abs()));
        Rows::of(&(*m * (1.0 / largest)))
    };
    let (a, b) = (normed(a), normed(b));
    let mirrored = Rows { x: -b.x, ..b };
    let apart = |b: &Rows| {
        let d = a.matrix() - b.matrix();
        d.to_cols_array().iter().fold(0.0_f64, |s, x| s.max(x.abs()))
    };
    apart(&b).min(apart(&mirrored))
}

/// Largest difference of x and y of two maps over the receivers' body.
pub fn apart(s: &Setup, a: &Rows, b: &Rows) -> f64 {
    let d = |p: &DVec3| (a.project(*p) - b.project(*p)).truncate().abs().max_element();
    s.view.receivers.vertices().iter().map(d).fold(0.0, f64::max)
}

/// Views at random: boxes of all shapes around and before a camera of any angle, near and far that matter, any light.
pub fn random_setups(count: usize) -> Vec<Setup> {
    let mut random = Random(42);
    let mut all = Vec::with_capacity(count);
    while all.len() < count {
        let size = DVec3::new(random.between(2.0, 60.0), random.between(0.1, 30.0), random.between(2.0, 60.0));
        let middle = random.vector() * 10.0;
        let near = 10.0_f64.powf(random.between(-2.0, 0.0));
        let far = near * 10.0_f64.powf(random.between(0.3, 3.5));
        let eye = middle + random.vector() * 20.0;
        let (fov, aspect) = (random.between(0.2, 2.0), random.between(0.5, 2.0));
        let up = random.vector();
        let Ok(camera) = Camera::look_at(eye, eye + random.vector(), up, fov, aspect, near, far) else { continue };
        let s = Setup::new(box_scene(middle - size, middle + size), camera, random.vector());
        if s.view.coverage == shadowlab::focus::Coverage::AsAsked {
            all.push(s);
        }
    }
    all
}

/// Uniform random numbers from a seed (SplitMix64).
pub struct Random(pub u64);

impl Random {
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        low + (high - low) * (((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64)
    }
    pub fn vector(&mut self) -> DVec3 {
        DVec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0))
    }
}

pub fn set(name: &'static str, x: f64) -> (&'static str, Value) {
    (name, Value::Number(x))
}

pub fn word(name: &'static str, word: &str) -> (&'static str, Value) {
    (name, Value::Choice(word.to_string()))
}

pub fn close(what: &str, ours: f64, expected: f64, relative: f64) {
    assert!((ours / expected - 1.0).abs() < relative, "{what}: {ours} and {expected}");
}

/// A camera of no symmetry: field of view, aspect and near that no formula hides behind.
pub fn oblique() -> Camera {
    let eye = DVec3::new(3.0, -2.0, 5.0);
    Camera::look_at(eye, eye + DVec3::new(0.5, -0.2, -1.0), DVec3::new(0.1, 1.0, 0.0), 0.9, 1.5, 0.7, 60.0)
        .expect("a camera")
}

/// Light at an angle to the view of a camera, turned around the view by an azimuth.
pub fn turned(c: &Camera, theta: f64, azimuth: f64) -> DVec3 {
    let across = c.up() * azimuth.cos() + c.right() * azimuth.sin();
    c.forward() * theta.cos() - across * theta.sin()
}
