//! Walks through the hierarchies, of a ray and of a bundle, and what is looked for on the way.

mod alpha;
mod bundle_walk;
mod leaves;
mod one_ray;
mod stacks;
mod ties;
mod touched;
mod visitors;

pub use bundle_walk::traverse_together;
pub use one_ray::{Stack, traverse_one};
pub use stacks::Stacks;
pub use ties::{first_of_ties, tie_reach};
pub use touched::Touched;
pub use visitors::{Blocked, Closest, SurelyBlocked};
