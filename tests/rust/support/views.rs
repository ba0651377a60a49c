//! Scenes, cameras and lights to hold the techniques against: the library's, and awkward ones by hand.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use shadowlab::focus::Samples;
use shadowlab::geometry::Aabb;
use shadowlab::image::GBuffer;
use shadowlab::render::Renderer;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::scene::{Camera, DirectionalLight, Instance, Light, Mesh, PointLight, Scene, SpotLight, library};
use shadowlab::techniques::Needs;
use shadowlab::{Progress, survey};

/// Uniform random numbers from a seed (SplitMix64).
pub struct Random(pub u64);

impl Random {
    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
    pub fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }
    pub fn in_box(&mut self, b: &Aabb) -> DVec3 {
        let a = DVec3::new(self.unit(), self.unit(), self.unit());
        b.min + (b.max - b.min) * a
    }
    pub fn direction(&mut self) -> DVec3 {
        let cube = Aabb { min: DVec3::NEG_ONE, max: DVec3::ONE };
        std::iter::repeat_with(|| self.in_box(&cube))
            .find(|p| (0.01..1.0).contains(&p.length()))
            .expect("one")
            .normalize()
    }
}

pub struct View {
    pub name: String,
    pub scene: Scene,
    pub camera: Camera,
    pub light: Light,
}

pub fn mesh(vertices: &[[f64; 3]], faces: &[[i64; 3]]) -> Arc<Mesh> {
    Arc::new(Mesh::new(vertices, faces).expect("a mesh"))
}

/// A box from -1 to 1.
pub fn cube() -> Arc<Mesh> {
    let corners = Aabb { min: DVec3::NEG_ONE, max: DVec3::ONE }.corners().map(|p| p.to_array());
    let faces: [[i64; 4]; 6] = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];
    let triangles: Vec<[i64; 3]> = faces.iter().flat_map(|f| [[f[0], f[1], f[2]], [f[0], f[2], f[3]]]).collect();
    mesh(&corners, &triangles)
}

/// A flat square from -1 to 1 at y = 0.
pub fn square() -> Arc<Mesh> {
    let corners = [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]];
    mesh(&corners, &[[0, 2, 1], [0, 3, 2]])
}

pub fn placed(parts: &[(Arc<Mesh>, DMat3, DVec3)]) -> Scene {
    let meshes = parts.iter().map(|p| p.0.clone()).collect();
    let instances = parts
        .iter()
        .enumerate()
        .map(|(i, p)| Instance { mesh: i as u32, world_from_mesh: DAffine3::from_mat3_translation(p.1, p.2) })
        .collect();
    Scene::new(meshes, instances).expect("a scene")
}

pub fn look(eye: DVec3, target: DVec3, fov: f64, near: f64, far: f64) -> Camera {
    let up = if (target - eye).cross(DVec3::Y).length() < 1e-6 * (target - eye).length() { DVec3::Z } else { DVec3::Y };
    Camera::look_at(eye, target, up, fov, 1.4, near, far).expect("a camera")
}

