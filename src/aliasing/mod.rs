//! Errors as numbers. Sees only data: images, matrices, cameras.

pub mod against_truth;
pub mod cause_counts;
pub mod causes;
pub mod footprint;
pub(crate) mod placed;
pub(crate) mod receivers;
pub mod selection;
pub mod summary;
pub mod texel;
pub mod usage;
