//! Depth maps, G-buffers and masks, by both renderers.

mod against_truth;
mod blending;
mod blur;
mod cpu;
mod culled;
mod edge_on;
mod filter_text;
mod filtered;
#[cfg(feature = "gpu")]
mod gpu;
mod holes;
mod kernels;
mod near_plane;
mod selection;
mod states;
mod stored;
mod strong;
