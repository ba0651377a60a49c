//! The eye-space blur: (14.1) on a wall, its stop at an edge, and that it can be interrupted.

use glam::{DVec3, Vec3};
use shadowlab::image::Surfaces;
use shadowlab::render::{BlurSettings, BlurStrength, blur};
use shadowlab::scene::ViewVolume;
use shadowlab::{Camera, Error, Progress};

const SIDE: usize = 21;
/// Four operations a step in single precision.
const CLOSE: f32 = 1e-6;

/// A wall one pixel to a unit, straight across parallel rays, whose right half stands `step` further away.
struct Wall {
    position: Vec<[f32; 3]>,
    normal: Vec<[f32; 3]>,
    triangle: Vec<i32>,
}

impl Wall {
    fn new(step: f32) -> Self {
        let middle = SIDE as f32 / 2.0;
        let at = |i: usize| {
            let (x, y) = ((i % SIDE) as f32 + 0.5 - middle, middle - (i / SIDE) as f32 - 0.5);
            [x, y, if x > 0.6 { -10.0 - step } else { -10.0 }]
        };
        let pixels = SIDE * SIDE;
        Self {
            position: (0..pixels).map(at).collect(),
            normal: vec![[0.0, 0.0, 1.0]; pixels],
            triangle: vec![0; pixels],
        }
    }
    fn surfaces(&self) -> Surfaces<'_> {
        Surfaces {
            size: [SIDE as u32; 2],
            origin: DVec3::ZERO,
            position: &self.position,
            normal: &self.normal,
            triangle: &self.triangle,
            instance: &self.triangle,
        }
    }
}

fn camera() -> Camera {
    let volume = ViewVolume::orthographic(SIDE as f64, 1.0, 1.0, 100.0);
    Camera::look_along(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, volume).unwrap()
}

fn steps(steps: u32) -> BlurSettings {
    BlurSettings { steps, strength: BlurStrength::Even, depth: None }
}

fn point() -> Vec<f32> {
    (0..SIDE * SIDE).map(|i| f32::from(u8::from(i == SIDE * (SIDE / 2) + SIDE / 2))).collect()
}

#[test]
fn a_wall_gets_binomial_weights() {
    let wall = Wall::new(0.0);
    let found = blur(&point(), &wall.surfaces(), &camera(), &steps(2), &Progress::new()).unwrap();
    let weights = [1.0, 4.0, 6.0, 4.0, 1.0].map(|w: f32| w / 16.0);
    for (i, &light) in found.iter().enumerate() {
        let [x, y] = [i % SIDE, i / SIDE].map(|k| (k + 2).checked_sub(SIDE / 2).and_then(|k| weights.get(k)));
        let expected = x.zip(y).map_or(0.0, |(x, y)| x * y);
        assert!((light - expected).abs() <= CLOSE, "pixel {i}: {light}, not {expected}");
    }
}

#[test]
fn nothing_crosses_an_edge_of_a_pixel() {
    let lit: Vec<f32> = (0..SIDE * SIDE).map(|i| f32::from(u8::from(i % SIDE <= SIDE / 2))).collect();
    let far = blur(&lit, &Wall::new(1.01).surfaces(), &camera(), &steps(9), &Progress::new()).unwrap();
    assert_eq!(far, lit);
    let low = blur(&lit, &Wall::new(0.5).surfaces(), &camera(), &steps(1), &Progress::new()).unwrap();
    // Half of a quarter; of the distance to the plane what positions in single precision may be off does not count.
    let wall = Wall::new(0.5);
    let reach: f32 = [SIDE / 2, SIDE / 2 + 1].iter().map(|&i| Vec3::from_array(wall.position[i]).length()).sum();
    let expected = 0.25 * (0.5 + 2.0 * f32::EPSILON * reach);
    assert!((low[SIDE / 2 + 1] - expected).abs() <= CLOSE, "{} is not {expected}", low[SIDE / 2 + 1]);
}

#[test]
fn it_counts_its_steps_and_stops() {
    let (wall, progress) = (Wall::new(0.0), Progress::new());
    blur(&point(), &wall.surfaces(), &camera(), &steps(5), &progress).unwrap();
    assert_eq!(progress.state(), (5, 5));
    progress.stop();
    let stopped = blur(&point(), &wall.surfaces(), &camera(), &steps(5), &progress);
    assert!(matches!(stopped, Err(Error::Interrupted)));
}
