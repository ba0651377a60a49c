//! The renderer on the processor.

mod bias;
mod gbuffer;
mod mask;
mod precision;
mod raster;
mod runs;
mod strong_warps;
mod uneven_lattice;
