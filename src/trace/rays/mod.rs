//! Rays taken into a frame, alone or in a bundle.

mod bundle;
mod ray;
mod rough;

pub use bundle::{ALL, BUNDLE, Bundle, Each, Hull, RayBits, largest};
pub use ray::{Line, LocalRay, LocalRays, SLAB_SLACK, WorldRay, WorldRays, largest_of};
pub use rough::{DEPTH_OF_BOUND, DEPTH_OF_ERROR};
