//! The plane-optimal warp, and the plane that most receivers lie in.

mod dominant;
mod lean;
mod warp;

pub use dominant::{DominantPlane, dominant_plane};
pub use warp::{SPEC, make};
