//! One random configuration: a scene, a camera, a light and a resolution from a seed, and settings for a technique.

use std::f64::consts::PI;
use std::fmt;

use glam::{DMat3, DVec2, DVec3};
use shadowlab::scene::{Camera, Light, PointLight, Scene, SpotLight, ViewVolume};
use shadowlab::techniques::{Kind, Spec, Value};

use crate::support::views::{Random, cube, directional, mesh, placed, square};

pub struct Configuration {
    pub what: String,
    pub scene: Scene,
    pub camera: Camera,
    pub light: Light,
    pub resolution: u32,
    /// Of the scene, world units.
    pub size: f64,
}

impl fmt::Debug for Configuration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}, {} texels, {:?}, {:?}, bounds {:?}",
            self.what,
            self.resolution,
            self.camera,
            self.light,
            self.scene.bounds()
        )
    }
}

fn pick<T: Copy>(all: &[T], random: &mut Random) -> T {
    all[random.below(all.len())]
}

/// Evenly in the logarithm.
fn log_between(random: &mut Random, low: f64, high: f64) -> f64 {
    random.between(low.ln(), high.ln()).exp().clamp(low, high)
}

impl Configuration {
    pub fn random(seed: u64) -> Self {
        let mut random = Random(seed.wrapping_mul(0xD134_2543_DE82_EF95));
        let random = &mut random;
        let size = pick(&[1.0, 10.0, 10.0, 300.0, 30_000.0, log_between(random, 1e-3, 3e4)], random);
        let far_off =
            pick(&[DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, DVec3::new(455_000.0, -1200.0, 5_411_000.0)], random);
        // Away from the origin only what is large enough for f64 there.
        let offset = if size >= 1.0 { far_off } else { DVec3::ZERO };
        let (kind, parts) = parts(random, size, offset);
        let scene = placed(&parts);
        let camera = varied(&camera(random, &scene, size), size, &mut Random(seed.wrapping_mul(0x9FB2_1C65_1E98_DF25)));
        let (light_kind, light) = light(random, &scene, &camera, size);
        let resolution = pick(&[3, 4, 5, 16, 100, 512, 2048, 16384], random);
        let what = format!("{kind} of size {size:.3} at {offset}, {light_kind}");
        Self { what, scene, camera, light, resolution, size }
    }
}

type Parts = Vec<(std::sync::Arc<shadowlab::scene::Mesh>, DMat3, DVec3)>;

fn turned(random: &mut Random) -> DMat3 {
    let axis = random.direction();
    DMat3::from_axis_angle(axis, random.between(0.0, 2.0 * PI))
}

fn parts(random: &mut Random, size: f64, at: DVec3) -> (&'static str, Parts) {
    let v = DVec3::new;
    let scale = |x: f64, y: f64, z: f64| DMat3::from_diagonal(v(x, y, z) * size);
    let any =
        |random: &mut Random| v(random.between(-1.0, 1.0), random.between(-0.3, 0.3), random.between(-1.0, 1.0)) * size;
    let floor = || (square(), scale(1.0, 1.0, 1.0), at);
    match random.below(12) {
        0 => {
            let corners = [0, 1, 2].map(|_| any(random).to_array());
            ("a triangle", vec![(mesh(&corners, &[[0, 1, 2]]), DMat3::IDENTITY, at)])
        }
        1 => ("a point", vec![(mesh(&[any(random).to_array()], &[[0, 0, 0]]), DMat3::IDENTITY, at)]),
        2 => {
            let (a, b) = (any(random), any(random));
            let corners = [a.to_array(), a.lerp(b, 0.3).to_array(), b.to_array()];
            ("a line", vec![(mesh(&corners, &[[0, 1, 2]]), DMat3::IDENTITY, at)])
        }
        3 => ("a floor", vec![floor()]),
        4 => ("a wall", vec![(square(), DMat3::from_rotation_x(0.5 * PI) * scale(1.0, 1.0, 0.5), at)]),
        5 => ("a tilted square", vec![(square(), turned(random) * scale(1.0, 1.0, 0.2), at)]),
        6 => ("a box", vec![(cube(), turned(random) * scale(0.8, 0.3, 0.5), at)]),
        7 => {
            let apart = v(size, 0.0, 0.0);
            let half = DMat3::from_diagonal(DVec3::splat(0.05 * size));
            ("two far apart", vec![(cube(), half, at - apart), (cube(), half, at + apart)])
        }
        8 => {
            let slab = (cube(), scale(1.0, 1e-3, 1.0), at);
            ("a slab and a tower", vec![slab, (cube(), scale(0.02, 0.4, 0.02), at + v(0.1, 0.4, -0.2) * size)])
        }
        kind => {
            let mut all = if kind < 11 { vec![floor()] } else { Vec::new() };
            for _ in 0..random.below(8) + 1 {
                let shape = v(random.unit(), random.unit(), random.unit()) * (0.3 * size) + DVec3::splat(1e-3 * size);
                let flip = if random.below(5) == 0 { -1.0 } else { 1.0 };
                let turn = turned(random) * DMat3::from_diagonal(shape * v(flip, 1.0, 1.0));
                let middle = at + any(random);
                all.push(if random.below(4) == 0 { (square(), turn, middle) } else { (cube(), turn, middle) });
            }
            (if kind < 11 { "boxes on a floor" } else { "boxes" }, all)
        }
    }
}

