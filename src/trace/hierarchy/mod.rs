//! What rays walk through: trees of boxes over four triangles at a time, one per mesh and one over the instances.

mod build;
mod frame;
mod refit;
mod tracer;
mod tree;
mod triangles;

#[cfg(all(test, target_arch = "x86_64"))]
pub use build::Item;
pub use frame::{Frame, inverse_power_of_two, power_of_two_near};
pub use tracer::{Inner, TracedMesh, Tracer};
pub use tree::{Box3, LEAF, LEAF_BIT, NO_ITEM, Node, Tree, WIDTH};
pub use triangles::{Face, Packet};
