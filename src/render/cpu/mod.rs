//! The rasteriser on the processor: no driver, deterministic, the rules of graphics hardware.
//!
//! A pass goes batch by batch of instances through [`raster`]; maps with a post-warp are drawn apart
//! ([`uneven_lattice`]). [`lookup`] reads what is drawn.

mod faces;
mod gbuffer;
pub mod lookup;
mod passes;
mod raster;
mod renderer;
mod stored;
mod tested_triangle;
mod uneven_lattice;

pub use lookup::look_up;
pub use renderer::CpuRenderer;
