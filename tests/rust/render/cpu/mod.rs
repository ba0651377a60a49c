//! The renderer on the processor.

mod gbuffer;
mod log_rows;
mod mask;
mod precision;
mod raster;
mod strong_warps;
