//! Geometry in f64, knowing only glam.

mod aabb;

pub use aabb::Aabb;
