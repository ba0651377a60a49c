//! Triangles into bands of an image: vertices are projected once each, triangles are culled, clipped where they must be and
//! sorted into bands, and each band is filled by one thread.

mod batch;
mod binning;
mod clip;
mod fill;
mod lanes;
mod simd;
mod tested;
mod triangle_setup;
mod vertices;

pub use batch::{Batches, Round, Scratch, batches, by_test};
pub use binning::{Bands, Bins, Draw};
pub use fill::{BandArea, DepthPixels, Entries, IdPixels, LayerPixels, Pixels, draw, draw_fragments};
pub use lanes::two_nearest;
pub use simd::LANES;
pub use tested::Tested;
pub use triangle_setup::smaller;
pub use vertices::Viewport;
