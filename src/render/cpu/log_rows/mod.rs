//! Depth maps whose rows are even in the logarithm of w, drawn exactly as projective ones with uneven rows.

mod triangle;
mod uneven;

pub use uneven::UnevenMap;
