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

#[cfg(target_arch = "x86_64")]
pub use avx2::Avx2;
pub use batch::{Batches, Pending, ROUND, Round, SLAB, Scratch, batches, by_test, fill_bins, is_small};
pub use bins::{BandArea, Bands, Bins, CHUNK_BYTES};
pub use cover::{Cover, Tiles};
pub use drawn_mesh::Draw;
pub use fill::{Entries, draw};
pub use fragments::Fragments;
pub use lanes::Lanes;
#[cfg(test)]
pub use lanes::two_nearest;
pub use pixels::{DepthPixels, Fragment, IdPixels, LayerPixels, Pixels};
pub use plain::Plain;
pub use simd::LANES;
pub use tested::Tested;
pub use triangle_setup::{larger, smaller};
pub use vertices::Viewport;
pub(super) use with_lanes::with_lanes;
