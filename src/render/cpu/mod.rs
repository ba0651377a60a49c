//! The rasteriser on the processor: no driver, deterministic, the rules of graphics hardware.
//!
//! A pass goes batch by batch of instances through [`raster`]; maps with a logarithm after the projection are drawn apart
//! ([`log_rows`]). [`lookup`] reads what is drawn.

mod gbuffer;
mod log_rows;
pub mod lookup;
mod passes;
mod raster;
mod renderer;

pub use lookup::look_up;
pub use renderer::CpuRenderer;