fn camera(random: &mut Random, scene: &Scene, size: f64) -> Camera {
    let b = scene.bounds();
    let target = random.in_box(b);
    let axes = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
    let direction = if random.below(3) == 0 { pick(&axes, random) } else { random.direction() };
    // Inside the boxes, before them, far off.
    let distance = size * pick(&[1e-3, 0.1, 0.5, 1.0, 3.0, 100.0], random);
    let mut eye = target - direction * distance;
    if random.below(4) == 0 {
        // On the level of a corner: flat scenes are seen edge on.
        eye.y = b.min.y;
    }
    let target = if eye == target { target + direction * distance } else { target };
    let forward = (target - eye).normalize();
    let up = std::iter::repeat_with(|| if random.below(2) == 0 { pick(&axes, random) } else { random.direction() })
        .find(|up| up.cross(forward).length() > 1e-6)
        .expect("an up vector");
    let degrees = pick(&[1.0, 170.0, 60.0, 90.0, random.between(1.0, 170.0)], random);
    let aspect = pick(&[1.0, 1.5, 0.3, 3.0], random);
    let ratio = pick(&[1.001, 1e6, log_between(random, 1.001, 1e6)], random);
    // The target lies somewhere between the planes, most of the time.
    let depth = (target - eye).length();
    let near = depth * ratio.powf(-random.unit()) * pick(&[1.0, 1.0, 1.0, 1.0, 0.3, 3.0], random);
    Camera::look_at(eye, target, up, f64::to_radians(degrees), aspect, near, near * ratio).expect("a camera")
}

/// The camera as it is, or another that stands there: with parallel rays, a shifted picture, no end, an extreme aspect.
fn varied(camera: &Camera, size: f64, random: &mut Random) -> Camera {
    let volume = camera.volume();
    let (near, far) = (volume.near, volume.far);
    let aspect = pick(&[volume.aspect, volume.aspect, 0.05, 20.0, log_between(random, 0.05, 20.0)], random);
    let mut random_shift = || {
        let edge = pick(&[0.0, 0.3, 1.0, -1.0, 2.5], random);
        DVec2::new(edge, random.between(-1.5, 1.5)) * pick(&[1.0, 1.0, 1e-9, 40.0], random)
    };
    let shift = random_shift();
    let volume = match random.below(8) {
        0..4 => volume,
        4 => ViewVolume { aspect, ..volume }.shifted(shift),
        5 => ViewVolume { aspect, ..volume }.with_depths(near, f64::INFINITY),
        kind => {
            // As high as the perspective one is somewhere between its planes; depths of either sign.
            let depth = log_between(random, near, far.min(1e3 * near));
            // Positions of samples are f32 from the middle of the scene: smaller pictures show their steps.
            let height = (volume.height() * depth).max(1e-4 * size);
            let near = pick(&[near, -near, -far, 0.0], random);
            let volume = ViewVolume::orthographic(height, aspect, near, far);
            if kind == 6 { volume } else { volume.shifted(shift) }
        }
    };
    camera.with_volume(volume).expect("a camera")
}

