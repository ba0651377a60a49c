//! Rays taken into a frame, alone or in a bundle.

mod bundle;
mod ray;
mod rough;
mod ways;

pub use bundle::{ALL, BUNDLE, Bundle, Each, Hull, RayBits, largest};
pub use ray::{Line, LocalRay, LocalRays, SLAB_SLACK, Shared, WorldRay, WorldRays};
pub use rough::{DEPTH_OF_BOUND, DEPTH_OF_ERROR};
pub use ways::largest_of;
