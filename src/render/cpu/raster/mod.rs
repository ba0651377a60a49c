//! Triangles into bands of an image: vertices are projected once each, triangles are culled, clipped where they must be and
//! sorted into bands, and each band is filled by one thread.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod batch;
mod binning;
mod bins;
mod clip;
mod cover;
mod drawn_mesh;
mod fill;
mod fill_large;
mod fragments;
mod lanes;
mod pieces;
mod pixels;
mod plain;
mod projected;
mod projection;
mod run;
mod simd;
mod tested;
mod tiny;
mod triangle_setup;
mod vertices;
mod with_lanes;

pub use batch::{Batches, Round, SLAB, Scratch, batches, by_test, is_small};
pub use bins::{BandArea, Bands, Bins};
pub use cover::{Cover, Tiles};
pub use drawn_mesh::Draw;
pub use fill::{Entries, draw};
pub use lanes::two_nearest;
pub use pixels::{DepthPixels, IdPixels, LayerPixels, Pixels};
pub use simd::LANES;
pub use tested::Tested;
pub use triangle_setup::smaller;
pub use vertices::Viewport;
