//! Views that are hard for a depth buffer: grazing floors, thin gaps, stacks, tiny far triangles, eyes at walls.

use std::f64::consts::{FRAC_PI_2, TAU};

use std::fmt;
use std::sync::Arc;

use glam::{DMat3, DVec3};
use shadowlab::scene::{Camera, Mesh, Scene};

use super::configuration::Configuration;
use crate::support::views::{Random, mesh, placed, square};

/// A scene and who looks at it.
pub struct EyeView {
    pub what: String,
    pub scene: Scene,
    pub camera: Camera,
    /// Pixels.
    pub size: [u32; 2],
}

impl fmt::Debug for EyeView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {:?}, bounds {:?}, {:?} px", self.what, self.camera, self.scene.bounds(), self.size)
    }
}

type Parts = Vec<(Arc<Mesh>, DMat3, DVec3)>;

fn log_between(random: &mut Random, low: f64, high: f64) -> f64 {
    random.between(low.ln(), high.ln()).exp()
}

fn turned(random: &mut Random) -> DMat3 {
    DMat3::from_axis_angle(random.direction(), random.between(0.0, TAU))
}

/// A square of n x n squares, uneven as terrain where asked.
fn grid(n: usize, bumps: f64, random: &mut Random) -> Arc<Mesh> {
    let at = |i: usize| 2.0 * i as f64 / n as f64 - 1.0;
    let mut points = Vec::new();
    for i in 0..=n {
        for j in 0..=n {
            points.push([at(i), bumps * random.unit(), at(j)]);
        }
    }
    let index = |i: usize, j: usize| (i * (n + 1) + j) as i64;
    let squares = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let faces: Vec<[i64; 3]> = squares
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    mesh(&points, &faces)
}

fn soup(count: usize, size: f64, random: &mut Random) -> Arc<Mesh> {
    let points: Vec<[f64; 3]> = (0..count)
        .flat_map(|_| {
            let middle = DVec3::new(random.between(-1.0, 1.0), random.between(-0.3, 0.3), random.between(-1.0, 1.0));
            [0, 1, 2].map(|_| (middle + size * random.direction()).to_array())
        })
        .collect();
    let faces: Vec<[i64; 3]> = (0..count as i64).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    mesh(&points, &faces)
}

