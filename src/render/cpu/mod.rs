//! The rasteriser on the processor: no driver, deterministic, the rules of graphics hardware.
//!
//! A pass goes batch by batch of instances through [`raster`]; maps with a post-warp are drawn apart
//! ([`uneven_lattice`]). [`lookup`] reads what is drawn.

mod casters;
mod faces;
mod gbuffer;
mod kept;
pub mod lookup;
mod masks;
mod passes;
mod raster;
mod renderer;
mod rooms;
mod scratches;
mod stored;
mod tested_triangle;
mod uneven_lattice;

#[cfg(feature = "gpu")]
pub(super) use casters::{asked_of, casters_of, keep_of};
pub use lookup::look_up;
pub use renderer::CpuRenderer;