/// Scenes whose bodies are flat, tiny, huge, sheared, out of view, or around the eye.
pub fn by_hand() -> Vec<(&'static str, Scene, Camera)> {
    let v = DVec3::new;
    let scale = |x, y, z| DMat3::from_diagonal(v(x, y, z));
    let sheared = DMat3::from_cols(v(3.0, 0.5, 0.0), v(1.0, -2.0, 0.3), v(0.0, 0.4, 4.0));
    let town = || {
        let mut random = Random(7);
        let mut parts = vec![(square(), scale(60.0, 1.0, 60.0), DVec3::ZERO)];
        for _ in 0..60 {
            let at = v(random.between(-50.0, 50.0), 0.0, random.between(-50.0, 50.0));
            let turn = DMat3::from_rotation_y(random.between(0.0, 6.0));
            parts.push((cube(), turn * scale(1.5, random.between(1.0, 9.0), 2.5), at));
        }
        placed(&parts)
    };
    let triangle = mesh(&[[0.0, 0.0, 0.0], [2.0, 0.1, 0.0], [0.3, 1.5, 0.4]], &[[0, 1, 2]]);
    let edge_on = mesh(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], &[[0, 1, 2]]);
    let point = mesh(&[[1.0, 2.0, 3.0]], &[[0, 0, 0]]);
    let eye = v(3.0, 4.0, 9.0);
    vec![
        (
            "cube",
            placed(&[(cube(), scale(4.0, 4.0, 4.0), DVec3::ZERO)]),
            look(v(5.0, 6.0, 9.0), DVec3::ZERO, 0.9, 0.1, 100.0),
        ),
        (
            "floor",
            placed(&[(square(), scale(30.0, 1.0, 30.0), DVec3::ZERO)]),
            look(eye, v(0.0, 0.0, -8.0), 1.0, 0.1, 200.0),
        ),
        (
            "floor from above",
            placed(&[(square(), scale(30.0, 1.0, 30.0), DVec3::ZERO)]),
            look(v(0.0, 9.0, 0.0), DVec3::ZERO, 1.0, 0.1, 200.0),
        ),
        (
            "floor edge on",
            placed(&[(square(), scale(30.0, 1.0, 30.0), DVec3::ZERO)]),
            look(v(0.0, 0.0, 50.0), DVec3::ZERO, 1.0, 0.1, 200.0),
        ),
        ("town", town(), look(v(20.0, 5.0, 55.0), v(0.0, 2.0, 0.0), 1.1, 0.2, 300.0)),
        ("town from inside", town(), look(v(0.3, 2.0, 0.1), v(10.0, 1.0, -20.0), 1.3, 0.05, 300.0)),
        ("town, seen narrowly from far", town(), look(v(900.0, 300.0, 900.0), v(0.0, 0.0, 0.0), 0.02, 10.0, 2000.0)),
        (
            "sheared and mirrored",
            placed(&[(cube(), sheared, v(1.0, 0.0, -3.0)), (square(), scale(9.0, 1.0, 9.0), v(0.0, -3.0, 0.0))]),
            look(eye, DVec3::ZERO, 0.8, 0.1, 60.0),
        ),
        (
            "triangle",
            placed(&[(triangle, DMat3::IDENTITY, DVec3::ZERO)]),
            look(v(0.5, 0.5, 5.0), v(0.5, 0.5, 0.0), 0.7, 0.1, 50.0),
        ),
        (
            "line",
            placed(&[(edge_on, DMat3::IDENTITY, DVec3::ZERO)]),
            look(v(0.5, 0.5, 5.0), v(0.5, 0.5, 0.0), 0.7, 0.1, 50.0),
        ),
        (
            "point",
            placed(&[(point, DMat3::IDENTITY, DVec3::ZERO)]),
            look(v(0.0, 2.0, 8.0), v(1.0, 2.0, 3.0), 0.7, 0.1, 50.0),
        ),
        (
            "nothing in view",
            placed(&[(cube(), DMat3::IDENTITY, DVec3::ZERO)]),
            look(v(0.0, 0.0, 9.0), v(0.0, 0.0, 20.0), 0.8, 0.1, 60.0),
        ),
        (
            "behind the far plane",
            placed(&[(cube(), DMat3::IDENTITY, DVec3::ZERO)]),
            look(v(0.0, 0.0, 9.0), DVec3::ZERO, 0.8, 0.1, 3.0),
        ),
        (
            "gap between two",
            placed(&[(cube(), DMat3::IDENTITY, v(-20.0, 0.0, 0.0)), (cube(), DMat3::IDENTITY, v(20.0, 0.0, 0.0))]),
            look(v(0.0, 0.0, 9.0), DVec3::ZERO, 0.4, 0.1, 60.0),
        ),
        (
            "eye in a corner",
            placed(&[(cube(), scale(5.0, 5.0, 5.0), DVec3::ZERO)]),
            look(DVec3::splat(5.0), DVec3::ZERO, 1.5, 1e-4, 1e4),
        ),
        (
            "wide and deep",
            placed(&[(cube(), scale(5e3, 20.0, 5e3), DVec3::ZERO)]),
            look(v(0.0, 10.0, 4e3), v(0.0, 5.0, 0.0), 2.8, 1e-3, 1e6),
        ),
    ]
}

/// Directions along, against, across and nearly along the camera's own; up, down, level, and random ones.
pub fn directions(camera: &Camera) -> Vec<(String, DVec3)> {
    let (f, u, r) = (camera.forward(), camera.up(), camera.right());
    let mut all = vec![
        ("along the view".to_string(), f),
        ("against the view".to_string(), -f),
        ("along the camera's up".to_string(), u),
        ("against the camera's up".to_string(), -u),
        ("across the view".to_string(), r),
        ("down".to_string(), DVec3::NEG_Y),
        ("up".to_string(), DVec3::Y),
        ("level".to_string(), DVec3::new(0.8, 0.0, 0.6)),
        ("grazing".to_string(), DVec3::new(0.8, -1e-3, 0.6)),
    ];
    for tilt in [1e-1, 1e-3, 1e-5, 1e-7, 1e-9, 1e-13] {
        all.push((format!("{tilt:e} off the view"), f - u * tilt));
        all.push((format!("{tilt:e} off against the view"), -f - u * tilt + r * (0.5 * tilt)));
    }
    let mut random = Random(3);
    all.extend((0..4).map(|i| (format!("random {i}"), random.direction())));
    all
}

pub fn directional(direction: DVec3) -> Light {
    Light::Directional(DirectionalLight::new(direction).expect("a light"))
}

