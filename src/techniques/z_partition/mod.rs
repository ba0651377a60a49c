//! Depth splits: the scheme, and where the depths are split.

mod scheme;
mod splits;

pub use scheme::{SPEC, make};
