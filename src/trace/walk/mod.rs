//! Walks through the hierarchies, of a ray and of a bundle, and what is looked for on the way.

mod alpha;
mod bundle_walk;
mod one_ray;
mod visitors;

pub use bundle_walk::{Stacks, traverse_together};
pub use one_ray::{Stack, traverse_one};
pub use visitors::{Blocked, Closest, Face, SurelyBlocked};
