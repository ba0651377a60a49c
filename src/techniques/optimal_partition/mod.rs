//! Depth splits where they are best for what is seen, each with its own best homography.

mod division;
mod scheme;

pub use division::least_division;
pub use scheme::{SPEC, make};