fn light(random: &mut Random, scene: &Scene, camera: &Camera, size: f64) -> (String, Light) {
    let (f, u, r) = (camera.forward(), camera.up(), camera.right());
    match random.below(6) {
        4 => {
            let (what, position, direction) = position(random, scene, camera, size);
            let cone = pick(&[1e-3, 0.5, 1.5, 3.1, PI - 1e-12], random);
            let range = size * pick(&[0.1, 1.0, 10.0, 1000.0], random);
            (format!("a spot {what}"), Light::Spot(SpotLight::new(position, direction, cone, range).expect("a spot")))
        }
        5 => {
            let (what, position, _) = position(random, scene, camera, size);
            let range = size * pick(&[0.1, 1.0, 10.0, 1000.0], random);
            (format!("a point light {what}"), Light::Point(PointLight::new(position, range).expect("a light")))
        }
        kind => {
            let azimuth =
                if kind == 0 { pick(&[0.0, 0.5 * PI, PI, 1.5 * PI], random) } else { random.between(0.0, 2.0 * PI) };
            let across = match azimuth {
                0.0 => r,
                a if a == 0.5 * PI => u,
                a if a == PI => -r,
                a if a == 1.5 * PI => -u,
                a => r * a.cos() + u * a.sin(),
            };
            let tilt = pick(&[0.0, 1e-12, 1e-9, 1e-7, 1e-6, 1e-4, 1e-2], random);
            let (what, d) = match random.below(8) {
                0 => ("along the view", f + across * tilt),
                1 => ("against the view", -f + across * tilt),
                2 => ("across the view", across + f * tilt),
                3 => ("along up", u + f * tilt),
                4 => ("down", DVec3::NEG_Y + DVec3::X * tilt),
                _ => {
                    let angle = random.between(0.0, PI);
                    ("slanted", f * angle.cos() + across * angle.sin())
                }
            };
            (format!("light {what}, {tilt:e} off"), directional(d))
        }
    }
}

fn position(random: &mut Random, scene: &Scene, camera: &Camera, size: f64) -> (&'static str, DVec3, DVec3) {
    let b = scene.bounds();
    let (eye, f, middle) = (camera.eye(), camera.forward(), b.center());
    let inside = random.in_box(b);
    match random.below(7) {
        0 => ("at the eye", eye, f),
        1 => ("facing the eye", eye + f * (2.0 * (middle - eye).length()), -f),
        2 => ("inside", inside, random.direction()),
        3 => ("on a corner", b.max, random.direction()),
        4 => {
            let p = middle + DVec3::Y * (random.between(0.5, 3.0) * size);
            ("above", p, DVec3::NEG_Y)
        }
        5 => ("beside the eye", eye + camera.right() * (0.1 * size), f),
        _ => {
            let p = middle + random.direction() * (random.between(0.1, 5.0) * size);
            ("anywhere", p, if p == middle { f } else { inside - p })
        }
    }
}

/// Settings for a technique: none half of the time, else some of its parameters.
pub fn random_settings(spec: &Spec, c: &Configuration, random: &mut Random) -> Vec<(String, Value)> {
    if random.below(2) == 0 {
        return Vec::new();
    }
    let inner = ["uniform", "lispsm", "uniform/lispsm", "lispsm:near=basic"];
    let bases = ["uniform", "lispsm", "scene_optimal:cap=none", "lispsm:near=basic"];
    let number = |random: &mut Random, unit: &str, min: f64, max: f64| {
        let scale = match unit {
            "world units" => c.size,
            "per world unit" => 1.0 / c.size,
            _ => 1.0,
        };
        let x = match random.below(6) {
            0 => min,
            1 => max,
            2 => random.between(0.0, 1.0),
            _ => log_between(random, 1e-6, 1e6) * scale,
        };
        x.clamp(min, max)
    };
    let mut chosen = Vec::new();
    for p in spec.params {
        if random.below(5) >= 2 {
            continue;
        }
        let word = |random: &mut Random, words: &[&'static str]| Value::Choice(pick(words, random).to_string());
        let value = match p.kind {
            Kind::Number { min, max } => Value::Number(number(random, p.unit, min, max)),
            Kind::Integer { min, max } => {
                let most = max.min(min.saturating_add(5));
                Value::Integer(min + random.below((most - min + 1) as usize) as i64)
            }
            Kind::Flag => Value::Flag(random.below(2) == 0),
            Kind::Choice(words) => word(random, words),
            Kind::ChoiceOrNumber { words, min, max } => match random.below(2) {
                0 => word(random, words),
                _ => Value::Number(number(random, p.unit, min, max)),
            },
            Kind::Numbers { words, count, min, max } => match random.below(2) {
                0 if !words.is_empty() => word(random, words),
                _ => {
                    let many = count[0] + random.below(count[1].min(count[0] + 3) - count[0] + 1);
                    let mut list: Vec<f64> = (0..many).map(|_| number(random, p.unit, min, max)).collect();
                    list.sort_by(f64::total_cmp);
                    Value::Numbers(list)
                }
            },
            Kind::Techniques => word(random, &inner),
            Kind::Technique => word(random, &bases),
        };
        chosen.push((p.name.to_string(), value));
    }
    chosen
}