/// The things of a view, about the origin and about 1 in size, and where the eye is and looks.
fn things(random: &mut Random) -> (&'static str, Parts, DVec3, DVec3) {
    let v = DVec3::new;
    let scale = |x: f64, y: f64, z: f64| DMat3::from_diagonal(v(x, y, z));
    let n = [1, 4, 30][random.below(3)];
    let around = |random: &mut Random, distance: f64, low: f64| {
        let turn = random.between(0.0, TAU);
        v(distance * turn.cos(), distance * low, distance * turn.sin())
    };
    match random.below(7) {
        0 => {
            let floor = (grid(n, 0.0, random), scale(1.0, 1.0, 1.0), DVec3::ZERO);
            let eye = v(random.between(-0.9, 0.9), log_between(random, 1e-5, 0.3), random.between(-0.9, 0.9));
            let target = v(random.between(-1.0, 1.0), random.between(-0.1, 0.01), random.between(-1.0, 1.0));
            ("a grazing floor", vec![floor], eye, target)
        }
        1 => {
            // A table top a thousandth of the distance above the floor.
            let distance = log_between(random, 0.1, 3.0);
            let gap = 1e-3 * distance;
            let floor = (grid(n, 0.0, random), scale(1.0, 1.0, 1.0), DVec3::ZERO);
            let top = (grid([1, 5, 20][random.below(3)], 0.0, random), scale(0.3, 1.0, 0.3), v(0.0, gap, 0.0));
            let low = log_between(random, 0.02, 3.0);
            let eye = around(random, distance, low).normalize() * distance;
            ("a table top over a floor", vec![floor, top], eye, DVec3::ZERO)
        }
        2 => {
            let turn = turned(random);
            let distance = log_between(random, 0.3, 10.0);
            let gap = distance * log_between(random, 1e-4, 1e-2);
            let parts = (0..6).map(|k| {
                let mesh = if k % 2 == 0 { square() } else { grid(n, 0.0, random) };
                let spin = DMat3::from_rotation_y(k as f64) * 0.4;
                (mesh, turn * spin, turn * v(0.05 * k as f64, gap * k as f64, 0.0))
            });
            let parts: Parts = parts.collect();
            ("a tilted stack", parts, random.direction() * distance, DVec3::ZERO)
        }
        3 => {
            let size = log_between(random, 5e-3, 0.1);
            let distance = log_between(random, 1.5, 10.0);
            let parts = vec![(soup(2000, size, random), DMat3::IDENTITY, DVec3::ZERO)];
            ("tiny far triangles", parts, around(random, distance, 0.3), DVec3::ZERO)
        }
        4 => {
            let away = log_between(random, 1e-5, 1e-2);
            let wall = (grid(n, 0.0, random), scale(1.0, 1.0, 1.0), DVec3::ZERO);
            let other = (grid(n, 0.0, random), DMat3::from_rotation_x(FRAC_PI_2) * 0.8, v(0.0, 0.0, -0.7));
            let eye = v(random.between(-0.5, 0.5), away, random.between(-0.5, 0.5));
            let along = eye + v(random.between(-1.0, 1.0), random.between(-0.5, 0.3), random.between(-1.0, 1.0));
            ("an eye close to a wall", vec![wall, other], eye, along)
        }
        5 => {
            let parts: Parts = (0..5).map(|_| (grid(n, 0.0, random), turned(random) * 0.6, DVec3::ZERO)).collect();
            ("crossing squares", parts, around(random, 2.0, 0.5), DVec3::ZERO)
        }
        _ => {
            let terrain = (grid(40, 0.05, random), scale(1.0, 1.0, 1.0), DVec3::ZERO);
            let eye = v(random.between(-0.8, 0.8), 0.05 + log_between(random, 1e-4, 0.2), random.between(-0.8, 0.8));
            let target = v(random.between(-1.0, 1.0), 0.0, random.between(-1.0, 1.0));
            ("terrain", vec![terrain], eye, target)
        }
    }
}

impl EyeView {
    /// A view from a seed: 1e-6 to 1e9 units in size, fields of view of 1 to 170 degrees, far over near up to 1e7.
    pub fn random(seed: u64) -> Self {
        let mut random = Random(seed.wrapping_mul(0x9FB2_1C65_1E98_DF25));
        let random = &mut random;
        let size = match random.below(50) {
            0 => [1300, 1000],
            1..4 => [390, 300],
            _ => [65, 50],
        };
        if random.below(6) == 0 {
            let Configuration { what, scene, camera, .. } = Configuration::random(seed);
            return Self { what, scene, camera, size };
        }
        let (what, parts, eye, target) = things(random);
        let unit = log_between(random, 1e-6, 1e9);
        // Away from the origin as far as f64 has digits for the eye's place.
        let place = [DVec3::ZERO, DVec3::new(300.0, -20.0, 5000.0)][random.below(2)] * unit;
        let parts: Parts = parts.into_iter().map(|(mesh, map, at)| (mesh, map * unit, at * unit + place)).collect();
        let (eye, target) = (eye * unit + place, target * unit + place);
        let forward = target - eye;
        let up = std::iter::repeat_with(|| if random.below(2) == 0 { DVec3::Y } else { random.direction() })
            .find(|up| up.cross(forward.normalize()).length() > 1e-3)
            .expect("an up vector");
        let degrees: f64 = [1.0, 170.0, 60.0, 90.0, random.between(1.0, 170.0)][random.below(5)];
        let ratio = [1e7, 1e6, log_between(random, 3.0, 1e7)][random.below(3)];
        // What is looked at is before the far plane, and mostly beyond the near one.
        let far = forward.length() * log_between(random, 1.5, 30.0);
        let camera = Camera::look_at(eye, target, up, degrees.to_radians(), 1.3, far / ratio, far).expect("a camera");
        Self { what: format!("{what} of size {unit:e}"), scene: placed(&parts), camera, size }
    }
}
