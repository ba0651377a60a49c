//! The rasteriser on the processor: no driver, deterministic, the rules of graphics hardware.
//!
//! A pass goes batch by batch of instances: vertices are projected once each ([`screen`]), triangles are culled, clipped
//! where they must be, and sorted into bands of the image ([`binning`]), and each band is drawn by one thread ([`raster`]).
//! Maps with a logarithm after the projection are drawn apart ([`uneven`]).

mod batch;
mod binning;
mod clip;
mod gbuffer;
mod lanes;
pub mod lookup;
mod mask;
mod passes;
pub mod probe;
mod raster;
mod renderer;
mod screen;
mod setup;
mod simd;
mod uneven;

pub use mask::look_up;
pub use renderer::CpuRenderer;
