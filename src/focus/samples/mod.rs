//! What a camera sees, as points: for techniques that look at the receivers themselves.

mod edges;
mod flips;
mod outline;
mod part;
mod picture;
mod samples;

pub use edges::EdgeSample;
pub use flips::{NearEdge, RayFlip};
pub use outline::{Outline, RayFrame};
pub use part::RayEdge;
pub use picture::Picture;
pub use samples::{Samples, Shadows};
