//! Depth maps, G-buffers and masks, by both renderers.

mod against_truth;
mod blur;
mod cpu;
mod edge_on;
#[cfg(feature = "gpu")]
mod gpu;
mod holes;
mod near_plane;
mod selection;
mod stored;
mod strong;
