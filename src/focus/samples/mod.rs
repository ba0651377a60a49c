//! What a camera sees, as points: for techniques that look at the receivers themselves.

mod edges;
mod facing;
mod flips;
mod growing;
mod outline;
mod part;
mod picture;
mod runs;
#[expect(clippy::module_inception, reason = "the samples themselves, beside what is found of them")]
mod samples;

pub use edges::EdgeSample;
pub use flips::{NearEdge, RayFlip};
pub use outline::{Outline, RayFrame};
pub use part::RayEdge;
pub use picture::Picture;
pub use samples::{Samples, Shadows};