/// Spots above, inside, at the eye, behind, narrow, nearly flat.
pub fn spots(scene: &Scene, camera: &Camera) -> Vec<(String, Light)> {
    let (b, eye, f) = (*scene.bounds(), camera.eye(), camera.forward());
    let size = b.diagonal().max(1e-3);
    let middle = b.center();
    let spot = |p: DVec3, d: DVec3, cone: f64, range: f64| SpotLight::new(p, d, cone, range).expect("a spot");
    let above = DVec3::new(middle.x + 0.1 * size, b.max.y + 0.3 * size, middle.z);
    let pi = std::f64::consts::PI;
    let all = [
        ("above", spot(above, middle - above, 1.0, 3.0 * size)),
        ("above, straight down", spot(above, DVec3::NEG_Y, 0.8, 3.0 * size)),
        ("inside", spot(middle, DVec3::new(0.3, -1.0, 0.2), 1.5, 2.0 * size)),
        ("at the eye", spot(eye, f, 0.9, 4.0 * size)),
        ("facing the eye", spot(middle + f * size, -f, 0.9, 4.0 * size)),
        ("beside the eye", spot(eye + camera.right() * (0.1 * size), f, 0.5, 4.0 * size)),
        ("narrow", spot(above, middle - above, 1e-3, 3.0 * size)),
        ("nearly flat", spot(above, middle - above, 3.1, 3.0 * size)),
        ("flat up to rounding", spot(above, middle - above, pi - 1e-12, 3.0 * size)),
        ("reaches nothing", spot(above, DVec3::Y, 1.0, 0.1 * size)),
        ("short of range", spot(above, middle - above, 1.2, 0.45 * size)),
    ];
    all.into_iter().map(|(name, spot)| (name.to_string(), Light::Spot(spot))).collect()
}

/// Point lights above, inside, at the eye, and out of reach of everything.
pub fn points(scene: &Scene, camera: &Camera) -> Vec<(String, Light)> {
    let b = *scene.bounds();
    let size = b.diagonal().max(1e-3);
    let above = b.center().with_y(b.max.y + 0.3 * size) + DVec3::X * (0.1 * size);
    let all = [
        ("above", above, 3.0 * size),
        ("inside", b.center() + DVec3::new(0.03, 0.05, -0.02) * size, 2.0 * size),
        ("at the eye", camera.eye(), 4.0 * size),
        ("behind the eye", camera.eye() - camera.forward() * size, 9.0 * size),
        ("reaches nothing", above, 0.1 * size),
    ];
    all.into_iter()
        .map(|(name, p, range)| (format!("point {name}"), Light::Point(PointLight::new(p, range).expect("a light"))))
        .collect()
}

/// A small image of a view.
pub fn picture_of(scene: &Scene, camera: &Camera) -> GBuffer {
    let size = [64, (64.0 / camera.aspect()).round().clamp(1.0, 64.0) as u32];
    CpuRenderer::new().gbuffer(scene, camera, size, &Progress::new()).expect("a G-buffer")
}

/// What a small image of the view shows.
pub fn samples_of(scene: &Scene, camera: &Camera) -> Samples {
    Samples::of_surfaces(&picture_of(scene, camera).surfaces(), camera)
}

/// The same, with what of it is in shadow under a light.
pub fn shaded_samples(scene: &Scene, camera: &Camera, light: &Light, picture: &GBuffer) -> Samples {
    let samples =
        survey::samples_of_surfaces(scene, camera, light, picture.surfaces(), Needs::Shadows, &Progress::new());
    samples.expect("samples")
}

impl View {
    /// Samples with shadow states under the view's light.
    pub fn samples(&self) -> Samples {
        shaded_samples(&self.scene, &self.camera, &self.light, &picture_of(&self.scene, &self.camera))
    }
}

/// Parameters that scale a scene, and the most of each in tests of every technique on every scene, for time.
const FEW: [(&str, f64); 3] = [("trees", 300.0), ("facets", 16.0), ("leaves", 60.0)];

/// The library's scenes with their own cameras and lights, scaled down.
pub fn from_library() -> Vec<View> {
    let spec_of = |name: &str| library::specs().iter().find(|s| s.name == name).expect("a spec");
    library::names()
        .into_iter()
        .map(|name| {
            let few: Vec<(String, f64)> = spec_of(name)
                .params
                .iter()
                .filter_map(|p| FEW.iter().find(|(name, _)| *name == p.name).map(|(_, most)| (p, most)))
                .map(|(p, most)| (p.name.to_string(), most.clamp(p.min, p.max)))
                .collect();
            let built = library::build(name, 1, &few).expect(name);
            View { name: name.to_string(), scene: built.scene, camera: built.camera, light: built.light }
        })
        .collect()
}
