//! The renderer on the processor.

mod bias;
mod gbuffer;
mod mask;
mod precision;
mod raster;
mod strong_warps;
mod uneven_lattice;
