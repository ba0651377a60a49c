//! Depth maps whose rows, or rows and columns, are unevenly spaced in a projective map: every post-warp, drawn exactly.

#[cfg(test)]
mod agreement;
mod ascending;
mod batch;
mod bins;
mod fill;
mod lattice;
mod lists;
mod map;
mod places;
mod polygon;
mod tested;
mod tiny;
mod triangle;
mod vertex;

pub use lattice::Lattice;
pub use map::Scratch;
