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
mod terrain;
mod trees;

pub use registry::{LibraryParam, LibraryScene, LibrarySpec, build, names, specs};

/// Every scene, in the order they are listed.
static SPECS: &[LibrarySpec] =
    &[courtyard::SPEC, robots::SPEC, ceiling::SPEC, skylight::SPEC, dueling::SPEC, forest::SPEC];
