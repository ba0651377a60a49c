//! `tests/data/tables.json`: its numbers, and the cameras, lights and scenes that it speaks of.

use std::sync::Arc;

use glam::{DAffine3, DMat4, DVec3};
use serde_json::Value as Json;
use shadowlab::geometry::Aabb;
use shadowlab::scene::{Camera, DirectionalLight, Instance, Light, Mesh, Scene};

pub fn tables() -> Json {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/tables.json");
    serde_json::from_str(&std::fs::read_to_string(path).expect(path)).expect("tables.json")
}

pub fn number(j: &Json) -> f64 {
    j.as_f64().unwrap_or_else(|| panic!("a number, not {j}"))
}

pub fn numbers(j: &Json) -> Vec<f64> {
    j.as_array().expect("numbers").iter().map(number).collect()
}

pub fn vector(j: &Json) -> DVec3 {
    DVec3::new(number(&j[0]), number(&j[1]), number(&j[2]))
}

pub fn points(j: &Json) -> Vec<DVec3> {
    j.as_array().expect("points").iter().map(vector).collect()
}

pub fn matrix(j: &Json) -> DMat4 {
    let flat: Vec<f64> = (0..16).map(|i| number(&j[i / 4][i % 4])).collect();
    DMat4::from_rows_array(flat.as_slice().try_into().expect("16 numbers"))
}

pub fn camera(j: &Json) -> Camera {
    let forward = j.get("forward").or(j.get("forward_unnormalised")).expect("forward");
    let eye = vector(&j["eye"]);
    let [fov, aspect, near, far] = ["fovy", "aspect", "near", "far"].map(|k| number(&j[k]));
    Camera::look_at(eye, eye + vector(forward), vector(&j["up"]), fov, aspect, near, far).expect("a camera")
}

pub fn sun(along: DVec3) -> Light {
    Light::Directional(DirectionalLight::new(along).expect("a light"))
}

/// A box as a scene of one mesh: its twelve triangles.
pub fn box_scene(low: DVec3, high: DVec3) -> Scene {
    let corners = Aabb { min: low, max: high }.corners();
    let faces: [[i64; 4]; 6] = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];
    let triangles: Vec<[i64; 3]> = faces.iter().flat_map(|f| [[f[0], f[1], f[2]], [f[0], f[2], f[3]]]).collect();
    let mesh = Mesh::new(&corners.map(|p| p.to_array()), &triangles).expect("a box");
    Scene::new(vec![Arc::new(mesh)], vec![Instance { mesh: 0, world_from_mesh: DAffine3::IDENTITY }]).expect("a scene")
}
