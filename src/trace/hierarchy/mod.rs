//! What rays walk through: trees of boxes over four triangles at a time, one per mesh and one over the instances.

mod frame;
mod refit;
mod tracer;
mod tree;
mod triangles;

pub use frame::{Frame, power_of_two_near};
pub use tracer::{Inner, TracedMesh, Tracer};
#[cfg(all(test, target_arch = "x86_64"))]
pub use tree::Item;
pub use tree::{Box3, LEAF, LEAF_BIT, NO_ITEM, Node, Tree, WIDTH};
pub use triangles::{Face, Packet};
