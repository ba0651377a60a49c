//! Depth maps whose rows, or rows and columns, are unevenly spaced in a projective map: every post-warp, drawn exactly.

mod lattice;
mod map;
mod tested;
mod texels;
mod triangle;

pub use lattice::Lattice;
