//! A separable warp after a homography.

mod base;
mod density;
mod warp;

pub use density::{Densities, EdgeWidths, least_density};
pub use warp::{SPEC, make};
