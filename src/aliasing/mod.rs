//! Errors as numbers. Sees only data: images, matrices, cameras.

pub mod against_truth;
pub mod footprint;
pub mod texel;
