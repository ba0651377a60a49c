//! Procedural scenes: seeded, no files, each with a camera and a light that show what it is for.

mod architecture;
mod assembly;
mod builder;
mod ceiling;
mod courtyard;
mod dueling;
mod figures;
mod forest;
mod random;
mod registry;
mod robots;
mod skylight;
mod spec;
mod statues;
mod terrain;
mod trees;

pub(crate) use random::Random;
pub use registry::{build, names, specs, watched};
pub use spec::{LibraryParam, LibraryScene, LibrarySpec};

/// Every scene, in the order they are listed.
static SPECS: &[LibrarySpec] =
    &[courtyard::SPEC, robots::SPEC, ceiling::SPEC, skylight::SPEC, dueling::SPEC, forest::SPEC, statues::SPEC];
