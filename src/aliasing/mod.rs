//! Errors as numbers. Sees only data: images, matrices, cameras.

pub mod against_truth;
pub mod causes;
pub mod footprint;
pub mod texel;
pub mod usage;
